# SPDX-License-Identifier: MIT
"""How noisy the stencil's velocities are said to be, against noise that was made."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from test_recording import COMMANDS

from seatrial.boat.schema import CorrelatedEntry, NoiseEntry
from seatrial.recording.from_poses import make_recording
from seatrial.recording.pose_noise import pose_error_correlation
from seatrial.recording.recording import Recording
from seatrial.recording.stencil_noise import StencilNoise
from seatrial.recording.velocity import five_point_stencil

PERIOD = 0.1  # [s]
SHORT = CorrelatedEntry(0.004, 0.003, 0.3)
SWINGING = CorrelatedEntry(0.01, 0.02, 4.0, 1.7)
OVERDAMPED = CorrelatedEntry(0.01, 0.02, 0.2, 3.0)


def noisy(entry: CorrelatedEntry, white: float, seed: int, n: int = 40000) -> Recording:
    """A boat at rest: white errors of the poses, and such as are correlated as stated (by its spectrum)."""
    rng = np.random.default_rng(seed)
    lags = PERIOD * np.minimum(np.arange(n), n - np.arange(n))
    gain = np.sqrt(np.maximum(np.fft.rfft(pose_error_correlation(entry, lags)).real, 0.0))
    size = [entry.position, entry.position, entry.heading]
    together = np.fft.irfft(np.fft.rfft(rng.normal(size=(n, 3)), axis=0) * gain[:, None], n, axis=0)
    eta = together * size + white * rng.normal(size=(n, 3))
    return make_recording("noise", np.rint(1e9 * PERIOD * np.arange(n)).astype(int), eta, COMMANDS)


@pytest.mark.parametrize("entry", [SHORT, SWINGING, OVERDAMPED])
def test_what_is_left_of_errors_is_the_oscillators_correlation(entry):
    """By its differential equation: the correlation obeys it, from 1 with slope 0, or fades alone."""
    t = np.linspace(0.0, 3.0, 31)
    assert np.all(np.isfinite(pose_error_correlation(entry, np.array([1e3, 1e6]))))
    if entry.period is None:
        np.testing.assert_allclose(pose_error_correlation(entry, t), np.exp(-t / entry.memory))
        return
    square = (2.0 * np.pi / entry.period) ** 2
    found = solve_ivp(
        lambda _, y: [y[1], -2.0 / entry.memory * y[1] - square * y[0]],
        (0.0, 3.0), [1.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-10,
    )  # fmt: skip
    np.testing.assert_allclose(pose_error_correlation(entry, t), found.y[0], atol=1e-6)


@pytest.mark.parametrize("entry", [SHORT, SWINGING, OVERDAMPED])
def test_stencils_have_in_common_what_is_said(entry):
    recordings = [noisy(entry, 0.002, seed) for seed in range(4)]
    said = StencilNoise(NoiseEntry(0.002, 0.002, None, entry), recordings[0])
    variance = said.covariance(0)
    for steps in (0, 1, 2, 3, 4, 6, 10, 17):
        found = []
        for recording in recordings:
            slope, valid = five_point_stencil(recording)
            slope = slope[valid]
            found.append(np.mean(slope[: len(slope) - steps] * slope[steps:], axis=0))
        np.testing.assert_allclose(
            said.covariance(steps) / variance, np.mean(found, axis=0) / variance, atol=0.04
        )


def test_a_recordings_own_noise_is_parted_as_stated():
    """Fourth differences see part of what is correlated; the rest follows from the proportion."""
    recording = noisy(SHORT, 0.002, 9)
    stated = NoiseEntry(0.001, 0.001, None, CorrelatedEntry(0.002, 0.0015, SHORT.memory))
    noise = StencilNoise.of(recording, stated).noise  # the same proportion, twice as large
    assert noise.position == pytest.approx(0.002, rel=0.05)
    assert noise.heading == pytest.approx(0.002, rel=0.05)
    assert noise.correlated.position == pytest.approx(0.004, rel=0.05)
    assert noise.correlated.heading == pytest.approx(0.003, rel=0.05)


def test_what_states_no_noise_at_all_takes_the_recordings_as_white():
    recording = noisy(SHORT, 0.002, 9)
    noise = StencilNoise.of(recording, NoiseEntry(0.0, 0.0, None, CorrelatedEntry(0.0, 0.0, 0.3)))
    assert noise.noise.position > 0.002
    assert noise.noise.correlated.position == 0.0
