# SPDX-License-Identifier: MIT
"""Manoeuvres for one minute by joypad, as commands over time."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.util.frames import AXES, Array

MANOEUVRE_LENGTH = 60.0  # [s]
SIDE_WORDS = {  # of a positive and a negative force of an axis, forward-left-up
    0: ("ahead", "astern"),
    1: ("to the left", "to the right"),
    2: ("turning left", "turning right"),
}
PULSE_LENGTH, PAUSE_LENGTH = 3.0, 2.0  # [s]
QUICK_PULSE_LENGTH = 0.8  # [s]


@dataclass(frozen=True)
class Manoeuvre:
    """Commands for one minute."""

    text: str  # instruction to the driver
    effort: int  # 1: one stick one way, 2: both ways, 3: two sticks
    t: Array  # (n,) [s] when commands change
    commands: Array  # (n, inputs) in the vehicle's inputs


def manoeuvres(model: Model) -> list[Manoeuvre]:
    """Pulses of every axis, to one side, to both, quick ones; then two axes at a time."""
    directions = list(_directions(model))
    t = np.arange(0.0, MANOEUVRE_LENGTH, 0.1)  # [s]
    found = []
    for axis, name, direction in directions:
        for size in (1 / 3, 2 / 3, 1.0):  # of the largest recorded command
            much = f"at {100 * size * float(np.abs(direction).max()):.0f} % command"
            command = size * direction
            for side, word in zip((1.0, -1.0), SIDE_WORDS[axis], strict=True):
                wave = side * _pulses(t, PULSE_LENGTH, PAUSE_LENGTH)
                found.append(_made(f"{name} pulses {word} {much}", 1, t, wave, command))
            wave = _both(t, PULSE_LENGTH, PAUSE_LENGTH)
            found.append(_made(f"{name} pulses to both sides {much}", 2, t, wave, command))
            wave = _both(t, QUICK_PULSE_LENGTH, QUICK_PULSE_LENGTH)
            text = f"quick {name} pulses ({QUICK_PULSE_LENGTH:g} s) to both sides {much}"
            found.append(_made(text, 2, t, wave, command))
    turns = [direction for axis, _, direction in directions if axis == 2]
    for axis, name, direction in directions if turns else []:
        if axis == 2:
            continue
        turn = np.outer(np.ones(len(t)), 0.5 * turns[0])
        for wave, word in (
            (_pulses(t, PULSE_LENGTH, PAUSE_LENGTH), SIDE_WORDS[axis][0]),
            (_both(t, PULSE_LENGTH, PAUSE_LENGTH), "both ways"),
        ):
            text = f"full {name} pulses {word} while turning left at half command"
            found.append(Manoeuvre(text, 3, t, _limited(np.outer(wave, direction) + turn)))
    return found


def _directions(model: Model) -> Iterator[tuple[int, str, Array]]:
    """Axis, name, and the inputs (inputs,) at the largest recorded value of every force."""
    for force, axis, label, unit in force_commands(model.vehicle):
        low, high = model.envelope.forces.get(force, (-1.0, 1.0))
        command = unit * max(abs(low), abs(high))
        yield axis, label, command / max(1.0, float(np.abs(command).max()))


def force_commands(vehicle: Vehicle) -> Iterator[tuple[str, int, str, Array]]:
    """Every force that commands drive: its name, axis, label, and the inputs (inputs,) for a force of 1."""
    names = [force.name for force in vehicle.forces]
    direct = set(vehicle.inputs) == set(names)
    axes = [force.axis for force in vehicle.forces]
    for force, axis in enumerate(axes):
        label = AXES[axis] + (f" ({names[force]})" if axes.count(axis) > 1 else "")
        if direct:
            yield (
                names[force],
                axis,
                label,
                np.array([float(n == names[force]) for n in vehicle.inputs]),
            )
        elif set(vehicle.inputs) == set(vehicle.actuators):  # thruster commands for the force
            yield (
                names[force],
                axis,
                label,
                np.asarray(np.linalg.pinv(vehicle.mix)[:, force], dtype=float),
            )


def _made(text: str, effort: int, t: Array, wave: Array, command: Array) -> Manoeuvre:
    return Manoeuvre(text, effort, t, np.outer(wave, command))


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
