# SPDX-License-Identifier: MIT
"""The actuator chain by the core: static curves and step responses."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.steering import angle_names, steered_entries
from seatrial.util.frames import Array
from seatrial.util.statistics import root_of

CHAIN_DRAWS = 200  # of the constants
CHAIN_SEED = 7
CURVE_POINTS = 241
DEGREES = 180.0 / np.pi  # of a radian
BEFORE_STEP, AFTER_STEP = 0.5, 3.0  # [s] that a step response shows at least


@dataclass(frozen=True)
class Curve:
    """A static curve or a step response with its 95 % band, and the actuators or inputs it is of."""

    names: tuple[str, ...]
    x: Array  # (n,) command, or time since the step [s]
    y: Array  # (n,) share of the thrust at full command; [deg] of an angle
    low: Array  # (n,)
    high: Array  # (n,)

    @property
    def label(self) -> str:
        """The names, shortened."""
        if len(self.names) <= 3:
            return ", ".join(self.names)
        return f"{self.names[0]} … {self.names[-1]}, {len(self.names)} alike"


def curves(model: Model) -> list[Curve]:
    """Thrust against command of every kind of thruster, the others at rest."""
    angles = angle_names(model.vehicle.file.chain)
    return _static(model, [name for name in model.vehicle.actuators if name not in angles], 1.0)


def angle_curves(model: Model) -> list[Curve]:
    """Angle [deg] against command of every kind of angle, with its trim; empty where the boat has none."""
    return _static(model, angle_names(model.vehicle.file.chain), DEGREES)


def _static(model: Model, names: Sequence[str], unit: float) -> list[Curve]:
    """Static curves of these actuators. `unit`: of one in the core."""
    vehicle = model.vehicle
    x = np.linspace(-1.0, 1.0, CURVE_POINTS)
    drawn = _drawn(model)
    found: list[Curve] = []
    for name in names:
        k = vehicle.actuators.index(name)
        commands = np.zeros((CURVE_POINTS, len(vehicle.actuators)))
        sign = vehicle.actuator_signs[k]  # drawn in the file's signs
        commands[:, k] = sign * x
        every = unit * sign * np.array([_core.curve(vehicle.chain, q, k, commands) for q in drawn])
        _add(found, _curve((name,), x, every))
    return found


def step_responses(model: Model) -> list[Curve]:
    """Force after a step of each input from rest to full, over its final value.

    An angle has a force where its thrust has: that is full ahead all the time.
    """
    vehicle = model.vehicle
    drawn = _drawn(model)
    longest = _settling_time(model)
    t = np.linspace(-max(BEFORE_STEP, longest / 4.0), max(AFTER_STEP, longest), CURVE_POINTS)
    thrust_of = {
        angle: thrust for e in steered_entries(vehicle.file.chain) for thrust, angle in e.of
    }
    references = [vehicle.file.scales[name].reference for name in vehicle.scales]
    scales = np.array([references], dtype=float).reshape(1, len(references))
    found: list[Curve] = []
    for i, name in enumerate(vehicle.inputs):
        commands = np.zeros((2, len(vehicle.inputs)))
        if (held := thrust_of.get(name)) in vehicle.inputs:
            k = vehicle.inputs.index(held)
            commands[:, k] = vehicle.input_signs[k]
        commands[1, i] = 1.0
        every = np.array([_step(model, q, commands, scales, t) for q in drawn])
        if not np.isfinite(every).all():
            continue
        _add(found, _curve((name,), t, every))
    return found


def _add(found: list[Curve], new: Curve) -> None:
    """Join the names of equal curves; append a new one."""
    for place, old in enumerate(found):
        if np.allclose(old.y, new.y, atol=1e-3):
            found[place] = Curve((*old.names, *new.names), old.x, old.y, old.low, old.high)
            return
    found.append(new)


def _step(model: Model, q: Array, commands: Array, scales: Array, t: Array) -> Array:
    """The force that a step changes most, as share of the change; NaN where it changes none."""
    begin = np.array([t[0] - 60.0, 0.0])
    trace = _core.ThrustTrace(model.vehicle.chain, q, begin, commands, begin[:1], scales)
    forces = np.asarray(trace.forces(t))
    changes = forces - forces[0]
    most = int(np.argmax(np.abs(changes[-1])))
    last = float(changes[-1, most])
    return changes[:, most] / last if abs(last) > 0 else np.full(len(t), np.nan)


def _settling_time(model: Model) -> float:
    """Four times the largest latency and lag, and the longest stroke at its rate limit [s]."""
    each, q = model.vehicle.constants.of_each, model.constants
    angle = each(
        "full_angle", q
    )  # [deg]; 0: a thruster, whose stroke is from full astern to full ahead
    rate, stroke = each("slew_rate", q), np.where(angle > 0.0, angle, 2.0)
    limited = rate > 0.0
    strokes = stroke[limited] / rate[limited]
    slowest = np.abs(each("latency", q)).max() + np.abs(each("lag", q)).max()
    return float(4.0 * slowest + strokes.max(initial=0.0))


def _drawn(model: Model) -> Array:
    """Constants (draws, m): the model's own first."""
    n = len(model.coefficients)
    covariance = model.covariance[n:, n:]
    own = model.constants[None, :]
    if not covariance.any():
        return np.array(own)
    normal = np.random.default_rng(CHAIN_SEED).normal(size=(CHAIN_DRAWS, len(covariance)))
    moved = own + normal @ root_of(covariance).T
    # no draw beyond what an estimate can be; a given value may be
    low, high = np.array([model.vehicle.constants.bounds(i) for i in range(own.size)]).T
    moved = np.clip(moved, np.minimum(own, low), np.maximum(own, high))
    return np.vstack([own, moved])


def _curve(names: tuple[str, ...], x: Array, every: Sequence[Array] | Array) -> Curve:
    found = np.asarray(every)
    if len(found) == 1:
        return Curve(names, x, found[0], found[0], found[0])
    low, high = np.quantile(found[1:], [0.025, 0.975], axis=0)
    return Curve(names, x, found[0], low, high)
