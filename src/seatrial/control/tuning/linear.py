# SPDX-License-Identifier: MIT
"""The identified boat as a linear plant about steady motions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.control.allocation.steered import full_accelerations, steering_of
from seatrial.control.tuning.steered import gear_lag, steered_authority, steered_mix, steered_push
from seatrial.util.errors import ControlError, ModelError
from seatrial.util.frames import AXES, SYMBOLS, Array, freeze

Complex = NDArray[np.complex128]
SMALL_COMMAND = 1e-3  # of a command, to linearise the allocation: within every limit
VELOCITY_STEP = 1e-6  # of a velocity, for central differences
LEAST_AUTHORITY = 1e-6  # smallest over largest acceleration: below it an axis is not actuated
SLOPE_STEPS = 400  # of a thruster's curve
RUN_UP_TIME = 200.0  # [s] simulated until the speed at full command is steady


@dataclass(frozen=True)
class Actuators:
    """From axis commands to accelerations: the sum of push h(s) share over the thrusters."""

    push: Array  # (3, actuators) [m/s^2, m/s^2, rad/s^2] per unit of thrust
    share: Array  # (actuators, 3) thruster command per axis command
    latency: Array  # (actuators,) [s]
    lag: Array  # (actuators,) [s]

    def __post_init__(self) -> None:
        freeze(self, "push", "share", "latency", "lag")

    def response(self, omega: Array) -> Complex:
        """Accelerations (n, 3, 3) per axis command at angular frequencies (n,) [rad/s]: exact delays."""
        s = 1j * omega[:, None]
        h = np.exp(-s * self.latency) / (1.0 + s * self.lag)
        return np.asarray(np.einsum("ik,nk,kj->nij", self.push, h, self.share))

    @property
    def delay(self) -> Array:
        """First-order term (3,) [s] of each axis' own response: latency and lag alike."""
        own = np.einsum("ik,ki->ik", self.push, self.share)
        total = own.sum(axis=1, keepdims=True)
        driven = np.abs(self.share).max(axis=0)[:, None] > 0.0
        weight = np.divide(own, total, out=np.zeros_like(own), where=driven)
        return np.asarray(weight @ (self.latency + self.lag))


@dataclass(frozen=True)
class LinearBoat:
    """A boat about steady motions."""

    model: Model
    mix: Array  # (inputs, 3) commands per axis command; at an axis command of 1 the largest input is 1
    # (3,) [m/s^2, m/s^2, rad/s^2] by an axis command of 1; 0: an axis without thrust
    authority: Array
    actuators: Actuators
    speeds: Array  # (m, 3) steady motions [m/s, m/s, rad/s]; the first is rest
    slopes: Array  # (m, 3, 3) d nu_dot / d nu there
    steepest: float  # largest slope of a thruster's curve, over its chord

    def __post_init__(self) -> None:
        freeze(self, "mix", "authority", "speeds", "slopes")

    @property
    def driven(self) -> tuple[int, ...]:
        """The axes with thrust: all three, or surge and yaw."""
        return tuple(int(i) for i in np.flatnonzero(self.authority))

    @cached_property
    def fastest(self) -> Array:
        """Largest speed (3,) of each axis in the model's steady motions [m/s, m/s, rad/s]."""
        return np.asarray(np.abs(steady_motions(self.model)).max(axis=0))

    @cached_property
    def per_authority(self) -> Array:
        """(3,) axis command per acceleration; 0 where there is no thrust."""
        found = np.zeros(3)
        found[list(self.driven)] = 1.0 / self.authority[list(self.driven)]
        return found

    @cached_property
    def drag(self) -> Array:
        """Linear drag (m, 3) [1/s] of each axis."""
        return np.asarray(-np.einsum("mii->mi", self.slopes))

    @cached_property
    def loop_drag(self) -> Array:
        """Drag (m, 3) [1/s] for which each axis is tuned; of yaw with a free sway the quasi-static one.

        Where sway has no thrust, v follows r: the static gain of yaw is that of A_rr - A_rv A_vr / A_vv.
        """
        found = self.drag.copy()
        if 1 not in self.driven:
            A = self.slopes
            slow = A[:, 2, 2] - A[:, 2, 1] * A[:, 1, 2] / np.minimum(A[:, 1, 1], -1e-9)
            found[:, 2] = np.minimum(found[:, 2], -slow)
        return found


def linearise(model: Model, speeds: Array | None = None) -> LinearBoat:
    """The model about rest and its fastest steady motions, or about `speeds` (m, 3).

    Raises ControlError where the model's commands do not actuate surge and yaw independently.
    """
    constants = model.vehicle.constants
    latency, lag = (constants.of_each(stage, model.constants) for stage in ("latency", "lag"))
    points = steady_motions(model) if speeds is None else speeds
    if (steering := steering_of(model)) is not None:
        fastest = float(points[:, 0].max())
        mix, authority = (
            steered_mix(steering, fastest),
            steered_authority(model, steering, fastest),
        )
        push, share, slope = steered_push(model, steering, fastest), mix, 1.0  # curves are inverted
        lag = lag + gear_lag(steering) * np.eye(2)[steering.angle]
    else:
        push, G = _plain_push(model), _allocated(model)
        mix, authority = axis_commands(model, push @ G)
        share, slope = G @ mix, steepest(model)
    # A latency below 0 is a clock offset; a causal loop has none
    actuators = Actuators(push, share, np.maximum(latency, 0.0), np.maximum(lag, 0.0))
    return LinearBoat(model, mix, authority, actuators, points, slopes_at(model, points), slope)


def _plain_push(model: Model) -> Array:
    """Accelerations (3, actuators) by full thrust of thrusters in fixed directions."""
    return np.asarray(_force_effect(model) @ model.vehicle.mix @ np.diag(chords(model)))


def axis_commands(model: Model, effect: Array) -> tuple[Array, Array]:
    """The mix (inputs, 3) and authority (3,) of `effect` (3, inputs): accelerations at rest by inputs.

    A boat whose inputs do not actuate sway independently has none of it in both. Raises ControlError.
    """
    driven = _driven(model, effect)
    inverse = np.zeros((effect.shape[1], 3))
    inverse[:, driven] = np.linalg.pinv(effect[driven])
    authority = np.zeros(3)
    authority[driven] = 1.0 / np.abs(inverse[:, driven]).max(axis=0)
    return inverse * authority, authority


def redrawn(boat: LinearBoat, model: Model) -> LinearBoat:
    """Another draw of the model under the same axis commands and at the same motions."""
    fresh = linearise(model, boat.speeds)
    share = _allocated(model) @ boat.mix
    return replace(
        fresh, mix=boat.mix, authority=boat.authority, actuators=replace(fresh.actuators, share=share)
    )  # fmt: skip


def slopes_at(model: Model, speeds: Array) -> Array:
    """d nu_dot / d nu (m, 3, 3) without thrust, by central differences."""
    steps = np.vstack([VELOCITY_STEP * np.eye(3), -VELOCITY_STEP * np.eye(3)])
    nu = (speeds[:, None, :] + steps).reshape(-1, 3)
    found = accelerations(model, nu).reshape(len(speeds), 2, 3, 3)
    return np.asarray(np.swapaxes(found[:, 0] - found[:, 1], 1, 2) / (2.0 * VELOCITY_STEP))


def steady_motions(model: Model) -> Array:
    """Rest, the fastest motion along each axis both ways, and a turn at speed (m, 3).

    The fastest: of the identification data, or, without an envelope, at full command.
    """
    ranges = model.envelope.speeds
    stated = set(SYMBOLS) <= set(ranges)
    most = (
        np.array([max(map(abs, ranges[name])) for name in SYMBOLS]) if stated else _reached(model)
    )
    along = np.diag(most)
    turn = np.array([[0.7 * most[0], 0.0, 0.7 * most[2]]])
    return np.vstack([np.zeros((1, 3)), along, -along, turn])


def _reached(model: Model) -> Array:
    """Steady speed (3,) of each axis at full command, by its own equation."""
    speed, step = np.zeros(3), RUN_UP_TIME / 4000
    steering = steering_of(model)
    if steering is None:
        _, full = axis_commands(model, _plain_push(model) @ _allocated(model))
    for _ in range(4000):
        if steering is not None:
            full = full_accelerations(steering, float(speed[0]))
        rate = np.diag(accelerations(model, np.diag(speed))) + full
        speed = speed + step * rate
        if not np.isfinite(speed).all() or np.abs(speed).max() > 1e3:
            raise ControlError(
                f"{model.name}: its speed at full command is unbounded; identify it with a wider "
                "range of speeds, so that the drag is identified"
            )
    return np.asarray(speed)


def steepest(model: Model) -> float:
    """Largest slope of a thruster's curve between full reverse and full forward, over its chord."""
    n = len(model.vehicle.actuators)
    at = np.linspace(-1.0, 1.0, SLOPE_STEPS + 1)
    found = 1.0
    for k, chord in enumerate(chords(model)):
        rows = np.zeros((len(at), n))
        rows[:, k] = at
        curve = _core.curve(model.vehicle.chain, model.constants, k, rows)
        # over ten steps: the slope of a power below 1 is infinite at 0
        slope = (curve[10:] - curve[:-10]) / (at[10:] - at[:-10]) / chord
        found = max(found, float(slope.max()))
    return found


def accelerations(model: Model, nu: Array, force: Array | None = None) -> Array:
    """Accelerations (n, 3) at velocities (n, 3) by generalised forces (n, forces), by default none."""
    forces = np.zeros((len(nu), len(model.structure.forces))) if force is None else force
    return _core.accelerations(
        model.structure.compiled, model.coefficients, np.ascontiguousarray(nu), forces
    )


def _force_effect(model: Model) -> Array:
    """Accelerations (3, forces) at rest by a generalised force of 1."""
    n = len(model.structure.forces)
    force = np.vstack([np.zeros((1, n)), np.eye(n)])
    found = accelerations(model, np.zeros((n + 1, 3)), force)
    if not np.isfinite(found).all():
        raise ModelError(
            f"{model.name}: the accelerations in its equations can't be solved for; "
            "leave out a term like N_ud * u_dot"
        )
    return np.asarray((found[1:] - found[0]).T)


def _allocated(model: Model) -> Array:
    """Thruster commands (actuators, inputs) by an input of 1, without the offset of always-forward."""
    n = len(model.vehicle.inputs)
    small = SMALL_COMMAND * np.vstack([np.eye(n), -np.eye(n)])
    thrusters, _ = _core.allocate(model.vehicle.chain, small)
    return np.asarray((thrusters[:n] - thrusters[n:]).T / (2.0 * SMALL_COMMAND))


def chords(model: Model) -> Array:
    """Thrust (actuators,) at full forward command."""
    n = len(model.vehicle.actuators)
    chain, q = model.vehicle.chain, model.constants
    return np.array([_core.curve(chain, q, k, np.eye(n)[k : k + 1])[0] for k in range(n)])


def _driven(model: Model, effect: Array) -> list[int]:
    """All axes, or surge and yaw where sway is not independent of them. Raises ControlError."""
    strong = np.abs(effect).max()
    for axes in ([0, 1, 2], [0, 2]):
        values = np.linalg.svd(effect[axes], compute_uv=False)
        if len(values) == len(axes) and values[-1] > LEAST_AUTHORITY * strong:
            return axes
    idle = [AXES[axis] for axis in (0, 2) if np.abs(effect[axis]).max() <= LEAST_AUTHORITY * strong]
    raise ControlError(
        f"{model.name}: no command actuates {_joined(idle)}; the controller needs a force in surge and yaw: add "
        "a term like X_F * F_u or N_F * F_r to the structure and identify again"
        if idle
        else f"{model.name}: its {effect.shape[1]} commands can't actuate surge and yaw independently; "
        "the controller needs two independent forces"
    )


def _joined(words: Sequence[str]) -> str:
    return " or ".join(words)
