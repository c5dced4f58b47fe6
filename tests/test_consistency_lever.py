# SPDX-License-Identifier: MIT
"""A wrong pose column is found though the vehicle file states a lever arm, which it takes off the wrong way."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from recording_tools import in_vehicle_terms
from steered_boat import known

from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.between_recordings import check_each_recording
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.recording.from_poses import make_recording
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import simulate
from seatrial.util.frames import Axes
from tests.boats.hulls import MIDDLE, driven

ORIGIN = (0.0, 0.0)
LEVERS = [ORIGIN, (0.25, 0.0), (-0.1, 0.2)]  # [m]
MISTAKES = {
    "none": ((1, 1, 1), [0, 1, 2], set()),
    "heading in degrees": ((1, 1, 180 / np.pi), [0, 1, 2], {InconsistencyKind.ANGLE}),
    "heading turned": ((1, 1, -1), [0, 1, 2], {InconsistencyKind.MIRRORED}),
    "y turned": ((1, -1, 1), [0, 1, 2], {InconsistencyKind.MIRRORED}),
    "y and heading turned": ((1, -1, -1), [0, 1, 2], {InconsistencyKind.HANDED}),
    "x and y exchanged": ((1, 1, 1), [1, 0, 2], {InconsistencyKind.EXCHANGED}),
}


@pytest.fixture(scope="module")
def boat():
    vehicle, (drive,) = driven(
        MIDDLE, {"latency": 0.1, "lag": 0.1}, seed=5, white=2e-3, seconds=180, drives=1
    )
    return vehicle, drive


def seen_from(drive, lever, axes) -> np.ndarray:
    """x, y, psi of a point of the boat as a file in these axes has them."""
    eta = drive.raw.copy()
    c, s = np.cos(eta[:, 2]), np.sin(eta[:, 2])
    ahead, left = lever
    eta[:, :2] += np.column_stack([c * ahead - s * left, s * ahead + c * left])
    return eta * (1, -1, -1) if axes is Axes.FRD else eta


@pytest.mark.parametrize("axes", Axes)
@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.parametrize("lever", LEVERS)
def test_a_wrong_pose_column_is_found_with_a_lever_arm_in_the_file(boat, lever, mistake, axes):
    vehicle, drive = boat
    factors, order, kinds = MISTAKES[mistake]
    stated = Vehicle(msgspec.structs.replace(vehicle.file, axes=axes)).with_lever(lever)
    columns = (seen_from(drive, lever, axes) * factors)[:, order]
    recording = make_recording("r", drive.stamps, in_vehicle_terms(columns, stated), drive.commands)
    assert {f.kind for f in check_consistency([recording], stated).findings} == kinds


def test_with_a_right_file_a_lever_arm_is_taken_off_before_inputs_are_judged(boat):
    """Sway of a point ahead of the origin follows yaw: F_r would move it."""
    vehicle, drive = boat
    stated = vehicle.with_lever((0.25, 0.0))
    poses = in_vehicle_terms(seen_from(drive, (0.25, 0.0), Axes.FLU), stated)
    there = check_consistency([make_recording("r", drive.stamps, poses, drive.commands)], stated)
    for found, right in zip(there.table, check_consistency([drive], vehicle).table, strict=True):
        assert (found.input, found.axis) == (right.input, right.axis)
        assert found.value == pytest.approx(right.value, abs=1e-9)


def test_a_recording_without_a_stretch_of_poses_costs_the_others_nothing(boat):
    vehicle, drive = boat
    short = np.arange(len(drive.t)) % 12 < 6
    poor = make_recording("p", drive.stamps, drive.raw, drive.commands, marked_valid=short)
    assert check_consistency([poor], vehicle).text[0].startswith("too short to check signs")
    assert check_each_recording([poor, drive], vehicle).findings == ()
    assert (
        check_consistency([poor, drive], vehicle).table == check_consistency([drive], vehicle).table
    )


@pytest.mark.parametrize("arm", [(1.0, 0.0), (1.5, -0.5)])
def test_an_antenna_far_ahead_of_a_boat_that_turns_by_its_stern_is_no_fault(arm):
    """There the point goes to the side that the stern does not: the heading seemed to be the other way round."""
    boat = known()
    ahead = replace(boat, vehicle=boat.vehicle.with_lever(arm))
    trials = simulate(load_plan("lake"), ahead.vehicle, ahead)
    unstated = [
        replace(one, vehicle=one.vehicle.with_lever((0.0, 0.0))).recording for one in trials
    ]
    assert check_consistency(unstated, boat.vehicle).findings == ()
