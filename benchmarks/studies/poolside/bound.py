# SPDX-License-Identifier: MIT
"""How soon the best mixture of stick patterns has the intervals of S1 to S3, beside guided drives.

    python -m benchmarks.studies.poolside.bound --seeds 5

The mixture is the D-optimal one (multiplicative algorithm; Silvey, Optimal Design, 1980, section 3.4) of the
advice's patterns and of random sticks, from rest and from a moving boat, by the model at the end of the guided
drive. It needs no model to begin with, knows no walls, and loses no time between patterns. Its information counts
as much as that of the guided drive turned out to.
"""

import sys
from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.studies.poolside.__main__ import by_water, of_waters
from benchmarks.studies.poolside.drivers import Guided, Protocol
from benchmarks.studies.poolside.drives import LONGEST, WATERS, Drive
from seatrial.boat.model import Model
from seatrial.identification.experiment_design.information import reference_point
from seatrial.identification.experiment_design.simulated_drive import simulated_drive
from seatrial.poolside.stick_patterns import stick_directions, stick_patterns
from seatrial.util.frames import Array
from seatrial.util.statistics import NORMAL_95

MOVING = 5  # states to begin with, beside rest
RANDOM, RANDOM_SECONDS = 200, 20.0  # segments of random sticks, and their length [s]
SHORTEST_HOLDS = (0.5, 1.0, 2.0, 3.0)  # [s] of random sticks; the longest are twice as long
STEPS = 2000  # of the algorithm


def bound(water: str, seed: int) -> tuple[float, float, float]:
    """Seconds of S1 to S3, of the guided drive and of the mixture, until the median interval is as narrow."""
    own = WATERS[water](seed)
    protocol = Protocol(own, seed)
    goal = Drive(own, protocol).run(protocol.length, {}).widths
    own = WATERS[water](seed)
    drive = Drive(own, Guided(own, seed))
    guided = drive.run(LONGEST, goal).same
    assert drive.model is not None
    rates, names = _information_rates(drive.model, own.period)
    rates *= drive.estimator.trust
    kept = [i for i, name in enumerate(names) if name in goal]
    variances = np.diag(np.linalg.inv(_d_optimal(rates)))[kept]
    ratios = NORMAL_95 * np.sqrt(variances) / np.array([goal[names[i]] for i in kept])
    return protocol.length, guided, float(np.median(ratios)) ** 2


def _information_rates(model: Model, period: float) -> tuple[Array, tuple[str, ...]]:
    """Fisher information a second (k, p, p) along each segment, and the parameters' names."""
    found, point = [], None
    for t, commands, seconds, begin in _segments(model):
        drive = simulated_drive(model, begin, (t, commands), np.arange(0.0, seconds, period))
        point = point or reference_point(model, [drive.recording])
        runs = point.run_filter([drive.recording], [drive.states[0, 3:]])
        if runs.by_recording[0].good:
            found.append(runs.information_of(0) / seconds)
    assert point is not None
    return np.array(found), point.names


def _segments(model: Model) -> Iterator[tuple[Array, Array, float, Array]]:
    """Times, commands, seconds and first states: all patterns, and random sticks."""
    rng = np.random.default_rng(0)
    t, commands = _random_sticks(model, rng, 1.0, 300.0)
    states = simulated_drive(model, np.zeros(6), (t, commands), np.arange(0.0, 300.0, 0.1)).states
    begins = [np.zeros(6), *states[rng.integers(0, len(states), MOVING)]]
    for pattern in stick_patterns(model.vehicle):
        for begin in begins:
            yield pattern.t, pattern.commands, pattern.seconds, begin
    for k in range(RANDOM):
        hold = SHORTEST_HOLDS[k % len(SHORTEST_HOLDS)]
        sticks = _random_sticks(model, rng, hold, RANDOM_SECONDS)
        yield *sticks, RANDOM_SECONDS, begins[k % len(begins)]


def _random_sticks(
    model: Model, rng: np.random.Generator, hold: float, seconds: float
) -> tuple[Array, Array]:
    """All sticks at random, each for one to two times `hold` [s]."""
    t = np.concatenate([[0.0], np.cumsum(rng.uniform(hold, 2 * hold, int(seconds / hold)))])
    t = t[t < seconds]
    directions = np.array([command for _, _, command in stick_directions(model.vehicle)])
    commands = rng.choice([-1.0, -0.5, 0.0, 0.5, 1.0], (len(t), len(directions))) @ directions
    return t, commands / np.maximum(1.0, np.abs(commands).max(axis=1, keepdims=True))


def _d_optimal(rates: Array) -> Array:
    """The information a second (p, p) of the mixture with the largest determinant."""
    scale = 1.0 / np.sqrt(np.median([np.diag(one) for one in rates], axis=0))
    scaled = rates * np.outer(scale, scale)
    weights = np.full(len(rates), 1.0 / len(rates))
    for _ in range(STEPS):
        inverse = np.linalg.inv(np.einsum("k,kij->ij", weights, scaled))
        weights *= np.einsum("kij,ji->k", scaled, inverse) / len(scale)
    return np.asarray(np.einsum("k,kij->ij", weights, rates))


def main(arguments: Sequence[str]) -> None:
    """Print a line a drive, and the medians."""
    given = of_waters("studies.poolside.bound", __doc__, 5).parse_args(arguments)
    for water, drives in by_water(given, bound):
        found = np.array(drives)
        for length, guided, best in found:
            print(f"{water}: S1 to S3 {length:.0f} s, guided {guided:.0f} s, mixture {best:.0f} s")
        guided, best = np.median(found[:, 1:] / found[:, :1], axis=0)
        print(f"{WATERS[water].name}: guided {guided:.2f}, mixture {best:.2f} of S1 to S3")


if __name__ == "__main__":
    main(sys.argv[1:])
