# SPDX-License-Identifier: MIT
"""Stick patterns of 7 to 20 s that a person can drive: a small library to choose the next manoeuvre from."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.experiment_design.manoeuvres import (
    SIDE_WORDS,
    Drive,
    force_commands,
    held_by_both,
)
from seatrial.util.frames import AXES, Array

LEVELS = (1.0, 0.6, 0.3)  # of the full stick
COAST = 5.0  # [s] after a step
PAIR_HOLD, PAIR_TIMES = 1.5, 8  # [s] of each stick of two, and how often
RANDOM_SEEDS = 4  # of random patterns


@dataclass(frozen=True)
class StickPattern:
    """Commands from its beginning; after its end the sticks are released."""

    text: str  # for the driver
    t: Array  # (n,) [s] when commands change, rising from 0
    commands: Array  # (n, inputs) in the vehicle's inputs, forward-left-up
    seconds: float

    @property
    def and_coasting(self) -> "StickPattern":
        """With the released sticks after it, until the boat has slowed down."""
        t = np.append(self.t, self.seconds)
        commands = np.vstack([self.commands, np.zeros_like(self.commands[:1])])
        return StickPattern(self.text, t, commands, self.seconds + COAST)


def stick_directions(vehicle: Vehicle, model: Model | None = None) -> list[Drive]:
    """Every axis that commands drive, at full stick; where these are no forces, every input for itself."""
    found = [
        replace(one, command=one.command / np.abs(one.command).max())
        for one in force_commands(vehicle, model)
    ]
    if found:
        return found
    axes = [force.axis for force in vehicle.forces] or [0]
    count = len(vehicle.inputs)
    return [
        Drive("", axes[min(i, len(axes) - 1)], name, np.eye(count)[i], np.zeros(count))
        for i, name in enumerate(vehicle.inputs)
    ]


def stick_patterns(vehicle: Vehicle, model: Model | None = None) -> list[StickPattern]:
    """Steps with coasting and doublets of each axis at several levels, two axes at a time, and random sticks.

    model: as of `force_commands`.
    """
    directions = stick_directions(vehicle, model)
    found = [one for direction in directions for one in _single(direction)]
    for a, b in combinations(directions, 2):
        found += _double(a, b)
        found += _double(b, a)
    found += [_random(directions, seed) for seed in range(RANDOM_SEEDS)]
    return found


def first_patterns(vehicle: Vehicle, driven: Array) -> list[StickPattern]:
    """Without a model: half stick to each side; first what was driven least, by seconds `driven` (3, 2)."""
    axes = {force.name: force.axis for force in vehicle.forces}
    sides = [(one, side) for one in stick_directions(vehicle) for side in (1.0, -1.0)]
    sides.sort(key=lambda pair: float(driven[axes.get(pair[0].force, pair[0].axis)].sum()))
    return [_held(one, 0.5 * side, 2.0, 1.5) for one, side in sides]


def _single(direction: Drive) -> Iterator[StickPattern]:
    for level in LEVELS:
        for side in (1.0, -1.0):
            yield _held(direction, side * level, 3.0, COAST)
            yield _held(direction, side * level, 2.0, 2.0)
            yield _alternating(direction, side * level, 1.0, 10)
            yield _alternating(direction, side * level, 2.0, 6)


def _held(direction: Drive, level: float, on: float, off: float) -> StickPattern:
    """To one side and let go, to the other and let go."""
    one, other = _sides(direction, level)
    much = _much(level)
    text = f"{much} {one} {on:g} s, let go {off:g} s, {much} {other} {on:g} s, let go {off:g} s"
    t = np.array([0.0, on, on + off, 2 * on + off])
    return _alone(direction, text, t, np.array([level, 0.0, -level, 0.0]), 2 * (on + off))


def _alternating(direction: Drive, level: float, hold: float, times: int) -> StickPattern:
    one, other = _sides(direction, level)
    text = f"{_much(level)} {one} and {other} in turn, {hold:g} s each, {times} times"
    signs = np.where(np.arange(times) % 2 == 0, 1.0, -1.0)
    t = hold * np.arange(times, dtype=float)
    return _alone(direction, text, t, level * signs, hold * times)


def _alone(direction: Drive, text: str, t: Array, levels: Array, seconds: float) -> StickPattern:
    """One axis at these levels (n,), with what is held meanwhile."""
    commands = np.outer(levels, direction.command) + direction.held
    return _made(f"{direction.label}{direction.holding}: {text}", t, commands, seconds)


def _double(first: Drive, second: Drive) -> Iterator[StickPattern]:
    """One axis held while the other alternates or is held, too; both in turn, a quarter apart."""
    label, command, other, steer = first.label, first.command, second.label, second.command
    kept, holding = held_by_both(first, second)
    a, b = _sides(second, 1.0)
    t = PAIR_HOLD * np.arange(PAIR_TIMES, dtype=float)
    in_turn, quarter, late = (
        np.where((np.arange(PAIR_TIMES) + shift) // every % 2 == 0, 1.0, -1.0)
        for shift, every in ((0, 1), (0, 2), (1, 2))
    )
    for level in (0.5, 1.0):
        for side in (1.0, -1.0):
            held, back = _sides(first, side)
            push, what = side * level * command, f"{label}{holding}: {_much(level)} {held}"
            text = f"{what}; {other}: {_much(0.6)} {a} and {b} in turn, {PAIR_HOLD:g} s each"
            yield _made(text, t, push + kept + np.outer(0.6 * in_turn, steer), t[-1] + PAIR_HOLD)
            text = f"{what}; {other}: half stick {a}; both held 10 s"
            yield _made(text, np.zeros(1), (push + kept + 0.5 * steer)[None], 10.0)
            text = (
                f"{what} and {back} in turn, {2 * PAIR_HOLD:g} s each; {other}: {_much(level)} {a} and {b}, "
                f"{PAIR_HOLD:g} s earlier"
            )
            rows = np.outer(quarter, push) + np.outer(level * late, steer) + kept
            yield _made(text, t, rows, t[-1] + PAIR_HOLD)


def _random(directions: Sequence[Drive], seed: int) -> StickPattern:
    """All sticks at random, every 1 to 2 s."""
    rng = np.random.default_rng(seed)
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(1.0, 2.0, 12))])
    sizes = rng.choice([-1.0, -0.5, 0.0, 0.5, 1.0], (len(t), len(directions)))
    commands = sizes @ np.array([one.command for one in directions])
    return _made("all sticks as drawn", t, commands, 20.0)


def _made(text: str, t: Array, commands: Array, seconds: float) -> StickPattern:
    within = commands / np.maximum(1.0, np.abs(commands).max(axis=1, keepdims=True))
    return StickPattern(text[0].upper() + text[1:], t, within, seconds)


def _much(level: float) -> str:
    size = abs(level)
    return {1.0: "full stick", 0.5: "half stick"}.get(size, f"{100 * size:.0f} % stick")


def _sides(direction: Drive, level: float) -> tuple[str, str]:
    own = ("up", "down")
    if direction.label.startswith(AXES[direction.axis]):
        own = SIDE_WORDS[direction.axis]
    return own if level > 0 else own[::-1]
