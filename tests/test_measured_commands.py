# SPDX-License-Identifier: MIT
"""Measured speeds named as commands, as of a ground robot: no force explains the motion, which one line says."""

import numpy as np
import pytest
from cli_tools import run
from sheets import sheet

from seatrial.identification.likelihood.optimiser import Outcome, converged
from seatrial.util.errors import IdentificationError

RATE = 20.0  # [Hz]


def followed(folder):
    """A path that is driven exactly as the speeds say, without inertia or noise."""
    t = np.arange(0.0, 90.0, 1 / RATE)
    u = -0.25 + 0.25 * np.sin(0.4 * t) * np.sign(np.sin(0.13 * t))
    r = 0.5 * np.sin(0.53 * t + 0.4 * np.sin(0.21 * t))
    psi = np.concatenate([[0.0], np.cumsum(0.5 * (r[1:] + r[:-1])) / RATE])
    x, y = (
        np.concatenate([[0.0], np.cumsum(u[1:] * along(psi[1:])) / RATE])
        for along in (np.cos, np.sin)
    )
    folder.mkdir()
    sheet(folder / "poses.csv", "t,x,y,psi", t, x, y, psi)
    sheet(folder / "speeds.csv", "t,u_cmd,r_cmd", t, u, r)
    return folder


def test_a_robot_that_follows_its_speeds_at_once_has_no_model(tmp_path, capsys):
    """The search runs away, and so do the trials with other headings: their likelihood is not finite."""
    code, _, line = run(capsys, "auto", followed(tmp_path / "robot"), "-o", tmp_path / "out", "-q")
    assert (code, line.count("\n")) == (1, 1), line
    assert "the model is unstable: driven in surge" in line


def test_a_search_that_runs_away_asks_for_measured_speeds():
    with pytest.raises(IdentificationError, match="sent to the thrusters, not a measured speed"):
        converged((None, Outcome.DIVERGED))
