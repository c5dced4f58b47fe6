# SPDX-License-Identifier: MIT
"""Runs: a course, a pilot, a plant and the weather; distances from the path."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.harness.still import Still
from benchmarks.studies.guidance.boat import (
    CALM,
    SETTLING,
    TICK,
    WINDY,
    Sea,
    Weather,
    identified,
    truth,
)
from benchmarks.studies.guidance.pilots import ByHand, HandGains, Tuned, Waiting, nearest
from benchmarks.studies.tracking.pilots import Pilot
from seatrial.boat.model import Model
from seatrial.control import (
    KNOB,
    ByLength,
    Course,
    Eight,
    Shape,
    Tuning,
    at_speed,
    lawn_mower,
    rounded_square,
    tune,
)
from seatrial.util.frames import Array

SHAPES: dict[str, Callable[[], Shape]] = {
    "square": lambda: rounded_square(20.0, 3.0),
    "figure of eight": lambda: ByLength(Eight(16.0, 6.0)),
    "lawn-mower": lambda: lawn_mower(25.0, 10.0, 4, 2.5),
}
SPEEDS = (0.5, 1.5)  # [m/s]
SEEDS = (1, 2)
RAMP = 6.0  # [s] to the speed and back
GRID_HEADING = [(p, d) for p in (0.5, 1.0, 2.0) for d in (0.25, 0.5, 1.0)]
GRID_SPEED = (0.5, 1.0, 2.0)
GRID_AHEAD = (1.5, 2.0, 3.0, 4.0, 6.0)  # [m]
WATCH = 240.0  # [s] of station keeping; the last half counts


@dataclass(frozen=True)
class Outcome:
    """One run."""

    across: Array  # (n,) [m] true distance from the nearest point of the path
    behind: Array  # (n,) [m] true distance from the reference

    @property
    def rms(self) -> float:
        """Of the distance from the path [m]."""
        return float(np.sqrt((self.across**2).mean()))

    @property
    def most(self) -> float:
        """95 % quantile [m]."""
        return float(np.quantile(self.across, 0.95))


@cache
def course(shape: str, speed: float) -> Course:
    """A shape at a speed [m/s]."""
    return at_speed(SHAPES[shape](), speed, RAMP)


@cache
def tuned(knob: float = KNOB) -> Tuning:
    """By the identified model."""
    return tune(identified(), knob, rate=1.0 / TICK)


def run(plant: Model, pilot: Pilot, path: Course, weather: Weather, seed: int) -> Outcome:
    """The course once."""
    sea = Sea(plant, weather, seed, path.at(0.0).eta)
    poses: list[Array] = []
    behind: list[float] = []
    for _ in range(round((SETTLING + path.duration) / TICK)):
        values = pilot.command(sea.time, path) if sea.time > 1.0 else np.zeros(2)
        sea.command(values)
        for stamp, eta in sea.advance():
            pilot.pose(stamp, eta)
        if sea.time >= SETTLING:
            poses.append(sea.eta[:2])
            wanted = path.at(sea.time - SETTLING).eta
            behind.append(float(np.hypot(*(sea.eta - wanted)[:2])))
    return Outcome(distances(np.array(poses), path), np.array(behind))


def distances(points: Array, path: Course) -> Array:
    """From each point (n, 2) to the nearest of the path's, near the one that was passed last."""
    passed, found = 0.0, np.zeros(len(points))
    for i, point in enumerate(points):
        passed, near = nearest(path, passed, point)
        found[i] = np.hypot(*(near[:2] - point))
    return found


@cache
def by_hand() -> HandGains:
    """The best of a grid on the true boat, in calm water, on square and lawn-mower at both speeds."""
    tried: dict[HandGains, float] = {}

    def cost(gains: HandGains) -> float:
        if gains not in tried:
            found = [
                run(truth(), ByHand(gains), course(shape, speed), CALM, 100)
                for shape in ("square", "lawn-mower")
                for speed in SPEEDS
            ]
            tried[gains] = float(sum(np.log(one.rms) for one in found))
        return tried[gains]

    best = HandGains((1.0, 0.5), 1.0, 3.0)
    best = min((HandGains(h, best.speed, best.ahead) for h in GRID_HEADING), key=cost)
    best = min((HandGains(best.heading, best.speed, a) for a in GRID_AHEAD), key=cost)
    return min((HandGains(best.heading, s, best.ahead) for s in GRID_SPEED), key=cost)


PILOTS: dict[str, Callable[[], Pilot]] = {
    "PID by hand, plain LOS": lambda: ByHand(by_hand()),
    "tuned, ILOS": lambda: Tuned(tuned()),
    "tuned, ILOS, waiting": lambda: Waiting(tuned()),
}


@cache
def outcomes(
    shape: str, speed: float, pilot: str, *, windy: bool, left: float = 1.0
) -> tuple[Outcome, ...]:
    """One a seed."""
    return tuple(
        run(truth(left), PILOTS[pilot](), course(shape, speed), WINDY if windy else CALM, seed)
        for seed in SEEDS
    )


def keeping_station(weather: Weather, left: float = 1.0) -> tuple[float, float]:
    """RMS and 95 % of the distance [m] from the goal, by the tuned controller."""
    found = [
        run(truth(left), Tuned(tuned()), Course(Still(), WATCH), weather, seed).behind
        for seed in SEEDS
    ]
    late = np.concatenate([one[len(one) // 2 :] for one in found])
    return float(np.sqrt((late**2).mean())), float(np.quantile(late, 0.95))
