# SPDX-License-Identifier: MIT
"""The actuator chain by the core: static curve and step response."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.util.frames import Array

CHAIN_DRAWS = 200  # of the constants
CHAIN_SEED = 7
CURVE_POINTS = 241
BEFORE_STEP, AFTER_STEP = 0.5, 3.0  # [s] that a step response shows at least


@dataclass(frozen=True)
class Curve:
    """A static curve or a step response with its 95 % band, and the actuators or inputs it is of."""

    names: tuple[str, ...]
    x: Array  # (n,) command, or time since the step [s]
    y: Array  # (n,) share of the thrust at full command
    low: Array  # (n,)
    high: Array  # (n,)

    @property
    def label(self) -> str:
        """The names, shortened."""
        if len(self.names) <= 3:
            return ", ".join(self.names)
        return f"{self.names[0]} … {self.names[-1]}, {len(self.names)} alike"


def curves(model: Model) -> list[Curve]:
    """Thrust against command of every kind of actuator, the others at rest."""
    vehicle = model.vehicle
    x = np.linspace(-1.0, 1.0, CURVE_POINTS)
    drawn = _drawn(model)
    found: list[Curve] = []
    for k, name in enumerate(vehicle.actuators):
        commands = np.zeros((CURVE_POINTS, len(vehicle.actuators)))
        sign = vehicle.actuator_signs[k]  # drawn in the file's signs
        commands[:, k] = sign * x
        every = sign * np.array([_core.curve(vehicle.chain, q, k, commands) for q in drawn])
        _add(found, _curve((name,), x, every))
    return found


def step_responses(model: Model) -> list[Curve]:
    """Force after a step of each input from rest to full, over its final value."""
    vehicle = model.vehicle
    drawn = _drawn(model)
    longest = 4.0 * max([_slowest(model, q) for q in drawn[:1]])
    t = np.linspace(-max(BEFORE_STEP, longest / 4.0), max(AFTER_STEP, longest), CURVE_POINTS)
    references = [vehicle.file.scales[name].reference for name in vehicle.scales]
    scales = np.array([references], dtype=float).reshape(1, len(references))
    found: list[Curve] = []
    for i, name in enumerate(vehicle.inputs):
        commands = np.zeros((2, len(vehicle.inputs)))
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
    """The force that a step changes most, over its final value; NaN where it changes none."""
    begin = np.array([t[0] - 60.0, 0.0])
    trace = _core.ThrustTrace(model.vehicle.chain, q, begin, commands, begin[:1], scales)
    forces = np.asarray(trace.forces(t))
    most = int(np.argmax(np.abs(forces[-1])))
    last = float(forces[-1, most])
    return forces[:, most] / last if abs(last) > 0 else np.full(len(t), np.nan)


def _slowest(model: Model, q: Array) -> float:
    """Largest latency and lag together [s]."""
    kinds = [name.partition(".")[0] for name in model.vehicle.constants.names]
    parts = [
        [v for k, v in zip(kinds, q.tolist(), strict=True) if k == kind]
        for kind in ("latency", "lag")
    ]
    return sum(max((abs(v) for v in part), default=0.0) for part in parts)


def _drawn(model: Model) -> Array:
    """Constants (draws, m): the model's own first."""
    n = len(model.coefficients)
    covariance = model.covariance[n:, n:]
    own = model.constants[None, :]
    if not covariance.any():
        return np.array(own)
    spectrum, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(spectrum, 0.0))
    normal = np.random.default_rng(CHAIN_SEED).normal(size=(CHAIN_DRAWS, len(spectrum)))
    moved = own + normal @ root.T
    kinds = [name.partition(".")[0] for name in model.vehicle.constants.names]
    low = np.array(
        [
            -np.inf
            if k in ("latency", "scale_power", "steer_offset") or k.startswith("pair_offset")
            else 0.0
            for k in kinds
        ]
    )
    high = np.array(
        [0.9 if k.startswith(("edge", "pair_dead", "steer_dead")) else np.inf for k in kinds]
    )
    return np.vstack([own, np.clip(moved, low, high)])


def _curve(names: tuple[str, ...], x: Array, every: Sequence[Array] | Array) -> Curve:
    found = np.asarray(every)
    if len(found) == 1:
        return Curve(names, x, found[0], found[0], found[0])
    low, high = np.quantile(found[1:], [0.025, 0.975], axis=0)
    return Curve(names, x, found[0], low, high)
