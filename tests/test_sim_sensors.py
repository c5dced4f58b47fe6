# SPDX-License-Identifier: MIT
"""The simulator's sensors against what they are told to be."""

import numpy as np
import pytest
from test_sim import NONE

import seatrial
from seatrial.simulation import ImuSettings, LidarSettings, PoseSettings, Sensors, World
from seatrial.simulation.plan import load_plan
from seatrial.simulation.scene import BoatEntry, PoolEntry, PostEntry, SceneFile, pool

EXACT = {"position_noise": 0.0, "heading_noise": 0.0, "stamp_jitter": 0.0}


def test_pose_noise_rate_delay_and_lever_are_as_told(boat):
    settings = PoseSettings(
        rate=20.0, position_noise=0.004, heading_noise=0.01, stamp_jitter=0.002, delay=0.1
    )
    simulator = seatrial.Simulator(
        boat, sensors=Sensors(settings, None, None), start=(1.0, 2.0, 0.5), lever=(0.5, 0.2), seed=1
    )
    found = simulator.advance(100.0)
    assert len(found) == pytest.approx(20.0 * 100.0, abs=3)
    values = np.array([r.eta for r in found])
    c, s = np.cos(0.5), np.sin(0.5)
    want = [1.0 + 0.5 * c - 0.2 * s, 2.0 + 0.5 * s + 0.2 * c, 0.5]
    assert np.all(np.abs(values.mean(axis=0) - want) < [4e-4, 4e-4, 1e-3])
    np.testing.assert_allclose(values.std(axis=0), [0.004, 0.004, 0.01], rtol=0.06)
    due = np.arange(1, len(found) + 1) / 20.0
    np.testing.assert_allclose([r.arrival for r in found], due + 0.1, atol=1e-9)
    assert np.std([r.stamp for r in found] - due) == pytest.approx(0.002, rel=0.06)
    assert simulator.pose() is found[-1]


def test_pose_noise_hangs_together_for_as_long_as_told(boat):
    settings = PoseSettings(rate=20.0, noise_correlation=0.3, position_noise=0.01)
    found = seatrial.Simulator(boat, sensors=Sensors(settings, None, None), seed=2).advance(400.0)
    x = np.array([r.eta[0] for r in found])
    assert x.std() == pytest.approx(0.01, rel=0.1)
    assert np.corrcoef(x[1:], x[:-1])[0, 1] == pytest.approx(np.exp(-0.05 / 0.3), abs=0.03)


def test_drop_outs_and_jumps_come_as_often_as_told(boat):
    settings = PoseSettings(
        rate=10.0, drop_outs=2.0, drop_out_shortest=1.0, drop_out_longest=2.0,
        jumps=3.0, jump_shortest=0.3, jump_longest=0.5, jump_samples=2, **EXACT,
    )  # fmt: skip
    found = seatrial.Simulator(boat, sensors=Sensors(settings, None, None), seed=4).advance(6000.0)
    stamps = np.array([r.stamp for r in found])
    gaps = np.diff(stamps)[np.diff(stamps) > 0.15]
    # a wait of 30 s on average, then 1 to 2 s away
    assert len(gaps) == pytest.approx(6000.0 / 31.5, rel=0.2)
    assert gaps.min() > 0.9
    assert gaps.max() < 2.2
    size = np.hypot(*np.array([r.eta[:2] for r in found]).T)
    wrong = size > 1e-9
    begins = np.count_nonzero(np.diff(wrong.astype(int)) == 1)
    assert begins == pytest.approx(300, rel=0.2)
    assert size[wrong].min() >= 0.3
    assert size[wrong].max() <= 0.5


def test_the_plans_pose_sensor_is_taken_over():
    plan = load_plan("paper-like").pose
    settings = PoseSettings.of_plan(plan)
    assert (settings.rate, settings.position_noise) == (plan.rate, plan.position_noise)
    assert (settings.drop_outs, settings.drop_out_longest) == (0.6, 2.0)
    assert (settings.jumps, settings.jump_samples, settings.delay) == (0.3, 3, 0.0)


def test_the_imu_measures_the_mean_yaw_rate_and_specific_force(boat):
    """In a steady turn the force is centripetal; over any period it is the gain of velocity."""
    quiet = ImuSettings(rate=100.0, yaw_rate_noise=0.0, yaw_rate_bias=0.0,
                        acceleration_noise=0.0, acceleration_bias=0.0)  # fmt: skip
    simulator = seatrial.Simulator(boat, sensors=Sensors(None, quiet, None), current=(0.05, 0.0))
    simulator.command([0.8, 0.0, 0.5])
    simulator.advance(60.0)
    for _ in range(5):
        before, turned = simulator.nu, simulator.eta
        simulator.advance(0.01)
        after, imu = simulator.nu, simulator.imu()
        mean = 0.5 * (before + after)
        rate = (after - before) / 0.01
        force = [rate[0] - mean[2] * mean[1], rate[1] + mean[2] * mean[0]]
        np.testing.assert_allclose(imu.acceleration, force, atol=1e-5)
        assert imu.yaw_rate == pytest.approx((simulator.eta - turned)[2] / 0.01, abs=1e-9)
    assert abs(force[1]) > 0.01


def test_imu_noise_and_bias_are_as_told(boat):
    settings = ImuSettings(yaw_rate_noise=0.02, yaw_rate_bias=0.3,
                           acceleration_noise=0.1, acceleration_bias=0.5)  # fmt: skip
    means = []
    for seed in range(60):
        found = seatrial.Simulator(boat, sensors=Sensors(None, settings, None), seed=seed)
        values = np.array([r.values for r in found.advance(2.0)])
        means.append(values.mean(axis=0))
    np.testing.assert_allclose(values.std(axis=0), [0.02, 0.1, 0.1], rtol=0.2)
    np.testing.assert_allclose(np.std(means, axis=0), [0.3, 0.5, 0.5], rtol=0.3)


def test_the_lidar_measures_walls_posts_and_the_other_boat(mp, boat):
    quiet = LidarSettings(noise=0.0, beams=361, field=2 * np.pi, farthest=8.0)
    file = SceneFile(
        pool=PoolEntry(10.0, 6.0), posts=[PostEntry(0.0, 2.0, 0.25)],
        sensors=Sensors(None, None, quiet), boats=[BoatEntry(name="a"), BoatEntry((3.0, 0.0, 0.0), "b")],
    )  # fmt: skip
    world = World(file)
    a, b = world.add(boat), world.add(boat, sensors=NONE, radius=0.5)
    assert (a.name, b.name) == ("a", "b")
    world.advance(0.1)
    scan = a.scan()
    at = {round(np.rad2deg(angle)): r for angle, r in zip(scan.angles, scan.ranges, strict=True)}
    assert at[0] == pytest.approx(3.0 - 0.5)
    assert at[90] == pytest.approx(2.0 - 0.25)
    assert at[-90] == pytest.approx(3.0)
    assert at[180] == pytest.approx(5.0)
    assert at[-45] == pytest.approx(3.0 * np.sqrt(2.0))
    assert scan.arrival - scan.stamp == pytest.approx(1.0 / 15.0)
    assert np.isinf(at[150]) == (5.0 / np.cos(np.deg2rad(30)) > 8.0)
    far = seatrial.Simulator(boat, scene=pool(30.0, 30.0), sensors=Sensors(None, None, quiet))
    far.advance(0.1)
    assert np.isinf(far.scan().ranges).all()


def test_each_beam_is_measured_at_its_own_time(boat):
    """A boat that turns: the corner of the pool is seen where it was at that beam's time."""
    quiet = LidarSettings(noise=0.0, beams=271, mount=(0.2, 0.1, 0.3))
    scene = pool(10.0, 6.0)
    simulator = seatrial.Simulator(boat, scene=scene, sensors=Sensors(None, None, quiet))
    simulator.command([0.3, 0.3, 1.0])
    track = []
    while simulator.time < 2.0 - 1e-9:
        simulator.advance(0.001)
        track.append([simulator.time, *simulator.eta])
    track, scan = np.array(track), simulator.scan()
    t = scan.stamp + scan.sweep * np.arange(271) / 270
    at = np.column_stack([np.interp(t, track[:, 0], track[:, i]) for i in (1, 2, 3)])
    c, s = np.cos(at[:, 2]), np.sin(at[:, 2])
    origin = at[:, :2] + np.column_stack([0.2 * c - 0.1 * s, 0.2 * s + 0.1 * c])
    want = scene.ranges(origin, at[:, 2] + 0.3 + scan.angles)
    np.testing.assert_allclose(scan.ranges, want, atol=4e-3)
    still = scene.ranges(np.tile(origin[-1], (271, 1)), at[-1, 2] + 0.3 + scan.angles)
    assert np.abs(still - want).max() > 0.05
