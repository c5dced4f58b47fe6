# SPDX-License-Identifier: MIT
"""The mimic: a simulated carrier with wheels that slip follows what the boat really did."""

import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from cli_tools import refused
from conftest import TABLE_II, make_model

import seatrial
from seatrial import _core
from seatrial.commands.mimic import LIMITS
from seatrial.simulation.mimic import Carrier, Mimic, MimicHealth
from seatrial.util.errors import MimicError, PredictorError
from tests.boats.carrier import DT, driven, follow
from tests.boats.mecanum import TO_BODY, TO_WHEELS, Ground, SimulatedCarrier

LAG = Carrier(lag=0.14)  # the ground's lag and delay


@pytest.fixture(scope="module")
def whole():
    """All of the bundled S7; its truth is what the boat did."""
    return driven()


@pytest.fixture(scope="module")
def minute():
    """Its first."""
    return driven(60.0)


@pytest.fixture(scope="module")
def boat(minute):
    return minute[0]


@pytest.mark.system
def test_the_carrier_follows_the_boat_within_two_centimetres_on_s7(whole):
    for seed in (1, 2):
        run = follow(*whole, Ground(), LAG, seed)
        position, heading = run.off
        assert position < 0.02, position
        assert heading < 0.03, heading
    assert np.hypot(*np.diff(run.boat[:, :2], axis=0).T).sum() > 20.0  # [m] it really drove


def test_the_boats_way_is_that_of_the_recorded_trial(minute):
    run = follow(*minute, Ground(), LAG)
    poses = np.array([m.pose for m in run.motions])
    assert np.abs(poses - run.boat).max() < 1e-3


def test_without_the_way_back_it_drifts_away(whole):
    blind = follow(*whole, Ground(), Carrier(lag=0.14, gain=0.0, lost=1e3))
    assert blind.off[0] > 0.1


def test_an_odometry_that_does_not_see_slip_can_not_bring_it_back(whole):
    """It believes itself near; the truth is elsewhere. Said in docs/mimic.md."""
    run = follow(*whole, Ground(sees_slip=False), LAG)
    believed = np.array([m.mismatch[:2] for m in run.motions])
    assert np.sqrt(np.mean(np.sum(believed**2, axis=1))) < 0.03
    assert run.off[0] > 0.1


def test_the_lead_is_worth_what_it_costs(minute):
    """Wheels without faults: leading by the lag leaves a fraction of what is off without."""
    perfect = Ground(worn=0.0, slips_per_minute=0.0, position_noise=0.0, heading_noise=0.0)
    led, late = (follow(*minute, perfect, Carrier(lag=lag)).off[0] for lag in (0.14, 0.0))
    assert led < 0.3 * late


def test_limits_are_respected_and_said(minute):
    slow = Carrier(
        lag=0.14, speed=0.1, yaw_rate=0.3, acceleration=0.2, yaw_acceleration=0.5, lost=1e3
    )
    run = follow(*minute, Ground(), slow)
    velocity = np.array([m.velocity for m in run.motions])
    assert np.hypot(velocity[:, 0], velocity[:, 1]).max() <= 0.1 + 1e-12
    assert np.abs(velocity[:, 2]).max() <= 0.3 + 1e-12
    change = np.diff(velocity, axis=0)
    assert np.hypot(change[:, 0], change[:, 1]).max() <= 0.2 * DT + 1e-12
    assert np.abs(change[:, 2]).max() <= 0.5 * DT + 1e-12
    raised = [m.health for m in run.motions]
    assert any(MimicHealth.SPEED_LIMITED in h for h in raised)
    assert any(MimicHealth.ACCELERATION_LIMITED in h for h in raised)
    assert "SPEED_LIMITED" in next(h for h in raised if MimicHealth.SPEED_LIMITED in h).names


def test_without_lag_and_error_the_velocity_is_the_boats(boat):
    mimic = Mimic(boat, Carrier(lag=0.0, gain=2.0, acceleration=100.0, yaw_acceleration=100.0))
    simulator = seatrial.Simulator(boat, start=(1.0, 2.0, 0.5))
    mimic.pose(10.0, simulator.eta)
    for k in range(200):
        t = k * 0.05
        values = [np.sin(t), 0.4, np.cos(0.3 * t)]
        simulator.command(values)
        mimic.command(10.0 + t, values)
        simulator.advance_to(t + 0.05)
        motion = mimic.at(10.0 + t + 0.05)
        np.testing.assert_allclose(motion.nu, simulator.nu, atol=1e-7)
        np.testing.assert_allclose(motion.pose, simulator.eta, atol=1e-7)
        np.testing.assert_allclose(motion.velocity, simulator.nu, atol=1e-7)
        mimic.pose(motion.time, simulator.eta)
    assert motion.health == MimicHealth(0)
    np.testing.assert_allclose(motion.mismatch, 0.0, atol=1e-7)


def test_the_lead_is_the_boats_acceleration_times_the_lag(boat):
    mimic = Mimic(boat, Carrier(lag=0.2, acceleration=100.0, yaw_acceleration=100.0))
    mimic.command(0.0, [0.8, 0.3, 0.4])
    before, now, after = (mimic.at(t) for t in (0.999, 1.0, 1.001))
    rate = (after.nu - before.nu) / 0.002
    np.testing.assert_allclose(now.velocity - now.nu, 0.2 * rate, atol=1e-5)


def test_the_way_back_is_the_error_times_the_gain_in_the_carriers_frame(boat):
    mimic = Mimic(boat, Carrier(gain=1.5, yaw_rate=9.0, acceleration=100.0, yaw_acceleration=100.0))
    mimic.pose(0.0, [1.0, 1.0, 0.3])
    mimic.at(0.1)
    assert mimic.pose(0.1, [0.9, 1.0, 0.3 + np.pi / 2])
    motion = mimic.at(0.2)
    # the boat is 0.1 m along x from it; by its heading (0.3 + 90 degrees) that is mostly to the right
    heading = 0.3 + np.pi / 2
    want = [0.1 * np.cos(heading), -0.1 * np.sin(heading), -np.pi / 2]
    np.testing.assert_allclose(motion.mismatch, want, atol=1e-9)
    np.testing.assert_allclose(motion.velocity[:2], 1.5 * np.array(want[:2]), atol=1e-9)


def test_a_late_pose_is_compared_with_where_the_boat_was_then(boat):
    mimic = Mimic(boat)
    mimic.pose(0.0, [0.0, 0.0, 0.0])
    mimic.command(0.0, [1.0, 0.0, 0.5])
    poses = {k: mimic.at(k * 0.02).pose for k in range(200)}
    assert mimic.pose(3.0, poses[150])
    np.testing.assert_allclose(mimic.at(4.0).mismatch, 0.0, atol=1e-9)
    assert not mimic.pose(2.9, poses[145])  # older than the last
    assert not mimic.pose(float("nan"), poses[150])
    assert not mimic.pose(5.0, [0.0, np.inf, 0.0])


def test_too_far_away_it_stops_and_without_poses_it_says_so(boat):
    mimic = Mimic(boat, Carrier(lost=0.3, pose_timeout=0.5))
    mimic.command(0.0, [0.8, 0.0, 0.0])
    assert MimicHealth.NO_POSE in mimic.at(0.1).health
    mimic.pose(0.1, [0.0, 0.0, 0.0])
    running = [mimic.at(0.1 + 0.02 * k) for k in range(20)]
    assert running[-1].velocity[0] > 0.02
    mimic.pose(0.5, [-1.0, 0.0, 0.0])
    stopped = [mimic.at(0.5 + 0.02 * k) for k in range(20)]
    assert MimicHealth.LOST in stopped[-1].health
    np.testing.assert_allclose(stopped[-1].velocity, 0.0)
    assert any("stopped" in words for words in stopped[-1].health.advice)
    late = mimic.at(1.2)
    assert MimicHealth.NO_POSE in late.health
    assert MimicHealth.LOST not in late.health


def test_silent_commands_stop_the_thrusters(boat):
    file = msgspec.structs.replace(boat.vehicle.file, command_timeout=0.5)
    mimic = Mimic(replace(boat, vehicle=replace(boat.vehicle, file=file)))
    mimic.command(0.0, [1.0, 0.0, 0.0])
    speeds = [mimic.at(0.02 * k).nu[0] for k in range(200)]
    assert MimicHealth.COMMAND_SILENCE in mimic.at(4.0).health
    assert speeds[-1] < 0.9 * max(speeds)
    at = int(np.argmax(speeds)) * 0.02
    assert 0.5 < at < 1.0  # the lag goes on a while
    mimic.command(4.1, [1.0, 0.0, 0.0])
    assert MimicHealth.COMMAND_SILENCE not in mimic.at(4.2).health


def test_an_unstable_model_stops_the_carrier(mp):
    mimic = Mimic(make_model(mp, TABLE_II["AF"] | {"X_u": 5.0, "X_uu": 5.0}))
    mimic.command(0.0, [1.0, 0.0, 0.0])
    for k in range(1500):
        motion = mimic.at(0.02 * k)
    assert MimicHealth.DIVERGED in motion.health
    np.testing.assert_allclose(motion.velocity, 0.0)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"speed": 0.0}, "speed is 0; expected more than 0 m/s: give the carrier's highest"),
        ({"yaw_rate": -1.0}, "yaw_rate is -1; expected more than 0 rad/s: give the carrier's highest"),
        ({"acceleration": np.nan}, "acceleration is nan; expected more than 0 m/s^2: give the"),
        ({"yaw_acceleration": -0.5}, "yaw_acceleration is -0.5; expected more than 0 rad/s^2: give"),
        ({"lag": 2.0}, "lag is 2; expected 0 to 1 s: measure its delay and time constant"),
        ({"gain": 50.0}, "gain is 50; expected 0 to 20 1/s: a third of one over its delay is"),
        ({"pose_timeout": 0.0}, "pose_timeout is 0; expected more than 0 s: give some periods"),
        ({"lost": -2.0}, "lost is -2; expected more than 0 m: give how far from the virtual boat"),
        ({"speed": "fast"}, "speed is 'fast'; expected a number"),
    ],
)  # fmt: skip
def test_a_carrier_that_can_not_be_is_said(boat, settings, words):
    with pytest.raises(MimicError, match="^" + re.escape(f"carrier: {words}")):
        Mimic(boat, Carrier(**settings))


def test_what_is_asked_beyond_the_limits_is_told(boat):
    """The velocity given is the one asked, along the same direction, down to the limit."""
    free, slow = Mimic(boat, Carrier(lag=0.0)), Mimic(boat, Carrier(lag=0.0, speed=0.05))
    for k in range(200):
        for one in (free, slow):
            one.command(0.02 * k, [1.0, 0.3, 0.0])
            motion = one.at(0.02 * (k + 1))
        if k == 0:
            np.testing.assert_allclose(motion.asked, motion.nu, atol=1e-12)
    assert MimicHealth.SPEED_LIMITED in motion.health
    np.testing.assert_allclose(motion.asked, free.at(4.0).velocity, rtol=1e-9)
    assert np.hypot(*motion.velocity[:2]) == pytest.approx(0.05)
    np.testing.assert_allclose(
        motion.velocity / np.linalg.norm(motion.velocity), motion.asked / np.linalg.norm(motion.asked)
    )  # fmt: skip


def test_inputs_of_another_shape_are_said(boat):
    mimic = Mimic(boat)
    with pytest.raises(PredictorError, match="expected 3 numbers"):
        mimic.command(0.0, [1.0])
    assert not mimic.command(0.0, [1.0, np.nan, 0.0])


def test_the_wheels_are_mecanum_wheels():
    """Forward: all alike; sideways: diagonal pairs; and the body's velocity comes back."""
    np.testing.assert_allclose(TO_WHEELS @ [1, 0, 0], [1, 1, 1, 1])
    np.testing.assert_allclose(TO_WHEELS @ [0, 1, 0], [-1, 1, 1, -1])
    np.testing.assert_allclose(TO_BODY @ TO_WHEELS, np.eye(3), atol=1e-12)
    perfect = SimulatedCarrier(
        Ground(lag=1e-6, delay=0.0, worn=0.0, slips_per_minute=0.0), 0.001, 0
    )
    for _ in range(1000):
        perfect.step(np.array([0.2, 0.0, 0.5]))
    np.testing.assert_allclose(
        perfect.eta, [0.4 * np.sin(0.5), 0.4 * (1 - np.cos(0.5)), 0.5], atol=1e-6
    )
    assert _core.wrap(np.array([perfect.eta[2]]))[0] == pytest.approx(0.5)


@pytest.mark.parametrize("command", ["mimic", "sim"])
def test_the_commands_refuse_an_unstable_model(mp, tmp_path, capsys, command):
    path = tmp_path / "model.yaml"
    seatrial.save(make_model(mp, TABLE_II["AF"] | {"X_u": 3.0, "X_uu": 3.0}), path)
    assert "unstable" in refused(capsys, command, path)


def test_the_help_states_the_defaults_of_the_core():
    for name, (_, text) in LIMITS.items():
        (stated,) = re.findall(r"\(default: (.*)\)", text)
        assert float(stated) == getattr(_core.Carrier(), name.replace("-", "_"))
