# SPDX-License-Identifier: MIT
"""Coverage of a drive: seconds by speed and command."""

import numpy as np
import pytest

from seatrial.boat.vehicle import vehicle_from
from seatrial.poolside.coverage import COMMAND_EDGES, Coverage, axis_commands


def seconds_at(state, speed, command):
    """Seconds in the bin of a speed and a command."""
    row = int(np.searchsorted(state.speeds, speed, side="right")) - 1
    column = int(np.searchsorted(state.commands, command, side="right")) - 1
    return state.seconds[row][column]


def drive(coverage, nu, command, begin=0.0, count=11):
    for k in range(count):
        coverage.add(begin + 0.1 * k, np.array(nu), np.array(command))


def test_seconds_are_in_the_bin_of_speed_and_command(mp):
    coverage = Coverage(mp)
    drive(coverage, [0.12, -0.03, 0.0], [0.5, 0.0, -1.0])
    surge, sway, yaw = coverage.state()
    assert seconds_at(surge, 0.12, 0.5) == pytest.approx(1.0)
    assert seconds_at(sway, -0.03, 0.0) == pytest.approx(1.0)
    assert yaw.seconds[4][0] == pytest.approx(1.0)  # at rest, full right
    assert sum(map(sum, surge.seconds)) == pytest.approx(1.0)
    assert coverage.driven.tolist() == pytest.approx(np.array([[0, 1], [0, 0], [1, 0]]))


def test_a_faster_boat_widens_the_bins_and_keeps_the_seconds(mp):
    coverage = Coverage(mp)
    drive(coverage, [0.12, 0.0, 0.0], [0.5, 0.0, 0.0])
    drive(coverage, [0.7, 0.0, 0.0], [1.0, 0.0, 0.0], begin=1.1)
    surge = coverage.state()[0]
    assert surge.speeds[-1] == pytest.approx(0.8)
    assert seconds_at(surge, 0.12, 0.5) == pytest.approx(1.0)
    assert surge.seconds[-1][-1] == pytest.approx(1.1)


def test_discarded_seconds_are_taken_out_to_a_second(mp):
    coverage = Coverage(mp)
    drive(coverage, [0.12, 0.0, 0.0], [0.5, 0.0, 0.0], count=101)
    drive(coverage, [0.9, 0.0, 0.0], [1.0, 0.0, 0.0], begin=10.1, count=100)
    coverage.discard(10.1)
    assert coverage.driven[0, 1] == pytest.approx(10.0, abs=1.0)
    coverage.discard(-1.0)
    assert not coverage.driven.any()


def test_gaps_and_unknown_velocities_do_not_count(mp):
    coverage = Coverage(mp)
    for t, u in [(0.0, 0.1), (3.0, 0.1), (3.1, np.nan), (3.2, 0.1)]:
        coverage.add(t, np.array([u, 0.0, 0.0]), np.zeros(3))
    assert sum(map(sum, coverage.state()[0].seconds)) == pytest.approx(0.1)


def test_bins_are_in_the_vehicle_files_own_axes(mp):
    content = {**mp.to_mapping(), "axes": "forward-right-down"}
    coverage = Coverage(vehicle_from(content, "down"))
    drive(coverage, [0.0, 0.12, 0.0], [0.0, 1.0, 0.0])  # to the left
    sway = coverage.state()[1]
    assert seconds_at(sway, -0.12, -1.0) == pytest.approx(1.0)
    assert sway.commands == COMMAND_EDGES


def test_the_command_of_an_axis_is_the_force_of_its_thrusters(mp):
    assert axis_commands(mp, np.eye(3)) == pytest.approx(np.eye(3), abs=1e-12)


def test_thrusters_that_are_commanded_one_by_one_are_at_full_command_together(mp):
    content = {**mp.to_mapping(), "allocation": {"scheme": "direct"}}
    content["commands"] = {"inputs": {name: {"column": name} for name in content["thrusters"]}}
    four = vehicle_from(content, "four")
    ahead = np.sign(four.mix[0])
    for level in (1.0, 0.4):
        shares = axis_commands(four, level * ahead[None])
        assert shares[0] == pytest.approx([level, 0.0, 0.0], abs=1e-12)
