# SPDX-License-Identifier: MIT
"""Where the boat was, how fast it was, and when work is due again."""

import time

import numpy as np
import pytest
from live_sessions import ROW, SECOND

from seatrial.boat.vehicle import vehicle_from
from seatrial.poolside.session.body_velocity import BodyVelocity
from seatrial.poolside.session.track import MOST_ROWS, Track
from seatrial.poolside.session.turn import Turn


def test_what_is_due_leaves_the_core_idle(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    turn = Turn(4.0)
    assert turn.due
    with turn:
        now[0] += 0.5
    now[0] += 3.9
    assert not turn.due
    now[0] += 0.2
    assert turn.due
    with turn:
        now[0] += 3.0  # a heavy one waits for four times as long
    now[0] += 11.9
    assert not turn.due
    now[0] += 0.2
    assert turn.due


def test_the_track_is_in_the_files_own_axes(mp):
    content = mp.to_mapping() | {"axes": "forward-right-down"}
    turned = Track(vehicle_from(content, "turned"))
    turned.use("pose", 0, ROW)
    assert turned.pose == (1.0, -2.0, -0.5)


def test_positions_and_headings_of_two_sensors_are_one_track(mp):
    track = Track(mp)
    track.use("position", 0, ROW[:2])
    assert track.pose is None and track.rows == []
    track.use("heading", 1, ROW[2:])
    track.use("position", SECOND, ROW[:2] + 1.0)
    assert track.pose == (2.0, 3.0, 0.5)
    assert track.rows == [(1.0, 2.0, 3.0, 0.5)]
    assert track.poses == 2


@pytest.mark.parametrize("jump", [5e7, -7200.0])
def test_the_time_goes_on_where_a_clock_is_set(mp, jump):
    track, velocity = Track(mp), BodyVelocity()
    step = SECOND // 10
    for i in range(200):
        stamp = i * step + (round(jump * SECOND) if i >= 100 else 0)
        track.use("pose", stamp, ROW)
        velocity.use("pose", stamp, np.array([0.02 * i, 0.0, 0.0]))
    assert track.newest == stamp  # a discard begins there
    assert track.time == pytest.approx(19.8)  # less the step that no clock shows
    assert len(track.rows) == pytest.approx(100, abs=1)
    assert velocity.nu == pytest.approx([0.2, 0.0, 0.0])


def test_one_pose_of_a_far_stamp_changes_no_time(mp):
    track = Track(mp)
    for i in range(200):
        track.use("pose", i * SECOND // 10 + (10**17 if i == 100 else 0), ROW)
    assert track.time == pytest.approx(19.7)


def test_driven_is_the_time_under_command(mp):
    track = Track(mp)
    for i in range(100):
        track.use("command", i * SECOND // 10, np.full(len(mp.inputs), 0.5 if i < 30 else 0.01))
        track.use("pose", i * SECOND // 10, ROW)
    assert track.driven == pytest.approx(2.9)
    track.use("command", 10 * SECOND, np.full(len(mp.inputs), 0.5))
    track.use("pose", 20 * SECOND, ROW)
    assert track.driven == pytest.approx(2.9)  # a gap is not driven


def test_a_long_track_stays_bounded_over_the_whole_drive(mp):
    track = Track(mp)
    for i in range(MOST_ROWS + 10):
        track.use("pose", i * SECOND // 5, ROW)
    assert len(track.rows) == MOST_ROWS // 2 + 10
    assert track.changes == 1
    assert track.rows[0][0] == 0.0 and track.rows[-1][0] == pytest.approx(0.2 * (MOST_ROWS + 9))


def test_body_velocity_is_that_of_a_circle():
    """Speed 0.5 m/s ahead and 0.3 rad/s: exact but for the chord of the baseline."""
    velocity, r, u = BodyVelocity(), 0.3, 0.5
    for i in range(60):
        t = 0.02 * i
        eta = np.array(
            [u / r * np.sin(r * t), u / r * (1.0 - np.cos(r * t)), np.remainder(r * t + 3.0, 2 * np.pi)]
        )  # fmt: skip
        turned = 3.0
        c, s = np.cos(turned), np.sin(turned)
        eta[:2] = c * eta[0] - s * eta[1], s * eta[0] + c * eta[1]
        assert velocity.use("pose", round(t * 1e9), eta)
    assert velocity.nu == pytest.approx([u, 0.0, r], abs=1e-3)


def test_body_velocity_does_not_follow_a_jump_or_a_gap():
    velocity = BodyVelocity()
    assert np.isnan(velocity.nu).all()
    for i in range(60):
        jump = 5.0 if i == 57 else 0.0
        velocity.use("pose", i * SECOND // 15, np.array([0.01 * i + jump, 0.0, 0.0]))
    assert velocity.nu == pytest.approx([0.15, 0.0, 0.0], abs=1e-9)
    assert not velocity.use("pose", 0, ROW)  # out of order
    for i in range(3):
        velocity.use("pose", (100 + 10 * i) * SECOND, ROW)
    assert np.isnan(velocity.nu).all()
