# SPDX-License-Identifier: MIT
"""Scores against what they must be: closed forms, Monte Carlo, hand-made errors."""

import re
from dataclasses import replace

import numpy as np
import pytest
from cli_tools import done, run
from conftest import TABLE_II, at_length, in_coarse_steps, make_model
from hypothesis import given
from hypothesis import strategies as st

from seatrial.boat.model_file import save
from seatrial.boat.schema import NoiseEntry
from seatrial.evaluation.console import scores_text
from seatrial.evaluation.prediction import predict
from seatrial.evaluation.scores import scores_json
from seatrial.evaluation.validation import validate
from seatrial.identification.regression.equation_error import equation_error
from seatrial.io.trial_files import write_trial
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.recording.velocity import motion
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.errors import ModelError, RecordingError
from seatrial.util.statistics import autocorrelation, kurtosis, moving_average_band, white_band
from tests.boats.plans import planned


@pytest.fixture(scope="module")
def truth_af(af):
    return plant_model(load_plan("clean"), af)


def test_the_true_model_from_true_starts_predicts_to_the_last_digit(truth_af, clean_af):
    trial = clean_af["S7"]
    got = predict(truth_af, trial.recording, velocities=trial.true_motion)
    assert (
        np.sqrt(np.mean(got.errors**2, axis=0)).max() < 1e-4
    )  # 240 steps a second, poses at 15 Hz
    assert got.floor.tolist() == [0, 0, 0]


@pytest.mark.parametrize("preset", [at_length("paper-like"), "hard"])
def test_a_perfect_models_score_is_the_noise_floor(af, preset):
    """The floor is computed from noise and sensitivities; the score is measured."""

    from seatrial.simulation.trials import simulate

    exact = {"pose": {"stamp_jitter": 0.0}, "joypad": {"clock_offset": 0.0}}
    plan = planned(preset, "S7", seconds=200.0, **exact)
    (trial,) = simulate(plan, af)
    truth = in_coarse_steps(plant_model(plan, af))
    scores = validate(truth, [trial.recording], reference="stencil").recordings[0].scores
    for symbol in "uvr":
        assert scores[symbol].rms == pytest.approx(scores[symbol].floor, rel=0.08), symbol
        assert scores[symbol].excess < 0.45 * scores[symbol].floor


def test_scores_are_what_their_names_say(clean_mp, mp):
    model = make_model(mp, TABLE_II["MP"])
    record = clean_mp["S7"].recording.cut(0.0, 100.0)
    got = predict(model, record, 1.0)
    assert got.steps == 15
    moving = motion(record)
    np.testing.assert_array_equal(got.measured, moving.nu[got.index])
    np.testing.assert_array_equal(got.stamps, record.stamps[got.index])
    np.testing.assert_array_equal(got.start, moving.nu[got.index - 15])
    np.testing.assert_allclose(record.t[got.index] - record.t[got.index - 15], 1.0, atol=1e-9)
    score = validate(model, [record], reference="stencil").recordings[0].scores["v"]
    errors = moving.nu[got.index, 1] - got.nu[:, 1]
    assert score.rms == pytest.approx(np.sqrt(np.mean(errors**2)))
    still = moving.nu[got.index, 1] - moving.nu[got.index - 15, 1]
    assert score.stays_constant == pytest.approx(np.sqrt(np.mean(still**2)))
    assert score.ratio == pytest.approx(score.rms / score.stays_constant)
    assert score.bias == pytest.approx(errors.mean())
    from scipy.stats import kurtosis as reference

    assert score.kurtosis == pytest.approx(reference(errors, fisher=False))


def test_excess_and_floor_add_up_to_the_score(paper_af, af):
    model = equation_error([paper_af[s].recording for s in ("S1", "S2", "S3")], af)
    score = validate(model, [paper_af["S7"].recording]).recordings[0].scores["u"]
    assert score.excess**2 + score.floor**2 == pytest.approx(score.rms**2)


@pytest.mark.system
def test_table_threes_pairing_is_found_from_the_excitation(clean_af, af):
    model = make_model(af, TABLE_II["AF"])
    parts = [clean_af[s].recording.cut(0.0, 60.0) for s in ("S4", "S5", "S6")]
    rows = validate(model, [*parts, clean_af["S7"].recording])
    assert [r.excited for r in rows.recordings] == ["surge", "sway", "yaw", None]
    text = scores_text(rows)
    marked = [line.split()[-9] for line in text.splitlines() if "/s " in line and "* " in line]
    assert marked == ["u*", "v*", "r*"]
    assert scores_json(rows)["recordings"][0]["recording"] == "S4-AF"


def test_a_prediction_ends_at_the_pose_that_is_nearest_to_the_horizon(af, paper_af):
    model = make_model(af, TABLE_II["AF"])
    record = paper_af["S7"].recording
    got = predict(model, record)
    assert np.all(np.abs(record.t[got.index] - record.t[got.begun] - 1.0) < 0.75 / 15)
    few = np.flatnonzero(
        np.arange(len(record.t)) % 4 < 3
    )  # one of four is missing: steps are of two lengths
    uneven = make_recording("uneven", record.stamps[few], record.eta[few], record.commands)
    got = predict(model, uneven, 2.0)
    ends = uneven.t[got.begun] + 2.0
    nearest = np.abs(uneven.t[None, :] - ends[:, None]).argmin(axis=1)
    np.testing.assert_array_equal(got.index, nearest)
    assert len(got.index) > 0.8 * motion(uneven).valid.sum() > 1000


def test_no_prediction_runs_through_a_stretch_without_commands(af, clean_af):
    model, trial = make_model(af, TABLE_II["AF"]), clean_af["S7"]
    signal = trial.recording.commands
    t = signal.stamps * 1e-9
    keep = (t < 100.0) | (t > 100.7)
    holed = Signal(signal.names, signal.stamps[keep], signal.values[keep])
    record = make_recording("hole", trial.pose_stamps, trial.pose, holed)
    for horizon in (1.0, 3.0):
        got = predict(model, record, horizon)
        start = got.t - horizon
        assert not np.any((start < 100.69) & (got.t > 100.02))
        assert np.any(np.abs(start - 100.7) < 0.2)
        assert np.any(np.abs(got.t - 99.95) < 0.2)


def test_a_model_that_runs_away_from_some_starts_gives_no_score(af, clean_af):
    model = make_model(af, TABLE_II["AF"] | {"X_u": 400.0, "X_uu": 0.0})
    with pytest.raises(ModelError, match=r"diverges from \d+ of \d+ start states within 1 s"):
        predict(model, clean_af["S4"].recording)


def test_a_horizon_that_does_not_fit_is_one_line(clean_af, af):
    model = make_model(af, TABLE_II["AF"])
    with pytest.raises(RecordingError, match="shorter than the time between poses"):
        predict(model, clean_af["S1"].recording, 0.01)
    with pytest.raises(RecordingError, match="no two usable velocities 500 s apart"):
        predict(model, clean_af["S1"].recording, 500.0)


def test_autocorrelation_of_a_moving_average_is_the_triangle():
    rng = np.random.default_rng(0)
    k, n = 15, 200_000
    errors = np.convolve(rng.normal(size=n), np.ones(k), "valid")
    rho = autocorrelation(errors, np.arange(len(errors)), 40)
    triangle = np.maximum(0, 1 - np.arange(41) / k)
    np.testing.assert_allclose(rho, triangle, atol=0.04)


def test_the_bands_cover_what_they_claim():
    """White errors within the white band; a moving average of order k - 1 within Bartlett's beyond k."""
    rng = np.random.default_rng(1)
    n, k, runs = 3000, 15, 300
    white_in, average_in, fooled = [], [], []
    for _ in range(runs):
        e = rng.normal(size=n)
        rho = autocorrelation(e, np.arange(n), 30)
        white_in.append(np.abs(rho[1:]) < white_band(n))
        e = np.convolve(rng.normal(size=n + k - 1), np.ones(k), "valid")
        rho = autocorrelation(e, np.arange(n), 60)
        band = moving_average_band(rho, k, n)
        average_in.append(np.abs(rho[k:]) < band[k:])
        fooled.append(np.abs(rho[k:]) < white_band(n))
    assert np.mean(white_in) == pytest.approx(0.95, abs=0.01)
    assert np.mean(average_in) == pytest.approx(0.95, abs=0.025)
    assert np.mean(fooled) < 0.6  # the white band cries wolf at a perfect model


def test_gaps_do_not_pair_samples_that_are_further_apart():
    rng = np.random.default_rng(2)
    e = rng.normal(size=4000)
    index = np.concatenate([np.arange(2000), np.arange(2000) + 5000])
    rho = autocorrelation(e, index, 5)
    by_hand = np.concatenate([(e[:2000] - e.mean())[1:] * (e[:2000] - e.mean())[:-1],
                              (e[2000:] - e.mean())[1:] * (e[2000:] - e.mean())[:-1]])  # fmt: skip
    assert rho[1] == pytest.approx(by_hand.mean() / e.var(), rel=1e-12)


@given(st.lists(st.floats(-10, 10), min_size=5, max_size=50).filter(lambda x: np.std(x) > 1e-3))
def test_kurtosis_equals_scipys(values):
    from scipy.stats import kurtosis as reference

    assert kurtosis(np.array(values)) == pytest.approx(reference(values, fisher=False), rel=1e-6)


def test_the_floor_is_that_of_the_recordings_own_noise(clean_af, af):
    """A model of clean poses, scored on noisy ones, and the other way round."""
    from dataclasses import replace

    from seatrial.recording.from_poses import make_recording

    model = replace(plant_model(load_plan("clean"), af), noise=NoiseEntry(1.0, 1.0))
    trial, rng = clean_af["S7"], np.random.default_rng(3)
    white = rng.normal(size=trial.pose.shape)
    floors = []
    for sigma in (0.0, 0.001, 0.002):
        pose = trial.pose + sigma * white
        record = make_recording("noisy", trial.pose_stamps, pose, trial.recording.commands)
        floors.append(predict(model, record).floor)
    right = predict(model, clean_af["S7"].recording)  # what stencils miss is left
    assert floors[0] == pytest.approx(np.sqrt(np.mean(right.errors**2, axis=0)), rel=0.5)
    assert floors[0].max() < 1e-4
    np.testing.assert_allclose(floors[2], 2 * floors[1], rtol=0.1)
    assert floors[1][0] > 0.9 * 0.95 * 0.001 * 15


# Test recordings of another kind than the vehicle file's. #


def test_commands_in_another_unit_have_no_score(clean_af, af, truth_af):
    """Pulse widths would be forces of 1500: the errors are small beside the velocities that they predict."""
    recording = clean_af["S7"].recording
    signal = recording.commands
    pulses = replace(
        recording, commands=Signal(signal.names, signal.stamps, 1500 + 400 * signal.values)
    )
    with pytest.raises(RecordingError, match=r"S7.*F_u reaches .*, but full command is 1"):
        validate(truth_af, [pulses])


def test_a_test_recording_that_contradicts_the_vehicle_file_is_told(clean_af, af, tmp_path, capsys):
    path = write_trial(clean_af["S7"], tmp_path)
    save(in_coarse_steps(plant_model(load_plan("clean"), af)), model := tmp_path / "model.yaml")
    assert run(capsys, "validate", model, path)[1].count("doubt: ") == 0
    commands = path / "commands.csv"
    commands.write_text(commands.read_text().replace("t,F_u,F_v,F_r", "t,F_v,F_u,F_r"))
    out = done(capsys, "validate", model, path)
    (doubt,) = re.findall("doubt: (.*)", out)
    assert doubt.startswith("F_u and F_v are swapped")
    assert (
        f"next: correct the recordings, or give their own vehicle file by --vehicle  ({doubt})"
        in out
    )
