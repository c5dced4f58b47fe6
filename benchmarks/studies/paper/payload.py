# SPDX-License-Identifier: MIT
"""A payload on board: thrust over mass from a short recording, alone and with the old model as prior."""

from typing import Any

from benchmarks.studies.payload import AFTER, FIRST, VEHICLE, loaded, recordings
from seatrial.boat.model import Model
from seatrial.evaluation.comparison.compare import compare
from seatrial.identification.estimator import output_error
from seatrial.identification.prior import widened
from seatrial.recording.recording import Recording
from seatrial.util.errors import SeatrialError
from tests.boats.scenes import FORCE, TRAINING, UNSEEN, pushed

KINDS = {"still": None, "pushed": FORCE}
SECONDS = (10.0, 20.0, 40.0, 80.0, 160.0)  # of S7
BEGIN = 20.0  # [s]
FORCES = ("X_F", "Y_F", "N_F")
SEEDS_EACH = 2  # boats for a seed of the study


def keys(seeds: range) -> list[tuple[Any, ...]]:
    """What is to be run."""
    return [(kind, n, seed) for seed in seeds for kind in KINDS for n in range(SEEDS_EACH)]


def work(kind: str, n: int, seed: int) -> dict[str, Any]:
    """The old model from S1-S3, then pieces of the loaded boat's S7."""
    plan, own = pushed("hard", KINDS[kind]), SEEDS_EACH * seed + n
    old = output_error(recordings(plan, TRAINING, FIRST + own), VEHICLE)
    (run,) = recordings(loaded(plan), [UNSEEN], AFTER + own)
    return {f"{s:g}": _from_piece(old, run.cut(BEGIN, BEGIN + s)) for s in SECONDS}


def _from_piece(old: Model, piece: Recording) -> dict[str, Any]:
    """Thrust over the old with the prior; whether the piece alone shows that the boat changed."""
    out: dict[str, Any] = {}
    try:
        new = output_error([piece], VEHICLE, start=old, prior=widened(old))
        out["factors"] = [new.values[n] / old.values[n] for n in FORCES]
    except SeatrialError as failure:
        out["prior refused"] = str(failure)
    try:
        alone = output_error([piece], VEHICLE, start=old)
    except SeatrialError as failure:
        return out | {"refused": str(failure)}
    found = compare(old, alone)
    return out | {
        "changed": found.joint is not None and bool(found.joint.p < 0.05),
        "alone": [float(axis.factor) for axis in found.factors],
    }
