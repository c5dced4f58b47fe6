# SPDX-License-Identifier: MIT
"""Physical meaning of a model: top speed, rise time, coasting distance; stability and plausibility."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.actuators import STAGES, USES
from seatrial.boat.allocation import Scheme
from seatrial.boat.model import INTEGRATORS, Model
from seatrial.boat.structure import Structure, Term
from seatrial.boat.vehicle import WRENCH, Vehicle
from seatrial.util.errors import ModelError
from seatrial.util.frames import AXES, SYMBOLS, Array

RUN = 120.0  # [s] of constant command, then of coasting: long for a small boat
WHOLE_STEP = 1e-6  # of a step, to which a run is a whole number of them
STOPPED_SHARE = 0.02  # of the top speed, at which a boat has stopped
SIGNIFICANT = 2.0  # standard errors by which a coefficient differs significantly from 0 (95 %)
ABSURD_SPEED = 10.0  # [m/s], [rad/s] faster than a small boat, unless recorded so
OVER_THRUST = 1.5  # times the speed that thrust alone gives, the same
RUNAWAY = 3.0  # times the recorded speed, above which a model is unstable
NEGATIVE_LATENCY = -1e-3  # [s] a latency below it gets a message where it can't be simulated
WELL_ABOVE = 1.2  # times the recorded speed; a larger top speed is extrapolated
TIME_CONSTANT = 0.632  # of the top speed, reached after one time constant
PARTIAL_COMMAND = 0.75  # of full command; a smaller recorded command is stated with the top speed


@dataclass(frozen=True)
class AxisPhysics:
    """Response of one axis to its first force with the others at rest, then coasting."""

    axis: int
    command: float  # of that force: full, or the largest recorded if that is smaller
    full_command: float  # of that force, as `full_forces`
    top_speed: float  # [m/s] or [rad/s]
    rise_time: float  # [s] to 63 % of it
    coast: float  # [m] or [rad] until 2 % of the top speed is left


def axis_physics(model: Model) -> list[AxisPhysics]:
    """Top speed, rise time and coasting of each driven axis. Raises ModelError if unstable."""
    return [_drive(model, axis) for axis in range(3) if _first_force(model, axis) is not None]


def physics_line(model: Model) -> str:
    """Top speeds and coasting distances in one sentence."""
    found = axis_physics(model)
    if not found:
        return "No command drives any axis of this structure."
    speeds = ", ".join(
        f"{round(s.top_speed, 2) + 0.0:.2f} {'rad/s' if s.axis == 2 else 'm/s'} in {AXES[s.axis]}"
        f"{_command_text(s)}{_recorded_text(model, s)}"
        for s in found
    )
    coasts = ", ".join(
        f"{s.coast:.2f} {'rad' if s.axis == 2 else 'm'} in {AXES[s.axis]}" for s in found
    )
    return (
        f"Implied top speed {speeds}; coasting distance from it {coasts}. Compare with your boat."
    )


def negative_latencies(model: Model) -> list[str]:
    """Messages about negative latencies, which a simulation sets to 0."""
    constants = zip(model.vehicle.constants.names, model.constants, strict=True)
    return [
        f"{name} is {value:.3g} s (the commands' stamps are late); a simulation can't respond before the "
        "command and uses 0"
        for name, value in constants
        if name.partition(".")[0] == "latency" and value < NEGATIVE_LATENCY
    ]


def _command_text(found: AxisPhysics) -> str:
    """The largest recorded command, where it is below `PARTIAL_COMMAND`."""
    if found.command >= PARTIAL_COMMAND * found.full_command:
        return ""
    return f" at {100 * found.command / found.full_command:.0f} % of full command"


def _recorded(model: Model, axis: int) -> float:
    """The largest recorded speed; infinite where it is unknown."""
    return max(abs(x) for x in model.envelope.speeds.get(SYMBOLS[axis], (-np.inf, np.inf)))


def _recorded_text(model: Model, found: AxisPhysics) -> str:
    """The recorded speed, where the top speed is well above it."""
    seen = _recorded(model, found.axis)
    return f" (recorded: up to {seen:.2f})" if abs(found.top_speed) > WELL_ABOVE * seen else ""


def model_concerns(model: Model) -> list[str]:
    """Warnings of the model file, then implausible coefficients; each once."""
    return list(dict.fromkeys([*model.warnings, *implausible_coefficients(model)]))


def implausible_coefficients(model: Model) -> list[str]:
    """Coefficients of implausible sign or size, one message each."""
    return [*_positive_drag(model), *_implausible_thrust(model)]


def _positive_drag(model: Model) -> list[str]:
    found = []
    why = (
        "Possible causes: the bias of a regression on noisy velocities"
        if model.noise.process is None
        else "Possible causes: drag that grows with speed in another way than these terms"
    )
    for axis, symbol in enumerate(SYMBOLS):
        own = {f"{'XYN'[axis]}_{symbol}": "linear", f"{'XYN'[axis]}_{symbol * 2}": "quadratic"}
        for name, kind in own.items():
            value = model.values.get(name, 0.0)
            error = model.standard_errors.get(name, 0.0)
            if value > 0 and value > SIGNIFICANT * error:
                turns = " A hull without directional stability has it, too." if axis == 2 else ""
                found.append(
                    f"{name} = {value:.3g} ± {error:.2g} is positive: {kind} "
                    f"{AXES[axis]} drag that accelerates the boat. {why}; or these speeds do not "
                    f"distinguish the two drag terms. Drive faster and slower, or drop one.{turns}"
                )
    return found


def backward_thrust(model: Model) -> list[str]:
    """Thrust gains of F_u in surge, F_v in sway and F_r in yaw that are significantly negative."""
    return [one.gain for one in backward_forces(model)]


@dataclass(frozen=True)
class BackwardForce:
    """A force that drives its axis backwards."""

    gain: str
    force: str
    text: str  # what was found
    mend: str  # in the vehicle file


def backward_forces(model: Model, least_t: float = SIGNIFICANT) -> list[BackwardForce]:
    """Those of `backward_thrust`, by gains at least so many standard errors below 0."""
    found = []
    for name, force, axis in _own_thrust(model):
        value, error = model.values[name], model.standard_errors[name]
        if value < -least_t * error:
            text = f"{name} = {value:.3g} ± {error:.2g} is negative: {force} drives {AXES[axis]} backwards"
            found.append(BackwardForce(name, force, text, _turned(model, force)))
    return found


def _own_thrust(model: Model) -> Iterator[tuple[str, str, int]]:
    """Coefficients of F_u in surge, F_v in sway and F_r in yaw, with force and axis."""
    for term in model.structure.terms:
        force, name = WRENCH[term.axis], term.coefficient
        if name is not None and term.factors == (force,) and term.acceleration is None:
            yield name, force, term.axis


def _implausible_thrust(model: Model) -> list[str]:
    """Thrust gains that are negative or not significant."""
    found, backward = [], {one.gain: one for one in backward_forces(model)}
    for name, force, axis in _own_thrust(model):
        value, error = model.values[name], model.standard_errors[name]
        what = f"{name} = {value:.3g} ± {error:.2g}"
        if name in backward:
            found.append(f"{backward[name].text}. {backward[name].mend}")
        elif value < SIGNIFICANT * error:
            found.append(
                f"{what}: {force} does not significantly drive {AXES[axis]}. Check for two inputs "
                "swapped in the vehicle file, and the clock of the commands."
            )
    return found


def _turned(model: Model, force: str) -> str:
    """What to do where a force drives its axis backwards."""
    vehicle = model.vehicle
    if vehicle.file.thrusters and force not in vehicle.inputs:
        return (
            "The thrusters' places or angles may be mirrored: change the sign of every y and angle_deg in the "
            "vehicle file's thrusters, or check the axes."
        )
    j = [f.name for f in vehicle.forces].index(force)
    makers = [n for n, w in zip(vehicle.actuators, vehicle.mix[j], strict=True) if w != 0.0]
    inputs = [force] if force in vehicle.inputs else [n for n in makers if n in vehicle.inputs]
    where = f" (inputs: {', '.join(inputs)}: sign)" if inputs else ""
    return f"Change the sign of its inputs in the vehicle file{where}, or check the axes."


def _first_force(model: Model, axis: int) -> int | None:
    used = {f for t in model.structure.terms if t.axis == axis for f in t.factors}
    for i, force in enumerate(model.structure.forces):
        if force.axis == axis and force.name in used:
            return i
    return None


def _drive(model: Model, axis: int) -> AxisPhysics:
    driving, force, t = _step_profile(model, axis)
    command, full = float(force[0].max()), full_forces(model.vehicle)[driving]
    _refuse_unstable(model, axis, command, t, _run(model, model.structure, force, t))
    states = _single_axis_states(model, axis, force, t)
    _refuse_unstable(model, axis, command, t, states)
    off = len(t) // 2  # where the command ends
    top = float(states[off, 3 + axis])
    if top == 0.0:
        return AxisPhysics(axis, command, full, 0.0, 0.0, 0.0)
    share, path = states[:, 3 + axis] / top, states[:, axis]
    rise = _rise_time(t[: off + 1], share[: off + 1])
    return AxisPhysics(axis, command, full, top, rise, _coast(share[off:], path[off:]))


def _rise_time(t: Array, share: Array) -> float:
    """When a share of the top speed passes `TIME_CONSTANT`; what is left to the top decays exponentially."""
    after = int(np.argmax(np.abs(share) >= TIME_CONSTANT))
    around = [after, after - 1]
    left = np.log(np.maximum(np.abs(1.0 - share[around]), np.finfo(float).tiny))
    return float(np.interp(np.log(1.0 - TIME_CONSTANT), left, t[around]))


def _coast(share: Array, path: Array) -> float:
    """Distance until `STOPPED_SHARE` is left, or all of it; between steps it is linear in the speed."""
    slow = np.abs(share) <= STOPPED_SHARE
    after = int(np.argmax(slow)) if slow.any() else len(slow) - 1
    around = [after, after - 1]
    return float(np.interp(STOPPED_SHARE, np.abs(share[around]), np.abs(path[around] - path[0])))


def driven(model: Model, axis: int) -> tuple[Array, Array]:
    """Time (n,) [s] and speed (n,) of an axis under `AxisPhysics.command` for RUN, then coasting."""
    _, force, t = _step_profile(model, axis)
    return t, np.asarray(_single_axis_states(model, axis, force, t)[:, 3 + axis])


def full_forces(vehicle: Vehicle) -> dict[str, float]:
    """The largest of each force, by name: that of a full stick, or of its actuators at commands of 1.

    1 where no actuator has a weight.
    """
    names = [force.name for force in vehicle.forces]
    if vehicle.scheme is not Scheme.DIRECT:
        return dict.fromkeys(names, 1.0)
    most = (np.abs(vehicle.mix) + np.abs(vehicle.deflection)).sum(axis=1)
    return dict(zip(names, np.where(most > 0.0, most, 1.0).tolist(), strict=True))


def largest_forces(model: Model) -> dict[str, float]:
    """The largest recorded size of each force, at most full; full where none is recorded."""
    recorded, full = model.envelope.forces, full_forces(model.vehicle)
    return {
        name: min(most, max(map(abs, recorded.get(name, (most,))))) for name, most in full.items()
    }


def _step_profile(model: Model, axis: int) -> tuple[str, Array, Array]:
    """The driving force, all forces (2, forces) during RUN and after it, and times (n,) [s] with RUN halfway."""
    place = _first_force(model, axis) or 0
    driving = model.structure.forces[place].name
    force = np.zeros((2, len(model.structure.forces)))
    force[0, place] = largest_forces(model)[driving]
    steps = int(np.ceil(RUN / model.integration.step - WHOLE_STEP))
    on = np.linspace(0.0, RUN, steps + 1)
    return driving, force, np.concatenate([on, RUN + on[1:]])


def _single_axis_states(model: Model, axis: int, force: Array, t: Array) -> Array:
    """States (n, 6) with the other axes at rest."""
    single = Structure(model.name, _own_terms(model.structure, axis), model.structure.forces)
    return _run(model, single, force, t)


def _own_terms(structure: Structure, axis: int) -> tuple[Term, ...]:
    """Terms that act with the other axes at rest."""
    others = {s for i, s in enumerate(SYMBOLS) if i != axis}
    return tuple(
        t
        for t in structure.terms
        if t.axis == axis
        and t.acceleration is None
        and not others & {factor.strip("|") for factor in t.factors}
    )


def _run(model: Model, structure: Structure, force: Array, t: Array) -> Array:
    """States (n, 6) under force[0] for RUN seconds, then force[1], from rest."""
    n = len(structure.forces)
    values = np.array([model.values[name] for name in structure.coefficients])
    code = INTEGRATORS.index(model.integration.scheme)
    boat = _core.Boat(structure.compiled, values, code, model.integration.step)
    trace = _core.ThrustTrace(
        direct_chain(n), np.zeros(0), np.array([0.0, RUN]), force, np.zeros(0), np.zeros((0, 0))
    )
    return _core.simulate(boat, trace, np.zeros(6), t)[0]


def _refuse_unstable(model: Model, axis: int, command: float, t: Array, states: Array) -> None:
    """Raise ModelError for an unstable model, with the first velocity to diverge and its coefficients."""
    seen = np.array([_recorded(model, axis) for axis in range(3)])
    limit = np.maximum(ABSURD_SPEED, RUNAWAY * np.where(np.isfinite(seen), seen, 0.0))
    # a craft without drag gains speed evenly: only more than its thrust gives is a runaway
    thrust = np.nan_to_num(np.abs(states[1, 3:] - states[0, 3:]) / (t[1] - t[0]), nan=0.0)
    given = OVER_THRUST * thrust * (t - t[0])[:, None]
    fast = np.nan_to_num(np.abs(states[:, 3:]), nan=np.inf) > np.maximum(limit, given)
    if not fast.any():
        return
    first = int(np.argmax(fast.any(axis=1)))
    away = int(np.argmax(fast[first]))
    raise ModelError(
        f"{model.name}: the model is unstable: driven in {AXES[axis]} at command {command:.2g}, "
        f"{AXES[away]} passes {limit[away]:.3g} {'rad/s' if away == 2 else 'm/s'} within "
        f"{np.ceil(t[first]):.0f} s; its drag does not limit it: {_listed(model, away)}. "
        f"Drive longer in {AXES[away]}, at several speeds"
    )


def direct_chain(n: int) -> _core.Chain:
    """A chain without any stage: n commands are the n generalised forces."""
    rows = np.full((n, len(STAGES) + len(USES)), -1, dtype=np.int32)
    return _core.Chain(
        0, np.eye(n), 0.0, float("inf"), np.eye(n), rows, 0, np.zeros(0), np.zeros((0, 2)),
        np.zeros((n, n)),
    )  # fmt: skip


def _listed(model: Model, axis: int) -> str:
    names = dict.fromkeys(
        t.coefficient for t in model.structure.terms if t.axis == axis and t.coefficient
    )
    return ", ".join(f"{n} = {model.values[n]:.3g}" for n in names)
