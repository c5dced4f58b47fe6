# SPDX-License-Identifier: MIT
"""Pose errors that last, and strong pushes: told from motion, and from velocities that wander."""

import numpy as np
import pytest
from conftest import at_length, make_model, on_request
from survey_boat import both, driven, pulses

from seatrial import _core
from seatrial.boat.findings import FindingKind
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.estimator import fit, output_error
from seatrial.identification.likelihood.optimiser import maximise_likelihood
from seatrial.identification.likelihood.start_noise import noise_from_poses
from seatrial.recording.from_poses import make_recording
from seatrial.recording.resolution import heading_step
from tests.boats.motions import recorded, states_at
from tests.boats.vehicles import by_columns

SURGE = {
    "X_u": -0.2, "X_uu": -1.7, "X_F": 0.3, "Y_v": -0.3, "Y_vv": -1.3, "Y_F": 0.3, "N_r": -0.7, "N_rr": -0.3, "N_F": 1.4,
}  # fmt: skip


def tug(chain=()):
    structure = {
        "surge": ["v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
        "sway": ["-1 * u * r", "Y_v * v", "Y_vv * |v| * v", "Y_F * F_v"],
        "yaw": ["N_r * r", "N_rr * |r| * r", "N_F * F_r"],
    }
    return by_columns("tug", ("F_u", "F_v", "F_r"), structure, chain=list(chain))


def come_and_go(rng, t, memory):
    """What is 1 on average of its square, and forgotten after `memory` [s]."""
    keep = np.exp(-np.diff(t, prepend=t[0]) / memory)
    out = rng.normal(size=len(t))
    for i in range(1, len(t)):
        out[i] = keep[i] * out[i - 1] + np.sqrt(1.0 - keep[i] ** 2) * out[i]
    return out


def under_gnss(seed, sd, memory, seconds=200.0):
    """Poses at 10 Hz whose position errs by `sd` [m] for `memory` [s], and by 1 cm from pose to pose."""
    rng = np.random.default_rng(seed)
    truth = make_model(tug([{"latency": 0.05, "lag": 0.1}]), SURGE)
    values = np.column_stack([pulses(rng, seconds, both, 0.3) for _ in range(3)])
    begin, t = np.arange(len(values)) / 20.0, np.arange(0.0, seconds, 0.1)
    eta = states_at(truth, t, begin, values)[:, :3]
    eta += rng.normal(size=eta.shape) * [0.01, 0.01, 2e-3]
    for i in range(2):
        eta[:, i] += sd * come_and_go(rng, t, memory)
    return recorded(f"drive {seed}", truth.vehicle, (t, eta), (begin, values))


def of_a_filter(seed, seconds=120.0, tau=2.0):
    """Positions at 10 Hz, white by 1 cm, and the heading of a complementary filter at 50 Hz: gyro and compass."""
    recording = under_gnss(seed, 0.0, 1.0, seconds)
    rng = np.random.default_rng(seed)
    truth = make_model(tug([{"latency": 0.05, "lag": 0.1}]), SURGE)
    commands, t = recording.commands, np.arange(0.0, seconds, 0.02)
    psi = states_at(truth, t, recording.seconds(commands.stamps), commands.values)[:, 2]
    gyro = np.diff(psi, prepend=psi[0]) + 0.02 * rng.normal(1e-3, 2e-3, len(t))  # [rad]
    compass = psi + 0.01 * come_and_go(rng, t, 5.0) + 0.02 * rng.normal(size=len(t))
    heading = psi.copy()
    for i in range(1, len(t)):
        ahead = heading[i - 1] + gyro[i]
        heading[i] = ahead + 0.02 / tau * (compass[i] - ahead)
    return recording, heading[::5]


@pytest.mark.parametrize(("step", "least"), [(0.01, 4.36e-5), (0.0, 1e-6)])
def test_the_heading_of_a_filter_has_a_floor_and_is_named(step, least):
    """Centidegrees, as an autopilot logs them, have rounding errors of 0.05 mrad: less is impossible."""
    recording, heading = of_a_filter(2)
    if step:
        heading = np.radians(step * np.round(np.degrees(heading) / step))
    assert np.degrees(heading_step(make(recording, heading))) == pytest.approx(step)
    model = output_error([make(recording, heading)], tug())
    assert model.noise.heading == pytest.approx(least, rel=0.01)
    (named,) = model.findings_of(FindingKind.SMOOTH_HEADING)
    assert 3.0 < named.number("lasting") < 15.0  # [mrad]
    for name, value in SURGE.items():
        assert model.values[name] == pytest.approx(value, abs=4.0 * model.standard_errors[name])


def tracked(z, step, white, acceleration):
    """Positions (n,) of a Kalman filter for constant velocity, as in a GNSS receiver."""
    ahead, out = np.array([[1.0, step], [0.0, 1.0]]), z.copy()
    spread = acceleration * np.array([[step**3 / 3.0, step**2 / 2.0], [step**2 / 2.0, step]])
    x, p = np.array([z[0], 0.0]), np.eye(2)
    for i in range(1, len(z)):
        x, p = ahead @ x, ahead @ p @ ahead.T + spread
        gain = p[:, 0] / (p[0, 0] + white**2)
        x, p = x + gain * (z[i] - x[0]), p - np.outer(gain, p[0])
        out[i] = x[0]
    return out


@pytest.mark.parametrize("filtered", [True, False])
def test_the_position_of_a_filter_is_named_and_no_other_one(filtered):
    recording = under_gnss(4, 0.0, 1.0, 120.0)
    eta = recording.raw.copy()
    if filtered:
        eta[:, :2] = np.column_stack([tracked(z, 0.1, 0.01, 3e-3) for z in eta[:, :2].T])
    model = output_error(
        [make_recording("drive", recording.stamps, eta, recording.commands)], tug()
    )
    found = model.findings_of(FindingKind.SMOOTH_POSITION)
    assert len(found) == filtered
    for named in found:
        assert 3.0 < named.number("lasting") < 15.0  # [mm]
        assert 0.1 < named.number("memory") < 1.0  # [s]


def make(recording, heading):
    """The recording with other headings."""
    eta = np.column_stack([recording.raw[:, :2], heading])
    return make_recording(recording.name, recording.stamps, eta, recording.commands)


@pytest.mark.parametrize("step", [np.radians(1.0), 1e-3, 0.0])
def test_steps_of_a_heading_are_seen_in_degrees_and_in_radians(step):
    rng = np.random.default_rng(1)
    recording = under_gnss(11, 0.0, 1.0, 20.0)
    heading = 0.3 + np.cumsum(rng.normal(scale=0.1, size=len(recording.t)))
    if step:
        heading = 0.3 + step * np.round(heading / step)
    assert heading_step(make(recording, heading)) == pytest.approx(step)
    assert heading_step(make(recording, np.full(len(recording.t), 0.3))) == 0.0


@pytest.mark.parametrize(
    ("sd", "memory"), [(0.05, 1.5), on_request(0.05, 3.0), at_length(0.3, 20.0)]
)
def test_position_errors_that_last_for_seconds_are_no_motion(sd, memory):
    """As those of GNSS do: a velocity that wanders would stand for them, and thrust that follows it."""
    recordings = [under_gnss(seed, sd, memory) for seed in (11, 12, 13)]
    model = output_error(recordings, tug())
    for name, value in SURGE.items():
        assert model.values[name] == pytest.approx(value, abs=4.5 * model.standard_errors[name]), (
            name
        )
    assert model.standard_errors["X_F"] < 0.02
    coloured = model.noise.correlated
    assert coloured is not None
    assert 0.5 * memory < coloured.memory < 4.0 * memory
    assert not model.findings_of(FindingKind.NO_BETTER_THAN_CONSTANT)


@pytest.mark.system
def test_a_strong_push_is_not_taken_for_a_velocity_that_wanders():
    """A sixth of full thrust, and commands that answer it: the boat goes from place to place by itself."""
    truth = make_model(tug([{"latency": 0.05, "lag": 0.1}]), SURGE)
    recordings = [going(truth, seed) for seed in (20, 21)]
    model = output_error(recordings, tug())
    for name, value in SURGE.items():
        assert model.values[name] == pytest.approx(value, abs=4.5 * model.standard_errors[name]), (
            name
        )
    assert model.noise.process.disturbance_linear == pytest.approx(0.05, rel=0.2)
    assert model.noise.process.disturbance_yaw == pytest.approx(0.2, rel=0.2)


def going(truth, seed, seconds=200.0, rate=20.0):
    """From place to place by a controller, pushed by 0.05 m/s^2 and 0.2 rad/s^2 that last 5 s."""
    rng = np.random.default_rng(seed)
    pushed = _pushed_tug()
    model = make_model(pushed, SURGE)
    plant = _core.Plant(
        _core.Boat(pushed.structure.compiled, model.coefficients, 0, 1 / 240),
        pushed.chain,
        model.constants,
    )
    t = np.arange(round(seconds * rate)) / rate
    push = np.column_stack([s * come_and_go(rng, t, 5.0) for s in (0.05, 0.05, 0.2)])
    commands, states, seen = np.zeros((len(t), 3)), np.zeros((len(t), 6)), np.zeros((len(t), 3))
    aim, until, force, rate_seen, last = np.zeros(3), 0.0, np.zeros(3), np.zeros(3), None
    for i, now in enumerate(t):
        if i:
            plant.advance_to(now)
        states[i] = plant.state
        if now >= until:
            aim, until = rng.uniform(-1.0, 1.0, 3) * [1.0, 1.0, 3.0], now + rng.uniform(4.0, 15.0)
        if i % 2 == 0:
            seen[i] = states[i, :3] + rng.normal(size=3) * [2e-3, 2e-3, 3e-3]
            if last is not None:
                rate_seen = 0.7 * rate_seen + 0.3 * (seen[i] - last) * rate / 2
            last, off = seen[i], aim - seen[i]
            off[2] = (off[2] + np.pi) % (2 * np.pi) - np.pi
            pull = np.array([2.0, 2.0, 1.0]) * off - np.array([2.5, 2.5, 0.8]) * rate_seen
            c, s = np.cos(seen[i, 2]), np.sin(seen[i, 2])
            force = np.clip(
                [c * pull[0] + s * pull[1], c * pull[1] - s * pull[0], pull[2]], -1.0, 1.0
            )
        commands[i] = force
        plant.command(now, np.concatenate([force, push[i]]))
    return recorded(f"drive {seed}", truth.vehicle, (t[::2], seen[::2]), (t, commands))


def _pushed_tug():
    """The same with inputs of its own for what pushes it, without latency and lag."""
    content = tug(
        [{"name": "own", "actuators": ["F_u", "F_v", "F_r"], "latency": 0.05, "lag": 0.1}]
    ).to_mapping()
    pushes = {"surge": "F_du", "sway": "F_dv", "yaw": "F_dr"}
    names = ["F_u", "F_v", "F_r", *pushes.values()]
    content["commands"]["inputs"] = {n: {"column": n} for n in names}
    axes = [*pushes, *pushes]
    content["forces"] = {n: {"axis": a, "of": {n: 1.0}} for n, a in zip(names, axes, strict=True)}
    for axis, name in pushes.items():
        content["structure"][axis].append(f"1 * {name}")
    return vehicle_from(content, "pushed tug")


@pytest.mark.system
def test_metres_of_pose_noise_are_as_centimetres_of_a_smaller_boat():
    """Lengths times 40: the same poses, the same numbers."""
    noise = np.array([0.05, 0.05, 0.02])
    vehicle, drive = driven({}, [both, both, both], bow=True, seconds=600.0, noise=noise)
    eta = drive.raw.copy()
    eta[:, :2] *= 40.0
    large = make_recording("large", drive.stamps, eta, drive.commands)
    small, large = (output_error([r], vehicle) for r in (drive, large))
    assert large.noise.position == pytest.approx(40.0 * small.noise.position, rel=0.01)
    for name, times in (("X_F", 40.0), ("Y_F", 40.0), ("X_uu", 1 / 40.0), ("N_r", 1.0)):
        error = small.standard_errors[name]
        assert large.values[name] / times == pytest.approx(small.values[name], abs=0.05 * error)
        assert large.standard_errors[name] / times == pytest.approx(error, rel=0.02)


def test_a_start_outside_the_bounds_is_moved_into_them_with_the_others():
    """Quadratic drag that drives, and linear drag that makes up for it: none of both is where it is."""
    vehicle, drive = driven({}, [both, both, both], bow=True, seconds=200.0)
    found = fit([drive], vehicle)
    theta = found.theta.copy()
    quadratic, linear = (found.problem.names.index(n) for n in ("X_uu", "X_u"))
    theta[quadratic], theta[linear] = 0.9, -0.6
    assert found.problem.clipped(theta)[quadratic] == 0.0
    again = maximise_likelihood(found.problem, theta, noise_from_poses([drive]))
    assert again.runs.cost == pytest.approx(found.runs.cost, abs=0.5)
    assert again.theta[quadratic] == pytest.approx(found.theta[quadratic], abs=0.1)
