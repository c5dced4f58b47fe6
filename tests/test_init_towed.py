# SPDX-License-Identifier: MIT
"""A log that begins on a trailer or ends in tow: init sees the boat's own motion only."""

import numpy as np
import pytest
from conftest import at_length
from init_tools import proposed
from sheets import sheet
from survey_boat import driven, even, past_idle

from seatrial.inspection.advice import implausible_units
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.undriven import without_undriven_ends
from tests.boats.motions import recorded

LENGTH, ROAD = 300.0, 180.0  # [s] of the drive, and of the way to it or from it


def with_road(speed, *, before):
    """A drive with a stretch at a speed [m/s] before it or after it, and the servos' 1500 us where nothing is commanded."""
    rng = np.random.default_rng(3)
    vehicle, drive = driven(
        {},
        [past_idle] * 2,
        seconds=LENGTH,
        seed=3,
        stamps=even(5.0),
        noise=np.array([0.04, 0.04, 0.03]),
    )
    away = np.arange(0.2, ROAD, 0.2)
    course = 0.3 * np.sin(0.1 * away)
    pace = (
        0.2 * speed * (1.0 + 0.3 * np.sin(2.0 * away))
    )  # [m] from pose to pose, of who walks or drives
    track = np.cumsum(np.column_stack([pace * np.cos(course), pace * np.sin(course)]), axis=0)
    road = np.column_stack([track, course + 0.5 * np.sin(2.0 * away)]) + 0.02 * rng.normal(
        size=(len(away), 3)
    )
    rest = np.full((round(20 * ROAD), 2), 1500.0)
    servos = 1500.0 + 400.0 * drive.commands.values
    if before:
        road = road[::-1] - road[0] + drive.eta[0]
        poses = (np.concatenate([away, drive.t + ROAD]), np.vstack([road, drive.eta]))
        rows = np.vstack([rest, servos])
    else:
        poses = (
            np.concatenate([drive.t, drive.t[-1] + away]),
            np.vstack([drive.eta, road + drive.eta[-1]]),
        )
        rows = np.vstack([servos, rest])
    return vehicle, poses, (0.05 * np.arange(len(rows)), rows)


@pytest.mark.parametrize(
    ("speed", "before"), [(12.0, True), (3.0, False), at_length(3.0, True), at_length(12.0, False)]
)
def test_both_thrusters_are_found(speed, before, tmp_path):
    _, (t, eta), (begin, rows) = with_road(speed, before=before)
    folder = tmp_path / "lake"
    folder.mkdir()
    sheet(folder / "poses.csv", "t,x,y,psi", t, eta)
    sheet(folder / "commands.csv", "t,left,right", begin, rows)
    _, vehicle = proposed(folder)
    forces = {name: force.of for name, force in vehicle.file.forces.items()}
    assert forces == {"F_u": {"left": 0.5, "right": 0.5}, "F_r": {"left": -0.5, "right": 0.5}}
    assert vehicle.file.pose.x.unit in (None, "m")


@pytest.mark.parametrize("before", [True, False])
def test_the_part_that_is_left_out_is_the_road(before):
    vehicle, poses, commands = with_road(5.0, before=before)
    whole = recorded("lake", vehicle, poses, commands)
    (fault,) = [f for f in without_undriven_ends(whole).faults if f.kind is FaultKind.EXCLUDED]
    road = (0.0, ROAD) if before else (LENGTH, LENGTH + ROAD)
    assert (fault.start, fault.end) == pytest.approx(road, abs=4.0)


def test_a_boat_that_rests_before_and_after_is_left_as_it_is():
    vehicle, poses, commands = with_road(0.0, before=True)
    whole = recorded("pool", vehicle, poses, commands)
    assert without_undriven_ends(whole) is whole


def test_inspect_takes_a_drive_to_the_lake_for_no_other_unit():
    vehicle, poses, commands = with_road(11.0, before=True)
    whole = recorded("lake", vehicle, poses, commands)
    assert implausible_units(whole, vehicle) == []
