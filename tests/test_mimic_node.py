# SPDX-License-Identifier: MIT
"""The mimic node without ROS: how long a command holds, beside the plant itself."""

from dataclasses import replace

import numpy as np
import pytest
from board_boats import changed
from cpp_tools import built, fed
from ros1_node_tools import plant_states

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.simulation.mimic import MimicHealth

pytestmark = pytest.mark.system
BEGIN = 1_000_000_000_000  # [ns]
STICKS = np.array([0.5, 0.25, -0.125])  # surge, sway, yaw
TWO = {"F_u": "axes[1]", "F_v": "axes[0]", "F_r": {"field": "data[0]", "topic": "/helm"}}


@pytest.fixture(scope="module")
def program():
    """The node, under the sanitizers."""
    return built("mimic")


def event(t, words):
    return f"{BEGIN + round(1e9 * t)} {words}"


def joy(t):
    surge, sway, yaw = STICKS
    return event(t, f"numbers sensor_msgs/Joy /joy {sway} {surge} 0 {yaw} |")


def ticks(program, model, path, events, **settings):
    """Health and states (n, 6) at each tick, of a boat that the first pose has placed at the origin."""
    seatrial.save(model, path)
    done = fed(program, [event(0.0, "pose 0 0 0"), *events], model=path, **settings)
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines()]
    health = [MimicHealth(int(row[0])) for row in rows]
    return health, np.array([[float.fromhex(x) for x in row[1:]] for row in rows])


@pytest.mark.parametrize(
    ("stated", "settings", "holds"),
    [(None, {}, 0.5), (None, {"command_timeout": 1.2}, 1.2), (0.8, {"command_timeout": 1.2}, 0.8)],
)
def test_a_dead_joypad_s_command_ends(program, boat, tmp_path, *, stated, settings, holds):
    """After the parameter's time, or the vehicle's own."""
    if stated is not None:
        boat = replace(boat, vehicle=changed(boat.vehicle, command_timeout=stated))
    t = (np.arange(200) + 0.5) * 0.02
    events = [joy(0.0), *(event(x, "tick") for x in t)]
    health, states = ticks(program, boat, tmp_path / "m.yaml", events, **settings)
    silent = np.array([MimicHealth.COMMAND_SILENCE in h for h in health])
    np.testing.assert_array_equal(silent, t > holds)
    want = plant_states(boat, (0.0, 0.0, 0.0), [(0.0, STICKS), (holds, 0.0 * STICKS)], t)
    np.testing.assert_allclose(states, want, atol=1e-6)
    assert np.abs(states[:, 3]).max() > 0.02


def test_one_of_two_topics_that_is_dead_ends_the_command(program, boat, tmp_path):
    """The other's messages go on; the command ends within twice the time."""
    content = boat.vehicle.to_mapping()
    content["commands"] = {"topic": "/joy", "inputs": TWO}
    two = replace(boat, vehicle=vehicle_from(content, "two"))
    helm = "numbers std_msgs/Float64MultiArray /helm -0.125"
    events = []
    for k in range(200):
        events.append(joy(0.02 * k))
        if k < 50:
            events.append(event(0.02 * k, helm))
        events.append(event(0.02 * k, "tick"))
    health, _ = ticks(program, two, tmp_path / "m.yaml", events)
    silent = [MimicHealth.COMMAND_SILENCE in h for h in health]
    assert not any(silent[1:75])
    assert all(silent[102:])
