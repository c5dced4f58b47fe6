# SPDX-License-Identifier: MIT
"""Positions, headings and yaw rates with stamps of their own, averaged poses, and even clocks."""

from dataclasses import replace

import numpy as np
import pytest

import seatrial
from seatrial import _core
from seatrial.boat.noise_parameters import OUTLIER
from seatrial.evaluation.filtering import filter_pass, run_filter
from seatrial.recording.asynchronous import joined, split_rates
from seatrial.recording.averaging import with_enough_poses
from seatrial.recording.bursts import on_even_clock
from seatrial.recording.from_poses import make_recording
from seatrial.recording.resolution import coarse_position, resolution
from seatrial.recording.signal import Signal
from seatrial.recording.yaw_rate import with_yaw_rate
from seatrial.simulation.plan import load_plan, with_seed
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import RecordingError


def stamps_of(t):
    return np.rint(1e9 * np.asarray(t)).astype(np.int64)


@pytest.fixture(scope="module")
def drive(mp):
    """A trial with yaw, and its truth."""
    return next(t for t in simulate(with_seed(load_plan("clean"), 3), mp) if t.name[:2] == "S3")


def truth_at(drive, t):
    """True states (n, 6) at times [s]."""
    return np.column_stack([np.interp(t, drive.truth_t, column) for column in drive.truth.T])


def test_rows_of_one_rate_stay_as_they_are():
    t = np.arange(100) * 0.1
    eta = np.column_stack([t, np.sin(t), 0.1 * t])
    found = split_rates(stamps_of(t), eta)
    np.testing.assert_array_equal(found.eta, eta)
    assert found.parts is None and found.asynchronous is None and found.remarks == ()


def test_a_few_empty_cells_are_faults_and_no_second_rate():
    t = np.arange(100) * 0.1
    eta = np.column_stack([t, np.sin(t), 0.1 * t])
    eta[[7, 30], 2] = np.nan
    assert split_rates(stamps_of(t), eta).parts is None


def test_headings_between_positions_are_beside_and_interpolated_at_them():
    tp, th = np.arange(0.05, 20, 0.2), np.arange(0, 20, 0.1)
    poses = joined(
        stamps_of(tp), np.column_stack([tp, tp]), stamps_of(th), np.angle(np.exp(1j * th))
    )
    np.testing.assert_allclose(poses.eta[:, 2], tp, atol=1e-9)
    assert set(poses.parts.tolist()) == {_core.POSITION_PART}
    assert len(poses.asynchronous.stamps) == len(th)


def test_no_heading_is_interpolated_over_a_hole():
    tp, th = np.arange(0, 20, 0.2), np.arange(0, 20, 0.1)
    th = th[(th < 8) | (th > 11)]
    poses = joined(stamps_of(tp), np.column_stack([tp, tp]), stamps_of(th), 0.1 * th)
    inside = (tp > 7.95) & (tp < 11.05)
    assert np.isnan(poses.eta[inside, 2]).all() and np.isfinite(poses.eta[~inside, 2]).all()


def test_the_filter_uses_headings_beside_the_poses(mp, drive):
    """Alone at the poses they leave the yaw rate less certain than with those between."""
    model = plant_model(load_plan("clean"), mp)
    t = np.arange(0.2, drive.truth_t[-1], 0.5)
    rng = np.random.default_rng(0)
    fast = np.arange(0.2, drive.truth_t[-1], 0.05)
    state, turn = truth_at(drive, t), truth_at(drive, fast)[:, 2] + rng.normal(0, 0.02, len(fast))
    noisy = state[:, :2] + rng.normal(0, 0.01, (len(t), 2))
    both = joined(stamps_of(t), noisy, stamps_of(fast), turn)
    commands = drive.recording.commands
    whole = make_recording(
        "both", both.stamps, both.eta, commands, parts=both.parts, asynchronous=both.asynchronous
    )
    alone = make_recording("alone", both.stamps, both.eta, commands)
    noise = np.array([0.01, 0.02, 0.05, 0.2, 1e-3, 1e-3, 1.0, 0, 0, 1, 0, 1], dtype=float)
    found, less = (run_filter(model, r, noise).motion for r in (whole, alone))
    true = truth_at(drive, t)[:, 5]
    error, other = (float(np.sqrt(np.nanmean((m.nu[:, 2] - true) ** 2))) for m in (found, less))
    assert error < 0.9 * other
    assert np.nanmedian(found.deviation[:, 2]) < 0.85 * np.nanmedian(less.deviation[:, 2])


def gyro(drive, *, factor=1.0, bias=0.02, noise=0.01, rate=50.0):
    t = np.arange(0.5, drive.truth_t[-1] - 0.5, 1.0 / rate)
    r = truth_at(drive, t)[:, 5] + np.random.default_rng(1).normal(0, noise, len(t)) + bias
    return stamps_of(t), factor * r


def test_the_bias_of_a_gyro_is_removed_and_its_noise_found(drive):
    stamps, r = gyro(drive)
    asynchronous = with_yaw_rate(drive.recording, stamps, r, "pose: yaw_rate").asynchronous
    true = truth_at(drive, 1e-9 * asynchronous.stamps)[:, 5]
    assert abs(float(np.mean(asynchronous.values - true))) < 5e-4
    assert asynchronous.rate_deviation == pytest.approx(
        float(np.std(asynchronous.values - true)), rel=0.2
    )


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (-1.0, "turns the other way than the heading: give it sign: -1"),
        (180 / np.pi, "is in deg/s: give it unit: deg"),
        (0.5, "is not the rate of the heading, which turns 2 times as much"),
    ],
)
def test_another_sense_unit_or_axis_of_a_gyro_is_named(drive, factor, words):
    with pytest.raises(RecordingError, match=words):
        with_yaw_rate(drive.recording, *gyro(drive, factor=factor, bias=0.0), "pose: yaw_rate")


@pytest.mark.parametrize("noise", [1e-3, 0.3])
def test_a_gyro_of_another_axis_is_refused(drive, noise):
    """Also a still one: as a yaw rate it would say that the boat does not turn."""
    stamps, _ = gyro(drive)
    roll = np.random.default_rng(2).normal(0, noise, len(stamps))
    with pytest.raises(RecordingError, match="does not follow the heading: it is of another axis"):
        with_yaw_rate(drive.recording, stamps, roll, "pose: yaw_rate")


@pytest.mark.system
def test_a_gyro_makes_the_coefficients_of_yaw_surer(mp, drive):
    vehicle = mp
    trials = {t.name[:2]: t for t in simulate(with_seed(load_plan("clean"), 3), mp)}
    rng = np.random.default_rng(5)
    plain, with_gyro = [], []
    for name in ("S1", "S2", "S3"):
        trial = trials[name]
        eta = trial.pose + rng.normal(0, [0.02, 0.02, 0.017], trial.pose.shape)
        recording = make_recording(name, trial.pose_stamps, eta, trial.recording.commands)
        plain.append(recording.cut(0.0, 60.0))
        with_gyro.append(with_yaw_rate(recording, *gyro(trial), "pose: yaw_rate").cut(0.0, 60.0))
    before, after = (seatrial.identify(r, vehicle) for r in (plain, with_gyro))
    truth = plant_model(load_plan("clean"), mp).values
    assert after.standard_errors["N_F"] < 0.6 * before.standard_errors["N_F"]
    assert abs(after.values["N_F"] - truth["N_F"]) < 3 * after.standard_errors["N_F"]


def test_fast_poses_are_averaged_at_their_middle_and_faults_keep_their_time():
    t = np.arange(0, 20, 1 / 240)
    rng = np.random.default_rng(0)
    exact = np.column_stack([np.sin(2 * t), np.cos(2 * t), 0.5 * np.sin(3 * t)])
    eta = exact + rng.normal(0, 1e-3, exact.shape)
    eta[2000:2100] = np.nan
    commands = Signal(("F_u",), stamps_of(t[::10]), np.sin(t[::10])[:, None])
    fast = make_recording("fast", stamps_of(t), eta, commands)
    slow = with_enough_poses(fast)
    assert len(slow.t) == pytest.approx(len(t) / 5, abs=3)
    own = slow.valid
    at = 1e-9 * slow.stamps[own]
    true = np.column_stack([np.sin(2 * at), np.cos(2 * at), 0.5 * np.sin(3 * at)])
    assert np.std(slow.eta[own] - true) == pytest.approx(1e-3 / np.sqrt(5), rel=0.15)
    (hole,) = [f for f in slow.faults if f.samples == 100]
    assert hole.start + 1e-9 * slow.origin == pytest.approx(t[2000], abs=1e-6)
    assert "240 Hz" in slow.remarks[-1]


def test_poses_at_a_usual_rate_are_not_averaged(drive):
    assert with_enough_poses(drive.recording) is drive.recording


def test_even_jittered_and_gapped_stamps_are_no_bursts():
    rng = np.random.default_rng(2)
    even = np.arange(2000) * 0.05
    gapped = even[(np.arange(2000) % 97) > 3]
    for t in (even, even + rng.normal(0, 0.004, 2000), gapped):
        stamps = stamps_of(t)
        same, text = on_even_clock(stamps)
        assert text == "" and same is stamps


def test_the_step_of_a_coordinate_is_found_where_it_is_rounded():
    x = np.cumsum(np.random.default_rng(0).normal(0, 0.03, 3000))
    assert resolution(np.round(x, 2)) == pytest.approx(0.01)
    assert resolution(x) < 1e-3
    assert coarse_position("r", np.column_stack([x, x[::-1]])) == ""


def test_a_recording_cut_keeps_what_was_measured_beside(drive):
    stamps, r = gyro(drive)
    whole = with_yaw_rate(drive.recording, stamps, r, "pose: yaw_rate")
    part = whole.cut(20.0, 30.0)
    inside = (whole.asynchronous.stamps >= part.stamps[0]) & (
        whole.asynchronous.stamps <= part.stamps[-1]
    )
    assert len(part.asynchronous.stamps) == pytest.approx(int(inside.sum()), abs=2)
    assert replace(part).asynchronous is part.asynchronous


def test_a_steady_turn_shows_no_gain_of_a_gyro():
    """Its bias is found: gain and bias can't be told apart, and are not refused."""
    t = np.arange(0, 60, 0.1)
    rng = np.random.default_rng(0)
    eta = np.column_stack([np.sin(0.3 * t), np.cos(0.3 * t), 0.3 * t + rng.normal(0, 0.01, len(t))])
    commands = Signal(("F_u",), stamps_of(t), np.sin(t)[:, None])
    recording = make_recording("turn", stamps_of(t), eta, commands)
    g = np.arange(0.5, 59, 0.05)
    rates = 0.3 + 0.05 + rng.normal(0, 0.01, len(g))
    asynchronous = with_yaw_rate(recording, stamps_of(g), rates, "pose: yaw_rate").asynchronous
    assert float(np.mean(asynchronous.values)) == pytest.approx(0.3, abs=2e-3)


@pytest.mark.parametrize("coloured", [False, True])
def test_a_heading_of_the_same_time_counts_as_that_of_a_whole_pose(mp, drive, coloured):
    """Sequential updates of independent sensors equal the joint one: likelihood, gradient, smoothed states."""
    model = plant_model(load_plan("clean"), mp)
    recording = drive.recording.cut(20.0, 60.0)
    t, eta = recording.t, recording.eta
    n = len(t)
    noise = np.array([5e-4, 3e-3, 1e-3, 1e-2, 1e-2, 1e-2, 1.0, 0, 0, 1, 0, 1], dtype=float)
    if coloured:
        noise[7:10] = 1e-3, 2e-3, 0.5
    begin = np.concatenate([eta[0], np.zeros(3)])
    use, velocity = np.ones(n, dtype=np.int8), np.array([0.3, 0.3, 1.0])
    whole = _core.Series(t, eta, use, begin, velocity)
    kinds = np.full(n, _core.HEADING_PART, dtype=np.int8)
    places = np.full(n, _core.POSITION_PART, dtype=np.int8)
    parted = _core.Series(
        t, eta, use, begin, velocity, None, 0.0, places, (t, kinds, np.ascontiguousarray(eta[:, 2]), 0.0)
    )  # fmt: skip
    one, two = (filter_pass(model, recording, series, noise) for series in (whole, parted))
    assert two.cost == pytest.approx(one.cost, rel=1e-9)
    np.testing.assert_allclose(two.gradient, one.gradient, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(two.information, one.information, rtol=1e-6)
    joint, sequential = (
        np.asarray(_core.smoothed(run, series, noise, OUTLIER)[0])
        for run, series in ((one, whole), (two, parted))
    )
    np.testing.assert_allclose(sequential, joint, atol=2e-6)


def test_a_yaw_rate_pulls_the_smoothed_one_towards_it(mp, drive):
    model = plant_model(load_plan("clean"), mp)
    stamps, r = gyro(drive, bias=0.0, noise=1e-3)
    eta = drive.pose + np.random.default_rng(4).normal(0, 0.02, drive.pose.shape)
    plain = make_recording("noisy", drive.pose_stamps, eta, drive.recording.commands)
    recording = with_yaw_rate(plain, stamps, r, "pose: yaw_rate")
    noise = np.array([0.02, 0.02, 0.05, 0.5, 1e-2, 1e-2, 1.0, 0, 0, 1, 0, 1], dtype=float)
    errors = []
    for one in (plain, recording):
        found = run_filter(model, one, noise)
        state = np.asarray(_core.smoothed(found.run, found.series, noise, OUTLIER)[0])
        errors.append(float(np.sqrt(np.mean((state[:, 5] - truth_at(drive, one.t)[:, 5]) ** 2))))
    assert errors[1] < 0.2 * errors[0]
