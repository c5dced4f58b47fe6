# SPDX-License-Identifier: MIT
"""Two models with all that is told of either, and of them together."""

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
COLOURS = (BLUE, RED)
SIGNS = ("circle", "square")
DASHES = ("solid", "dash")


@dataclass(frozen=True)
class Both:
    """A and B, in this order."""

    models: tuple[Model, Model]
    known: tuple[Identifiability, Identifiability]
    physics: tuple[Physics, Physics]
    evidence: tuple[Evidence, Evidence] | None  # None: no recordings were given
    found: Comparison
    horizon: float  # [s]


def both(
    a: Model, b: Model, recordings: Sequence[Recording], found: Comparison, horizon: float
) -> Both:
    """All of it."""
    told = None
    if recordings:
        told = collect(a, recordings, horizon), collect(b, recordings, horizon)
    return Both(
        (a, b), (identifiability(a), identifiability(b)),
        (told[0].physics, told[1].physics) if told else (physics(a), physics(b)),
        told, found, horizon,
    )  # fmt: skip
