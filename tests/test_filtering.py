# SPDX-License-Identifier: MIT
"""Velocities from the model's filter against the truth of simulated trials, and against causality."""

from dataclasses import replace

import numpy as np
import pytest

from seatrial.boat.noise_parameters import NOISE_LEAST, noise_entry, noise_vector
from seatrial.boat.schema import CorrelatedEntry, Integration, NoiseEntry, ProcessEntry
from seatrial.evaluation.filtering import filter_noise, run_filter
from seatrial.recording.from_poses import make_recording
from seatrial.recording.velocity import motion
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import ModelError
from tests.boats.plans import planned


def one_trial(preset, vehicle, duration):
    """S7 with exact clocks: the plan's plant is the whole truth."""
    exact = {"pose": {"stamp_jitter": 0.0}, "joypad": {"clock_offset": 0.0}}
    return next(iter(simulate(planned(preset, "S7", seconds=duration, **exact), vehicle)))


@pytest.fixture(scope="module")
def trial(mp):
    """With 4 mm and 4 mrad of noise."""
    return one_trial("hard", mp, 100.0)


@pytest.fixture(scope="module")
def truth(mp):
    return replace(
        plant_model(load_plan("hard"), mp), integration=Integration("runge-kutta", 1 / 60)
    )


@pytest.fixture(scope="module")
def noise(truth, trial):
    return filter_noise(truth, [trial.recording])


def test_the_filter_is_as_good_as_it_says_and_better_than_the_stencil(truth, trial, noise):
    got = run_filter(truth, trial.recording, noise).motion
    stencil = motion(trial.recording)
    use = got.valid & stencil.valid & (trial.recording.t > 5.0)
    errors = np.sqrt(np.mean((got.nu - trial.true_motion.nu)[use] ** 2, axis=0))
    said = np.sqrt(np.mean(got.deviation[use] ** 2, axis=0))
    raw = np.sqrt(np.mean((stencil.nu - trial.true_motion.nu)[use] ** 2, axis=0))
    assert np.all(errors < 2.0 * said)
    assert np.all(errors < 0.2 * raw)


def test_the_noise_of_the_poses_is_found_with_the_model_held_fixed(noise):
    np.testing.assert_allclose(noise[:2], [4e-3, 4e-3], rtol=0.07)


def test_what_comes_later_changes_nothing(truth, trial, noise):
    record = trial.recording
    late, shift = record.t > 50.0, np.array([0.1, -0.2, 0.05])
    pose = np.where(late[:, None], trial.pose + shift, trial.pose)
    other = make_recording("later", trial.pose_stamps, pose, record.commands)
    a, b = run_filter(truth, record, noise).motion, run_filter(truth, other, noise).motion
    np.testing.assert_array_equal(a.nu[~late], b.nu[~late])
    assert not np.allclose(a.eta[late][:, :2], b.eta[late][:, :2], atol=0.01, equal_nan=True)


def test_the_residuals_of_the_true_model_are_white_and_of_size_one(truth, trial, noise):
    got = run_filter(truth, trial.recording, noise).residual[trial.recording.t > 5.0]
    e = got[np.isfinite(got).all(axis=1)]
    np.testing.assert_allclose(e.std(axis=0), 1.0, atol=0.1)
    neighbours = np.array([np.corrcoef(x[1:], x[:-1])[0, 1] for x in e.T])
    assert np.abs(neighbours).max() < 4 / np.sqrt(len(e))


def test_a_models_own_process_noise_is_believed(truth, trial):
    process = ProcessEntry(0.01, 0.02, 0.03, 0.04, 5.0)
    model = replace(truth, noise=NoiseEntry(0.002, 0.003, process))
    assert noise_vector(truth.noise) is None
    own = [0.002, 0.003, 0.01, 0.02, 0.03, 0.04, 5.0]
    white = filter_noise(model, [trial.recording])
    assert white.tolist() == [*own, *NOISE_LEAST[7:]]
    assert noise_entry(white) == model.noise
    coloured = replace(
        model, noise=NoiseEntry(0.002, 0.003, process, CorrelatedEntry(0.004, 0.005, 0.3))
    )
    noise = filter_noise(coloured, [trial.recording])
    assert noise.tolist() == [*own, 0.004, 0.005, 0.3, *NOISE_LEAST[10:]]
    assert noise_entry(noise) == coloured.noise


def test_a_model_that_diverges_is_refused(truth, trial, noise):
    names = truth.structure.coefficients
    wild = truth.coefficients.copy()
    wild[names.index("X_uu")] = 4000.0
    with pytest.raises(ModelError, match="diverges in its own filter"):
        run_filter(replace(truth, coefficients=wild), trial.recording, noise)
