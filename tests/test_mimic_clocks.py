# SPDX-License-Identifier: MIT
"""The mimic and clocks: stray stamps, clocks that are set, and the time-out of commands, which nothing switches off."""

import json
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, make_model

from seatrial.onboard.live import Settings
from seatrial.simulation.mimic import Carrier, Mimic, MimicHealth
from seatrial.simulation.mimic.server import MimicStream

DT = 0.02  # [s] between velocities
FULL, STOP = [0.6, 0.0, 0.2], [0.0, 0.0, 0.0]
STRAYS = [5.1, 60.1, 3600.0, 1e6, 3.9e9]  # [s] ahead
EPOCH = 1.7e9  # [s]


@pytest.fixture(scope="module")
def boat(mp):
    """Its commands hold for half a second."""
    file = msgspec.structs.replace(mp.file, command_timeout=0.5)
    return replace(make_model(mp, TABLE_II["MP"]), vehicle=replace(mp, file=file))


def moved(motion) -> np.ndarray:
    return np.concatenate([motion.velocity, motion.nu, motion.pose, motion.mismatch])


def run(mimic, begin, end, command=None, pose=None):
    """Motions from one instant to another; a command and a pose of the carrier at each."""
    motions = []
    for k in range(round(begin / DT), round(end / DT)):
        t = k * DT
        if command is not None:
            assert mimic.command(t, command)
        if pose is not None:
            assert mimic.pose(t, pose)
        motions.append(mimic.at(t))
    return motions


@pytest.mark.parametrize("stray", STRAYS)
@pytest.mark.parametrize("then", [None, STOP])
def test_a_stray_command_is_as_if_it_had_not_been(boat, stray, then):
    """Before, it kept the thrust of the last command for ever: no time-out, and no later command."""
    own, other = Mimic(boat), Mimic(boat)
    for mimic in (own, other):
        run(mimic, 0.0, 2.0, FULL)
    assert not own.command(2.0 + stray, FULL)
    one, two = (run(mimic, 2.0, 6.0, then) for mimic in (own, other))
    np.testing.assert_array_equal([*map(moved, one)], [*map(moved, two)])
    assert one[0].nu[0] > 0.1
    assert one[-1].nu[0] < 0.4 * one[0].nu[0]
    assert (MimicHealth.COMMAND_SILENCE in one[-1].health) == (then is None)


@pytest.mark.parametrize("ahead", [0.3, 2.0, 4.9])
def test_a_command_stamped_ahead_hinders_none_before_it(boat, ahead):
    """It acts at its stamp; until then stops are followed, and the time-out of the others holds."""
    stopped, silent = Mimic(boat), Mimic(boat)
    for mimic in (stopped, silent):
        run(mimic, 0.0, 2.0, FULL)
        assert mimic.command(2.0 + ahead, FULL)
    other = Mimic(boat)
    run(other, 0.0, 2.0, FULL)
    one, two = (run(mimic, 2.0, 1.9 + ahead, STOP) for mimic in (stopped, other))
    np.testing.assert_array_equal([*map(moved, one)], [*map(moved, two)])
    quiet = run(silent, 2.0, 9.0)
    raised = [MimicHealth.COMMAND_SILENCE in motion.health for motion in quiet]
    assert raised[-1]
    assert raised[round((ahead - 0.1) / DT)] == (ahead > 0.8)  # [s] time-out, latency and a bit
    assert quiet[-1].nu[0] < 0.5 * quiet[0].nu[0]


def test_stray_after_stray_is_left_out(boat):
    mimic = Mimic(boat)
    run(mimic, 0.0, 1.0, FULL)
    for k in range(1, 20):
        assert not mimic.command(1e5 * k, FULL)
        assert not mimic.pose(2e5 * k, STOP)
    assert MimicHealth.COMMAND_SILENCE in run(mimic, 1.0, 3.0)[-1].health


def test_commands_by_a_clock_far_ahead_act_at_once_and_expire(boat):
    """Stamps that agree are no strays; they are of another clock than the velocities."""
    own, other = Mimic(boat), Mimic(boat)
    for k in range(101):
        t = k * DT
        assert own.command(t + 3600.0, FULL) == (k != 1)  # the first begins the clock
        if k != 1:
            other.command(t, FULL)
        one, two = own.at(t), other.at(t)
    np.testing.assert_allclose(one.nu, two.nu, atol=1e-9)
    assert MimicHealth.COMMAND_SILENCE in run(own, 2.02, 4.0)[-1].health


def test_a_command_that_is_overtaken_does_not_come_back(boat):
    own, other = Mimic(boat), Mimic(boat)
    for mimic in (own, other):
        run(mimic, 0.0, 1.0, FULL)
        assert mimic.command(1.01, STOP)
        mimic.at(1.02)
    assert not own.command(1.0, FULL)
    one, two = (run(mimic, 1.04, 2.0) for mimic in (own, other))
    np.testing.assert_array_equal([*map(moved, one)], [*map(moved, two)])


@pytest.mark.parametrize("stray", STRAYS)
def test_a_stray_pose_does_not_end_the_feedback(boat, stray):
    """Before, its mismatch drove the carrier for ever, as if it were new."""
    own, other = Mimic(boat), Mimic(boat)
    for mimic in (own, other):
        run(mimic, 0.0, 2.0, FULL, [0.1, 0.0, 0.0])
    assert not own.pose(2.0 + stray, [0.1, 0.0, 0.0])
    one, two = (run(mimic, 2.0, 3.0, STOP, [0.3, 0.0, 0.0]) for mimic in (own, other))
    np.testing.assert_array_equal([*map(moved, one)], [*map(moved, two)])
    assert MimicHealth.NO_POSE not in one[-1].health
    assert MimicHealth.NO_POSE in run(own, 3.0, 4.5)[-1].health


@pytest.mark.parametrize("back", [0.05, 2.0, 50.0, 3600.0, 1e9])
def test_a_clock_that_is_set_back_changes_nothing_but_stamps(boat, back):
    """Before, the carrier drove on at its last velocity until the clock was where it had been."""
    own, other = Mimic(boat), Mimic(boat)
    for k in range(300):
        real = k * DT
        command = FULL if k < 150 else STOP
        clock = real - back if k >= 100 else real
        same = real - DT if k >= 100 else real  # the instant at which it is set back lasts no time
        for mimic, t in ((own, clock), (other, same)):
            motion = mimic.at(t)
            assert mimic.command(t, command)
        if k == 149:
            fast = motion
        got = own.at(clock), other.at(same)
        np.testing.assert_allclose(moved(got[0]), moved(got[1]), atol=1e-5)
        assert got[0].health == got[1].health
    assert fast.nu[0] > 0.1
    assert got[0].nu[0] < 0.5 * fast.nu[0]


@pytest.mark.parametrize("leap", [61.0, 3600.0, EPOCH])
def test_a_clock_that_leaps_leaves_the_boat_where_it_is(boat, leap):
    """Boot time to epoch. Before, the boat drove all that time, which took hours to compute."""
    file = msgspec.structs.replace(boat.vehicle.file, command_timeout=None)
    mimic = Mimic(replace(boat, vehicle=replace(boat.vehicle, file=file)))
    before = run(mimic, 0.0, 2.0, FULL)[-1]
    after = mimic.at(2.0 + leap)
    np.testing.assert_array_equal(after.pose, before.pose)
    np.testing.assert_array_equal(after.nu, before.nu)
    assert MimicHealth.COMMAND_SILENCE in after.health
    at_rest = [mimic.at(2.0 + leap + DT * k) for k in range(150)][-1]
    assert at_rest.nu[0] < 0.5 * before.nu[0]
    t = 5.0 + leap
    assert mimic.command(t, FULL)
    assert mimic.pose(t, at_rest.pose)
    driven = [mimic.at(t + DT * k) for k in range(50)][-1]
    assert driven.health == MimicHealth(0)
    assert driven.nu[0] > 0.1


@pytest.mark.parametrize("odd", [1e4, -1e300, np.inf, np.nan])
def test_an_absurd_number_is_left_out(boat, odd):
    mimic = Mimic(boat)
    run(mimic, 0.0, 1.0, FULL)
    assert not mimic.command(1.0, [0.0, odd, 0.0])
    assert not mimic.pose(1.0, [odd * 1e5, 0.0, 0.0])
    motion = run(mimic, 1.0, 2.0, FULL)[-1]
    assert MimicHealth.DIVERGED not in motion.health
    assert motion.nu[0] > 0.1


def lines(begin, end, command, clock=0.0, pose=False):
    """Lines by the data's clock: commands at 10 Hz, and poses of a carrier that stands still."""
    for k in range(round(10 * begin), round(10 * end)):
        yield json.dumps({"t": clock + 0.1 * k, "command": command})
        if pose:
            yield json.dumps({"t": clock + 0.1 * k + 0.01, "pose": [0, 0, 0]})


def answers(boat, given):
    said: list[str] = []
    stream = MimicStream(Mimic(boat, Carrier(lost=9.0)), Settings(rate=20.0), said.append)
    return [json.loads(line) for text in given for line in stream.take(text, 0)], said


def test_stray_lines_are_left_out_one_by_one(boat):
    """Before, the second was taken, and the program ran through all the time up to it."""
    odd = [
        '{"t": 1e6, "command": [1, 0, 0]}',
        '{"t": 2e6, "command": [1, 0, 0]}',
        '{"t": 3e6, "pose": [0, 0, 0]}',
    ]
    plain, _ = answers(boat, [*lines(0, 3, FULL), *lines(3, 6, STOP)])
    got, said = answers(boat, [*lines(0, 3, FULL), *odd, *lines(3, 6, STOP)])
    assert got == plain
    assert len(said) == 3
    assert (
        "line 31: command at 1000000.000000 s was not used: its stamp is 999997.1 s after"
        in said[0]
    )


@pytest.mark.parametrize("pose", [False, True])
@pytest.mark.parametrize("clock", [-2.0, -20.0, -1e4, 100.0, EPOCH])
def test_lines_of_a_clock_that_was_set_are_followed(boat, clock, pose):
    before = lines(0, 3, FULL, 0.0, pose)
    after = [*lines(3, 8, FULL, clock, pose), *lines(8, 10, STOP, clock, pose)]
    got, _ = answers(boat, [*before, *after])
    late = [row for row in got[61:] if clock < 0 or row["t"] > 60]
    times = [row["t"] - clock for row in late]
    np.testing.assert_allclose(np.diff(times), 0.05, atol=1e-6)
    assert times[0] < 4.2  # after ten stamps that agree
    assert times[-1] > 9.8
    fastest = max(row["boat"][3] for row in late)
    assert fastest > 0.1
    assert late[-1]["boat"][3] < 0.5 * fastest


@pytest.mark.parametrize("pose", [False, True])
def test_strays_that_agree_do_not_silence_it(boat, pose):
    odd = [*lines(1e6, 1e6 + 0.2, FULL, 0.0, pose)]
    got, _ = answers(boat, [*lines(0, 3, FULL, 0.0, pose), *odd, *lines(3, 9, STOP, 0.0, pose)])
    late = [row for row in got if 4.5 < row["t"] < 1e5]
    np.testing.assert_allclose(np.diff([row["t"] for row in late]), 0.05, atol=1e-6)
    assert late[-1]["t"] > 8.8
    assert late[-1]["boat"][3] < 0.5 * late[0]["boat"][3]
