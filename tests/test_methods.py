# SPDX-License-Identifier: MIT
"""What every method of identification keeps to."""

from dataclasses import replace

import numpy as np
import pytest
from method_trials import changed, driven

import seatrial
from seatrial.identification.methods import METHODS
from seatrial.recording.signal import Signal
from seatrial.util.errors import SeatrialError


@pytest.fixture(scope="module", params=METHODS)
def method(request) -> str:
    return request.param


@pytest.fixture(scope="module")
def trial():
    return driven("paper-like", "mallard-mp", 1)


@pytest.fixture(scope="module")
def model(method, trial):
    return seatrial.identify(trial[1], trial[0], method=method)


def test_a_model_says_how_it_came_about(method, model, trial):
    assert model.estimator.method == method
    assert [r.name for r in model.recordings] == [r.name for r in trial[1]]
    assert model.noise.position == pytest.approx(0.0007, rel=0.3)
    low, high = model.envelope.speeds["u"]
    assert -0.5 < low < -0.05 < 0.05 < high < 0.5
    assert set(model.envelope.forces) == {f.name for f in trial[0].forces}


def test_its_covariance_is_one(model):
    covariance = model.covariance
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-9, atol=0)
    size = np.sqrt(np.diag(covariance))
    known = size > 0
    assert known[: len(model.coefficients)].all()
    correlation = covariance[np.ix_(known, known)] / np.outer(size[known], size[known])
    assert np.linalg.eigvalsh(correlation).min() > -1e-8
    assert np.abs(correlation).max() < 1 + 1e-9


def test_its_signs_are_those_of_a_boat(model):
    for name in ("X_uu", "Y_vv", "N_r"):
        assert model.values[name] < 0, name
    for name in ("X_F", "Y_F", "N_F"):
        assert model.values[name] > 0, name


def test_it_is_written_and_read_back(model, tmp_path):
    seatrial.save(model, tmp_path / "m.yaml")
    loaded = seatrial.load(tmp_path / "m.yaml")
    np.testing.assert_allclose(loaded.coefficients, model.coefficients, rtol=1e-8)
    np.testing.assert_allclose(loaded.constants, model.constants, rtol=1e-8, atol=1e-12)
    assert loaded.estimator.method == model.estimator.method
    assert loaded.estimator.settings == model.estimator.settings
    assert [s.coefficients for s in loaded.estimator.steps] == [
        s.coefficients for s in model.estimator.steps
    ]


def test_twice_is_the_same(method, model, trial):
    again = seatrial.identify(trial[1], trial[0], method=method)
    np.testing.assert_array_equal(again.coefficients, model.coefficients)
    np.testing.assert_array_equal(again.covariance, model.covariance)


def test_where_the_map_has_its_origin_and_north_is_no_matter(method, model, trial):
    turn = 2.0  # [rad]
    c, s = np.cos(turn), np.sin(turn)
    moved = []
    for r in trial[1]:
        eta = r.raw.copy()
        eta[:, :2] = eta[:, :2] @ np.array([[c, s], [-s, c]]) + [30.0, -20.0]
        eta[:, 2] += turn
        moved.append(changed(r, eta))
    found = seatrial.identify(moved, trial[0], method=method)
    error = np.array([model.standard_errors[n] for n in model.parameters])
    both = [np.concatenate([m.coefficients, m.constants]) for m in (found, model)]
    assert np.all(np.abs(both[0] - both[1]) <= 0.05 * error + 1e-9)


def test_an_axis_that_was_never_driven_is_refused_in_words(method, trial):
    vehicle, recordings = trial
    dead = [
        replace(
            r, commands=Signal(vehicle.inputs, r.commands.stamps, r.commands.values * [1, 1, 0])
        )
        for r in recordings
    ]
    with pytest.raises(SeatrialError, match=r"yaw .*(drive|excited)"):
        seatrial.identify(dead, vehicle, method=method)


def test_a_recording_that_is_too_short_is_refused_in_words(method, trial):
    vehicle, recordings = trial
    with pytest.raises(SeatrialError, match=r"S1-MP, S2-MP, S3-MP: 8.8 s in all is too short"):
        seatrial.identify([r.cut(30, 33) for r in recordings], vehicle, method=method)


@pytest.mark.parametrize("method", ["weak-form", "smoother"])
def test_a_recording_without_poses_in_a_row_beside_good_ones_tells_nothing(method, mp, clean_mp):
    """Half of its poses are missing, three of six: there is no second of it to look at."""
    *good, more = (clean_mp[s].recording.cut(0.0, 120.0) for s in ("S1", "S2", "S3", "S4"))
    valid = more.valid & (np.arange(len(more.t)) % 6 < 3)
    gappy = replace(more, name="gappy", valid=valid, segment=np.arange(len(valid)) // 6)
    alone, beside = (seatrial.identify(r, mp, method=method) for r in (good, [*good, gappy]))
    for name, value in alone.values.items():
        assert beside.values[name] == pytest.approx(value, abs=0.02 * abs(value) + 0.01), name
