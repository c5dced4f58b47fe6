# SPDX-License-Identifier: MIT
"""Process noise that differs between surge and sway: a gust moves unequal masses unequally."""

import numpy as np
import pytest
from conftest import on_request
from survey_boat import as_stated

from seatrial.boat.findings import FindingKind
from seatrial.boat.model import Model
from seatrial.boat.model_file import load, save
from seatrial.boat.noise_parameters import (
    NOISE_LEAST,
    SWAY_RATIO,
    equal_in_plane,
    noise_entry,
    noise_vector,
)
from seatrial.identification.estimator import fit, output_error
from seatrial.identification.likelihood import noise_structures
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import Point
from seatrial.simulation.plan import DisturbanceForce
from seatrial.util.frames import Array
from tests.boats.hulls import CORNERS, Hull, driven, sticks

CHAIN = {"latency": 0.1, "lag": 0.12, "dead_zone": {"forward": 0.075, "reverse": 0.075}}
SLENDER = Hull(CORNERS, 8.0, (10.0, 30.0, 0.6), (4.0, 6.0, 0.35), (18.0, 30.0, 0.4))
TRUE_RATIO = 10.0 / 30.0  # equal forces on its masses


def gusty(seed: int) -> Model:
    push = DisturbanceForce(0.05, 2.0)
    vehicle, recordings = driven(SLENDER, CHAIN, seed=seed, push=push, white=4e-3, seconds=80.0)
    return output_error(recordings, vehicle)


@pytest.mark.parametrize("seed", [0, on_request(1), on_request(2)])
def test_gusts_on_unequal_masses_are_found_as_such(seed):
    """One process noise for both axes made a right model look wrong, and its sway intervals too wide."""
    model = gusty(seed)
    process = model.noise.process
    assert process.sway_ratio == pytest.approx(TRUE_RATIO, rel=0.3)  # about a hundred gusts
    assert process.disturbance_linear == pytest.approx(0.05 * SLENDER.coefficients["X_F"], rel=0.25)
    assert model.findings_of(FindingKind.MODEL_MISMATCH) == ()
    assert as_stated(model, {**SLENDER.coefficients, "latency": 0.1, "lag": 0.12}) == {}


def ahead(rng: np.random.Generator, seconds: float) -> Array:
    """Pulses of surge; the others steer."""
    return np.asarray(sticks(rng, seconds) * [1.0, 0.1, 0.1])


@pytest.mark.parametrize("seed", [2, on_request(0), on_request(1)])
def test_a_drive_ahead_in_gusts_is_no_model_mismatch(seed):
    """The process noise of surge stood for that of sway, which gusts alone move: the lag vanished (seed 2)."""
    push = DisturbanceForce(0.05, 2.0)
    vehicle, recordings = driven(
        SLENDER, CHAIN, seed=seed, push=push, white=1e-3, seconds=80.0, rate=28.0, pattern=ahead
    )
    model = output_error(recordings, vehicle)
    assert model.findings_of(FindingKind.MODEL_MISMATCH) == ()
    assert as_stated(model, {**SLENDER.coefficients, "latency": 0.1, "lag": 0.12}) == {}


def test_gusts_on_equal_masses_are_searched_no_further(monkeypatch):
    round_hull = Hull(CORNERS, 8.0, (12.0, 12.0, 0.6), (4.0, 6.0, 0.35), (18.0, 30.0, 0.4))
    push = DisturbanceForce(0.05, 2.0)
    vehicle, recordings = driven(round_hull, CHAIN, seed=0, push=push, white=4e-3, seconds=80.0)
    found = fit(recordings, vehicle)
    assert found.noise[SWAY_RATIO] == 1.0

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("another noise structure is searched")

    monkeypatch.setattr(noise_structures, "search", refused)
    at = Point(found.theta, found.noise, filter_along(found.problem, found.theta, found.noise))
    assert noise_structures.with_unequal_axes(at) is at


def test_the_model_file_keeps_the_ratio(tmp_path):
    model = gusty(0)
    save(model, tmp_path / "model.json")
    kept = load(tmp_path / "model.json").noise
    assert kept.process.sway_ratio == pytest.approx(model.noise.process.sway_ratio, rel=1e-9)
    assert noise_vector(kept)[SWAY_RATIO] == kept.process.sway_ratio


def test_an_earth_fixed_disturbance_has_no_axes_of_the_boat():
    noise = NOISE_LEAST.copy()
    noise[[4, SWAY_RATIO]] = 0.1, 0.5
    assert noise_vector(noise_entry(noise)).tolist() == noise.tolist()
    earth = noise_entry(equal_in_plane(noise), earth=True)
    assert earth.process.disturbance_linear == pytest.approx(0.1 * np.sqrt(0.5 * (1.0 + 0.25)))
    assert noise_vector(earth)[SWAY_RATIO] == 1.0
