# SPDX-License-Identifier: MIT
"""The search's steps within bounds."""

import pytest
from conftest import CSE1

import seatrial
from seatrial.boat.actuators import ESTIMATE
from seatrial.boat.schema import ChainGroup
from seatrial.identification.estimator import OutputErrorSettings, fit
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.optimiser import Damping, Outcome, search
from seatrial.identification.selection.actuator_selection import moved_to, wider_problem
from seatrial.identification.selection.actuator_stages import actuator_groups, with_free_stages


@pytest.mark.system
def test_latencies_of_the_real_ship_are_found_beside_a_lag_at_its_bound():
    """The lag ends at its bound, and drags none of the latencies along: at this horizon they are those without a lag."""
    vehicle = seatrial.load_vehicle(CSE1 / "vehicle.yaml")
    kinds = actuator_groups(vehicle)
    asked = [ChainGroup(name=n, actuators=of, latency=ESTIMATE) for n, of in kinds.items()]
    recording = seatrial.read(CSE1 / "csv" / "CSE1_data_random_run1.csv", vehicle)
    recordings, settings = [recording.cut(200.0, 380.0)], OutputErrorSettings(select_stages=False)
    free, without = (
        vehicle.with_chain([*vehicle.file.chain, *asked, *lag])
        for lag in ([], [ChainGroup(lag=0.0)])
    )
    found = fit(recordings, free, settings=settings)
    whole = with_free_stages(without, recordings)
    problem = wider_problem(found.problem, whole, without, settings)
    there, outcome = search(
        problem, moved_to(found.point, problem, {}), found.noise, least=noise_floor(problem, found.horizon)
    )  # fmt: skip
    assert outcome is Outcome.CONVERGED
    estimates, none = (
        dict(zip(names, theta.tolist(), strict=True))
        for names, theta in ((found.problem.names, found.theta), (problem.names, there.theta))
    )
    assert estimates["lag"] < 0.005
    for force in kinds:
        name = f"latency.{force}"
        assert estimates[name] == pytest.approx(none[name], abs=0.005), name


@pytest.mark.parametrize("curvature", [2.0, 3.0, 8.0])  # of what was promised
def test_a_failed_step_is_shortened_to_the_minimum_of_its_parabola(curvature):
    """In one dimension: the fall 2 t - curvature t^2 of a share t of the step, where 2 t - t^2 was promised."""
    damping = Damping(value=0.0)
    damping.after_none(ratio=2.0 - curvature)
    shorter = 1.0 / (1.0 + damping.value)
    assert shorter == pytest.approx(1.0 / curvature)


def test_a_step_that_diverges_is_shortened_by_a_finite_factor():
    damping = Damping()
    damping.after_none(ratio=-float("inf"))
    assert 1.0 < damping.value < 100.0
