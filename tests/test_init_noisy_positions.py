# SPDX-License-Identifier: MIT
"""Positions of a usual GNSS receiver: noise has most of their acceleration, and init finds the thrusters all the same."""

import numpy as np
import pytest
from conftest import at_length
from init_tools import proposed
from sheets import sheet
from survey_boat import driven, even, past_idle

from seatrial.inspection.consistency.accelerations import WINDOW
from seatrial.inspection.consistency.check import file_commands
from seatrial.inspection.consistency.gains import LONGEST_WINDOW, read_runs

NOISE = np.array([0.05, 0.05, 0.03])  # [m], [m], [rad]
WANDER, MEMORY = 0.5, 20.0  # [m], [s]


def with_wander(recording, rng):
    """Poses (n, 3) whose positions wander as a Gauss-Markov process."""
    fading = np.exp(-recording.period / MEMORY)
    off = np.zeros((len(recording.t), 2))
    for k in range(1, len(off)):
        off[k] = fading * off[k - 1] + WANDER * np.sqrt(1 - fading**2) * rng.normal(size=2)
    return recording.eta + np.column_stack([off, np.zeros(len(off))])


@pytest.mark.parametrize("seed", [1, at_length(2), at_length(3)])
def test_both_motors_move_the_boat_ahead(seed, tmp_path):
    """In windows of the usual length one motor or both had no clear gain in surge."""
    _, drive = driven({}, [past_idle] * 2, seconds=900.0, seed=seed, stamps=even(5.0), noise=NOISE)
    poses = with_wander(drive, np.random.default_rng(seed))
    folder = tmp_path / "lake"
    folder.mkdir()
    sheet(folder / "poses.csv", "t,x,y,psi", drive.t, poses)
    t = 1e-9 * (drive.commands.stamps - drive.origin)
    sheet(folder / "commands.csv", "t,left,right", t, drive.commands.values)
    _, vehicle = proposed(folder)
    forces = {name: force.of for name, force in vehicle.file.forces.items()}
    assert forces == {"F_u": {"left": 0.5, "right": 0.5}, "F_r": {"left": -0.5, "right": 0.5}}


@pytest.mark.parametrize(
    ("noise", "window"), [([2e-3, 2e-3, 3e-3], None), ([0.1, 0.1, 3e-3], LONGEST_WINDOW)]
)
def test_windows_are_as_long_as_the_noise_asks_for(noise, window):
    vehicle, drive = driven({}, [past_idle] * 2, seed=2, noise=np.array(noise))
    (run,) = read_runs([drive], [file_commands(vehicle, drive)])
    assert run.window == window
    assert 2 * run.smooth.half == pytest.approx(window or WINDOW, rel=0.1)
