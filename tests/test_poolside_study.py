# SPDX-License-Identifier: MIT
"""The study's boats and drivers: they keep off the walls, and follow the advice as a person does."""

from dataclasses import replace

import numpy as np
import pytest
from live_advice_boat import known_boat
from live_states import FakeSession, shown_state

from benchmarks.live_operator import Api
from benchmarks.studies.poolside.__main__ import spelled
from benchmarks.studies.poolside.drivers import REACTION, Guided
from benchmarks.studies.poolside.drives import AT_WALL, DRIVERS, WATERS, inside, reached, widths
from seatrial.poolside.web.server import PageServer, Place


def drive(water, driver, seconds):
    """States (n, 6) and commands (n, inputs), tick by tick."""
    states, commands = [], []
    for tick in range(round(seconds / water.tick)):
        states.append(water.state)
        commands.append(driver.look(tick * water.tick, water.state))
        water.step(commands[-1])
    return np.array(states), np.array(commands)


@pytest.mark.parametrize("water", WATERS)
@pytest.mark.parametrize("name", DRIVERS)
def test_no_driver_is_at_a_wall(water, name):
    own = WATERS[water](7)
    states, commands = drive(own, DRIVERS[name](own, 7), 60.0)
    assert own.area.margins(states[:, :2]).min() > own.radius - AT_WALL
    assert np.abs(commands).max() <= 1.0
    assert np.abs(states[:, 3:]).max() > 0.1  # it is driven


def test_the_operator_is_late_and_his_sticks_are_a_bit_off():
    own = WATERS["pool"](3)
    driver = Guided(own, 3)
    _, commands = drive(own, driver, 5.0)
    first = round(REACTION / own.tick)
    assert not commands[:first].any()
    sizes = commands[first + 1 : first + 50, 0]  # half stick ahead for 2 s
    assert np.ptp(sizes) == 0.0
    assert sizes[0] == pytest.approx(0.5, abs=0.15)
    assert sizes[0] != pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(("water", "names"), [("pool", ("X_u", "lag")), ("twin", ("X_u", "lag"))])
def test_a_boat_knows_its_truth(water, names):
    known = {"pool": (-0.20, 0.08), "twin": (-8.0 / 32.0, 0.2)}
    assert WATERS[water](1).truth((*names, "edge_forward"))[:2] == pytest.approx(known[water])


def test_intervals_are_compared_with_the_goal_and_with_the_truth():
    model = known_boat(0.05)
    goal = widths(model)
    assert reached(model, goal)
    assert not reached(model, {name: 0.9 * width for name, width in goal.items()})
    own = WATERS["pool"](1)
    assert sum(inside(model, own)) == len(goal) - 1  # the truth's latency is the clock's offset
    moved = replace(model, coefficients=1.3 * model.coefficients)
    assert sum(inside(moved, own)) == len(goal) - 12


def test_minutes_are_median_least_and_most():
    assert spelled([60.0, np.inf, 120.0]) == "2.0 (1.0 to never)"


def test_an_operator_reads_his_advice_from_the_api():
    session = FakeSession(shown_state())
    with PageServer(Place(port=0)) as server:
        server.serve(session)
        api = Api(server.url.rstrip("/"))
        api.wait()
        assert api.state() == session.state()
        assert api.advise()[0] == session.state().next
        assert api.stop() == session.stop()
