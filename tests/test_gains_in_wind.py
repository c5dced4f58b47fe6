# SPDX-License-Identifier: MIT
"""Gains of the inputs in a steady wind: it is no noise of theirs, so that init finds the same forces."""

import numpy as np
import pytest
from conftest import on_request
from sheets import two_sheets
from survey_boat import TRUTH, blown

from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.proposal.propose import init

SEEDS = [1, 2, on_request(3)]
WIND = 0.3, 0.1  # [m/s^2]; full thrust ahead is 0.5


def gains(wind, seed):
    """Gain and t of each input in surge and yaw."""
    vehicle, recording = blown(wind, 1.5, seconds=150.0, seed=seed)
    table = check_consistency([recording], vehicle).table
    found = {(gain.axis, gain.input): (gain.value, gain.t) for gain in table}
    return np.array([found[axis, name] for axis in (0, 2) for name in ("left", "right")])


@pytest.mark.parametrize("seed", SEEDS)
def test_gains_in_wind_are_as_sure_as_in_calm_air(seed):
    """Before, t of surge fell to an eighth. A boat of two thrusters has half of full thrust by each."""
    windy, calm = gains(WIND, seed), gains((0.0, 0.0), seed)
    assert (np.abs(windy[:, 1]) > 0.5 * np.abs(calm[:, 1])).all()
    truth = np.array([TRUTH["X_F"], TRUTH["X_F"], -TRUTH["N_F"], TRUTH["N_F"]]) / 2.0
    np.testing.assert_allclose(windy[:, 0], truth, rtol=0.1)


@pytest.mark.parametrize("degrees", [0.0, 12.0])
@pytest.mark.parametrize("seed", SEEDS)
def test_init_in_wind_proposes_equal_thrusters_and_the_offset(seed, degrees, tmp_path):
    _, recording = blown(WIND, 1.5, seconds=150.0, seed=seed)
    poses = recording.eta + np.radians([0.0, 0.0, degrees])
    found = init(two_sheets(tmp_path, recording, "left", "right", poses=poses))
    assert {name: force["of"] for name, force in found.drive.forces.items()} == {
        "F_u": {"left": 0.5, "right": 0.5},
        "F_r": {"left": -0.5, "right": 0.5},
    }
    offset = np.degrees(found.drive.pose["psi"].get("offset", 0.0))
    assert offset == pytest.approx(degrees, abs=1.0)
