# SPDX-License-Identifier: MIT
"""The five-point stencil: its weights, its exactness, its noise."""

from gc import collect
from weakref import ref

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_recording import COMMANDS

from seatrial.boat.schema import NoiseEntry
from seatrial.recording.from_poses import make_recording
from seatrial.recording.velocity import (
    STENCIL_NOISE,
    five_point_stencil,
    motion,
    stencil_deviation,
    stencil_weights,
)


def test_even_stamps_give_the_textbook_weights():
    h = 1 / 15
    got = stencil_weights(np.arange(5)[None] * h)[0]
    np.testing.assert_allclose(got, np.array([1, -8, 0, 8, -1]) / (12 * h), atol=1e-9)


@given(
    st.lists(st.floats(0.3, 1.0), min_size=4, max_size=4),
    st.lists(st.floats(-2, 2), min_size=5, max_size=5),
)
def test_quartics_are_differentiated_exactly_at_uneven_stamps(steps, coefficients):
    t = np.concatenate([[0.0], np.cumsum(steps)])[None]
    p = np.polynomial.Polynomial(coefficients)
    got = np.sum(stencil_weights(t) * p(t))
    assert got == pytest.approx(p.deriv()(t[0, 2]), abs=1e-9)


def test_white_pose_noise_becomes_velocity_noise_of_095_sigma_over_dt():
    assert pytest.approx(0.95, abs=0.001) == STENCIL_NOISE
    rng = np.random.default_rng(0)
    t = np.rint(np.arange(20000) / 15 * 1e9).astype(np.int64)
    eta = rng.normal(0, 0.002, (20000, 3))
    eta[:, 2] = 0.0
    record = make_recording("noise", t, eta, COMMANDS)
    eta_dot, valid = five_point_stencil(record)
    assert eta_dot[valid][:, :2].std() == pytest.approx(STENCIL_NOISE * 0.002 * 15, rel=0.02)


def test_body_velocity_is_the_earth_velocity_turned_by_the_heading(paper_af, clean_af):
    trial = clean_af["S7"]
    got, true = motion(trial.recording), trial.true_motion
    errors = (got.nu - true.nu)[got.valid]
    # what is left is the stencil's own truncation where thrusters switch
    assert np.sqrt(np.mean(errors**2, axis=0)) == pytest.approx([0, 0, 0], abs=2e-3)


@pytest.mark.parametrize("jitter", [0.0, 0.1, 0.25])
def test_the_stencils_deviation_is_that_of_its_velocities_at_stamps_as_they_are(jitter):
    """Where stamps come close together the derivative is far noisier than at even ones."""
    rng = np.random.default_rng(8)
    t = np.arange(0.0, 400.0, 0.1)
    t = t + 0.1 * np.clip(rng.normal(0.0, jitter, len(t)), -0.45, 0.45)
    noise = rng.normal(size=(len(t), 3)) * [0.003, 0.003, 0.002]
    stamps = np.rint(1e9 * t).astype(np.int64)
    recording = make_recording("noise", stamps, noise, COMMANDS)
    found, valid = five_point_stencil(recording)
    said = stencil_deviation(NoiseEntry(0.003, 0.002), recording)
    np.testing.assert_allclose(said, found[valid].std(axis=0), rtol=0.05)


def test_velocities_are_computed_once_and_live_as_long_as_their_recording(clean_af):
    """They are read-only: who gets them has the same arrays as others."""
    own = clean_af["S1"].recording.cut(0.0, 20.0)
    found = motion(own)
    assert motion(own) is found
    assert not (found.nu.flags.writeable or found.valid.flags.writeable)
    assert motion(clean_af["S1"].recording.cut(0.0, 10.0)) is not found
    left = ref(found)
    del own, found
    collect()
    assert left() is None
