# SPDX-License-Identifier: MIT
"""Simulated trials like the paper's S1-S7: an operator, a boat, a SLAM, two clocks."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial import _core
from seatrial.boat.allocation import Scheme
from seatrial.boat.model import Model
from seatrial.boat.schema import EnvelopeEntry, EstimatorEntry, Integration, NoiseEntry
from seatrial.boat.steering import angles_alone
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.delays import heading_at_positions, stamps_of_headings
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.recording.velocity import Motion
from seatrial.simulation.joypad import joypad_of, response
from seatrial.simulation.pilots import make_operator
from seatrial.simulation.plan import DisturbanceForce, PlanFile, PoseSensor, TrialEntry
from seatrial.util.arguments import expect
from seatrial.util.errors import ModelError, VehicleError
from seatrial.util.frames import Array, Mask, Stamps, body_velocity, earth_offset

SUFFIX = {Scheme.MP: "-MP", Scheme.AF: "-AF", Scheme.DIRECT: ""}
TRANSPORT = 0.002  # [s] from the stamp of a message to its arrival at the recorder
LEAD = 0.5  # [s] of joypad before the first pose and after the last
OUTSIDE_POOL = 0.3  # [m] beyond the wall: the trial is refused
DISTURBANCE_STEP = 0.01  # [s] of the disturbance force


@dataclass(frozen=True, eq=False)
class Trial:
    """One simulated trial: the recording, and the truth at every pose tick.

    name: such as S1
    vehicle: its vehicle file
    pose_stamps: (n,) [ns] of the poses that arrived
    pose: (n, 3) of the SLAM, heading wrapped
    command_stamps: (m,) [ns] by the joypad's clock
    command: (m, inputs)
    pose_arrival: (n,) [ns] by the recorder's clock, which is the poses'
    command_arrival: (m,) [ns]
    truth_t: (k,) [s] true times of all pose ticks
    truth: (k, 6) x, y, psi, u, v, r
    truth_force: (k, forces) generalised forces after the actuator chain
    arrived: (k,) ticks whose pose arrived
    """

    name: str
    vehicle: Vehicle
    pose_stamps: Stamps
    pose: Array
    command_stamps: Stamps
    command: Array
    pose_arrival: Stamps
    command_arrival: Stamps
    truth_t: Array
    truth: Array
    truth_force: Array
    arrived: Mask

    @cached_property
    def recording(self) -> Recording:
        """The recording, as from `read`."""
        commands = Signal(self.vehicle.inputs, self.command_stamps, self.command)
        position, heading = self.vehicle.delays
        stamps = stamps_of_headings(self.pose_stamps, heading)
        eta, apart = self.pose.copy(), position - heading
        psi = heading_at_positions(self.pose_stamps, eta[:, 2], apart)
        eta[:, :2] -= earth_offset(psi, *self.vehicle.lever)
        names = self.vehicle.scales
        scales = Signal(names, self.command_stamps, self.scale) if names else None
        return make_recording(self.name, stamps, eta, commands, scales=scales, position_delay=apart)

    @property
    def scale(self) -> Array:
        """Known signals (m, scales) that scale thrust, at their references, as the plant has them."""
        references = [scale.reference for scale in self.vehicle.file.scales.values()]
        return np.tile(np.array(references, dtype=float), (len(self.command), 1))

    @cached_property
    def true_motion(self) -> Motion:
        """True poses and velocities at the recording's poses."""
        x = self.truth[self.arrived]
        return Motion(self.recording.t, x[:, :3], x[:, 3:], self.recording.valid)


def simulate(plan: PlanFile, vehicle: Vehicle, model: Model | None = None) -> Iterator[Trial]:
    """The plan's trials with one vehicle, in order, each simulated when it is its turn.

    The truth is the plan's plant, or `model` if given. The same plan, vehicle and seed give the
    same trials; each trial has its own stream of random numbers.
    """
    expect(plan, PlanFile, "plan")
    expect(vehicle, Vehicle, "vehicle")
    plant = plant_model(plan, vehicle) if model is None else model.with_vehicle(vehicle)
    still = [name for name, entry in plan.trials.items() if entry.drive == "sway"]
    if not joypad_of(plant).sway and still:
        raise VehicleError(
            f"{vehicle.source}: trial {still[0]} of plan {plan.name} drives sway, and no input moves this boat in "
            "sway alone; give a plan without sway, such as --plan lake"
        )
    return (_run(plan, plant, name, entry) for name, entry in plan.trials.items())


def plant_model(plan: PlanFile, vehicle: Vehicle) -> Model:
    """The plan's plant as a model: the truth for identified models."""
    if vehicle.automatic:
        raise VehicleError(
            f"{vehicle.source}: structure: auto has no terms before recordings choose them; simulate a model, "
            "--model MODEL, or write the terms"
        )
    driven = vehicle.with_chain(plan.plant.chain)
    names = driven.structure.coefficients
    if driven.estimated:
        raise VehicleError(
            f"plan {plan.name}: the plant's chain leaves {', '.join(driven.estimated)} to be "
            "estimated; give numbers"
        )
    odd = set(names) ^ set(plan.plant.coefficients)
    if odd:
        raise ModelError(
            f"plan {plan.name}: its plant and the structure of {vehicle.source} disagree on "
            f"{', '.join(sorted(odd))}; expected {', '.join(names)}. Drive an identified boat, --model MODEL, or "
            "write its coefficients into a plan"
        )
    values = np.array([plan.plant.coefficients[name] for name in names])
    return Model(
        driven,
        values,
        np.zeros((len(values), len(values))),
        driven.constants.values,
        Integration("runge-kutta", plan.plant.step),
        NoiseEntry(plan.pose.position_noise, plan.pose.heading_noise),
        EnvelopeEntry({}, {}),
        estimator=EstimatorEntry("truth", {"plan": plan.name}),
    )


def _run(plan: PlanFile, model: Model, name: str, entry: TrialEntry) -> Trial:
    label = name + SUFFIX[model.vehicle.scheme]
    rng = np.random.default_rng([plan.seed, zlib.crc32(label.encode())])
    stick_t, inputs, truth_t, truth, force, seen = _drive(plan, model, label, entry, rng)
    joypad_t = np.arange(-LEAD, entry.duration + LEAD, 1.0 / plan.joypad.rate)
    held = np.maximum(np.searchsorted(stick_t, joypad_t + 1e-9, side="right") - 1, 0)
    command = np.where((joypad_t < 0)[:, None], 0.0, inputs[held])
    pose, arrived = _observe(plan.pose, truth_t, seen, rng)
    pose_t = truth_t + rng.normal(0.0, 1.0, len(truth_t)) * plan.pose.stamp_jitter
    return Trial(
        label,
        model.vehicle.with_chain(angles_alone(model.vehicle.file.chain)),
        _nanoseconds(pose_t)[arrived],
        pose[arrived],
        _nanoseconds(joypad_t + plan.joypad.clock_offset),
        command,
        _nanoseconds(truth_t + TRANSPORT)[arrived],
        _nanoseconds(joypad_t + TRANSPORT),
        truth_t,
        truth,
        force,
        arrived,
    )


def _drive(
    plan: PlanFile,
    model: Model,
    label: str,
    entry: TrialEntry,
    rng: np.random.Generator,
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Operator and boat in closed loop: times of sticks and the inputs then, truth at the pose ticks.

    The last is the measured pose: that of the lever arm, position and heading as late as these are.
    """
    joypad = joypad_of(model)
    operator = make_operator(entry.drive, plan.operator, plan.pool, rng, sway=joypad.sway)
    disturbance = np.random.default_rng([plan.seed, zlib.crc32(label.encode()), 1])
    plant = DisturbedPlant(model, plan.plant.unmodelled, disturbance)
    state = np.zeros(6)
    state[2] = operator.start_heading()
    plant.state = state
    tick = 1.0 / plan.joypad.rate
    looks = np.arange(0, entry.duration, plan.operator.reaction)
    looks = np.round(looks / tick) * tick  # sticks are read at the joypad's rate
    ticks = np.arange(0, entry.duration, 1.0 / plan.pose.rate)
    sensor = plan.pose
    delays = np.add(model.vehicle.delays, (sensor.position_delay, sensor.heading_delay))
    late = [np.maximum(ticks - d, 0.0) for d in delays]
    poses = np.unique(np.concatenate([ticks, *late]))
    inputs = np.zeros((len(looks), len(model.vehicle.inputs)))
    truth = np.zeros((len(poses), 6))
    force = np.zeros((len(poses), len(model.structure.forces)))
    due, j = [*poses.tolist(), np.inf], 0
    for i, t in enumerate(looks.tolist()):
        while due[j] < t:
            j = _note(plant, due[j], truth, force, j)
        plant.advance_to(t)
        x = plant.state
        _check_inside(plan, label, t, x)
        inputs[i] = joypad.inputs(operator.look(t, x))
        plant.command(t, inputs[i])
    while j < len(poses):
        j = _note(plant, due[j], truth, force, j)
    at, *before = (np.searchsorted(poses, t) for t in (ticks, *late))
    point = truth[before[0], :2] + earth_offset(truth[before[0], 2], *model.vehicle.lever)
    seen = np.column_stack([point, truth[before[1], 2]])
    return looks, inputs, ticks, truth[at], force[at], seen


def _check_inside(plan: PlanFile, label: str, t: float, state: Array) -> None:
    """Raise ModelError where the boat has left the pool."""
    wall_x, wall_y = plan.pool.length / 2 + OUTSIDE_POOL, plan.pool.width / 2 + OUTSIDE_POOL
    if not (abs(state[0]) < wall_x and abs(state[1]) < wall_y):
        raise ModelError(
            f"{label}: the boat left the pool after {t:.1f} s at ({state[0]:.2f}, {state[1]:.2f}) m; "
            "the plant is too fast or too weak for this operator and pool"
        )


class DisturbedPlant(_core.Plant):
    """The plant with a disturbance force: a velocity increment every DISTURBANCE_STEP."""

    def __init__(
        self, model: Model, force: DisturbanceForce | None, rng: np.random.Generator
    ) -> None:
        super().__init__(model.boat, model.vehicle.chain, model.constants)
        self.force, self.rng = force, rng
        if force is not None:
            self.response = response(model) * force.share  # to full thrust, force by force
            self.level = rng.normal(size=len(self.response))

    def advance_to(self, t: float) -> bool:
        """Advance to t [s]."""
        if self.force is None:
            return super().advance_to(t)
        begin, good = self.time, True
        steps = max(1, round((t - begin) / DISTURBANCE_STEP))
        length = (t - begin) / steps
        decay = np.exp(-length / self.force.correlation)
        noise = np.sqrt(1.0 - decay**2) * self.rng.normal(size=(steps, len(self.level)))
        for i in range(steps):
            state = self.state
            acceleration = self.level @ self.response
            if self.force.earth_fixed:
                # accelerations rotate like velocities
                acceleration = body_velocity(state[2:3], acceleration[None])[0]
            state[3:] += acceleration * length
            self.state = state
            good = super().advance_to(t if i == steps - 1 else begin + (i + 1) * length)
            self.level = decay * self.level + noise[i]
        return good


def _note(plant: _core.Plant, t: float, truth: Array, force: Array, j: int) -> int:
    plant.advance_to(t)
    truth[j] = plant.state
    force[j] = plant.forces(force.shape[1])
    return j + 1


def _observe(
    sensor: PoseSensor, t: Array, eta: Array, rng: np.random.Generator
) -> tuple[Array, Mask]:
    """Poses of a SLAM: with noise, drop-outs and jumps."""
    n = len(t)
    noise = np.array([sensor.position_noise, sensor.position_noise, sensor.heading_noise])
    pose = eta + _coloured(rng.normal(0.0, 1.0, (n, 3)), t, sensor.noise_correlation) * noise
    minutes = (t[-1] - t[0]) / 60.0
    for _ in range(rng.poisson(sensor.jumps.per_minute * minutes)):
        first = int(rng.integers(1, n))
        last = first + int(rng.integers(1, sensor.jumps.samples + 1))
        size, angle = (
            rng.uniform(sensor.jumps.shortest, sensor.jumps.longest),
            rng.uniform(-np.pi, np.pi),
        )
        pose[first:last] += size * np.array([np.cos(angle), np.sin(angle), rng.uniform(-1.0, 1.0)])
    arrived = np.ones(n, dtype=bool)
    for _ in range(rng.poisson(sensor.drop_outs.per_minute * minutes)):
        begin = rng.uniform(t[0], t[-1])
        end = begin + rng.uniform(sensor.drop_outs.shortest, sensor.drop_outs.longest)
        arrived[(t >= begin) & (t < end)] = False
    arrived[0] = True
    pose[:, 2] = _core.wrap(np.ascontiguousarray(pose[:, 2]))
    return pose, arrived


def _coloured(white: Array, t: Array, correlation: float) -> Array:
    """First-order Gauss-Markov noise of the same variance; white where `correlation` [s] is 0."""
    if correlation == 0.0:
        return white
    decay = np.exp(-np.diff(t) / correlation)
    out = white.copy()
    for k, a in enumerate(decay.tolist(), start=1):
        out[k] = a * out[k - 1] + np.sqrt(1.0 - a * a) * white[k]
    return out


def _nanoseconds(t: Array) -> Stamps:
    return np.rint(t * 1e9).astype(np.int64)
