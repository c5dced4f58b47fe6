# SPDX-License-Identifier: MIT
"""Manoeuvres that a person with a joypad can drive for a minute, as commands over time."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.util.frames import AXES, Array

MANOEUVRE_LENGTH = 60.0  # [s] of a manoeuvre
COMMAND_PERIOD = 0.1  # [s] between its commands
COMMAND_SHARES = (1 / 3, 2 / 3, 1.0)  # of the largest command that was recorded
SIDE_WORDS = {  # what a positive and a negative force of an axis do, forward-left-up
    0: ("ahead", "astern"),
    1: ("to the left", "to the right"),
    2: ("turning left", "turning right"),
}
PULSE_LENGTH, PAUSE_LENGTH = 3.0, 2.0  # [s] of a usual pulse
QUICK_PULSE_LENGTH = 0.8  # [s] of a quick one
TURN_SHARE = 0.5  # share of the largest yaw command that turns the boat beside another manoeuvre


@dataclass(frozen=True)
class Manoeuvre:
    """Commands for a minute."""

    text: str  # what to do
    effort: int  # 1: one stick one way, 2: both ways, 3: two sticks
    t: Array  # (n,) [s] when commands change
    commands: Array  # (n, inputs) in the vehicle's inputs


def manoeuvres(model: Model) -> list[Manoeuvre]:
    """Pulses of every axis, to one side, to both, quick ones; and two axes at a time."""
    directions = list(_directions(model))
    t = np.arange(0.0, MANOEUVRE_LENGTH, COMMAND_PERIOD)
    found = []
    for axis, name, direction in directions:
        for size in COMMAND_SHARES:
            much = f"at {100 * size * float(np.abs(direction).max()):.0f} % command"
            push = size * direction
            for side, word in zip((1.0, -1.0), SIDE_WORDS[axis], strict=True):
                wave = side * _pulses(t, PULSE_LENGTH, PAUSE_LENGTH)
                found.append(_made(f"{name} pulses {word} {much}", 1, t, wave, push))
            wave = _both(t, PULSE_LENGTH, PAUSE_LENGTH)
            found.append(_made(f"{name} pulses to both sides {much}", 2, t, wave, push))
            wave = _both(t, QUICK_PULSE_LENGTH, QUICK_PULSE_LENGTH)
            text = f"quick {name} pulses ({QUICK_PULSE_LENGTH:g} s) to both sides {much}"
            found.append(_made(text, 2, t, wave, push))
    turns = [direction for axis, _, direction in directions if axis == 2]
    for axis, name, direction in directions if turns else []:
        if axis == 2:
            continue
        turn = np.outer(np.ones(len(t)), TURN_SHARE * turns[0])
        for wave, word in (
            (_pulses(t, PULSE_LENGTH, PAUSE_LENGTH), SIDE_WORDS[axis][0]),
            (_both(t, PULSE_LENGTH, PAUSE_LENGTH), "both ways"),
        ):
            text = f"full {name} pulses {word} while turning left at half command"
            found.append(Manoeuvre(text, 3, t, _limited(np.outer(wave, direction) + turn)))
    return found


def _directions(model: Model) -> Iterator[tuple[int, str, Array]]:
    """Axis, name, and the inputs (inputs,) of the largest recorded push of every force."""
    vehicle = model.vehicle
    names = [force.name for force in vehicle.forces]
    direct = set(vehicle.inputs) == set(names)
    axes = [force.axis for force in vehicle.forces]
    for force, axis in enumerate(axes):
        label = AXES[axis] + (f" ({names[force]})" if axes.count(axis) > 1 else "")
        if direct:
            push = np.array([float(name == names[force]) for name in vehicle.inputs])
        elif set(vehicle.inputs) == set(vehicle.actuators):
            push = np.linalg.pinv(vehicle.mix)[:, force]
        else:
            continue
        low, high = model.envelope.forces.get(names[force], (-1.0, 1.0))
        push = push * max(abs(low), abs(high))  # of thrusters: those that make the force
        yield axis, label, push / max(1.0, float(np.abs(push).max()))


def _made(text: str, effort: int, t: Array, wave: Array, push: Array) -> Manoeuvre:
    return Manoeuvre(text, effort, t, np.outer(wave, push))


def _pulses(t: Array, on: float, off: float) -> Array:
    """1 during a pulse, 0 in between."""
    return np.where(t % (on + off) < on, 1.0, 0.0)


def _both(t: Array, on: float, off: float) -> Array:
    """Pulses one way and the other in turns."""
    side = np.where(np.floor(t / (on + off)) % 2 == 0, 1.0, -1.0)
    return np.asarray(side * _pulses(t, on, off))


def _limited(commands: Array) -> Array:
    """Commands within -1..1, all of a row scaled alike."""
    return np.asarray(commands / np.maximum(1.0, np.abs(commands).max(axis=1, keepdims=True)))
