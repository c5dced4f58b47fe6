# SPDX-License-Identifier: MIT
"""What a model means for the boat: top speed, coasting distance; and whether it is a boat at all."""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.actuators import STAGES, USES
from seatrial.boat.model import INTEGRATORS, Model
from seatrial.boat.structure import Structure, Term
from seatrial.boat.vehicle import WRENCH
from seatrial.util.errors import ModelError
from seatrial.util.frames import AXES, SYMBOLS, Array

RUN = 120.0  # [s] long enough for a small boat to reach its top speed, and to coast
STILL = 0.02  # share of the top speed at which a boat counts as stopped
TOLD_APART = 2.0  # standard errors that a value must be away from 0 to count as not 0
ABSURD_SPEED = 10.0  # [m/s], [rad/s] boats are not faster, but those that were recorded so
FASTER = 3.0  # times the recorded speed from which on a model runs away
EARLY = -1e-3  # [s] a latency below this is said where it can't be simulated
PART = 0.75  # of full command: what was driven with less is said with its command


@dataclass(frozen=True)
class AxisSanity:
    """One axis driven by its first force with the others held still, then left to coast."""

    axis: int
    command: float  # of that force: 1, or the largest recorded if that is smaller
    top_speed: float  # [m/s] or [rad/s]
    rise_time: float  # [s] to 63 % of it
    coast: float  # [m] or [rad] until 2 % of the top speed is left


def sanity(model: Model) -> list[AxisSanity]:
    """Each driven axis in physical terms. Raises ModelError where the model is unstable."""
    return [_drive(model, axis) for axis in range(3) if _first_force(model, axis) is not None]


def sanity_line(model: Model) -> str:
    """One line in plain words."""
    found = sanity(model)
    if not found:
        return "No command drives any axis of this structure."
    speeds = ", ".join(
        f"{round(s.top_speed, 2) + 0.0:.2f} {'rad/s' if s.axis == 2 else 'm/s'} in {AXES[s.axis]}"
        f"{_by(s)}{_beyond(model, s)}"
        for s in found
    )
    coasts = ", ".join(
        f"{s.coast:.2f} {'rad' if s.axis == 2 else 'm'} in {AXES[s.axis]}" for s in found
    )
    return f"Top speed {speeds}; from there it coasts {coasts}: is that your boat?"


def early(model: Model) -> list[str]:
    """What is to be said of a simulation of thrusters that answer before their commands' stamps."""
    constants = zip(model.vehicle.constants.names, model.constants, strict=True)
    return [
        f"{name} is {value:.3g} s, as the commands' stamps are late: a simulation can't answer before it is "
        "told, and takes 0"
        for name, value in constants
        if name.partition(".")[0] == "latency" and value < EARLY
    ]


def _by(found: AxisSanity) -> str:
    """The command, where it is not a full one: no larger was recorded."""
    return f" by {100 * found.command:.0f} % of full command" if found.command < PART else ""


def _recorded(model: Model, axis: int) -> float:
    """The largest speed that was driven; infinite where it is not known."""
    return max(abs(x) for x in model.envelope.speeds.get(SYMBOLS[axis], (-np.inf, np.inf)))


def _beyond(model: Model, found: AxisSanity) -> str:
    """A remark where the top speed is well above what was recorded."""
    seen = _recorded(model, found.axis)
    return f" (recorded: up to {seen:.2f})" if abs(found.top_speed) > 1.2 * seen else ""


def concerns(model: Model) -> list[str]:
    """What was noted when the model was made, and what a physicist would frown at; each once."""
    return list(dict.fromkeys([*model.warnings, *doubts(model)]))


def doubts(model: Model) -> list[str]:
    """What a physicist would frown at, one sentence each."""
    return [*_odd_drag(model), *_odd_thrust(model)]


def _odd_drag(model: Model) -> list[str]:
    found = []
    why = (
        "Pose noise does that to regressions"
        if model.noise.process is None
        else "Drag that grows with speed in another way than these terms does that"
    )
    for axis, symbol in enumerate(SYMBOLS):
        own = {f"{'XYN'[axis]}_{symbol}": "linear", f"{'XYN'[axis]}_{symbol * 2}": "quadratic"}
        for name, kind in own.items():
            value = model.values.get(name, 0.0)
            error = model.standard_errors.get(name, 0.0)
            if value > 0 and value > TOLD_APART * error:
                turns = (
                    " A hull that does not keep its course by itself has it, too."
                    if axis == 2
                    else ""
                )
                found.append(
                    f"{name} = {value:.3g} ± {error:.2g} is positive: {kind} "
                    f"{AXES[axis]} drag that drives the boat. {why}; or these speeds don't tell the two "
                    f"drag terms apart: drive faster and slower, or drop one.{turns}"
                )
    return found


def _odd_thrust(model: Model) -> list[str]:
    """Gains of F_u in surge, F_v in sway and F_r in yaw that are negative or not there."""
    found = []
    for term in model.structure.terms:
        force, name = WRENCH[term.axis], term.coefficient
        if name is None or term.factors != (force,) or term.acceleration is not None:
            continue
        value, error = model.values[name], model.standard_errors[name]
        what = f"{name} = {value:.3g} ± {error:.2g}"
        if value < -TOLD_APART * error:
            vehicle = model.vehicle
            j = [f.name for f in vehicle.forces].index(force)
            makers = [n for n, w in zip(vehicle.actuators, vehicle.mix[j], strict=True) if w != 0.0]
            inputs = (
                [force] if force in vehicle.inputs else [n for n in makers if n in vehicle.inputs]
            )
            where = f" (inputs: {', '.join(inputs)}: sign)" if inputs else ""
            found.append(
                f"{what} is negative: {force} drives {AXES[term.axis]} backwards. Turn the sign round of "
                f"what makes it in the vehicle file{where}, or check the axes."
            )
        elif value < TOLD_APART * error:
            found.append(
                f"{what}: {force} does not visibly drive {AXES[term.axis]}. Are two inputs swapped "
                "in the vehicle file, or are the commands of another time?"
            )
    return found


def _first_force(model: Model, axis: int) -> int | None:
    used = {f for t in model.structure.terms if t.axis == axis for f in t.factors}
    for i, force in enumerate(model.structure.forces):
        if force.axis == axis and force.name in used:
            return i
    return None


def _drive(model: Model, axis: int) -> AxisSanity:
    command, force, t = _course(model, axis)
    _refuse_unstable(model, axis, command, t, _run(model, model.structure, force, t))
    states = _alone(model, axis, force, t)
    _refuse_unstable(model, axis, command, t, states)
    speed, way = states[:, 3 + axis], _path(states, t, axis)
    driven = t <= RUN
    top = float(speed[driven][-1])
    if top == 0.0:
        return AxisSanity(axis, command, 0.0, 0.0, 0.0)
    rise = float(t[driven][np.argmax(np.abs(speed[driven]) >= 0.632 * abs(top))])
    slow = np.abs(speed[~driven]) <= STILL * abs(top)
    end = int(np.argmax(slow)) if slow.any() else len(slow) - 1
    return AxisSanity(axis, command, top, rise, float(abs(way[~driven][end] - way[driven][-1])))


def driven(model: Model, axis: int) -> tuple[Array, Array]:
    """Time (n,) [s] and speed (n,) of an axis under `AxisSanity.command` for RUN, then without."""
    _, force, t = _course(model, axis)
    return t, np.asarray(_alone(model, axis, force, t)[:, 3 + axis])


def _course(model: Model, axis: int) -> tuple[float, Array, Array]:
    """The command, the forces (2, forces) during RUN and after it, and the times (n,) [s]."""
    driving = _first_force(model, axis)
    recorded = model.envelope.forces.get(model.structure.forces[driving or 0].name, (-1.0, 1.0))
    command = min(1.0, max(abs(recorded[0]), abs(recorded[1])))
    force = np.zeros((2, len(model.structure.forces)))
    force[0, driving] = command
    return command, force, np.arange(0.0, 2 * RUN + model.integration.step, model.integration.step)


def _alone(model: Model, axis: int, force: Array, t: Array) -> Array:
    """States (n, 6) with the other axes held still."""
    alone = Structure(model.name, _own_terms(model.structure, axis), model.structure.forces)
    return _run(model, alone, force, t)


def _own_terms(structure: Structure, axis: int) -> tuple[Term, ...]:
    """Terms that act while the other axes are held still."""
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
    """Raise ModelError, naming the velocity that runs away first and its coefficients."""
    seen = np.array([_recorded(model, axis) for axis in range(3)])
    limit = np.maximum(ABSURD_SPEED, FASTER * np.where(np.isfinite(seen), seen, 0.0))
    fast = np.nan_to_num(np.abs(states[:, 3:]), nan=np.inf) > limit
    if not fast.any():
        return
    first = int(np.argmax(fast.any(axis=1)))
    away = int(np.argmax(fast[first]))
    raise ModelError(
        f"{model.name}: the model is unstable: driven in {AXES[axis]} at command {command:.2g}, "
        f"{AXES[away]} passes {limit[away]:.3g} {'rad/s' if away == 2 else 'm/s'} within "
        f"{np.ceil(t[first]):.0f} s; its drag does not hold it back: {_listed(model, away)}. "
        f"Drive longer in {AXES[away]}, at several speeds"
    )


def direct_chain(n: int) -> _core.Chain:
    """A chain without any stage: n commands are the n generalised forces."""
    rows = np.full((n, len(STAGES) + len(USES)), -1, dtype=np.int32)
    return _core.Chain(
        0, np.eye(n), 0.0, float("inf"), np.eye(n), rows, 0, np.zeros(0), np.zeros((0, 2))
    )


def _path(states: Array, t: Array, axis: int) -> Array:
    """Distance made good along the axis, [m] or [rad]."""
    steps = 0.5 * (states[1:, 3 + axis] + states[:-1, 3 + axis]) * np.diff(t)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _listed(model: Model, axis: int) -> str:
    names = dict.fromkeys(
        t.coefficient for t in model.structure.terms if t.axis == axis and t.coefficient
    )
    return ", ".join(f"{n} = {model.values[n]:.3g}" for n in names)
