# SPDX-License-Identifier: MIT
"""Manoeuvres for one minute by joypad, as commands over time."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.static_forces import static_forces
from seatrial.boat.steering import angle_names, steered_entries
from seatrial.boat.structure import Force
from seatrial.boat.vehicle import Vehicle
from seatrial.util.format import percent
from seatrial.util.frames import AXES, Array

MANOEUVRE_LENGTH = 60.0  # [s]
SIDE_WORDS = {  # of a positive and a negative force of an axis, forward-left-up
    0: ("ahead", "astern"),
    1: ("to the left", "to the right"),
    2: ("turning left", "turning right"),
}
PULSE_LENGTH, PAUSE_LENGTH = 3.0, 2.0  # [s]
QUICK_PULSE_LENGTH = 0.8  # [s]
ROUNDING = 1e-12  # of a pseudoinverse: no command
HELD_THRUST = 0.5  # of full, ahead, while its angle is driven


@dataclass(frozen=True)
class Manoeuvre:
    """Commands for one minute."""

    text: str  # instruction to the driver
    effort: int  # 1: one stick one way, 2: both ways, 3: two sticks
    t: Array  # (n,) [s] when commands change
    commands: Array  # (n, inputs) in the vehicle's inputs


@dataclass(frozen=True)
class Drive:
    """Commands that drive one force."""

    force: str
    axis: int  # that moves: of a rudder's thrust across, yaw
    label: str  # for the driver
    command: Array  # (inputs,)
    held: Array  # (inputs,) commands that are held meanwhile: the thrust that an angle turns
    holding: str = ""  # the same in words


def manoeuvres(model: Model) -> list[Manoeuvre]:
    """Pulses of every axis, to one side, to both, quick ones; then two axes at a time."""
    directions = _directions(model)
    t = np.arange(0.0, MANOEUVRE_LENGTH, 0.1)  # [s]
    found = []
    for direction in directions:
        for size in (1 / 3, 2 / 3, 1.0):  # of the largest recorded command
            one = replace(direction, command=size * direction.command)
            much = f"at {100 * float(np.abs(one.command).max()):.0f} % command"
            for side, word in zip((1.0, -1.0), SIDE_WORDS[direction.axis], strict=True):
                wave = side * _pulses(t, PULSE_LENGTH, PAUSE_LENGTH)
                found.append(_made(f"{one.label} pulses {word} {much}", 1, t, wave, one))
            wave = _both(t, PULSE_LENGTH, PAUSE_LENGTH)
            found.append(_made(f"{one.label} pulses to both sides {much}", 2, t, wave, one))
            wave = _both(t, QUICK_PULSE_LENGTH, QUICK_PULSE_LENGTH)
            text = f"quick {one.label} pulses ({QUICK_PULSE_LENGTH:g} s) to both sides {much}"
            found.append(_made(text, 2, t, wave, one))
    turns = [one for one in directions if one.axis == 2]
    for one in directions if turns else []:
        if one.axis == 2:
            continue
        held, holding = held_by_both(one, turns[0])
        turn = np.outer(np.ones(len(t)), 0.5 * turns[0].command + held)
        for wave, word in (
            (_pulses(t, PULSE_LENGTH, PAUSE_LENGTH), SIDE_WORDS[one.axis][0]),
            (_both(t, PULSE_LENGTH, PAUSE_LENGTH), "both ways"),
        ):
            text = f"full {one.label} pulses {word} while turning left at half command"
            rows = _limited(np.outer(wave, one.command) + turn)
            found.append(Manoeuvre(text + holding, 3, t, rows))
    return found


def held_by_both(one: Drive, other: Drive) -> tuple[Array, str]:
    """What two drives at a time hold (inputs,), and in words; nothing of what the other one drives."""
    held, holding = np.zeros(len(one.held)), ""
    for own, driven in ((one, other.command), (other, one.command)):
        if own.held.any() and not driven[own.held != 0.0].any():
            held, holding = held + own.held, holding + own.holding
    return held, holding


def _directions(model: Model) -> list[Drive]:
    """Every force's drive, at its largest recorded value."""
    found = []
    for one in force_commands(model.vehicle, model):
        low, high = model.envelope.forces.get(one.force, (-1.0, 1.0))
        command = one.command * max(abs(low), abs(high))
        found.append(replace(one, command=command / max(1.0, float(np.abs(command).max()))))
    return found


def force_commands(vehicle: Vehicle, model: Model | None = None) -> list[Drive]:
    """Every force that commands drive, with the commands for a force of 1.

    model: whose coefficients tell to which side a turned thrust turns the boat; without one it is astern.
    """
    names = [force.name for force in vehicle.forces]
    if set(vehicle.inputs) == set(names):  # commands are forces
        columns = np.array([[float(n == name) for name in names] for n in vehicle.inputs])
        return _of_columns(vehicle, columns)
    if set(vehicle.inputs) != set(vehicle.actuators):
        return []
    # thruster commands for the force; an angle makes none without its thrust
    pairs = [pair for entry in steered_entries(vehicle.file.chain) for pair in entry.of]
    angles = {angle for _, angle in pairs}
    fixed = [k for k, name in enumerate(vehicle.actuators) if name not in angles]
    columns = np.zeros((len(vehicle.inputs), len(names)))
    inverse = np.linalg.pinv(vehicle.mix[:, fixed])
    columns[fixed] = np.where(np.abs(inverse) > ROUNDING, inverse, 0.0)
    turned = [one for thrust, angle in pairs for one in _of_angle(vehicle, thrust, angle, model)]
    return [*_of_columns(vehicle, columns), *turned]


def _of_columns(vehicle: Vehicle, columns: Array) -> list[Drive]:
    """By the inputs (inputs, forces) for a force of 1; forces that they do not move are left out."""
    still = np.zeros(len(vehicle.inputs))
    return [
        Drive(force.name, force.axis, _label(vehicle, force, force.axis), column, still)
        for force, column in zip(vehicle.forces, columns.T, strict=True)
        if column.any()
    ]


def _of_angle(vehicle: Vehicle, thrust: str, angle: str, model: Model | None) -> Iterator[Drive]:
    """The angle at a held thrust ahead, by the force that it changes most, in yaw where it has one.

    Where it has none, but the thrust across turns the boat, it is driven for the turn.
    """
    k, turned = vehicle.inputs.index(thrust), vehicle.inputs.index(angle)
    surge = [force.axis == 0 for force in vehicle.forces]
    held, full = np.zeros((2, len(vehicle.inputs)))
    held[k] = HELD_THRUST * (np.sign(vehicle.mix[surge, k].sum()) or 1.0)
    full[turned] = 1.0
    straight, across = static_forces(vehicle, np.array([held, held + full]))
    change = across - straight
    driven = [i for i, force in enumerate(vehicle.forces) if force.axis != 0 and change[i]]
    if driven:
        most = max(driven, key=lambda i: (vehicle.forces[i].axis, abs(change[i])))
        force, holding = vehicle.forces[most], f", {thrust} held at {percent(HELD_THRUST)}"
        side = _turning(force.name, model) if force.axis == 1 else 0.0
        axis = 2 if side else force.axis
        several = len(angle_names(vehicle.file.chain)) > 1  # each turns the boat
        label = f"{AXES[axis]} ({angle})" if several else _label(vehicle, force, axis)
        command = full * (side or 1.0) / change[most]
        yield Drive(force.name, axis, label, command, held, holding)


def _turning(force: str, model: Model | None) -> float:
    """To which side a force across turns the boat, 1: left, -1: right, as one astern does; 0: it does not."""
    if model is None:
        return -1.0
    own = [term for term in model.structure.terms if term.axis == 2 and term.factors == (force,)]
    values = [term.number * model.values.get(term.coefficient or "", 1.0) for term in own]
    return float(np.sign(sum(values)))


def _label(vehicle: Vehicle, force: Force, axis: int) -> str:
    """The axis that moves, and the force's name where others drive it, too."""
    alone = not any(one.axis == axis for one in vehicle.forces if one.name != force.name)
    return AXES[axis] if alone else f"{AXES[axis]} ({force.name})"


def _made(text: str, effort: int, t: Array, wave: Array, one: Drive) -> Manoeuvre:
    return Manoeuvre(text + one.holding, effort, t, np.outer(wave, one.command) + one.held)


def _pulses(t: Array, on: float, off: float) -> Array:
    """1 during a pulse, 0 in between."""
    return np.where(t % (on + off) < on, 1.0, 0.0)


def _both(t: Array, on: float, off: float) -> Array:
    """Pulses with alternating sign."""
    side = np.where(np.floor(t / (on + off)) % 2 == 0, 1.0, -1.0)
    return np.asarray(side * _pulses(t, on, off))


def _limited(commands: Array) -> Array:
    """Commands within -1..1, each row scaled as a whole."""
    return np.asarray(commands / np.maximum(1.0, np.abs(commands).max(axis=1, keepdims=True)))
