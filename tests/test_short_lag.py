# SPDX-License-Identifier: MIT
"""Lags that are short, beside the steps and beside their errors."""

import numpy as np
import pytest
from survey_boat import LATENCY, driven

from seatrial.identify import output_error
from seatrial.identify.short_lag import lag_error
from seatrial.statistics import NORMAL_95

QUIET = np.array([1e-5, 1e-5, 1e-5])  # [m], [rad]


def half(rng):
    return rng.uniform(0.2, 1.0) * rng.choice([-1.0, 1.0])


def found(lag, *, noise, seed=1, seconds=100.0):
    """Constants and standard errors of a boat with this lag."""
    curve = [{"name": "all", "actuators": ["left", "right"], "lag": lag, "latency": LATENCY}]
    vehicle, recording = driven(curve, [half] * 2, noise=noise, seed=seed, seconds=seconds)
    model = output_error([recording], vehicle)
    values = dict(zip(model.vehicle.constants.names, model.constants.tolist(), strict=True))
    return values, model.standard_errors


@pytest.mark.parametrize("lag", [0.0, 0.005, 0.01, 0.03])
def test_a_lag_shorter_than_the_steps_is_found_as_it_is(lag):
    """Steps are up to 50 ms: what they lose of a lag's first moment looked like 8 ms more of it."""
    values, _ = found(lag, noise=QUIET)
    assert values["lag"] == pytest.approx(max(lag, 0.002), abs=5e-4)
    assert values["lag"] + values["latency"] == pytest.approx(lag + LATENCY, abs=2e-4)


def test_thrusters_without_a_lag_are_within_the_intervals():
    """By the curvature at the best, lag and latency were 2.8 standard errors off on average."""
    for seed in range(12):
        values, errors = found(0.0, noise=np.array([2e-3, 2e-3, 4e-3]), seed=seed)
        assert values["lag"] < 0.05
        at_bound = values["lag"] == pytest.approx(0.002)
        assert at_bound or values["lag"] < 2.01 * errors["lag"]
        assert abs(values["latency"] - LATENCY) < 2.6 * errors["latency"]


@pytest.mark.parametrize(
    ("lag", "error"), [(0.08, 0.0005), (0.08, 0.01), (0.02, 0.02), (0.003, 0.03)]
)
def test_the_error_is_that_of_the_square(lag, error):
    """Where the square's interval reaches none, so does the lag's; a long lag keeps its own error."""
    said = lag_error(lag, error)
    rng = np.random.default_rng(1)
    squares = lag**2 + 2.0 * lag * error * rng.normal(size=200_000)
    low, high = np.percentile(np.sqrt(np.maximum(squares, 0.0)), [2.5, 97.5])
    assert NORMAL_95 * said == pytest.approx(max(lag - low, high - lag), rel=0.02)
    if error < 0.01 * lag:
        assert said == pytest.approx(error, rel=0.01)
