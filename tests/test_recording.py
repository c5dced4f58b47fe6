# SPDX-License-Identifier: MIT
"""Faults in poses: found where they are put, not found where there are none."""

import numpy as np
import pytest

from seatrial.errors import RecordingError
from seatrial.faults import FaultKind
from seatrial.noise import pose_noise
from seatrial.recording import Signal, make_recording, rising
from seatrial.velocity import motion

COMMANDS = Signal(("F_u", "F_v", "F_r"), np.array([0]), np.zeros((1, 3)))


def poses(n=600, rate=15.0, noise=0.0, seed=0):
    """A smooth wander with turns, sampled at `rate` Hz."""
    t = np.arange(n) / rate
    eta = np.column_stack([0.8 * np.sin(0.3 * t), 0.5 * np.sin(0.5 * t + 1), 2.5 * np.sin(0.2 * t)])
    eta += noise * np.random.default_rng(seed).normal(size=eta.shape)
    return np.rint(t * 1e9).astype(np.int64), eta


def kinds(record):
    return {f.kind for f in record.faults}


@pytest.mark.parametrize("noise", [0.0, 0.0007, 0.004, 0.008])
def test_a_good_recording_has_no_faults(noise):
    for seed in range(5):
        record = make_recording("good", *poses(noise=noise, seed=seed), COMMANDS)
        assert record.faults == ()
        assert record.valid.all()
        assert np.all(record.segment == 0)


def test_simulated_trials_without_faults_are_found_without_faults(clean_mp, clean_af):
    for trial in [*clean_mp.values(), *clean_af.values()]:
        assert trial.recording.faults == (), trial.name


@pytest.mark.parametrize("length", [1, 3, 8])
@pytest.mark.parametrize("size", [0.1, 1.0])
def test_a_false_match_is_masked_exactly(length, size):
    stamps, eta = poses(noise=0.004)
    eta[300 : 300 + length, 0] += size
    record = make_recording("jump", stamps, eta, COMMANDS)
    assert np.flatnonzero(~record.valid).tolist() == list(range(300, 300 + length))
    assert kinds(record) == {FaultKind.EXCURSION} | ({FaultKind.GAP} if length > 1 else set())


def test_a_jump_for_good_is_not_differentiated_over():
    stamps, eta = poses()
    eta[300:, 1] += 0.4
    record = make_recording("shift", stamps, eta, COMMANDS)
    assert FaultKind.JUMP in kinds(record)
    assert record.valid.all()
    assert record.segment[299] != record.segment[300]
    velocity = motion(record)
    assert not velocity.valid[298:302].any()
    assert np.nanmax(np.abs(velocity.nu[:, :2])) < 0.5


def test_frozen_poses_of_a_moving_boat_are_masked():
    stamps, eta = poses(noise=0.0005)
    eta[200:206] = eta[199]
    record = make_recording("frozen", stamps, eta, COMMANDS)
    assert np.flatnonzero(~record.valid).tolist() == list(range(200, 206))
    assert FaultKind.FROZEN in kinds(record)


def test_a_boat_at_rest_is_not_frozen():
    stamps, eta = poses()
    eta[:150] = eta[150]
    record = make_recording("rest", stamps, eta, COMMANDS)
    assert FaultKind.FROZEN not in kinds(record)


def test_a_gap_is_named_and_never_bridged():
    stamps, eta = poses()
    keep = np.ones(len(stamps), dtype=bool)
    keep[100:130] = False
    record = make_recording("gap", stamps[keep], eta[keep], COMMANDS)
    (fault,) = record.faults
    assert fault.kind is FaultKind.GAP
    assert fault.end - fault.start == pytest.approx(31 / 15)
    velocity = motion(record)
    assert np.flatnonzero(~velocity.valid).tolist() == [0, 1, 98, 99, 100, 101, 568, 569]


def test_drop_outs_marked_or_not_a_number_are_left_out():
    stamps, eta = poses()
    eta[50] = np.nan
    marked = np.ones(len(stamps), dtype=bool)
    marked[60:63] = False
    eta[60:63] = 0.0
    record = make_recording("marked", stamps, eta, COMMANDS, marked_valid=marked)
    assert np.flatnonzero(~record.valid).tolist() == [50, 60, 61, 62]
    assert {FaultKind.NOT_FINITE, FaultKind.MARKED} <= kinds(record)


def test_stamps_that_go_back_are_left_out():
    stamps, eta = poses()
    stamps[100] = stamps[90]
    record = make_recording("back", stamps, eta, COMMANDS)
    assert FaultKind.STAMP in kinds(record)
    assert np.all(np.diff(record.stamps) > 0)
    assert len(record.stamps) == 599


def test_heading_is_unwrapped_also_across_masked_samples():
    stamps, eta = poses()
    eta[:, 2] = np.linspace(0, 40, len(eta))
    wrapped = eta.copy()
    wrapped[:, 2] = (eta[:, 2] + np.pi) % (2 * np.pi) - np.pi
    wrapped[77] = np.nan
    record = make_recording("turns", stamps, wrapped, COMMANDS)
    np.testing.assert_allclose(record.eta[record.valid, 2], eta[record.valid, 2], atol=1e-12)


def test_cutting_keeps_the_command_that_holds_at_the_start():
    stamps, eta = poses()
    commands = Signal(
        ("F_u",), np.array([0, 10 * 10**9, 20 * 10**9]), np.array([[0.1], [0.2], [0.3]])
    )
    part = make_recording("cut", stamps, eta, commands).cut(12.0, 19.0)
    assert part.commands.values.tolist() == [[0.2]]
    assert part.duration == pytest.approx(7.0, abs=0.1)
    assert part.offset == pytest.approx(12.0, abs=0.07)
    assert part.cut(2.0).offset == pytest.approx(14.0, abs=0.07)
    with pytest.raises(RecordingError, match=r"it lasts 39\.9 s"):
        make_recording("cut", stamps, eta, commands).cut(100.0, None)


def test_rising_keeps_the_last_of_equal_stamps_and_drops_late_ones():
    assert rising(np.array([1, 2, 2, 1, 3])).tolist() == [True, False, True, False, True]


def test_recordings_hand_out_read_only_arrays():
    record = make_recording("good", *poses(), COMMANDS)
    with pytest.raises(ValueError, match="read-only"):
        record.eta[0, 0] = 1.0


@pytest.mark.parametrize("sigma", [0.0007, 0.004])
def test_pose_noise_is_estimated_within_a_tenth(sigma):
    rng = np.random.default_rng(5)
    stamps, eta = poses(3000)
    eta += rng.normal(size=eta.shape) * [sigma, sigma, 3 * sigma]
    found = pose_noise(make_recording("noisy", stamps, eta, COMMANDS))
    assert found.position == pytest.approx(sigma, rel=0.1)
    assert found.heading == pytest.approx(3 * sigma, rel=0.1)


def test_too_few_poses_say_so():
    stamps, eta = poses(600)
    with pytest.raises(RecordingError, match="1 poses"):
        make_recording("one", stamps[:1], eta[:1], COMMANDS)
    with pytest.raises(RecordingError, match="0 usable poses of 600, most not a number"):
        make_recording("none", stamps, np.full_like(eta, np.nan), COMMANDS)
    with pytest.raises(RecordingError, match="no commands"):
        make_recording(
            "mute", stamps, eta, Signal(("F_u",), np.zeros(0, np.int64), np.zeros((0, 1)))
        )
