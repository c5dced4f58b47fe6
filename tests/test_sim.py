# SPDX-License-Identifier: MIT
"""The simulator: its motion against the plant's, and what holds it."""

import re

import numpy as np
import pytest
from conftest import TABLE_II, make_model

import seatrial
from seatrial import _core
from seatrial.simulation import (
    ImuReading,
    LidarSettings,
    PoseReading,
    PoseSettings,
    Sensors,
    World,
)
from seatrial.simulation.plan import load_plan
from seatrial.simulation.scene import box, pool
from seatrial.simulation.trials import plant_model
from seatrial.util.errors import SeatrialError, SimulatorError

NONE = Sensors(pose=None, imu=None, lidar=None)


def commands(n=60, seed=3):
    rng = np.random.default_rng(seed)
    return np.column_stack([np.cumsum(rng.uniform(0.01, 0.4, n)), rng.uniform(-1, 1, (n, 3))])


def driven(simulator, script, end=12.0):
    for t, *values in script[script[:, 0] < end]:
        simulator.advance_to(t)
        simulator.command(values)
    simulator.advance_to(end)
    return np.concatenate([simulator.eta, simulator.nu])


def test_it_moves_as_the_plant_does(mp):
    boat, script = plant_model(load_plan("paper-like"), mp), commands()
    plant = _core.Plant(boat.boat, boat.vehicle.chain, boat.constants)
    for t, *values in script[script[:, 0] < 12.0]:
        plant.advance_to(t)
        plant.command(t, np.array(values))
    plant.advance_to(12.0)
    simulator = seatrial.Simulator(boat)
    np.testing.assert_allclose(driven(simulator, script), plant.state, atol=1e-8)
    np.testing.assert_allclose(simulator.forces, plant.forces(3), atol=1e-12)
    assert np.linalg.norm(plant.state[:2]) > 0.1


def test_a_current_carries_the_boat_with_the_water(boat):
    """The water's own frame knows nothing of the current: the way differs by current times time."""
    script, current = commands(), (0.05, -0.03)
    still = driven(seatrial.Simulator(boat, sensors=NONE), script)
    carried = driven(seatrial.Simulator(boat, sensors=NONE, current=current), script)
    np.testing.assert_allclose(carried[:2] - still[:2], np.array(current) * 12.0, atol=1e-9)
    np.testing.assert_allclose(carried[[2, 5]], still[[2, 5]], atol=1e-12)
    c, s = np.cos(still[2]), np.sin(still[2])
    over = np.array([[c, s], [-s, c]]) @ current
    np.testing.assert_allclose(carried[3:5] - still[3:5], over, atol=1e-12)


def test_a_boat_without_drive_drifts_at_the_current(boat):
    simulator = seatrial.Simulator(boat, sensors=NONE, current=(0.1, 0.0))
    np.testing.assert_allclose(simulator.nu, [0.1, 0.0, 0.0])
    simulator.advance(10.0)
    np.testing.assert_allclose(simulator.eta, [1.0, 0.0, 0.0], atol=1e-12)


def test_the_same_seed_says_the_same_and_another_does_not(boat):
    def readings(seed, step):
        simulator = seatrial.Simulator(boat, scene=pool(12.0, 5.0), seed=seed)
        simulator.command([0.5, 0.2, 0.3])
        found = []
        while simulator.time < 2.0:
            found += simulator.advance(step)
        return [(type(r), round(r.stamp, 9), r.values) for r in found if r.arrival < 1.95]

    first, again, other = readings(5, 0.1), readings(5, 0.037), readings(6, 0.1)
    assert len(first) > 200
    assert [row[:2] for row in first] == [row[:2] for row in again]
    for one, two in zip(first, again, strict=True):
        np.testing.assert_allclose(one[2], two[2], atol=1e-9)
    assert not all(np.allclose(a[2], b[2]) for a, b in zip(first, other, strict=False))


def test_walls_hold_the_boat(boat):
    """Full ahead into a wall for a minute: it ends at rest with its disc at the wall."""
    simulator = seatrial.Simulator(boat, scene=pool(4.0, 3.0), sensors=NONE, radius=0.4)
    simulator.command([1.0, 0.0, 0.0])
    deepest, touched = 0.0, False
    for _ in range(600):
        simulator.advance(0.1)
        deepest = max(deepest, simulator.eta[0] - 1.6)
        touched = touched or simulator.touched
    assert touched
    assert deepest < 0.003
    assert simulator.eta[0] == pytest.approx(1.6, abs=0.005)
    assert abs(simulator.nu[0]) < 0.01


def test_it_slides_along_a_wall_without_friction(boat):
    """A thrust at an angle: along the wall the boat goes as if there were no wall."""
    free = seatrial.Simulator(boat, sensors=NONE)
    walled = seatrial.Simulator(
        boat, sensors=NONE, radius=0.2, scene=seatrial.Scene([[-50.0, 0.2, 50.0, 0.2]], [])
    )
    for simulator in (free, walled):
        simulator.command([0.6, 0.0, 0.0])
        simulator.advance(10.0)
        simulator.command([0.6, 0.3, 0.0])
        simulator.advance(2.0)
    assert free.eta[1] > 0.05
    assert walled.eta[1] < 0.005
    assert walled.eta[0] == pytest.approx(free.eta[0], rel=0.02)


def test_a_bounce_keeps_the_stated_share(mp):
    """Without drag the speed after a head-on contact is 0.3 of the speed before."""
    values = dict.fromkeys(TABLE_II["AF"], 0.0) | {"X_F": 0.2, "Y_F": 0.2, "N_F": 1.0}
    simulator = seatrial.Simulator(
        make_model(mp, values), scene=pool(4.0, 3.0), sensors=NONE, radius=0.5
    )
    simulator.command([1.0, 0.0, 0.0])
    simulator.advance(1.0)
    simulator.command([0.0, 0.0, 0.0])
    before = simulator.nu[0]
    assert before == pytest.approx(0.2, rel=1e-9)
    while not simulator.touched:
        simulator.advance(0.005)
    assert simulator.nu[0] == pytest.approx(-0.3 * before, rel=1e-9)


def test_two_boats_keep_their_momentum(mp):
    values = dict.fromkeys(TABLE_II["AF"], 0.0) | {"X_F": 0.2, "Y_F": 0.2, "N_F": 1.0}
    world = World()
    model = make_model(mp, values)
    fast = world.add(model, name="fast", sensors=NONE)
    slow = world.add(model, name="slow", start=(1.5, 0.1, np.pi / 2), sensors=NONE)
    fast.command([1.0, 0.0, 0.0])
    world.advance(1.0)
    fast.command([0.0, 0.0, 0.0])
    world.advance(10.0)

    def over_ground(boat):
        psi, (u, v, _) = boat.eta[2], boat.nu
        return np.array([u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)])

    np.testing.assert_allclose(over_ground(fast) + over_ground(slow), [0.2, 0.0], atol=1e-9)
    assert over_ground(slow)[0] > 0.05
    assert np.hypot(*(fast.eta - slow.eta)[:2]) >= 2 * _core.HULL_RADIUS - 1e-9


def test_a_scene_file_and_its_arguments(boat, tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(
        "seatrial: scene 1\nname: basin\npool: {length: 6, width: 4}\nwalls: [[0, 1.5, 1, 1.5]]\n"
        "boxes: [{x: 2, y: 0, length: 0.5, width: 0.5, turn_deg: 45}]\nposts: [{x: 0, y: 1, radius: 0.1}]\n"
        "current: [0.02, 0]\nsensors: {lidar: null, pose: {rate: 5}}\n"
        "boats: [{name: tug, start: [-1, 0, 1.57], radius: 0.25}]\n"
    )
    simulator = seatrial.Simulator(boat, scene=path)
    assert simulator.name == "tug"
    assert simulator.radius == 0.25
    assert len(simulator.world.scene.segments) == 9
    np.testing.assert_allclose(simulator.world.scene.distance(np.array([[2.0, 0.0]])), 0.25)
    np.testing.assert_allclose(simulator.eta, [-1.0, 0.0, 1.57])
    kinds = {type(r) for r in simulator.advance(1.0)}
    assert kinds == {PoseReading, ImuReading}
    assert simulator.scan() is None
    np.testing.assert_allclose(simulator.eta[:2], [-0.98, 0.0])
    assert seatrial.Simulator(boat, scene=path, current=(0.0, 0.0)).nu[0] == 0.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"current": (1.0,)}, "expected 2 numbers"),
        ({"scene": pool(4.0, 3.0), "start": (1.9, 0.0, 0.0)}, "does not fit at (1.9, 0) m"),
        ({"start": (0.0, 0.0)}, "expected 3 numbers"),
        ({"radius": -1.0}, "radius -1.0 m"),
        ({"lever": (0.1, 0.0, 0.2)}, "lever of shape (3,); expected 2 numbers: forward [m]"),
        ({"lever": (np.nan, 0.0)}, "lever [nan, 0.0]; expected 2 numbers"),
        ({"seed": -1}, "seed -1"),
        ({"sensors": Sensors(lidar=LidarSettings(beams=1))}, "beams: expected 2 to 4096"),
        ({"sensors": Sensors(pose=PoseSettings(drop_out_shortest=9.0))}, "shortest: expected"),
        ({"scene": "nowhere.yaml"}, "nowhere.yaml: no such file"),
    ],
)
def test_what_can_not_be_simulated_is_said(boat, arguments, words):
    with pytest.raises(SeatrialError, match=re.escape(words)):
        seatrial.Simulator(boat, **arguments)


def test_a_bad_command_or_time_is_said(boat):
    simulator = seatrial.Simulator(boat)
    for bad in ([1.0], [1.0, np.nan, 0.0]):
        with pytest.raises(SeatrialError, match="expected"):
            simulator.command(bad)
    with pytest.raises(SimulatorError, match="times must increase"):
        simulator.advance(-1.0)
    simulator.advance(0.1)
    with pytest.raises(SimulatorError, match="before the first step"):
        simulator.world.add(boat, name="late")


def test_an_unstable_model_is_said(mp):
    values = TABLE_II["AF"] | {"X_u": 3.0, "X_uu": 3.0}
    simulator = seatrial.Simulator(make_model(mp, values), sensors=NONE)
    simulator.command([1.0, 0.0, 0.0])
    with pytest.raises(seatrial.SeatrialError, match="diverges"):
        simulator.advance(60.0)


def test_a_box_has_four_sides_that_meet():
    sides = box(1.0, 2.0, 0.5, 0.3, turn=0.4)
    np.testing.assert_allclose(sides[:, 2:], np.roll(sides[:, :2], -1, axis=0))
    np.testing.assert_allclose(np.hypot(*(sides[:, 2:] - sides[:, :2]).T), [0.5, 0.3, 0.5, 0.3])
