# SPDX-License-Identifier: MIT
"""Drives of a boat that changed after its model was identified, for the tests of a change."""

import numpy as np
import pytest

import seatrial
from seatrial.boat.schema import ChainGroup
from seatrial.evaluation.comparison.cause_candidates import BATTERY, MASS, OFF_CENTRE, ONE_THRUSTER
from seatrial.identification.estimator import output_error
from seatrial.monitoring.change_detector import ChangeDetector
from seatrial.onboard.boat_change import BoatChange
from seatrial.simulation.plan import PlanFile
from tests.boats.plans import planned
from tests.boats.scenes import TRAINING, driven, pushed, vehicle_of

PLAN = pushed("hard")  # a disturbance force of 4 % of full thrust
MORE = 1.2  # times mass and inertia
WEAK = 0.6  # of a thruster's thrust
SHIFT = 0.17  # [rad/m] of N_ud: a sixth of the mass, 5 cm aside, for a radius of gyration of 0.22 m
SECONDS = 100.0


def changed(cause: str) -> PlanFile:
    """The plan with another boat."""
    values, chain = dict(PLAN.plant.coefficients), list(PLAN.plant.chain)
    if cause in (MASS, OFF_CENTRE):
        values = {name: value / MORE for name, value in values.items()}
        values["N_ud"] += SHIFT if cause == OFF_CENTRE else 0.0
    if cause == BATTERY:
        values = {n: v * (0.8 if n.endswith("_F") else 1.0) for n, v in values.items()}
    if cause == ONE_THRUSTER:
        mean = (3.0 + WEAK) / 4.0
        gains = {f"F_{i}": (WEAK if i == 2 else 1.0) / mean for i in range(1, 5)}
        chain.append(ChainGroup(name="weak", gains=gains))
        values = {n: v * (mean if n.endswith("_F") else 1.0) for n, v in values.items()}
    return planned(PLAN, plant={"coefficients": values, "chain": chain})


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
        trial = driven(changed(cause), vehicle_of("MP"), 4002, ["S7"])["S7"]
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
