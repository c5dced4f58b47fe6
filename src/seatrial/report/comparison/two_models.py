# SPDX-License-Identifier: MIT
"""Two models with the evidence on each, and their comparison."""

from collections.abc import Sequence
from dataclasses import dataclass

from seatrial.boat.model import Model
from seatrial.evaluation.comparison.compare import Comparison
from seatrial.identification.uncertainty.identifiability import Identifiability, identifiability
from seatrial.recording.recording import Recording
from seatrial.report.evidence.model_evidence import Evidence, collect
from seatrial.report.evidence.physics import Physics, physics
from seatrial.report.figures.base import BLUE, RED

LETTERS = ("A", "B")
MODEL_COLOURS = (BLUE, RED)
MODEL_SIGNS = ("circle", "square")
MODEL_DASHES = ("solid", "dash")


@dataclass(frozen=True)
class ModelPair:
    """A and B, in this order."""

    models: tuple[Model, Model]
    known: tuple[Identifiability, Identifiability]
    physics: tuple[Physics, Physics]
    evidence: tuple[Evidence, Evidence] | None  # None: no recordings were given
    found: Comparison
    horizon: float  # [s]


def model_pair(
    a: Model, b: Model, recordings: Sequence[Recording], found: Comparison, horizon: float
) -> ModelPair:
    """Both models with their evidence on the recordings."""
    evidence = None
    if recordings:
        evidence = collect(a, recordings, horizon), collect(b, recordings, horizon)
    return ModelPair(
        (a, b), (identifiability(a), identifiability(b)),
        (evidence[0].physics, evidence[1].physics) if evidence else (physics(a), physics(b)),
        evidence, found, horizon,
    )  # fmt: skip
