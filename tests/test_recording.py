# SPDX-License-Identifier: MIT
"""Faults in poses: found where they are put, not found where there are none."""

import itertools

import numpy as np
import pytest
from recording_tools import COMMANDS, kinds, poses

from seatrial.boat.model import thrust_trace
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.from_poses import make_recording
from seatrial.recording.pose_noise import pose_noise
from seatrial.recording.signal import Signal
from seatrial.recording.velocity import motion
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.errors import RecordingError


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


SMALL_AND_LARGE = [[0.1, 0.07, 0.0], [0.5, -0.3, 0.0]]
CLOSE = [[[0.7, 0.4, 0.5], [0.1, -second, 0.0]] for second in (0.15, 0.8)]


@pytest.mark.parametrize(
    ("between", "off"), [(0, SMALL_AND_LARGE), *itertools.product([1, 2, 3, 4], CLOSE)]
)
def test_false_matches_close_together_are_masked_exactly(between, off):
    stamps, eta = poses(noise=0.004)
    wrong = [300, 301 + between]
    eta[wrong] += off
    record = make_recording("two", stamps, eta, COMMANDS)
    assert np.flatnonzero(~record.valid).tolist() == wrong
    assert FaultKind.JUMP not in kinds(record)


@pytest.mark.parametrize("samples", [1, 2, 5])
@pytest.mark.parametrize("before", [True, False])
def test_a_false_match_beside_a_gap_is_no_jump_for_good(samples, before):
    stamps, eta = poses(noise=0.004)
    keep = np.ones(len(stamps), dtype=bool)
    keep[300:345] = False
    wrong = slice(300 - samples, 300) if before else slice(345, 345 + samples)
    eta[wrong, :2] += [0.4, -0.5]
    record = make_recording("gap", stamps[keep], eta[keep], COMMANDS)
    assert kinds(record) == {FaultKind.EXCURSION, FaultKind.GAP}
    assert record.valid.sum() == keep.sum() - samples


def test_a_false_match_after_a_gap_is_not_taken_together_with_the_next():
    stamps, eta = poses(noise=0.0007)
    keep = np.ones(len(stamps), dtype=bool)
    keep[300:345] = False
    eta[345] += [-0.2, 0.97, -0.1]
    eta[353] += [-0.18, 0.56, 0.57]
    record = make_recording("gap", stamps[keep], eta[keep], COMMANDS)
    assert np.flatnonzero(~record.valid).tolist() == [300, 308]


@pytest.mark.parametrize("seed", range(4))
def test_many_false_matches_and_drop_outs_are_found_and_nothing_else(seed):
    stamps, eta = poses(n=6000, noise=0.004, seed=seed)
    rng = np.random.default_rng(seed)
    wrong = rng.random(len(eta)) < 0.02
    course = rng.uniform(-np.pi, np.pi, (wrong.sum(), 1))
    far = rng.uniform(0.1, 1.0, (wrong.sum(), 1))
    eta[wrong, :2] += far * np.hstack([np.cos(course), np.sin(course)])
    keep = np.ones(len(stamps), dtype=bool)
    for start in rng.integers(0, len(stamps), 7):
        keep[start : start + 45] = False
    record = make_recording("many", stamps[keep], eta[keep], COMMANDS)
    assert kinds(record) == {FaultKind.EXCURSION, FaultKind.GAP}
    assert np.mean(record.valid == ~wrong[keep]) > 0.999


@pytest.mark.parametrize("seed", range(4))
def test_a_false_match_whose_way_back_is_less_plain_is_masked_all_the_same(seed):
    """The way back was below what counts as a jump: it had jumped for good, and wrong poses were used."""
    stamps, eta = poses(n=3000, rate=10.0, noise=0.01, seed=seed)
    rng = np.random.default_rng(seed)
    wrong = np.zeros(len(eta), dtype=bool)
    for begin in range(100, 2900, 150):
        length, way = int(rng.integers(3, 8)), rng.uniform(-np.pi, np.pi)
        where = slice(begin, begin + length)
        eta[where, :2] += 0.2 * np.array([np.cos(way), np.sin(way)])
        wrong[where] = True
    record = make_recording("back", stamps, eta, COMMANDS)
    assert kinds(record) == {FaultKind.EXCURSION, FaultKind.GAP}
    assert record.valid[~wrong].all()
    assert record.valid[wrong].sum() < 12  # of about 95: both ways of a match or two


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


@pytest.mark.parametrize("turn", [np.pi, -np.pi, np.pi - 0.1])
def test_a_heading_that_is_reversed_for_a_while_is_left_out(turn):
    """A pair of antennas taken for each other: the position goes on, and the sense of surge is wrong meanwhile."""
    stamps, eta = poses(noise=0.002)
    clean = make_recording("right", stamps, eta, COMMANDS)
    for first, last in ((100, 160), (400, 475)):
        eta[first:last, 2] += turn
    eta[:, 2] = (eta[:, 2] + np.pi) % (2.0 * np.pi) - np.pi
    record = make_recording("reversed", stamps, eta, COMMANDS)
    assert kinds(record) == {FaultKind.EXCURSION, FaultKind.GAP}
    wrong = np.zeros(len(stamps), dtype=bool)
    wrong[100:160] = wrong[400:475] = True
    np.testing.assert_array_equal(record.valid, ~wrong)
    left = record.eta[~wrong] - clean.eta[~wrong]
    np.testing.assert_allclose(left[:, 2], left[0, 2], atol=1e-9)


def test_a_jump_of_the_whole_pose_is_no_reversed_heading():
    """A SLAM that takes one end of a hall for the other: both parts are the boat's motion."""
    stamps, eta = poses(noise=0.002)
    eta[300:, :2] = [5.0, 2.0] - eta[300:, :2]
    eta[300:, 2] += np.pi
    record = make_recording("hall", stamps, eta, COMMANDS)
    assert kinds(record) == {FaultKind.JUMP}
    assert record.valid.all()


def test_frozen_poses_of_a_moving_boat_are_masked():
    stamps, eta = poses(noise=0.0005)
    eta[200:206] = eta[199]
    record = make_recording("frozen", stamps, eta, COMMANDS)
    assert np.flatnonzero(~record.valid).tolist() == list(range(200, 206))
    assert FaultKind.FROZEN in kinds(record)


def test_a_position_that_repeats_while_the_heading_goes_on_is_masked_if_it_catches_up():
    """A receiver without a fix; rounded positions of a slow boat repeat without a large step after."""
    stamps, eta = poses(noise=0.002)
    eta[200:260, :2] = eta[200, :2]
    record = make_recording("stuck", stamps, eta, COMMANDS)
    assert kinds(record) >= {FaultKind.FROZEN}
    assert not record.valid[201:260].any()
    assert record.valid[200]
    stamps, eta = poses(n=1200, rate=60.0)
    eta[:, :2] = np.round(eta[:, :2], 2)
    assert FaultKind.FROZEN not in kinds(make_recording("rounded", stamps, eta, COMMANDS))


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


def test_heading_is_unwrapped_also_across_masked_samples():
    stamps, eta = poses()
    eta[:, 2] = np.linspace(0, 40, len(eta))
    wrapped = eta.copy()
    wrapped[:, 2] = (eta[:, 2] + np.pi) % (2 * np.pi) - np.pi
    wrapped[77] = np.nan
    record = make_recording("turns", stamps, wrapped, COMMANDS)
    np.testing.assert_allclose(record.eta[record.valid, 2], eta[record.valid, 2], atol=1e-12)


def test_cutting_keeps_the_commands_that_still_act_at_the_start():
    stamps, eta = poses()
    commands = Signal(
        ("F_u",), np.array([0, 10 * 10**9, 20 * 10**9]), np.array([[0.1], [0.2], [0.3]])
    )
    part = make_recording("cut", stamps, eta, commands).cut(12.0, 19.0)
    assert part.seconds(part.commands.stamps) == pytest.approx([-10.0, -2.0], abs=0.07)
    assert part.commands.values.tolist() == [[0.1], [0.2]]
    assert part.duration == pytest.approx(7.0, abs=0.1)
    assert part.offset == pytest.approx(12.0, abs=0.07)
    assert part.cut(2.0).offset == pytest.approx(14.0, abs=0.07)
    late = make_recording("cut", stamps, eta, commands).cut(
        12.0, 19.5
    )  # a clock may be late by 0.5 s
    assert late.seconds(late.commands.stamps) == pytest.approx([-10.0, -2.0, 8.0], abs=0.07)
    with pytest.raises(RecordingError, match=r"it lasts 39\.9 s"):
        make_recording("cut", stamps, eta, commands).cut(100.0, None)


def in_rows(stamps, eta, rate):
    """A log at a rate of its own [Hz] that writes the last pose there is."""
    rows = np.arange(stamps[0], stamps[-1], round(1e9 / rate))
    last = np.searchsorted(stamps, rows, side="right") - 1
    return rows, eta[last], np.append(True, np.diff(last) > 0)


@pytest.mark.parametrize("rest", [None, 0.0, 2e-3])  # with the noise of poses, and without
@pytest.mark.parametrize("rate", [20.0, 32.0, 60.0, 300.0])
def test_a_log_that_holds_the_last_pose_is_that_of_its_poses(rate, rest):
    """15 poses a second in more rows: the repeats are no poses, nor a tracker that hangs."""
    stamps, eta = poses(noise=0.0 if rest == 0.0 else 2e-3, rest=0 if rest is None else 200)
    rows, held, new = in_rows(stamps, eta, rate)
    record = make_recording("held", rows, held, COMMANDS)
    assert record.valid.all()
    assert {f.kind for f in record.faults} <= {
        FaultKind.JUMP
    }  # where the boat comes to rest at once
    kept = np.isin(rows, record.stamps)
    if rest == 0.0:  # while it rests a pose stays now and then
        assert kept.sum() < 600
    else:
        np.testing.assert_array_equal(kept, new)
    assert record.remarks[0].startswith(f"{100 * (1 - kept.mean()):.0f} % of the rows repeat")


@pytest.mark.parametrize("resolution", [0.0, 1e-3, 5e-3])
def test_a_boat_at_rest_or_poses_that_are_rounded_are_not_held(resolution):
    stamps, eta = poses(rest=250)
    if resolution:
        eta = resolution * np.rint(eta / resolution)
    record = make_recording("rest", stamps, eta, COMMANDS)
    assert (len(record.t), record.remarks) == (600, ())


def test_poses_that_never_change_are_as_many_as_there_are():
    record = make_recording("blank", poses()[0], np.zeros((600, 3)), COMMANDS)
    assert (len(record.t), record.remarks) == (600, ())


@pytest.mark.parametrize("uneven", [0.0, 0.2])
@pytest.mark.parametrize("rate", [12.0, 30.0])
def test_a_boat_that_rests_and_then_turns_quickly_has_no_faults(rate, uneven):
    """Each step is far from the one before and the one after, but between them: that is acceleration."""
    rng = np.random.default_rng(4)
    t = (np.arange(900) + uneven * rng.uniform(-1.0, 1.0, 900)) / rate
    turning = np.interp(t % 12.0, [0, 8, 8.3, 8.8, 9.2, 9.6, 12], [0, 0, 2.0, -2.0, 1.0, 0, 0])
    psi = np.concatenate([[0.0], np.cumsum(0.5 * (turning[1:] + turning[:-1]) * np.diff(t))])
    eta = np.column_stack([0.1 * np.sin(0.2 * t), 0.1 * t, psi]) + 2e-3 * rng.normal(size=(900, 3))
    stamps = np.rint(t * 1e9).astype(np.int64)
    assert make_recording("quick", stamps, eta, COMMANDS).faults == ()
    eta[600:, 2] += 1.0  # rad
    (fault,) = make_recording("quick", stamps, eta, COMMANDS).faults
    assert (fault.kind, fault.end) == (FaultKind.JUMP, pytest.approx(t[600] - t[0]))


@pytest.mark.parametrize("kind", [FaultKind.JUMP, FaultKind.GAP])
def test_after_a_cut_faults_end_at_their_pose_to_the_last_bit(kind):
    """A pose from which on SLAM is elsewhere is found by its time; rounded otherwise, it was the next."""
    rng = np.random.default_rng(5)
    for start in rng.uniform(1.0, 10.0, 100).tolist():
        stamps = np.cumsum(rng.integers(64_000_000, 69_000_000, 400)) + 1_700_000_000_000_000_000
        if kind is FaultKind.GAP:
            stamps[300:] += 5_000_000_000
        t = (stamps - stamps[0]) * 1e-9
        eta = np.column_stack([0.3 * t, 0.05 * np.sin(t), 0.1 * np.sin(0.3 * t)])
        if kind is FaultKind.JUMP:
            eta[300:, 1] += 1.5
        whole = make_recording("drive", stamps, eta, Signal(("F_u",), stamps, np.sin(t)[:, None]))
        part = whole.cut(start)
        (fault,) = (f for f in part.faults if f.kind is kind)
        assert fault.end == part.t[np.flatnonzero(part.stamps == stamps[300])[0]]


def test_a_cut_in_the_middle_of_a_drive_feels_the_same_forces(af, clean_af):
    """Latency and lag: what was commanded before the cut still acts after it."""
    plan = load_plan("paper-like")
    boat = plant_model(plan, af)
    whole = clean_af["S7"].recording
    part = whole.cut(40.3)
    t = np.linspace(0.0, 3.0, 31)
    forces = thrust_trace(boat.vehicle, boat.constants, part).forces(t)
    same = thrust_trace(boat.vehicle, boat.constants, whole).forces(t + part.offset)
    np.testing.assert_allclose(forces, same, atol=1e-6)
    assert np.ptp(same, axis=0).min() > 0.01


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
