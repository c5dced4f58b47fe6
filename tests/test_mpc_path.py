# SPDX-License-Identifier: MIT
"""Model predictive control of a boat without sway thrust: it follows the path; sway and heading are free."""

from dataclasses import replace

import numpy as np
import pytest
from board_boats import wrench
from conftest import make_model
from test_mpc import POOL, SHIP, of_another

import seatrial
from benchmarks.studies.guidance.boat import truth
from seatrial import _core
from seatrial.boat.schema import NoiseEntry, ProcessEntry
from seatrial.boat.vehicle import load_vehicle
from seatrial.control.mpc import Nmpc, Weights
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.errors import AllocationError, ControlError

pytest.importorskip("casadi")

PERIOD, SPEED = 0.1, 0.5  # [s], [m/s]
CURRENT = (0.0, 0.1)  # [m/s]
NOISE = NoiseEntry(0.005, 0.005, ProcessEntry(0.01, 0.01, 0.05, 0.01, 30.0, earth_fixed=True))


@pytest.fixture(scope="module")
def controller():
    return Nmpc(truth())


def straight(t, speed=SPEED):
    """Along x: pose and velocity (n, 6)."""
    t = np.asarray(t, dtype=float)
    still = np.zeros_like(t)
    return np.stack([speed * t, still, still, still + speed, still, still], axis=-1)


def drive(controller, reference, seconds, begin, current=CURRENT):
    """States (n, 6) of the core's boat under the controller, in a current that only the predictor finds out."""
    controller.forget()
    model = controller.model
    plant = _core.Plant(model.boat, model.vehicle.chain, model.constants)
    plant.state = np.array(begin)
    predictor, states = seatrial.Predictor(replace(model, noise=NOISE)), []
    for k in range(round(seconds / PERIOD)):
        t = k * PERIOD
        plant.advance_to(t)
        state = np.array(plant.state)
        state[:2] += PERIOD * np.array(current)
        plant.state = state
        predictor.pose(t, state[:3])
        found = predictor.at(t + controller.latency)
        ahead = reference(t + controller.latency + controller.grid.times)
        command = controller.command(t, found.pose, found.velocity, ahead, found.disturbance)
        predictor.command(t, command)
        plant.command(t, np.ascontiguousarray(command))
        states.append(state)
    return np.array(states)


def test_it_comes_back_to_a_line_and_keeps_it_in_a_cross_current(controller):
    """The bow points into the current: the heading that carries the boat along the line."""
    states = drive(controller, straight, 50.0, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    late = states[300:]
    assert np.abs(late[:, 1]).max() < 0.05  # [m] of a path 1 m away at the start
    crab = -np.arcsin(CURRENT[1] / SPEED)  # [rad]
    assert np.mean(late[:, 2]) == pytest.approx(crab, abs=0.03)
    assert np.abs(late[:, 0] - SPEED * PERIOD * np.arange(300, 500)).max() < 0.3
    assert controller.unsolved == 0


def test_in_still_water_it_heads_along_the_line(controller):
    states = drive(controller, straight, 30.0, np.zeros(6), current=(0.0, 0.0))
    np.testing.assert_allclose(states[200:, 1:3], 0.0, atol=0.01)


def test_walls_hold_for_a_boat_without_sway_thrust():
    kept = Nmpc(truth(), pool=(200.0, 3.0), clearance=0.5)  # |y| up to 1 m

    def beyond(t):
        return straight(t) + np.array([0.0, 1.3, 0.0, 0.0, 0.0, 0.0])

    states = drive(kept, beyond, 30.0, np.zeros(6))
    assert states[-100:, 1].max() < 1.0 + 0.02
    assert states[-100:, 1].min() > 0.8


def test_errors_along_and_across_are_those_of_a_turned_frame():
    """With weights that are almost alike the plan is that of one weight for both."""
    boat = plant_model(load_plan("hard"), load_vehicle("mallard-mp"))
    alike, nearly = Weights(), Weights(along=Weights().position * (1.0 + 1e-9))
    t = np.linspace(0.0, 1.0, 12)
    ahead = np.stack([0.1 * t, 0.2 * t, 0.7 + t, 0.2 + 0 * t, 0 * t, 1.0 + 0 * t], axis=-1)
    plans = []
    for weights in (alike, nearly):
        one = Nmpc(boat, pool=POOL, weights=weights)
        one.command(0.0, [0.05, -0.02, 0.6], [0.1, 0.0, 0.1], ahead)
        plans.append(one.path)
    np.testing.assert_allclose(plans[1], plans[0], atol=1e-6)


def test_what_it_does_not_steer_gets_one_line():
    with pytest.raises(AllocationError, match="can't actuate surge and yaw"):
        boat = plant_model(load_plan("hard"), load_vehicle("mallard-mp"))
        Nmpc(of_another(boat, load_vehicle(SHIP)))
    boat = wrench("forward-left-up")
    values = dict.fromkeys(boat.structure.coefficients, -0.5) | {"N_ud": 0.0}
    with pytest.raises(ControlError, match="names no thrusters and no forces"):
        Nmpc(make_model(boat, values))
