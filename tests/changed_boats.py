# SPDX-License-Identifier: MIT
"""Drives of a boat that changed after its model was identified, for the tests of a change."""

from functools import partial

import numpy as np
import pytest

import seatrial
from benchmarks.studies.changes.boats import SHIFT, damaged, heavier, weaker
from seatrial.evaluation.comparison.cause_candidates import BATTERY, MASS, OFF_CENTRE, ONE_THRUSTER
from seatrial.identification.estimator import output_error
from seatrial.monitoring.change_detector import ChangeDetector
from seatrial.onboard.boat_change import BoatChange
from tests.boats.plans import planned
from tests.boats.scenes import TRAINING, driven, pushed, vehicle_of

PLAN = pushed("hard")  # a disturbance force of 4 % of full thrust
SECONDS = 100.0
CHANGES = {
    MASS: heavier,
    OFF_CENTRE: partial(heavier, shift=SHIFT),
    BATTERY: partial(weaker, share=0.8),
    ONE_THRUSTER: damaged,
}


def sent(recording, shift: int = 0) -> list[tuple[int, str, np.ndarray]]:
    """Inputs in the order of their stamps [ns]."""
    signal = recording.commands
    rows = [
        (int(t) + shift, "command", v) for t, v in zip(signal.stamps, signal.values, strict=True)
    ]
    rows += [
        (int(t) + shift, "pose", v) for t, v in zip(recording.stamps, recording.raw, strict=True)
    ]
    return sorted(rows, key=lambda row: row[:2])


def findings(detector: ChangeDetector, rows) -> list[BoatChange]:
    """What a detector says of inputs, in their order."""
    found = []
    for stamp, kind, values in rows:
        detector.use(kind, stamp, values)
        change = detector.look() if kind == "pose" else None
        found += [] if change is None else [change]
    return found


class Drives(dict[str, seatrial.Recording]):
    """S7 by cause, made when it is asked for."""

    def __missing__(self, cause: str) -> seatrial.Recording:
        trial = driven(CHANGES.get(cause, planned)(PLAN), vehicle_of("MP"), 4002, ["S7"])["S7"]
        self[cause] = trial.recording.cut(0.0, SECONDS)
        return self[cause]


def _identified(_) -> seatrial.Model:
    trials = driven(PLAN, vehicle_of("MP"), 3001, TRAINING)
    return output_error([t.recording for t in trials.values()], vehicle_of("MP"))


@pytest.fixture(scope="module")
def known_model(once) -> seatrial.Model:
    """The model of the boat before it changes: a fixture of modules that name it `model`."""
    return once("boat-before-changes", _identified)[1]


@pytest.fixture(scope="module")
def drives_by_cause() -> Drives:
    """A fixture of modules that name it `drives`."""
    return Drives()
