# SPDX-License-Identifier: MIT
"""Model predictive control of one thruster and its angle: both are inputs, the gear's rate is a constraint."""

from functools import partial

import numpy as np
import pytest
from conftest import at_length
from steered_boat import BOW_THRUSTER, known, rudder
from test_mpc_path import CURRENT, PERIOD, drive, straight

from seatrial import _core
from seatrial.control import at_speed, rounded_square
from seatrial.control.mpc import Grid, Nmpc
from seatrial.control.mpc.problem import MOTION_SIZE, STEERED_GRID, stage
from seatrial.control.mpc.step import Layout
from seatrial.util.errors import ControlError

SPEED = 0.6  # [m/s]
line = partial(straight, speed=SPEED)
GEAR = np.radians(40.0)  # [rad/s] of the boat's helm
RUDDER = rudder(-0.3)


@pytest.fixture(scope="module")
def controller():
    return Nmpc(known())


@pytest.mark.parametrize("changed", [{}, RUDDER], ids=["outboard", "rudder"])
@pytest.mark.parametrize("share", [1.0, -1.0])
def test_a_stage_at_the_gears_rate_is_the_cores_motion(changed, share):
    """The helm turns over the whole stage, as the core's does; thrust follows by its lag."""
    length = 0.2
    model = known(**changed)
    own = Nmpc(model, grid=Grid(2, length, 48))  # the core's own step
    begin = np.array([0.3, -0.2, 0.4, 0.5, -0.05, 0.1])
    aim = np.array([0.8, own.thrusters.idle[1] + share * GEAR * length])
    plant = _core.Plant(model.boat, model.vehicle.chain, model.constants)
    plant.command(0.0, np.ascontiguousarray(own.thrusters.commands(aim)))
    plant.advance_to(own.latency)
    plant.state = begin
    plant.advance_to(own.latency + length)
    forward = stage(model, own.thrusters, own.grid)
    found = np.array(forward(np.concatenate([begin, own.thrusters.idle]), aim, np.zeros(3))).ravel()
    np.testing.assert_allclose(found[:6], plant.state, atol=1e-6)
    np.testing.assert_allclose(found[6:], [0.8 * (1 - np.exp(-length / 0.3)), aim[1]], rtol=1e-9)


def test_levels_between_commands_are_those_of_the_gear(controller):
    """At 40 deg/s the helm has turned 4 deg after 0.1 s, and waits at its target."""
    model, idle = controller.model, controller.thrusters.idle
    for seconds, turned in ((0.1, 4.0), (0.5, 20.0), (2.0, 30.0)):
        aim = idle + np.array([0.5, np.radians(30.0)])
        found = _core.levels_after(model.vehicle.chain, model.constants, idle, aim, seconds)
        assert np.degrees(found[1] - idle[1]) == pytest.approx(turned, abs=1e-9)
        assert found[0] == pytest.approx(0.5 * (1.0 - np.exp(-seconds / 0.3)))


@pytest.mark.parametrize(("y", "psi"), [at_length(1.0, 0.0), (-3.0, 1.5)])
def test_it_comes_back_to_a_line_bow_first_and_keeps_it_in_a_cross_current(controller, y, psi):
    states = drive(controller, line, 40.0, [0.0, y, psi, 0.0, 0.0, 0.0])
    late = states[300:]
    assert np.abs(late[:, 1]).max() < 0.08  # [m]
    assert np.mean(late[:, 2]) == pytest.approx(-np.arcsin(CURRENT[1] / SPEED), abs=0.04)
    assert np.abs(late[:, 0] - SPEED * PERIOD * np.arange(300, 400)).max() < 0.3
    assert controller.unsolved == 0


def test_no_plan_turns_the_helm_faster_than_its_gear(controller):
    """From the first stage on, though the path asks for more; the gear's limit is what holds it."""
    controller.forget()
    controller.command(0.0, [0.0, 3.0, 0.0], [0.6, 0.0, 0.0], line(STEERED_GRID.times))
    layout = Layout(2, STEERED_GRID.stages)
    plan = controller._plan
    steps = range(STEERED_GRID.stages)
    levels = np.array([plan[k * layout.block + MOTION_SIZE + 1] for k in steps])
    turned = np.array([plan[layout.thrust(k)][1] for k in steps]) - levels
    most = GEAR * STEERED_GRID.length
    assert np.abs(turned).max() == pytest.approx(most, rel=1e-2)
    assert np.abs(turned).max() < most + 1e-3


@pytest.mark.system
def test_it_follows_a_square_in_a_current_that_it_must_find_out(controller):
    """A quarter of what line of sight has in `test_steered_control.py`."""
    course = at_speed(rounded_square(24.0, 6.0), SPEED, 6.0)

    def reference(times):
        rows = [course.at(min(t, course.duration)) for t in times]
        return np.array([np.concatenate([row.eta, row.body()[0]]) for row in rows])

    begin = np.concatenate([course.at(0.0).eta, np.zeros(3)])
    states = drive(controller, reference, 60.0, begin, current=(0.05, 0.08))
    path = np.array([course.at(t).eta[:2] for t in np.linspace(0.0, course.duration, 4000)])
    off = np.array([np.hypot(*(path - row[:2]).T).min() for row in states[::3]])
    assert np.sqrt(np.mean(off**2)) < 0.15
    assert off.max() < 0.5


def test_commands_stay_within_their_limit_and_jump_the_dead_band(controller):
    thrusters = controller.thrusters
    for angle in np.radians([-38.0, -4.5, -3.5, 30.0]):
        values = thrusters.commands(np.array([0.4, angle]))
        assert np.abs(values).max() <= 1.0
        assert abs(values[1]) > 0.08
        reached = _core.curve(
            controller.model.vehicle.chain, controller.model.constants, 1, values[None]
        )
        assert reached[0] == pytest.approx(angle, abs=1e-9)


def test_what_is_no_single_steered_thruster_is_refused_in_one_line():
    with pytest.raises(ControlError, match="takes one thruster and one angle") as caught:
        Nmpc(known(**BOW_THRUSTER))
    assert "\n" not in str(caught.value)
