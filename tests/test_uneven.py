# SPDX-License-Identifier: MIT
"""Poses at any stamps: at random, of two trackers, half of them lost."""

import numpy as np
import pytest
from survey_boat import LAG, LATENCY, NOISE, TRUTH, as_stated, driven

from seatrial.causal import causal
from seatrial.identify.output_error import output_error
from seatrial.noise import pose_noise

KNOWN = {n: x for n, x in TRUTH.items() if n not in ("Y_F", "N_b")}
STAMPS = {
    "at random": lambda rng, seconds: np.sort(rng.uniform(0.0, seconds, int(15 * seconds))),
    "shaken": lambda rng, seconds: (np.arange(15 * seconds) + rng.uniform(0.01, 0.99, int(15 * seconds))) / 15.0,
    "two trackers": lambda rng, seconds: np.sort(
        np.concatenate([np.arange(0.0, seconds, 0.2), np.arange(0.011, seconds, 0.33)])
    ),
    "half lost": lambda rng, seconds: np.arange(15 * seconds)[rng.random(int(15 * seconds)) < 0.5] / 15.0,
    "most lost": lambda rng, seconds: np.arange(15 * seconds)[rng.random(int(15 * seconds)) < 0.2] / 15.0,
}  # fmt: skip


def both(rng):
    return rng.uniform(-1.0, 1.0)


@pytest.mark.parametrize("stamps", STAMPS.values(), ids=STAMPS)
def test_the_boat_is_found_whatever_the_stamps(stamps):
    vehicle, recording = driven({}, [both, both], stamps=stamps)
    assert recording.usable == 1.0
    model = output_error([recording], vehicle)
    assert not as_stated(model, {**KNOWN, "lag": LAG, "latency": LATENCY})
    assert model.standard_errors["X_u"] < 0.001
    assert model.noise.position == pytest.approx(NOISE[0], rel=0.05)
    top = max(abs(x) for x in model.envelope.speeds["u"])
    assert top < 1.0  # what its velocities by differences say is not noise
    assert causal(model, recording).motion.valid[recording.t > 2.1].all()


@pytest.mark.parametrize("stamps", STAMPS.values(), ids=STAMPS)
def test_noise_is_found_whatever_the_stamps(stamps):
    _, recording = driven({}, [both, both], stamps=stamps, seconds=120.0)
    found = pose_noise(recording)
    assert found.position == pytest.approx(NOISE[0], rel=0.4)  # a guess: motion over gaps is in it
    assert found.heading == pytest.approx(NOISE[2], rel=0.6)
