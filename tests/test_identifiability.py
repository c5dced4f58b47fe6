# SPDX-License-Identifier: MIT
"""Verdicts in words, and combinations that are known better than their parts."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import in_coarse_steps, make_model
from survey_boat import TRUTH, boat

import seatrial
from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.schema import ChainGroup, DeadZone, EnvelopeEntry
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.uncertainty.identifiability import condition, identifiability
from seatrial.identification.uncertainty.parameter_verdict import (
    ParameterVerdict,
    full_thrust,
    reach_text,
)
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.format import percent

ENVELOPE = {"u": (-0.2, 0.3), "v": (-0.3, 0.3), "r": (-1.0, 1.5)}
FORCES = dict.fromkeys(("F_u", "F_v", "F_r"), (-1.0, 1.0))


@pytest.fixture(scope="module")
def plant():
    vehicle = seatrial.load_vehicle("mallard-mp")
    chain = ChainGroup(latency=0.02, lag=0.08, dead_zone=DeadZone(0.08, 0.08))
    whole = vehicle.with_chain([chain])
    return replace(
        in_coarse_steps(plant_model(load_plan("clean"), vehicle)),
        vehicle=whole, constants=whole.constants.values, covariance=np.zeros((11, 11)),
        envelope=EnvelopeEntry(ENVELOPE, FORCES),
    )  # fmt: skip


def with_covariance(model, names, covariance):
    """The model with this covariance of the named parameters; all others are given."""
    whole = np.zeros((len(model.parameters),) * 2)
    places = [model.parameters.index(name) for name in names]
    whole[np.ix_(places, places)] = covariance
    return replace(model, covariance=whole)


@pytest.mark.parametrize(
    ("name", "error", "verdict"),
    [
        ("X_u", 0.009, ParameterVerdict.SHARP),  # of -0.2
        ("X_u", 0.03, ParameterVerdict.USABLE),
        ("X_u", 0.06, ParameterVerdict.WEAK),
        ("X_u", 0.11, ParameterVerdict.ZERO),
        (
            "X_u",
            0.6,
            ParameterVerdict.LOST,
        ),  # 0.6 * 0.3 m/s is more than full thrust gives, 0.14 m/s^2
        ("X_u", 0.0, ParameterVerdict.GIVEN),
        (
            "latency",
            0.004,
            ParameterVerdict.SHARP,
        ),  # of 0.1 s, although the latency itself is 0.02 s
        ("latency", 0.03, ParameterVerdict.WEAK),
        ("lag", 0.2, ParameterVerdict.LOST),
    ],
)
def test_the_verdict_goes_by_the_relative_error(name, error, verdict, plant):
    found = identifiability(with_covariance(plant, [name], [[error**2]]))[name]
    assert found.verdict is verdict
    assert found.error == pytest.approx(error)
    assert found.verdict.reliable == (
        verdict in (ParameterVerdict.SHARP, ParameterVerdict.USABLE, ParameterVerdict.GIVEN)
    )


def test_what_ended_at_a_bound_is_not_called_given(plant):
    ended = [finding_of(FindingKind.AT_BOUND, "X_uu", bound=0.0)]
    held = replace(plant, estimator=msgspec.structs.replace(plant.estimator, findings=ended))
    found = identifiability(with_covariance(held, ["X_u"], [[1e-4]]))
    assert found["X_uu"].verdict is ParameterVerdict.BOUND
    assert found["Y_v"].verdict is ParameterVerdict.GIVEN
    assert not ParameterVerdict.BOUND.reliable
    assert [v for v in ParameterVerdict if not v.estimated] == [
        ParameterVerdict.GIVEN,
        ParameterVerdict.BOUND,
    ]


def test_a_moment_that_pushes_sideways_is_no_thrust_in_sway():
    """A boat with two thrusters: its sway terms are compared with full thrust in surge, not with themselves."""
    vehicle = boat()
    content = vehicle.to_mapping()
    content["structure"]["sway"] = [*content["structure"]["sway"], "Y_Fr * F_r"]
    vehicle = vehicle_from(content, "twin")
    model = make_model(vehicle, TRUTH | {"Y_Fr": 0.02})
    ranges = {"u": (-0.4, 0.5), "v": (-0.2, 0.2), "r": (-1.0, 1.0)}
    model = replace(model, envelope=EnvelopeEntry(ranges, {"F_u": (-1.0, 1.0), "F_r": (-0.9, 1.0)}))
    found = identifiability(
        with_covariance(model, ["Y_Fr", "Y_v", "N_r"], np.diag([0.0004, 0.09, 0.25]))
    )
    assert full_thrust(model, 1) == 0.02 and full_thrust(model, 1, along=True) == 0.0
    of_surge = {"Y_Fr": (0.02 + 2 * 0.02) * 1.0 / 0.5, "Y_v": (0.4 + 2 * 0.3) * 0.2 / 0.5}
    for name, share in of_surge.items():
        assert found[name].verdict is ParameterVerdict.ZERO
        assert found[name].reach == pytest.approx(share)
        assert reach_text(found[name]) == f"at most {percent(share)} of full thrust in surge"
    assert found["N_r"].thrust_axis == ""
    assert reach_text(found["N_r"]) == f"at most {percent((0.8 + 1.0) / 1.5)} of full thrust"
    assert reach_text(found["X_F"]) == ""  # given


def test_what_is_not_told_from_zero_is_bounded_in_terms_of_full_thrust(plant):
    """X_uu (-1.74 +- 1) at 0.3 m/s: at most 3.74 * 0.09 m/s^2 out of 0.14."""
    found = identifiability(with_covariance(plant, ["X_uu"], [[1.0]]))["X_uu"]
    assert found.verdict is ParameterVerdict.ZERO
    assert full_thrust(plant, 0) == pytest.approx(plant.values["X_F"])
    assert found.reach == pytest.approx((1.74 + 2.0) * 0.09 / plant.values["X_F"])


def test_condition_number_of_equally_correlated_parameters():
    """Eigenvalues are 1 + (p - 1) rho and 1 - rho."""
    p, rho = 5, 0.7
    matrix = np.full((p, p), rho) + (1 - rho) * np.eye(p)
    assert condition(matrix) == pytest.approx((1 + (p - 1) * rho) / (1 - rho))
    assert condition(np.ones((2, 2))) == np.inf
    assert condition(np.zeros((0, 0))) == 1.0


def test_of_lag_and_latency_the_sum_is_reported(plant):
    """Sum 2 ms, difference 100 ms: they are independent, so the variances are halved sums."""
    sigma, delta = 0.002, 0.1
    same, cross = (sigma**2 + delta**2) / 4, (sigma**2 - delta**2) / 4
    model = with_covariance(plant, ["latency", "lag"], [[same, cross], [cross, same]])
    found = identifiability(model)
    assert not found["lag"].verdict.reliable
    assert found["lag"].partners[0] == ("latency", pytest.approx(cross / same))
    (only,) = found.combinations
    assert set(only.names) == {"lag", "latency"}
    assert only.text == "their sum"
    assert (only.value, only.error) == pytest.approx((0.1, sigma))
    assert only.verdict is ParameterVerdict.SHARP
    assert only.correlation < -0.99


def test_of_drag_driven_at_one_speed_the_drag_at_that_speed_is_reported(plant):
    """A regression on speeds about 0.25 m/s: its covariance is sigma^2 / (B'B)."""
    u = np.random.default_rng(5).normal(0.25, 0.02, 400)
    B, sigma = np.column_stack([u, u * np.abs(u)]), 0.03
    covariance = sigma**2 * np.linalg.inv(B.T @ B)
    found = identifiability(with_covariance(plant, ["X_u", "X_uu"], covariance))
    assert not found["X_u"].verdict.reliable
    (only,) = found.combinations
    assert only.names == ("X_u", "X_uu")
    assert only.text == "the drag at 0.25 m/s, X_u + 0.25 X_uu,"
    assert only.value == pytest.approx(-0.2 - 0.25 * 1.74)
    # the mean acceleration of n samples is known to sigma / sqrt(n), the drag is that over speed
    assert only.error == pytest.approx(sigma / np.sqrt(400) / 0.25, rel=0.05)
    assert only.verdict is ParameterVerdict.SHARP


def test_three_weak_parameters_of_which_one_sum_is_sharp(plant):
    rng = np.random.default_rng(2)
    names, sharp = ["N_r", "N_rr", "N_uu"], np.array([1.0, 0.8, 0.5])
    away = np.linalg.svd(sharp[None])[2][1:]
    draws = rng.normal(0, 0.4, (4000, 2)) @ away + rng.normal(0, 0.005, (4000, 1)) * sharp
    found = identifiability(with_covariance(plant, names, np.cov(draws.T)))
    (only,) = found.combinations
    assert set(only.names) == set(names)
    order = [names.index(n) for n in only.names]
    weights = sharp[order] / sharp[order[0]]
    true = float(weights @ [plant.values[n] for n in only.names])
    assert only.value == pytest.approx(true, abs=0.05)
    assert only.error == pytest.approx(np.std(draws[:, order] @ weights), rel=0.5)


def test_of_a_gain_and_its_dead_zones_edge_the_slope_past_the_edge_is_reported(plant):
    """The gain follows the edge so that X_F / (1 - edge) stays; its error is that of draws."""
    rng = np.random.default_rng(4)
    edge = 0.08 + rng.normal(0, 0.02, 20000)
    slope = plant.values["X_F"] / 0.92 * (1 + rng.normal(0, 0.002, 20000))
    draws = np.column_stack([slope * (1 - edge), edge])
    found = identifiability(with_covariance(plant, ["X_F", "edge_forward"], np.cov(draws.T)))
    (only,) = found.combinations
    assert only.text == "the gain past the edge, X_F / (1 - edge_forward),"
    assert only.value == pytest.approx(plant.values["X_F"] / 0.92)
    assert only.error == pytest.approx(np.std(draws[:, 0] / (1 - draws[:, 1])), rel=0.05)


def test_what_is_sharp_anyway_needs_no_combination(plant):
    covariance = 1e-8 * np.array([[1.0, -0.97], [-0.97, 1.0]])
    assert not identifiability(with_covariance(plant, ["X_u", "X_uu"], covariance)).combinations


def test_a_model_whose_coefficients_were_given_has_nothing_to_tell(plant):
    found = identifiability(plant)
    assert {f.verdict for f in found.findings} == {ParameterVerdict.GIVEN}
    assert (found.names, found.condition, found.combinations) == ((), 1.0, ())
