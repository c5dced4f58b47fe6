# SPDX-License-Identifier: MIT
"""Smoothed velocities against an independent smoother, and scores against the truth of simulated drives."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import TABLE_II, in_coarse_steps, make_model
from scipy.linalg import expm

from seatrial import _core
from seatrial.boat.findings import FindingKind, of_kinds
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import NOISE_LEAST, OUTLIER, noise_entry
from seatrial.boat.schema import NoiseEntry
from seatrial.evaluation.assessment import assess
from seatrial.evaluation.console import scores_text
from seatrial.evaluation.filtering import filter_pass, filter_series, recording_noise, run_filter
from seatrial.evaluation.predicted import Prediction
from seatrial.evaluation.prediction import Lookahead, predict
from seatrial.evaluation.reference import smoothed_motion
from seatrial.evaluation.scoring import axis_scores
from seatrial.evaluation.validation import validate
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.recording.velocity import motion
from seatrial.report.evidence import verdict
from seatrial.report.evidence.runs import gather
from seatrial.report.text.numbers import at_floor, resolved_ratio
from seatrial.simulation.trials import Trial
from tests.boats import wrong_models
from tests.boats.wrong_models import SENSORS, SURE, variants


def driven(*how, **more) -> tuple[Model, Trial]:
    """The boat and a trial."""
    boat, trial = wrong_models.driven(*how, **more)
    return in_coarse_steps(boat), trial


def predicted(model: Model, recording: Recording) -> Prediction:
    """A second ahead, from the filter to the smoothed velocity."""
    look = Lookahead(
        model,
        recording,
        filtered=run_filter(model, recording),
        smoothed=smoothed_motion(model, recording),
    )
    return look.predict(1.0, 2)


def error(ahead: Prediction, trial: Trial) -> np.ndarray:
    """RMS error (3,) of predictions, by the truth."""
    truth = trial.truth[trial.arrived, 3:]
    return np.sqrt(np.mean((truth[ahead.index] - ahead.nu) ** 2, axis=0))


def score(ahead: Prediction) -> np.ndarray:
    return np.array([one.rms for one in axis_scores(ahead).values()])


@pytest.mark.system
@pytest.mark.parametrize("sensor", SENSORS)
def test_a_score_is_the_true_error_of_right_and_wrong_models(af, sensor):
    """Also of models that state no process noise at all, whose own smoother would confirm them."""
    boat, trial = driven(af, sensor, seconds=120.0)
    recording = trial.recording
    scores, errors = [], []
    for name, model in variants(boat).items():
        likeliest = noise_entry(recording_noise(model, [recording]))
        for stated in (likeliest, NoiseEntry(*SENSORS[sensor][1:], SURE)):
            ahead = predicted(replace(model, noise=stated), recording)
            apart = np.hypot(0.04 * error(ahead, trial), ahead.reference_error)
            assert np.all(np.abs(score(ahead) - error(ahead, trial)) < apart), name
            scores.append(score(ahead))
            errors.append(error(ahead, trial))
    # they are ranked as the truth ranks them, where it tells two apart
    scores, errors = np.array(scores), np.array(errors)
    clear = errors[:, None] > 1.15 * errors[None]
    assert np.all((scores[:, None] > scores[None])[clear])
    assert clear.sum() > 60


@pytest.mark.system
@pytest.mark.parametrize("name", ["right", "drag"])
def test_errors_of_poses_that_last_are_not_taken_for_motion(af, name):
    """Correlated over 0.3 s, which the model does not state."""
    boat, trial = driven(af, "SLAM", correlation=0.3)
    ahead = predicted(variants(boat)[name], trial.recording)
    apart = np.hypot(0.04 * error(ahead, trial), ahead.reference_error)
    assert np.all(np.abs(score(ahead) - error(ahead, trial)) < apart)
    by_stencil = np.sqrt(predict(boat, trial.recording).squares.mean(axis=0))
    assert np.all(ahead.reference_error[:2] < 0.2 * by_stencil[:2])


def test_a_right_model_is_not_called_off_by_the_noise_of_its_reference(af):
    """Right to a tenth of a centimetre per second; by the stencil it was off by eleven."""
    boat, trial = driven(af, "GNSS", None)
    (found,) = assess(boat, [trial.recording], 1.0)
    assert error(found.prediction, trial)[:2].max() < 1e-3
    assert score(found.prediction)[:2].max() < 2e-3
    assert score(predict(boat, trial.recording))[:2].min() > 0.1
    runs = gather(boat, [found])
    assert at_floor(runs).all()
    assert resolved_ratio(runs).tolist() == [0.0, 0.0, 0.0]


def test_a_wrong_model_that_is_sure_of_itself_does_not_confirm_itself(af):
    """With its own noise its smoother returns its own simulation; with the recording's it does not."""
    boat, trial = driven(af, "motion capture", None)
    wrong = replace(variants(boat)["drag"], noise=NoiseEntry(*SENSORS["motion capture"][1:], SURE))
    truth = trial.truth[trial.arrived, 3:]
    noise = NOISE_LEAST.copy()
    noise[:2] = SENSORS["motion capture"][1:]
    own = smoothed_motion(wrong, trial.recording, noise).nu - truth
    used = smoothed_motion(wrong, trial.recording).nu - truth
    assert np.all(np.sqrt(np.mean(own**2, axis=0)) > 10.0 * np.sqrt(np.mean(used**2, axis=0)))


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_smoothed_velocity_errs_as_its_standard_deviation_says(af, sensor):
    boat, trial = driven(af, sensor)
    found = smoothed_motion(boat, trial.recording)
    off = found.nu - trial.truth[trial.arrived, 3:]
    # of 200 s, in which the smoother's errors last about a second
    assert np.sqrt(np.mean((off / found.deviation) ** 2, axis=0)) == pytest.approx(1.0, abs=0.35)
    filtered = run_filter(boat, trial.recording).motion
    settled = filtered.valid
    ahead = filtered.nu[settled] - trial.truth[trial.arrived, 3:][settled]
    assert np.all(np.mean(ahead**2, axis=0) > 2.0 * np.mean(off**2, axis=0))
    rough = motion(trial.recording)
    by_stencil = (rough.nu - trial.truth[trial.arrived, 3:])[rough.valid]
    assert np.all(np.mean(by_stencil**2, axis=0) > 25.0 * np.mean(off**2, axis=0))


def turning(af, n: int = 60, period: float = 0.1) -> tuple[Model, Recording, np.ndarray]:
    """Yaw with linear drag alone, at rest otherwise: a linear system; its noise (12,)."""
    values = dict.fromkeys(TABLE_II["AF"], 0.0) | {"X_u": -0.5, "Y_v": -0.5, "N_r": -0.6}
    noise = NOISE_LEAST.copy()
    noise[:7] = 1e-3, 2e-3, 1e-9, 1e-9, 1e-9, 0.1, 1.5
    model = replace(make_model(af, values), noise=noise_entry(noise))
    stamps = np.arange(n) * round(1e9 * period)
    rng = np.random.default_rng(4)
    eta = np.zeros((n, 3))
    eta[:, 2] = 0.3 * np.sin(0.8 * stamps * 1e-9) + 2e-3 * rng.normal(size=n)
    commands = Signal(model.vehicle.inputs, stamps, np.zeros((n, len(model.vehicle.inputs))))
    return model, make_recording("turning", stamps, eta, commands), noise


def smoothed(model: Model, recording: Recording, series: _core.Series, noise: np.ndarray):
    return _core.smoothed(filter_pass(model, recording, series, noise), series, noise, OUTLIER)


def test_the_smoother_is_that_of_rauch_tung_and_striebel(af):
    """Their recursion in its textbook form, which inverts predicted covariances."""
    model, recording, noise = turning(af)
    eta = np.ascontiguousarray(recording.eta)
    start = np.concatenate([eta[0], np.zeros(3)])
    series = _core.Series(recording.t, eta, np.ones(60, dtype=np.int8), start, np.full(3, 0.1))
    state, deviation = smoothed(model, recording, series, noise)
    drag, force, memory = 0.6, noise[5], noise[6]
    # the disturbance acts as it is at the begin of an interval, and fades
    F = expm(np.array([[0.0, 1.0, 0.0], [0.0, -drag, 1.0], [0.0, 0.0, 0.0]]) * recording.period)
    F[2, 2] = np.exp(-recording.period / memory)
    Q = np.diag([0.0, 0.0, force**2 * (1.0 - F[2, 2] ** 2)])
    x = np.array([eta[0, 2], 0.0, 0.0])
    P = np.diag([(3.0 * noise[1]) ** 2, 0.1**2, force**2])
    before, updated = [], []
    for k, psi in enumerate(recording.eta[:, 2]):
        if k:
            x, P = F @ x, F @ P @ F.T + Q
        before.append((x, P))
        gain = P[:, 0] / (P[0, 0] + noise[1] ** 2)
        x, P = x + gain * (psi - x[0]), P - np.outer(gain, P[0])
        updated.append((x, P))
    found = [updated[-1]]
    for (x, P), (ahead, A) in zip(updated[-2::-1], before[:0:-1], strict=True):
        G = P @ F.T @ np.linalg.inv(A)
        later_x, later_P = found[-1]
        found.append((x + G @ (later_x - ahead), P + G @ (later_P - A) @ G.T))
    means, covariances = (np.array(part) for part in zip(*found[::-1], strict=True))
    np.testing.assert_allclose(state[:, [2, 5, 8]], means, atol=2e-7)
    np.testing.assert_allclose(deviation[:, 2], np.sqrt(covariances[:, 1, 1]), rtol=1e-4)


def test_nothing_is_smoothed_across_a_restart(af):
    model, recording, noise = turning(af)
    use = np.ones(60, dtype=np.int8)
    use[30] = _core.USE_BEGINNING
    rest = np.zeros((60, 3))
    eta = np.ascontiguousarray(recording.eta)
    start = np.concatenate([eta[0], np.zeros(3)])
    series = _core.Series(recording.t, eta, use, start, np.full(3, 0.1), rest)
    state, deviation = smoothed(model, recording, series, noise)
    for part in (slice(0, 30), slice(30, 60)):
        own = recording.cut(float(recording.t[part][0]) - 0.01, float(recording.t[part][-1]) + 0.01)
        begin = np.concatenate([eta[part][0], np.zeros(3)])
        short = _core.Series(
            own.t, np.ascontiguousarray(own.eta), np.ones(30, dtype=np.int8), begin, np.full(3, 0.1)
        )
        alone = smoothed(model, own, short, noise)
        np.testing.assert_allclose(state[part], alone[0], atol=1e-9)
        np.testing.assert_allclose(deviation[part], alone[1], rtol=1e-5)


def test_after_a_jump_poses_say_nothing_of_where_it_was_before(af):
    """The velocity is smoothed across a jump as if there were none; the pose is not."""
    model, recording, noise = turning(af)
    eta = np.ascontiguousarray(recording.eta)
    start = np.concatenate([eta[0], np.zeros(3)])
    use = np.ones(60, dtype=np.int8)
    use[30] = _core.USE_JUMPED
    found = []
    for leap in (0.0, 2.0):
        moved = eta.copy()
        moved[30:, 0] += leap
        series = _core.Series(recording.t, moved, use, start, np.full(3, 0.1))
        found.append(smoothed(model, recording, series, noise)[0])
    apart = found[1] - found[0]
    apart[30:, 0] -= 2.0
    np.testing.assert_allclose(apart, 0.0, atol=1e-4)


def test_long_recordings_are_smoothed_chunk_by_chunk_alike(af):
    """1100 poses are three chunks; the last poses do not know how many there were before."""
    model, recording, noise = turning(af, 1100)
    late = recording.cut(40.0, None)
    whole = smoothed(model, recording, filter_series(recording), noise)
    part = smoothed(model, late, filter_series(late), noise)
    np.testing.assert_allclose(whole[0][-400:], part[0][-400:], atol=1e-6)
    np.testing.assert_allclose(whole[1][-400:, 2], part[1][-400:, 2], rtol=1e-5)


@pytest.mark.system
@pytest.mark.parametrize("sensor", ["GNSS", "SLAM"])
def test_a_right_model_expects_the_error_of_its_filters_start(af, sensor):
    """At all horizons: the filter lags behind the disturbance, so both errors are correlated."""
    boat, trial = driven(af, sensor)
    model = replace(boat, noise=noise_entry(recording_noise(boat, [trial.recording])))
    (row,) = validate(model, [trial.recording]).recordings
    assert [(h.horizon, h.start) for h in row.horizons][-1] == (5.0, "odometry")
    for found in row.horizons:
        for symbol, own in found.scores.items():
            assert own.rms == pytest.approx(own.expected_rms, rel=0.25), (found.horizon, symbol)
    assert not of_kinds(row.findings, FindingKind.EXCEEDS_EXPECTED_ERROR)


def test_a_recording_that_is_too_short_for_the_filter_has_the_stencils_scores(af):
    boat, trial = driven(af, "SLAM")
    short = trial.recording.cut(20.0, 22.5)
    found = validate(boat, [short])
    assert found.reference == "smoothed"
    assert found.recordings[0].reference == "stencil"
    assert (
        found.recordings[0].scores
        == validate(boat, [short], reference="stencil").recordings[0].scores
    )
    assert "reference: S7-AF: five-point stencil" in scores_text(found)


def test_the_text_names_the_reference_and_its_standard_error(af):
    boat, trial = driven(af, "SLAM")
    found = validate(boat, [trial.recording])
    surge = found.recordings[0].scores["u"]
    text = scores_text(found)
    assert (
        f"reference: S7-AF: smoothed velocity, standard error u {100 * surge.reference:.2g} cm/s"
        in text
    )


@pytest.mark.parametrize(
    ("resolved", "hidden", "ratio", "word"),
    [
        (0.0, True, 0.1, "very well"),
        (0.0, True, 0.6, "as well as these poses resolve"),
        (0.0, True, 1.1, "as well as these poses resolve"),
        (0.3, False, 0.6, "well"),
        (0.7, False, 0.9, "fairly"),
        (1.2, False, 1.1, "worse than no model"),
    ],
)
def test_the_verdict_is_of_what_the_poses_resolve(resolved, hidden, ratio, word):
    assert verdict.axis_word(resolved, hidden, ratio) == word


def test_the_error_beyond_the_floor_is_compared_with_constant_velocitys(af):
    """By the stencil, whose floor is most of both errors."""
    boat, trial = driven(af, "motion capture", None)
    wrong = variants(boat)["thrust"]
    found = assess(wrong, [trial.recording], 1.0, "stencil")
    runs = gather(wrong, found)
    ahead = found[0].prediction
    rms, still = (np.sqrt(np.mean(one, axis=0)) for one in (ahead.squares, ahead.constant_squares))
    expected = np.sqrt((rms**2 - ahead.floor**2) / (still**2 - ahead.floor**2))
    seen = ~at_floor(runs)
    assert seen[2]
    np.testing.assert_allclose(resolved_ratio(runs)[seen], expected[seen], rtol=1e-9)
    assert np.all(expected[seen] < (rms / still)[seen])
