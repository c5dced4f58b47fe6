# SPDX-License-Identifier: MIT
"""Poses at any stamps: at random, of two trackers, half of them lost."""

import numpy as np
import pytest
from survey_boat import LAG, LATENCY, NOISE, TRUTH, as_stated, both, driven

from seatrial.evaluation.filtering import run_filter
from seatrial.identification.estimator import output_error
from seatrial.recording.from_poses import make_recording
from seatrial.recording.pose_noise import pose_noise
from seatrial.util.errors import SeatrialError

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


@pytest.mark.parametrize("stamps", STAMPS.values(), ids=STAMPS)
def test_the_boat_is_found_whatever_the_stamps(stamps):
    vehicle, recording = driven({}, [both, both], stamps=stamps)
    assert (
        recording.usable > 0.99
    )  # a jump is hardly told from noise where poses are close together
    model = output_error([recording], vehicle)
    assert not as_stated(model, {**KNOWN, "lag": LAG, "latency": LATENCY})
    assert model.standard_errors["X_u"] < 0.001
    assert model.noise.position == pytest.approx(NOISE[0], rel=0.05)
    top = max(abs(x) for x in model.envelope.speeds["u"])
    assert top < 1.0  # what its velocities by differences say is not noise
    assert run_filter(model, recording).motion.valid[recording.t > 2.1].mean() > 0.99


@pytest.mark.parametrize("stamps", STAMPS.values(), ids=STAMPS)
def test_noise_is_found_whatever_the_stamps(stamps):
    _, recording = driven({}, [both, both], stamps=stamps, seconds=120.0)
    found = pose_noise(recording)
    assert found.position == pytest.approx(NOISE[0], rel=0.4)  # a guess: motion over gaps is in it
    assert found.heading == pytest.approx(NOISE[2], rel=0.6)


@pytest.mark.parametrize("offsets", [(0.0, 0.01), (0.0, 0.01, 0.04)])
def test_poses_that_come_in_twos_and_threes_are_refused_in_words(offsets):
    """Velocities by differences of poses that are hundredths of a second apart are noise."""

    def stamps(rng, seconds):
        return np.sort(np.concatenate([np.arange(o, seconds, 0.1) for o in offsets]))

    vehicle, recording = driven({}, [both, both], stamps=stamps, seconds=150.0)
    with pytest.raises(SeatrialError, match="no five usable poses in a row"):
        output_error([recording], vehicle)
    thinned = make_recording(
        "thinned",
        recording.stamps[:: len(offsets)],
        recording.eta[:: len(offsets)],
        recording.commands,
    )
    model = output_error([thinned], vehicle)
    assert not as_stated(model, {**KNOWN, "lag": LAG, "latency": LATENCY})


@pytest.mark.parametrize("stamps", ["at random", "half lost"])
def test_false_matches_are_left_out_whatever_the_stamps(stamps):
    vehicle, recording = driven({}, [both, both], stamps=STAMPS[stamps], seconds=150.0)
    rng, eta = np.random.default_rng(3), np.array(recording.raw)
    off = rng.choice(np.arange(5, len(eta) - 5), len(eta) // 50, replace=False)
    way = rng.uniform(0.0, 2.0 * np.pi, len(off))
    eta[off, :2] += 0.3 * np.column_stack([np.cos(way), np.sin(way)])
    spoilt = make_recording("spoilt", recording.stamps, eta, recording.commands)
    model = output_error([spoilt], vehicle)
    assert not as_stated(model, {**KNOWN, "lag": LAG, "latency": LATENCY})
    assert model.standard_errors["X_u"] < 0.001
