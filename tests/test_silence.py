# SPDX-License-Identifier: MIT
"""What is in force while no command is written."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_recording import kinds, poses

from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.util.errors import RecordingError


def pressed(*stretches, rate=50.0, end=40.0, steady=True):
    """Commands at `rate` Hz within the stretches [s]; unsteady: some, at odd times, as they change."""
    t = np.arange(0.0, end, 1 / rate)
    t = t[np.any([(t >= a) & (t < b) for a, b in stretches], axis=0)]
    if not steady:
        t = np.sort(np.random.default_rng(4).choice(t, len(t) // 6, replace=False))
    values = np.random.default_rng(5).uniform(-1, 1, (len(t), 3))
    return Signal(("F_u", "F_v", "F_r"), np.rint(t * 1e9).astype(np.int64), values), t


def let_go(stretches, *, last):
    """A stick that is moved in some stretches, and whose topic falls silent `last` rows of 0 after each."""
    signal, t = pressed(*stretches)
    values = np.array(signal.values)
    for _, end in stretches:
        values[np.flatnonzero(t < end)[-last:]] = 0.0
    return Signal(signal.names, signal.stamps, values)


def hidden(record):
    return np.flatnonzero(~record.valid)


def silent(t, held, timeout):
    """Poses later than `timeout` [s] after the last command before them: the definition, one by one."""
    return [i for i, x in enumerate(t.tolist()) if x - held[held <= x].max(initial=-1e9) >= timeout]


@pytest.mark.parametrize("steady", [True, False], ids=["steady", "on change"])
@pytest.mark.parametrize("timeout", [0.25, 1.0, 4.0])
def test_after_its_timeout_no_command_is_known(steady, timeout):
    stamps, eta = poses()
    commands, held = pressed((0.0, 12.0), (20.0, 30.0), steady=steady)
    record = make_recording("timeout", stamps, eta, commands, timeout=timeout)
    expected = silent(stamps * 1e-9, held, timeout)
    if not steady:  # half a second without commands at the start is let pass
        expected = [i for i in expected if stamps[i] * 1e-9 > held[0] + 1e-9]
    assert hidden(record).tolist() == expected
    assert kinds(record) == {FaultKind.SILENT}
    until = held[held < 19].max() + timeout
    assert any(f.start == pytest.approx(until) for f in record.faults)


def test_without_a_timeout_silence_is_a_hole_in_a_rhythm_and_nothing_in_a_log_of_changes():
    stamps, eta = poses()
    commands, held = pressed((0.0, 12.01), (20.0, 40.0))
    record = make_recording("hole", stamps, eta, commands)
    assert hidden(record).tolist() == silent(stamps * 1e-9, held, 0.02)
    commands, _ = pressed((0.0, 12.0), (20.0, 30.0), steady=False)
    assert make_recording("still", stamps, eta, commands).valid.all()


def test_a_stick_that_falls_silent_at_rest_is_at_rest():
    """With or without a timeout: after nothing was asked for, nothing is."""
    stamps, eta = poses()
    stretches = [(0.0, 8.0), (12.0, 18.0), (24.0, 30.0), (36.0, 40.0)]
    for timeout in (None, 0.5):
        record = make_recording("stick", stamps, eta, let_go(stretches, last=1), timeout=timeout)
        assert FaultKind.SILENT not in kinds(record)
        assert record.valid.all()


@pytest.mark.parametrize("timeout", [None, 0.5])
@pytest.mark.parametrize("rest", [True, False])
def test_the_end_of_the_commands_is_a_silence_like_those_before(rest, timeout):
    """A stick at rest until the end of the poses is at rest; one that stops during a pulse is lost."""
    stamps, eta = poses()
    stretches = [(0.0, 5.0), (9.0, 14.0), (18.0, 22.0), (26.0, 30.0)]
    commands = let_go(stretches, last=1)
    values = np.array(commands.values)
    values[-1] = 0.0 if rest else 0.7
    whole = Signal(commands.names, commands.stamps, values)
    record = make_recording("end", stamps, eta, whole, timeout=timeout)
    until = 1e-9 * whole.stamps[-1] + (timeout or 0.02)
    lost = [] if rest else np.flatnonzero(1e-9 * stamps >= until - 1e-9).tolist()
    assert hidden(record).tolist() == lost


def test_silences_after_commands_or_too_few_for_a_habit_are_holes():
    stamps, eta = poses()
    stretches = [(0.0, 8.0), (12.0, 18.0), (24.0, 30.0), (36.0, 40.0)]
    pushing, _ = pressed(*stretches)
    assert FaultKind.SILENT in kinds(make_recording("lost", stamps, eta, pushing))
    few = let_go([(0.0, 8.0), (12.0, 40.0)], last=1)
    assert FaultKind.SILENT in kinds(make_recording("once", stamps, eta, few))


@given(st.lists(st.tuples(st.integers(0, 1900), st.integers(1, 40)), min_size=1, max_size=4))
def test_commands_that_are_no_numbers_mask_exactly_their_stretch(stretches):
    """From the first that is none to the next that is one; what holds before goes on to it."""
    stamps, eta = poses()
    commands, held = pressed((0.0, 40.0))
    values = np.array(commands.values)
    bad = np.zeros(len(held), dtype=bool)
    for i, (begin, length) in enumerate(stretches):
        bad[begin : begin + length] = True
        values[begin : begin + length, i % 3] = (np.nan, np.inf, -np.inf)[i % 3]
    record = make_recording("nan", stamps, eta, Signal(commands.names, commands.stamps, values))
    row = np.searchsorted(commands.stamps, stamps, side="right") - 1
    np.testing.assert_array_equal(record.valid, ~bad[row])
    assert np.isfinite(record.commands.values).all()
    found = [f for f in record.faults if f.kind is FaultKind.NO_NUMBER]
    assert sum(f.samples for f in found) == bad[row].sum()
    first = np.flatnonzero(bad & ~np.concatenate([[False], bad[:-1]]))
    assert [f.start for f in found] == pytest.approx(held[first].tolist())


def test_no_command_that_is_a_number_is_no_command():
    stamps, eta = poses()
    with pytest.raises(RecordingError, match="no commands"):
        make_recording("nan", stamps, eta, Signal(("F_u",), stamps, np.full((600, 1), np.nan)))
