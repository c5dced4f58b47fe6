# SPDX-License-Identifier: MIT
"""Boats that are quicker, heavier or pushed otherwise than the paper's: what the noise is, and the thrust curve."""

import pytest
from conftest import at_length, on_request
from survey_boat import as_stated

from seatrial.boat.findings import FindingKind, finding_of, of_kinds
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.estimator import output_error
from seatrial.identification.selection.actuator_stages import STAGES_SELECTED
from seatrial.simulation.plan import DisturbanceForce
from tests.boats.hulls import BOWED, LIGHT, MIDDLE, SMALL, driven

CHAIN = {"latency": 0.1, "lag": 0.12, "dead_zone": {"forward": 0.075, "reverse": 0.075}}
CURVED = {**CHAIN, "reverse_ratio": 0.75, "power": 1.4}
CURVE = {"reverse_ratio": 0.75, "power": 1.4, "latency": 0.1, "lag": 0.12}


def misfit(model):
    return model.findings_of(FindingKind.MODEL_MISMATCH)


@pytest.mark.system
@pytest.mark.parametrize("seed", [0, on_request(1), on_request(2)])
def test_a_push_and_lasting_pose_errors_are_told_apart_on_a_quick_boat(seed):
    """Random walks of the velocity stood for both: errors two times too large, and a structure called wrong."""
    push = DisturbanceForce(0.04, 1.2)
    chain = {"latency": 0.06, "lag": 0.08, "dead_zone": {"forward": 0.03, "reverse": 0.03}}
    vehicle, recordings = driven(
        SMALL, chain, seed=seed, push=push, white=1e-3, lasting=(3e-3, 0.4), rate=30.0, drives=3
    )
    model = output_error(recordings, vehicle)
    process, lasting = model.noise.process, model.noise.correlated
    assert max(process.walk_linear, process.walk_yaw) < 2e-3
    assert process.disturbance_yaw == pytest.approx(0.04 * SMALL.coefficients["N_F"], rel=0.2)
    assert lasting.position == pytest.approx(3e-3, rel=0.2)
    assert lasting.memory == pytest.approx(0.4, rel=0.3)
    assert misfit(model) == ()
    assert as_stated(model, SMALL.coefficients) == {}


@pytest.mark.parametrize("share", [at_length(0.2), 0.5])
@pytest.mark.parametrize("seed", [0, on_request(1), on_request(2)])
def test_gusts_that_are_large_for_a_light_boat_are_process_noise(share, seed):
    """It ended at 1 m/s^2 and 5 rad/s^2: N_F 8 errors off; half of full thrust left 80 % outliers."""
    vehicle, recordings = driven(
        LIGHT, {"latency": 0.1, "lag": 0.12}, seed=seed, push=DisturbanceForce(share, 2.0),
        white=4e-3, seconds=80.0,
    )  # fmt: skip
    model = output_error(recordings, vehicle)
    process = model.noise.process
    assert process.disturbance_linear == pytest.approx(share * LIGHT.coefficients["X_F"], rel=0.25)
    assert process.disturbance_yaw == pytest.approx(share * LIGHT.coefficients["N_F"], rel=0.25)
    assert misfit(model) == ()
    assert as_stated(model, {**LIGHT.coefficients, "latency": 0.1, "lag": 0.12}) == {}


@pytest.mark.parametrize("earth", [False, True])
@pytest.mark.parametrize("seed", [0, on_request(1), on_request(2)])
def test_whether_a_push_turns_with_the_boat_is_found(earth, seed):
    """Taken for one that turns, wind made right structures look wrong, and lags vanish."""
    push = DisturbanceForce(0.05, 3.0, earth_fixed=earth)
    vehicle, recordings = driven(MIDDLE, CHAIN, seed=seed, push=push, white=4e-3, seconds=80.0)
    model = output_error(recordings, vehicle)
    assert model.noise.process.earth_fixed == earth
    assert misfit(model) == ()
    assert as_stated(model, {**MIDDLE.coefficients, "latency": 0.1, "lag": 0.12}) == {}


@pytest.mark.system
@pytest.mark.parametrize("seed", [0, on_request(1)])
def test_where_a_structure_is_not_right_the_pushs_side_is_asked_again(seed):
    """It was asked only as the likelihood has it, where coefficients follow what the structure lacks."""
    push = DisturbanceForce(0.05, 3.0, earth_fixed=True)
    whole, recordings = driven(MIDDLE, CHAIN, seed=seed, push=push, white=4e-3)
    linear = {
        "surge": ["v * r", "X_u * u", "X_F * F_u"],
        "sway": ["-1 * u * r", "Y_v * v", "Y_F * F_v"],
        "yaw": ["N_r * r", "N_F * F_r"],
    }
    vehicle = vehicle_from({**whole.to_mapping(), "structure": linear}, "boat")
    model = output_error(recordings, vehicle)
    assert len(misfit(model)) == 1
    assert model.noise.process.earth_fixed


@pytest.mark.parametrize(
    ("share", "seed"),
    [at_length(0.0, 0), (0.05, 2), at_length(0.01, 1), on_request(0.05, 3), on_request(0.05, 5)],
)
def test_a_curve_is_found_whatever_pushes_the_boat(share, seed):
    """Edges that were twice too large stood for it, 4 to 17 standard errors away; or it was believed loosely."""
    push = DisturbanceForce(share, 2.0) if share else None
    vehicle, recordings = driven(MIDDLE, CURVED, seed=seed, push=push, white=4e-3)
    model = output_error(recordings, vehicle)
    assert misfit(model) == ()
    assert as_stated(model, {**MIDDLE.coefficients, **CURVE}) == {}
    wide = model.standard_errors["X_F"] / MIDDLE.coefficients["X_F"]
    assert wide < (0.1 if share > 0.02 else 0.03 if share else 0.002)


@pytest.mark.parametrize("seed", [10, *map(on_request, range(11, 16))])
def test_a_linear_thruster_gets_no_curve(seed):
    push = DisturbanceForce(0.05, 2.0)
    vehicle, recordings = driven(MIDDLE, CHAIN, seed=seed, push=push, white=4e-3, seconds=80.0)
    found = output_error(recordings, vehicle).estimator.findings
    assert of_kinds(found, *STAGES_SELECTED) == (), found


@pytest.mark.parametrize("seed", [0, on_request(1)])
def test_a_bow_thruster_has_a_lag_of_its_own(seed):
    """One for all, the gain in sway was six standard errors off, and no note said so."""
    same = {"latency": 0.1, "dead_zone": {"forward": 0.075, "reverse": 0.075}}
    chain = [
        {"name": "stern", "actuators": ["t1", "t2"], **same, "lag": 0.12},
        {"name": "bow", "actuators": ["t3"], **same, "lag": 0.4},
    ]
    vehicle, recordings = driven(BOWED, chain, seed=seed, white=4e-3, seconds=80.0)
    model = output_error(recordings, vehicle)
    selected = finding_of(FindingKind.GROUP_STAGES_SELECTED, "t1+t2", "t3", stage="lag")
    assert selected in model.estimator.findings
    found = {"latency": 0.1, "lag.lag_t1": 0.12, "lag.lag_t3": 0.4}
    assert as_stated(model, {**BOWED.coefficients, **found}) == {}
