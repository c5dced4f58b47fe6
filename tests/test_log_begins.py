# SPDX-License-Identifier: MIT
"""Logs that begin while the boat is driven: what its thrusters did until then is not known."""

from dataclasses import replace

import numpy as np
import pytest

from seatrial.evaluation.filtering import COMMAND_MEMORY, filter_noise, filter_pass, filter_series
from seatrial.evaluation.prediction import Lookahead
from seatrial.identification.estimator import output_error
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.simulation.trials import plant_model
from tests.boats.plans import driven_by, planned


@pytest.fixture(scope="module")
def tracked(af):
    """A plan under motion capture, its recordings, and when each has just got a large command [s]."""
    pose = {"rate": 100.0, "position_noise": 2e-4, "heading_noise": 5e-4, "stamp_jitter": 0.0}
    plan = planned("paper-like", "S1", "S2", "S3", seed=3, pose=pose)
    return plan, [(r, changed(r)) for r in driven_by(plan, af)]


def changed(recording: Recording) -> float:
    """When a command has just changed by much and is large, after half a minute."""
    t = recording.seconds(recording.commands.stamps)
    change = np.abs(np.diff(recording.commands.values, axis=0))
    large = (change > 0.4) & (np.abs(recording.commands.values[1:]) > 0.4)
    return float(t[1:][(t[1:] > 30.0) & large.any(axis=1)][0]) + 0.03


def used(log, tracked, af):
    """The poses (n,) that the filter took."""
    plan, _ = tracked
    model = plant_model(plan, af)
    passed = filter_pass(model, log, filter_series(log), filter_noise(model, [log]))
    return np.asarray(passed.weight) > 0.0


def begun(recording: Recording, at: float, lasts: float = 60.0) -> Recording:
    """As if the log had begun there: commands, too."""
    part = recording.cut(at, at + lasts)
    c = part.commands
    rows = c.stamps >= part.stamps[0]
    return replace(part, commands=Signal(c.names, c.stamps[rows], c.values[rows]))


@pytest.mark.system
def test_poses_count_from_when_the_first_command_has_lasted(tracked, af):
    _, drives = tracked
    for recording, at in drives:
        log = begun(recording, at)
        ((before, first),) = log.unknown
        assert before == -np.inf
        assert 0.0 <= first < 0.1
        known = log.t >= first + COMMAND_MEMORY
        assert not used(log, tracked, af)[~known].any()
        assert np.array_equal(used(log, tracked, af)[known], log.valid[known])


@pytest.mark.system
def test_a_log_that_begins_at_rest_or_was_cut_is_known_from_the_beginning(tracked, af):
    _, drives = tracked
    for recording, at in drives:
        for one in (recording, recording.cut(at, at + 60.0)):
            assert all(end < one.t[0] - 2.0 for begin, end in one.unknown if begin < 0.0)
            assert np.array_equal(used(one, tracked, af), one.valid)


def test_a_log_too_short_for_that_is_used_whole(tracked, af):
    _, ((recording, at), *_) = tracked
    log = begun(recording, at, lasts=0.9)
    assert log.unknown[0][0] == -np.inf
    assert np.array_equal(used(log, tracked, af), log.valid)


def test_predictions_do_not_start_where_the_command_is_not_known(tracked, af):
    plan, ((recording, at), *_) = tracked
    log = begun(recording, at)
    late = replace(log, commands=later(log.commands, 1.5))
    found = Lookahead(plant_model(plan, af), late).predict(1.0, 1)
    assert log.t[found.index - found.steps].min() > 1.5


def later(signal: Signal, seconds: float) -> Signal:
    rows = signal.stamps >= signal.stamps[0] + round(1e9 * seconds)
    return Signal(signal.names, signal.stamps[rows], signal.values[rows])


@pytest.mark.system
def test_such_logs_tell_as_much_as_cut_ones(tracked, af):
    """With the commands before, and without: no force is made up, and errors are as small."""
    plan, drives = tracked
    known = output_error([r.cut(at, at + 60.0) for r, at in drives], af)
    found = output_error([begun(r, at) for r, at in drives], af)
    truth = plan.plant.coefficients
    for name, error in found.standard_errors.items():
        assert error < 1.3 * known.standard_errors[name], name
        if name in truth and name.endswith(("u", "v", "r", "d")):
            assert found.values[name] == pytest.approx(truth[name], abs=4.5 * error), name
    assert found.noise.process.disturbance_linear < 1e-4
