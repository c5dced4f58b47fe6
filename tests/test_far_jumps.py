# SPDX-License-Identifier: MIT
"""Poses that jump by more than any boat goes: a sensor that says 0, 0, 0 until it has a fix, in world coordinates."""

import numpy as np
import pytest
from conftest import at_length
from survey_boat import TRUTH, as_stated, driven, past_idle

from seatrial.boat.noise_parameters import noise_vector
from seatrial.evaluation.filtering import filter_pass, filter_series
from seatrial.identification.estimator import output_error
from seatrial.recording.from_poses import make_recording

UTM = np.array([500_000.0, 5_800_000.0])  # [m]


@pytest.fixture(scope="module")
def drive():
    return driven({}, [past_idle] * 3, seconds=200.0, bow=True)


def moved(recording, poses, by):
    """The recording with these poses elsewhere."""
    eta = recording.eta.copy()
    eta[poses, :2] += by
    return make_recording(recording.name, recording.stamps, eta, recording.commands)


@pytest.mark.parametrize("seconds", [0.3, 3.0])
def test_a_log_that_begins_without_a_fix_is_identified_as_one_with(drive, seconds):
    """The leap to the first fix was an outlier to the filter, which believed it less, and all after it."""
    vehicle, recording = drive
    far = moved(recording, slice(None), UTM)
    eta = far.eta.copy()
    eta[: round(10 * seconds)] = 0.0
    model = output_error([make_recording("far", far.stamps, eta, far.commands)], vehicle)
    assert as_stated(model, TRUTH) == {}
    assert model.standard_errors["X_u"] < 0.01


@pytest.mark.parametrize("leap", [100.0, at_length(1e4), 1e6])
def test_a_jump_for_good_costs_the_same_however_far_it_is(drive, leap):
    vehicle, recording = drive
    near, far = (
        output_error([moved(recording, slice(1000, None), by)], vehicle) for by in (1.0, leap)
    )
    for name, error in near.standard_errors.items():
        if name in TRUTH:
            assert far.values[name] == pytest.approx(near.values[name], abs=0.02 * error), name
            assert far.standard_errors[name] == pytest.approx(error, rel=0.02)


@pytest.mark.parametrize("gap", [0, at_length(30)])
def test_a_jumps_cost_has_no_step_where_it_is_further_than_anywhere(drive, gap):
    """10 m; a step of the likelihood there would be met by its derivatives."""
    vehicle, recording = drive
    model = output_error([recording], vehicle)

    def cost(leap):
        eta = recording.eta.copy()
        eta[1000:, 0] += leap
        kept = np.r_[0 : 1000 - gap, 1000 : len(eta)]
        jumped = make_recording("jumped", recording.stamps[kept], eta[kept], recording.commands)
        poses, noise = filter_series(jumped), noise_vector(model.noise)
        return filter_pass(model, jumped, poses, noise).cost

    costs = [cost(leap) for leap in np.arange(8.5, 11.5, 0.05)]
    assert np.abs(np.diff(costs)).max() < 0.05
    assert cost(1000.0) == pytest.approx(costs[-1], abs=0.01)
