# SPDX-License-Identifier: MIT
"""Where the estimator's filter begins: at poses that are noisy, or not usable, while the boat moves."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import all_values, at_length, on_request
from survey_boat import LAG, LATENCY, TRUTH, as_stated, both, driven, even

import seatrial
from seatrial.evaluation.filtering import run_filter
from seatrial.identification.estimator import output_error
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal

KNOWN = {n: x for n, x in TRUTH.items() if n not in ("Y_F", "N_b")}
CHAIN = {"lag": LAG, "latency": LATENCY}


@pytest.mark.parametrize("seed", [1, on_request(2), on_request(3)])
def test_a_start_velocity_from_noisy_poses_is_as_uncertain_as_they_are(seed):
    """0.1 m at 20 Hz: the stencil's velocity is off by 1.9 m/s, three times what the boat can go."""
    noise = np.array([0.1, 0.1, 0.05])
    vehicle, recording = driven(
        {}, [both, both], seconds=200.0, seed=seed, stamps=even(20.0), noise=noise
    )
    model = output_error([recording], vehicle)
    assert not as_stated(model, {**KNOWN, **CHAIN}, 4.0)
    assert model.standard_errors["X_u"] < 0.03
    process = model.noise.process
    assert max(process.walk_linear, process.disturbance_linear) < 2e-3
    assert model.noise.position == pytest.approx(0.1, rel=0.05)


@pytest.fixture(scope="module")
def moving():
    """A recording whose first 20 s are gone, and what is found from it."""
    vehicle, recording = driven({}, [both, both], seconds=200.0, seed=5)
    late = recording.cut(20.0, 200.0)
    return vehicle, recording, output_error([late], vehicle)


def unusable(r):
    return make_recording(r.name, r.stamps, r.eta, r.commands, marked_valid=r.t >= 20.0)


def without_commands(r):
    c = r.commands
    kept = r.seconds(c.stamps) >= 20.0
    return make_recording(r.name, r.stamps, r.eta, Signal(c.names, c.stamps[kept], c.values[kept]))


@pytest.mark.parametrize("begun", [unusable, without_commands])
def test_what_is_not_known_of_the_beginning_costs_no_more_than_that(moving, begun):
    vehicle, recording, late = moving
    model = output_error([begun(recording)], vehicle)
    assert not as_stated(model, {**KNOWN, **CHAIN})
    assert model.noise.process.disturbance_yaw < 1e-3
    assert dict(model.standard_errors).keys() == dict(late.standard_errors).keys()
    for name, error in late.standard_errors.items():
        known = model.standard_errors[name]
        assert known < 1.3 * error or known == error == 0.0, name  # an edge at its bound has none


def test_the_filter_says_nothing_before_it_knows(moving):
    _, recording, late = moving
    seen = run_filter(late, unusable(recording)).motion
    assert not seen.valid[recording.t < 22.0].any()
    assert seen.valid[recording.t > 22.5].all()


def test_few_seconds_beside_a_prior_are_not_surer_than_they_can_be():
    """Five blocks' scatter is chance: errors are no smaller than the information has them."""
    edge = 0.1
    zone = {"dead_zone": {"forward": edge, "reverse": edge}}
    truth = {**KNOWN, **CHAIN, "edge_forward": edge, "edge_reverse": edge}
    vehicle, long = driven(zone, [both, both], seconds=300.0, seed=100)
    before = output_error([long], vehicle)
    off = []
    for seed in range(12):
        _, short = driven(zone, [both, both], seconds=20.0, seed=seed)
        model = seatrial.identify([short], vehicle, prior=before)
        got = all_values(model)
        off += [(got[n] - x) / model.standard_errors[n] for n, x in truth.items()]
    assert np.sqrt(np.mean(np.square(off))) < 1.2  # 1.33 by the blocks' scatter alone
    assert np.mean(np.abs(off) > 1.96) < 0.1


@pytest.mark.parametrize("seconds", [0.15, at_length(0.35), on_request(0.6)])  # 3, 6 and 9 poses
def test_a_recording_of_few_poses_beside_long_ones_changes_nothing(mp, paper_mp, seconds):
    """They are fewer than the lags at which errors are looked through for a pattern."""
    long = [paper_mp[name].recording for name in ("S1", "S2", "S3")]
    short = replace(paper_mp["S6"].recording.cut(50.0, 50.0 + seconds), name="short")
    alone, beside = (seatrial.identify(recordings, mp) for recordings in (long, [*long, short]))
    errors = np.sqrt(np.diag(alone.covariance))[: len(alone.coefficients)]
    assert (np.abs(beside.coefficients - alone.coefficients) < 0.3 * errors).all()
