# SPDX-License-Identifier: MIT
"""Positions and headings of two times: read, and put at one time."""

from dataclasses import replace

import numpy as np
import pytest
from sheets import sheet
from test_delays import with_pose

from seatrial.io import read
from seatrial.recording.delays import at_one_time
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.recording.velocity import motion
from tests.boats.hulls import MIDDLE


def test_a_table_is_read_at_the_time_of_the_heading(tmp_path):
    """Of a point 0.5 m ahead, whose position is 0.2 s older than the heading beside it."""
    t = np.arange(0.0, 5.0, 0.1)
    turn = 0.8  # [rad/s]

    def place(t):
        return np.column_stack([0.3 * t + 0.5 * np.cos(turn * t), 0.5 * np.sin(turn * t)])

    columns = (t, place(t - 0.3), turn * (t - 0.1), np.zeros((len(t), 3)))
    path = sheet(tmp_path / "run.csv", "t,x,y,psi,F_u,F_v,F_r", *columns, form="%.12g")
    vehicle = with_pose(MIDDLE.vehicle([]), delay=0.3, heading_delay=0.1, lever=[0.5, 0.0])
    recording = read(path, vehicle)
    assert recording.position_delay == pytest.approx(0.2)
    seconds = 1e-9 * recording.stamps
    assert np.allclose(seconds, t - 0.1)
    assert np.allclose(recording.eta[:, 2], turn * seconds)
    # the origin, at the position's own time; the first two have no heading that old
    assert np.allclose(recording.eta[3:, 0], 0.3 * (t[3:] - 0.3), atol=1e-9)
    assert np.allclose(recording.eta[3:, 1], 0.0, atol=1e-9)
    whole = at_one_time(recording)
    assert np.allclose(whole.eta[whole.valid, 0], 0.3 * seconds[whole.valid], atol=1e-3)
    assert whole.valid.sum() >= len(t) - 3


@pytest.mark.parametrize("delay", [0.17, -0.23, 0.5])
def test_positions_are_interpolated_to_the_headings(delay):
    t = np.arange(0.0, 20.0, 0.1)
    at = t - delay
    eta = np.column_stack([np.sin(0.8 * at), np.cos(0.5 * at), 0.1 * t])
    still = Signal(("F_u",), np.array([0]), np.zeros((1, 1)))
    stamps = np.round(1e9 * t).astype(np.int64)
    recording = make_recording("r", stamps, eta, still, position_delay=delay)
    whole = at_one_time(recording)
    assert whole.position_delay == 0.0
    assert whole.valid.mean() > 0.95
    want = np.column_stack([np.sin(0.8 * t), np.cos(0.5 * t)])
    assert np.abs(whole.eta[:, :2] - want)[whole.valid].max() < 2e-4
    moving = motion(recording)
    true = np.column_stack([0.8 * np.cos(0.8 * t), -0.5 * np.sin(0.5 * t)])
    c, s = np.cos(0.1 * t), np.sin(0.1 * t)
    ahead = c * true[:, 0] + s * true[:, 1]
    assert np.abs(moving.nu[:, 0] - ahead)[moving.valid].max() < 5e-3
    # nothing across a gap
    holed = replace(recording, segment=(t > 9.95).astype(np.int64))
    gap = ~at_one_time(holed).valid & recording.valid
    assert gap[np.abs(t + delay - 9.95) < 0.05].all()


@pytest.mark.parametrize("delay", [0.02, -0.02])
def test_a_jump_leaves_the_poses_beside_it_as_they_are(delay):
    t = np.arange(0.0, 40.0, 0.1)
    eta = np.column_stack([0.2 * (t - delay) + np.where(t > 20.0, 2.0, 0.0), 0.0 * t, 0.0 * t])
    still = Signal(("F_u",), np.array([0]), np.zeros((1, 1)))
    jumped = make_recording(
        "r", np.round(1e9 * t).astype(np.int64), eta, still, position_delay=delay
    )
    assert len(np.unique(jumped.segment)) == 2
    whole = at_one_time(jumped)
    assert whole.valid.sum() >= len(t) - 2
    ahead = np.where(whole.segment > 0, 2.0, 0.0) + 0.2 * t
    assert np.allclose(whole.eta[whole.valid, 0], ahead[whole.valid], atol=1e-9)
    moving = motion(jumped)
    assert np.allclose(moving.nu[moving.valid, 0], 0.2, atol=1e-9)
