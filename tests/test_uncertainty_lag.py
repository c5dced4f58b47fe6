# SPDX-License-Identifier: MIT
"""Lags that are short, beside the steps and beside their errors."""

import numpy as np
import pytest
from survey_boat import LATENCY, driven, past_idle

from seatrial.identification.estimator import output_error
from seatrial.identification.uncertainty.covariance import lag_error
from seatrial.util.statistics import NORMAL_95

QUIET = np.array([1e-5, 1e-5, 1e-5])  # [m], [rad]


def found(lag, *, noise, seed=1, seconds=100.0):
    """Constants and standard errors of a boat with this lag."""
    curve = [{"name": "all", "actuators": ["left", "right"], "lag": lag, "latency": LATENCY}]
    vehicle, recording = driven(curve, [past_idle] * 2, noise=noise, seed=seed, seconds=seconds)
    model = output_error([recording], vehicle)
    values = dict(zip(model.vehicle.constants.names, model.constants.tolist(), strict=True))
    return values, model.standard_errors


@pytest.mark.parametrize("lag", [0.0, 0.005, 0.01, 0.03])
def test_a_lag_shorter_than_the_steps_is_found_as_it_is(lag):
    """Steps are up to 50 ms: what they lose of a lag's first moment looked like 8 ms more of it."""
    values, _ = found(lag, noise=QUIET)
    assert values["lag"] == pytest.approx(max(lag, 0.002), abs=5e-4)
    assert values["lag"] + values["latency"] == pytest.approx(lag + LATENCY, abs=2e-4)


@pytest.mark.system
def test_thrusters_without_a_lag_are_within_the_intervals():
    """By the curvature at the best, lag and latency were 2.8 standard errors off on average."""
    for seed in range(12):
        values, errors = found(0.0, noise=np.array([2e-3, 2e-3, 4e-3]), seed=seed)
        assert values["lag"] < 0.05
        at_bound = values["lag"] == pytest.approx(0.002)
        assert at_bound or values["lag"] < 2.01 * errors["lag"]
        assert abs(values["latency"] - LATENCY) < 2.6 * errors["latency"]


@pytest.mark.parametrize("lag", [0.0, 0.3, 0.5, 0.7, 1.0, 1.2, 1.5, 2.0, 3.0, 5.0, 8.0])
def test_intervals_hold_the_truth_however_short_the_lag(lag):
    """Squares of standard deviation 1, as good as it is known everywhere."""
    squares = lag**2 + np.random.default_rng(1).normal(size=20_000)
    found = np.sqrt(np.maximum(squares, 1e-6))
    errors = np.array([lag_error(one, 0.5 / one) for one in found.tolist()])
    assert 0.935 < np.mean(np.abs(found - lag) <= NORMAL_95 * errors) < 0.98


def test_a_lag_whose_squares_interval_reaches_none_reaches_none():
    for lag, error in [(0.02, 0.02), (0.003, 0.03)]:
        assert NORMAL_95 * lag_error(lag, error) >= lag
    assert lag_error(0.08, 0.0005) == pytest.approx(0.0005, rel=0.01)
