# SPDX-License-Identifier: MIT
"""Motion before, between and after commands: a boat that is carried, towed or adrift."""

from pathlib import Path

import numpy as np
import pytest
from conftest import make_model
from survey_boat import TRUTH, as_stated, boat, driven

import seatrial
from seatrial.guide.recordings import as_model_reads, while_driven
from seatrial.guide.steps import Steps, Task
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.recording.undriven import undriven_motion

RATE, BEFORE, DRIVEN, AFTER = 10.0, 40.0, 60.0, 40.0  # [Hz], [s] of each part


def log(before=0.0, after=0.0, noise=0.01):
    """A drive at 0.5 m/s in circles, carried by so many metres before it and after it."""
    t = np.arange(0.0, BEFORE + DRIVEN + AFTER, 1 / RATE)
    driven = np.clip(t - BEFORE, 0.0, DRIVEN)
    x = 2.5 * np.sin(0.2 * driven) + before * np.clip(t - 5.0, 0.0, 30.0) / 30.0
    x += after * np.clip(t - BEFORE - DRIVEN - 15.0, 0.0, 20.0) / 20.0
    eta = np.column_stack([x, 2.5 * np.cos(0.2 * driven), 0.2 * driven])
    eta[:, :2] += noise * np.random.default_rng(0).normal(size=(len(t), 2))
    values = np.where((t >= BEFORE) & (t < BEFORE + DRIVEN), 0.6, 0.0)[:, None] * [1.0, 0.0, 0.2]
    stamps = np.rint(t * 1e9).astype(np.int64)
    return make_recording("lake", stamps, eta, Signal(("F_u", "F_v", "F_r"), stamps, values))


def test_a_boat_that_rests_before_and_after_is_not_carried():
    assert undriven_motion(log()) == []
    assert undriven_motion(log(noise=0.1)) == []


def test_a_boat_that_is_carried_to_the_water_and_home_is_named_with_what_to_leave_out():
    whole = log(before=30.0, after=-12.0)
    first, last = undriven_motion(whole)
    assert first.text(whole) == (
        "the boat moves 30 m in the 39 s before the first command: carried, towed or adrift? "
        "Leave it out with --without lake=-39"
    )
    assert last.moved == pytest.approx(12.0, abs=0.5)
    assert "after the last command" in last.text(whole)
    assert last.text(whole).endswith("--without lake=110-")  # coasting stays
    (again,) = undriven_motion(whole.cut(7.0, None).without(-np.inf, 32.0))
    assert again.text(whole.cut(7.0, None)).endswith("--without lake=110-")  # of the whole log


def test_without_any_command_nothing_is_before_the_first():
    whole = log(before=30.0)
    assert undriven_motion(whole.cut(None, BEFORE - 2.0)) == []


def test_a_command_that_is_logged_once_drives_until_the_next_one():
    whole = log(before=30.0, after=-12.0)
    changes = np.array([BEFORE, BEFORE + DRIVEN]) * RATE
    own = whole.commands.values[changes.astype(int)]

    def logged(*rows):
        """With these changes in the log only."""
        stamps = whole.stamps[changes.astype(int)][[*rows]]
        signal = Signal(whole.commands.names, stamps, own[[*rows]])
        return undriven_motion(make_recording("lake", whole.stamps, whole.raw, signal))

    # on, off: as the log with every row; on alone: driven to the end
    assert logged(0, 1) == undriven_motion(whole)
    assert [one.first for one in logged(0)] == [True]


def test_a_log_of_commands_that_ends_while_the_boat_is_driven_drives_no_longer():
    whole = log(before=30.0, after=-12.0)
    kept = whole.stamps < round((BEFORE + DRIVEN) * 1e9)
    commands = Signal(
        whole.commands.names, whole.commands.stamps[kept], whole.commands.values[kept]
    )
    cut = make_recording("lake", whole.stamps, whole.raw, commands)
    assert undriven_motion(cut) == undriven_motion(whole)


PAUSE = 60.0  # [s] between two drives


def paused(motion, known=True):
    """Two drives at 0.5 m/s with a pause between; motion: x (n,) [m] of the boat in it, from its time (n,) [s]."""
    t = np.arange(0.0, 2 * DRIVEN + PAUSE, 1 / RATE)
    ran = np.clip(t, 0.0, DRIVEN) + np.clip(t - DRIVEN - PAUSE, 0.0, DRIVEN)
    x = 2.5 * np.sin(0.2 * ran) + motion(np.clip(t - DRIVEN, 0.0, PAUSE))
    eta = np.column_stack([x, 2.5 * np.cos(0.2 * ran), 0.2 * ran])
    eta[:, :2] += 0.01 * np.random.default_rng(0).normal(size=(len(t), 2))
    rests = (t >= DRIVEN) & (t < DRIVEN + PAUSE)
    values = np.where(rests, 0.0, 0.6)[:, None] * [1.0, 0.0, 0.2]
    values[rests] = 0.0 if known else np.nan
    stamps = np.rint(t * 1e9).astype(np.int64)
    return make_recording("lake", stamps, eta, Signal(("F_u", "F_v", "F_r"), stamps, values))


def towed(t):
    """15 m in half a minute, from the 20th second of the pause on."""
    return 0.5 * np.clip(t - 20.0, 0.0, 30.0)


def test_a_boat_that_is_towed_between_two_drives_is_named_with_what_to_leave_out():
    whole = paused(towed)
    (found,) = undriven_motion(whole)
    assert found.text(whole) == (
        "the boat moves 15 m in the 50 s without a command from 70 s on: carried, towed or adrift? "
        "Leave it out with --without lake=70-120"
    )
    assert undriven_motion(whole.without(70.0, 120.0)) == []
    later = whole.cut(30.0, None)
    assert undriven_motion(later)[0].text(later) == found.text(whole)  # of the whole log


@pytest.mark.parametrize(
    "motion",
    [
        pytest.param(lambda t: 0.0 * t, id="rests"),
        pytest.param(lambda t: 12.0 * (1.0 - np.exp(-t / 12.0)), id="coasts from 1 m/s"),
        pytest.param(lambda t: 0.4 * t, id="drifts with the water"),
    ],
)
def test_a_boat_that_moves_by_itself_in_a_pause_is_not_towed(motion):
    assert undriven_motion(paused(motion)) == []


def test_a_jump_of_the_poses_or_unknown_commands_in_a_pause_are_no_tow():
    jumped = paused(lambda t: 3.0 * (t > 30.0))
    assert [fault.kind for fault in jumped.faults] == [FaultKind.JUMP]
    assert undriven_motion(jumped) == []
    assert undriven_motion(paused(towed, known=False)) == []


def test_auto_leaves_a_tow_out_and_reads_the_log_again_without_it(monkeypatch):
    whole = paused(towed)
    task = Task((Path("lake"),), Path(), None, print, salvage=False, steps=Steps(Path("none")))
    task.log_of[whole.sources] = Path("lake")
    kept = while_driven(task, whole)
    assert task.again(Path("lake")) == ["lake", "--without", "lake=70-120"]
    assert task.again(Path("other")) == ["other"]
    assert not kept.valid[(kept.t > 70.1) & (kept.t < 119.9)].any()
    assert kept.valid[(kept.t < 69.9) | (kept.t > 120.1)].all()
    (said,) = task.assumed
    assert said.startswith("from 70 s on, 50 s of lake are left out: the boat moves 15 m there")
    # a lever arm that was found: the log is read again
    monkeypatch.setattr("seatrial.guide.recordings.read", lambda *_, **__: whole)
    model = make_model(boat().with_lever((0.1, 0.0)), TRUTH)
    (again,) = as_model_reads(task, model, boat(), [kept.cut(20.0, 170.0)])
    same = kept.cut(20.0, 170.0)
    np.testing.assert_array_equal(again.valid, same.valid)
    np.testing.assert_array_equal(again.stamps, same.stamps)


def test_auto_leaves_it_out_and_says_so():
    task = Task((Path("lake"),), Path(), None, print, salvage=False, steps=Steps(Path("none")))
    kept = while_driven(task, log(before=30.0, after=-12.0))
    assert kept.offset == pytest.approx(BEFORE - 1.0, abs=0.11)
    assert kept.duration == pytest.approx(DRIVEN + 1.0 + 10.0, abs=0.3)
    assert [one[:48] for one in task.assumed] == [
        "the first 39 s of lake are left out: the boat mo",
        "the last 30 s of lake are left out: the boat mov",
    ]
    resting = log()
    assert while_driven(task, resting) is resting


@pytest.mark.system
def test_the_model_of_a_boat_that_was_towed_between_is_the_truth_without_the_tow():
    vehicle, first = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=100.0)
    _, second = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=100.0, seed=2)
    t = np.arange(0.1, PAUSE, 0.1)  # [s] since the first drive
    coasts = (first.raw[-1] - first.raw[-4]) / 0.3 * 2.0 * (1.0 - np.exp(-t / 2.0))[:, None]
    between = first.raw[-1] + coasts + np.column_stack([towed(t), 0.0 * t, 0.0 * t])
    x, y, psi = between[-1]
    c, s = np.cos(psi), np.sin(psi)
    after = second.raw @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + [x, y, psi]
    own, last = second.commands, first.stamps[-1]
    later = last + round(PAUSE * 1e9)
    pause = last + np.arange(1, 20 * PAUSE, dtype=np.int64) * 50_000_000
    driven_until = first.commands.stamps < pause[0]
    commands = Signal(
        own.names,
        np.concatenate([first.commands.stamps[driven_until], pause, later + own.stamps]),
        np.concatenate(
            [first.commands.values[driven_until], np.zeros((len(pause), 2)), own.values]
        ),
    )
    stamps = np.concatenate(
        [first.stamps, last + np.rint(t * 1e9).astype(np.int64), later + second.stamps]
    )
    whole = make_recording("lake", stamps, np.concatenate([first.raw, between, after]), commands)
    model = seatrial.identify([whole], vehicle)
    assert model.warnings[0].startswith("lake: the boat moves 15 m in the")
    start, _, end = model.warnings[0].rpartition("=")[2].partition("-")
    kept = seatrial.identify([whole.without(float(start), float(end))], vehicle)
    assert not [w for w in kept.warnings if "towed" in w]
    names = kept.values.keys() & TRUTH.keys()
    assert as_stated(kept, {name: TRUTH[name] for name in names}) == {}


def test_the_model_tells_that_it_is_of_a_boat_that_was_carried():
    vehicle, drive = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=100.0)
    ashore = np.arange(-40.0, 0.0, 0.1)
    before = np.column_stack([ashore + 1.0, 0.0 * ashore, 0.0 * ashore])  # 1 m/s, to the start
    stamps = np.concatenate([np.rint(1e9 * ashore).astype(np.int64), drive.stamps])
    own = drive.commands
    rest = np.concatenate([np.zeros((1, 2)), own.values])
    commands = Signal(own.names, np.concatenate([stamps[:1], own.stamps]), rest)
    whole = make_recording("lake", stamps, np.concatenate([before, drive.raw]), commands)
    model = seatrial.identify([whole], vehicle)
    assert model.warnings[0].startswith("lake: the boat moves 39 m in the")
    name, _, span = model.warnings[0].rpartition(" ")[2].partition("=")
    assert name == "lake"
    kept = whole.without(-np.inf, float(span[1:]))
    assert not [w for w in seatrial.identify([kept], vehicle).warnings if "carried" in w]
