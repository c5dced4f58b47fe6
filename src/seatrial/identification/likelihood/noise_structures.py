# SPDX-License-Identifier: MIT
"""Selection of the noise structure: how pose errors and disturbance force are correlated in time, and their frame.

The likelihood has several local maxima in the noise. So a search ends near one structure, and the others are
screened on the linearisation of its last pass: parameters and noise are optimised there without integration. The
best are searched in full; the likeliest stays, correlated pose errors having a price.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain

import numpy as np

from seatrial.boat.noise_parameters import (
    COLOUR,
    COLOUR_MEMORY,
    COLOUR_TURN,
    COLOURED,
    DISTURBANCES,
    IN_PLANE,
    MEMORY,
    NOISE_LEAST,
    PROCESS,
    SWAY_RATIO,
    WALKS,
    equal_in_plane,
    is_unequal,
    noise_units,
    oscillates,
)
from seatrial.identification.likelihood.linearised import (
    Point,
    Promise,
    linearised_optimum,
    noise_box,
)
from seatrial.identification.likelihood.optimiser import (
    Outcome,
    full_pass,
    has_correlated_poses,
    search,
)
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.start_noise import correlated_size, noise_from_poses
from seatrial.identification.likelihood.whiteness import is_white
from seatrial.util.frames import Array
from seatrial.util.parallel import spread
from seatrial.util.progress import stage

# All gains and prices are falls of -2 log likelihood.
PARAMETER_PRICE = 4.0  # of a parameter of a noise source
# sources that a solution may do without, and their parameters
ALL_PROCESS = (2, 3, 4, 5)
SOURCES = ((ALL_PROCESS, 5), (tuple(COLOUR), 3), (tuple(WALKS), 2))
MUCH_LIKELIER = 0.2  # a pose: model mismatch gains less by other noise
SCREENED_SLACK = 4.0  # times the price: a linearised search may end so far from its optimum
SWITCH_GAIN = 3.0  # that another structure must reach beyond the prices
LONGER = 6.0  # times the memory of correlated pose errors, that is tried
SEARCHED = 2  # structures that are searched in full after the screening, at most
START_SWAY_RATIO = 1.25  # where the search of unequal process noise begins: any but 1
DISTURBANCE_MEMORY = 2.0  # [s] where the search of a disturbance force begins
POSES_PER_WAVE = 3.0  # at the least: fewer do not show an oscillation
TRIED_WAVE_PERIODS = np.geomspace(0.5, 10.0, 17)  # [s] that are tried


@dataclass(frozen=True)
class NoiseStructure:
    """Where the search of one noise structure begins."""

    name: str
    # correlated pose errors: memories [s], and sizes over the white errors; None: those that
    # have the fourth differences of the white errors
    memory: float | None = None
    size: float | None = None
    waves: bool = False  # they oscillate
    disturbance: bool = False  # a Gauss-Markov disturbance force; else no process noise
    keeps_process: bool = False  # process noise as the first search found it
    earth_fixed: bool = False  # the frame of the disturbance force
    unequal: bool = False  # in surge and sway

    @property
    def poses_only(self) -> bool:
        """Whether pose errors explain all that the model does not."""
        return not (self.disturbance or self.keeps_process)


STRUCTURES = (
    NoiseStructure("correlated poses", memory=0.3, keeps_process=True),
    NoiseStructure("disturbance", disturbance=True),
    NoiseStructure("unequal disturbance", disturbance=True, unequal=True),
    NoiseStructure("disturbance, correlated poses", memory=0.3, disturbance=True),
    NoiseStructure("disturbance, slowly correlated poses", memory=3.0, size=1.0, disturbance=True),
    NoiseStructure("earth-fixed disturbance", disturbance=True, earth_fixed=True),
    NoiseStructure(
        "earth-fixed disturbance, correlated poses", memory=0.3, disturbance=True, earth_fixed=True
    ),
    NoiseStructure("slowly correlated poses", memory=3.0, size=3.0),
    NoiseStructure("very slowly correlated poses", memory=10.0, size=10.0),
    NoiseStructure("waves", waves=True),
)


@dataclass(frozen=True)
class Screened:
    """The optimum of a noise structure by the linearisation of a pass."""

    begin: Point
    promise: Promise
    white: bool  # whether its innovations are

    @property
    def cost(self) -> float:
        """-2 log likelihood, with prices."""
        return self.begin.runs.cost - self.promise.fall + _price(self.promise.noise)

    def explains(self, at: Point) -> bool:
        """Whether it describes the innovations and the solution's structure does not: white, or much likelier."""
        poses = sum(len(r.t) for r in at.runs.problem.recordings)
        return self.white or self.cost < priced(at) - MUCH_LIKELIER * poses


def screened(at: Point, *, poses_only: bool) -> list[Screened]:
    """Noise structures by the linearisation of a pass, the likeliest first.

    poses_only: those without process noise, else the others.
    """
    frames = {at.runs.problem.earth_fixed: at}
    tried = [structure for structure in STRUCTURES if structure.poses_only == poses_only]
    with stage("", 0.4):
        begins = [_in_frame(at, structure, frames) for structure in tried]
        found = spread(partial(_screened, at), zip(tried, begins, strict=True), "")
    return sorted(chain(*found), key=lambda s: s.cost)


def _screened(at: Point, item: tuple[NoiseStructure, Point | None]) -> list[Screened]:
    """One structure, from where its pass begins; none where that diverges, or where the poses can not show it."""
    structure, begin = item
    if begin is None:
        return []
    found = []
    needed = begin.runs.cost - priced(at) + SWITCH_GAIN  # less is not searched
    for noise in _start_noises(structure, at, begin.runs.problem):
        box = noise_box(begin.runs.problem, noise)
        promise = linearised_optimum(begin, box, noise=noise, needed=needed)
        runs = begin.runs.relinearised(promise.noise, promise.move)
        there = Point(begin.theta + promise.move, promise.noise, runs)
        found.append(Screened(begin, promise, is_white(there)))
    return found


def searched(at: Point, candidates: Sequence[Screened]) -> Point:
    """The likeliest of a solution and those of the best of some structures, searched in full."""
    for one in candidates[:SEARCHED]:
        if one.cost < priced(at) - SWITCH_GAIN:
            at = _likelier(at, one.begin, one.promise)
    return at


def refined(at: Point) -> Point:
    """The solution in the likelier frame, with a longer memory if that is likelier, without needless sources."""
    return simplified(with_longer_memory(in_likelier_frame(at)))


def in_likelier_frame(at: Point, least: Array | None = None) -> Point:
    """The likelier of `at` and the solution with the disturbance force in the other frame, earth or body."""
    if not has_disturbance(at):
        return at
    problem = at.runs.problem
    turned = replace(problem, earth_fixed=not problem.earth_fixed)
    other = full_pass(turned, at.theta, equal_in_plane(at.noise))
    if not np.isfinite(other.runs.cost):
        return at
    promise = linearised_optimum(other, noise_box(problem, other.noise, least))
    if other.runs.cost - promise.fall > at.runs.cost - SWITCH_GAIN:
        return at
    return _likelier(at, other, promise, least)


def with_longer_memory(at: Point) -> Point:
    """The likelier of `at` and a solution whose pose errors have a longer correlation time."""
    if not has_correlated_poses(at.noise):
        return at
    noise = at.noise.copy()
    _lengthen(noise)
    box = noise_box(at.runs.problem, noise)
    promise = linearised_optimum(at, box, noise=noise)
    return at if promise.fall < SWITCH_GAIN else _likelier(at, at, promise)


def with_unequal_axes(at: Point) -> Point:
    """The likelier of `at` and a solution whose process noise differs between surge and sway.

    A force moves unequal masses unequally. An earth-fixed disturbance has no such ratio.
    """
    problem = at.runs.problem
    units = noise_units(at.noise, problem.period)
    moves = bool((at.noise > 0.01 * units)[IN_PLANE].any())
    if problem.earth_fixed or is_unequal(at.noise) or not moves:
        return at
    noise = at.noise.copy()
    noise[SWAY_RATIO] = START_SWAY_RATIO
    needed = SWITCH_GAIN + PARAMETER_PRICE
    promise = linearised_optimum(at, noise_box(problem, noise), noise=noise, needed=needed)
    if promise.fall < needed:
        return at
    found = _likelier(at, at, promise)
    return at if found is at else simplified(found)  # a random walk may have stood for it


def with_equal_axes(at: Point) -> Point:
    """The solution with one process noise for surge and sway.

    A term or a stage that an axis lacks looks like noise of that axis: tests see more with one for both.
    """
    if not is_unequal(at.noise):
        return at
    found, outcome = search(at.runs.problem, at.theta, equal_in_plane(at.noise))
    return found if outcome is Outcome.CONVERGED else at


def _lengthen(noise: Array) -> None:
    """Lengthens the correlation time of pose errors, with their variance: their change over a short time stays."""
    noise[COLOUR_MEMORY] *= LONGER
    noise[COLOUR] *= np.sqrt(LONGER)


def has_disturbance(at: Point) -> bool:
    """Whether there is a disturbance force, which has a frame."""
    units = noise_units(at.noise, at.runs.problem.period)
    return bool((at.noise > 0.01 * units)[DISTURBANCES].any())


def _likelier(at: Point, begin: Point, promise: Promise, least: Array | None = None) -> Point:
    """The likelier, with prices, of a solution and that of a search from a promise."""
    found, outcome = search(
        begin.runs.problem, begin.theta + promise.move, promise.noise, least=least
    )
    good = outcome is Outcome.CONVERGED and priced(found) < priced(at) - SWITCH_GAIN
    return found if good else at


def priced(at: Point) -> float:
    """-2 log likelihood, with prices."""
    return at.runs.cost + _price(at.noise)


def _price(noise: Array) -> float:
    return PARAMETER_PRICE * (
        3.0 * has_correlated_poses(noise) + oscillates(noise) + is_unequal(noise)
    )


def simplified(at: Point) -> Point:
    """The solution without noise sources that gain less than their price."""
    for sources, parameters in SOURCES:
        price = PARAMETER_PRICE * parameters
        if not (at.noise > NOISE_LEAST)[list(sources)].any():
            continue
        # correlated pose errors become white ones; the others are left out
        noise = at.noise.copy()
        if set(sources) == set(COLOUR):
            noise[:2] = np.hypot(noise[:2], noise[COLOUR])
            noise[COLOURED] = NOISE_LEAST[COLOURED]
        noise[list(sources)] = NOISE_LEAST[list(sources)]
        if sources == ALL_PROCESS:
            noise[SWAY_RATIO] = NOISE_LEAST[SWAY_RATIO]
            if has_correlated_poses(noise):
                _lengthen(noise)  # pose errors take the place of motion
        free = np.ones(len(noise), dtype=bool)
        free[list(sources)] = False
        box = noise_box(at.runs.problem, noise, free=free)
        promise = linearised_optimum(at, box, noise=noise)
        if promise.fall < -SCREENED_SLACK * price:
            continue
        theta = at.theta + promise.move
        found, outcome = search(at.runs.problem, theta, promise.noise, free=free)
        if outcome is Outcome.CONVERGED and found.runs.cost < at.runs.cost + price:
            at = found
    return at


def _in_frame(at: Point, structure: NoiseStructure, frames: dict[bool, Point]) -> Point | None:
    """The point with its pass in the structure's frame; None where that does not concern it, or diverges."""
    problem = at.runs.problem
    earth = structure.earth_fixed if structure.disturbance else problem.earth_fixed
    if earth not in frames:
        noise = equal_in_plane(at.noise) if earth else at.noise.copy()
        noise[DISTURBANCES] = _disturbances(at, problem)
        frames[earth] = full_pass(replace(problem, earth_fixed=earth), at.theta, noise)
    return frames[earth] if np.isfinite(frames[earth].runs.cost) else None


def _start_noises(structure: NoiseStructure, at: Point, problem: Problem) -> Iterator[Array]:
    """Noises (12,) where the search of a structure begins; none where the poses can not show it."""
    noise = noise_from_poses(problem.recordings)
    kept = [*range(*PROCESS.indices(len(noise))), SWAY_RATIO]
    noise[kept] = (at.noise if structure.keeps_process else NOISE_LEAST)[kept]
    noise[COLOURED] = NOISE_LEAST[COLOURED]
    if structure.disturbance:
        noise[DISTURBANCES], noise[MEMORY] = _disturbances(at, problem), DISTURBANCE_MEMORY
    if structure.unequal:
        noise[SWAY_RATIO] = START_SWAY_RATIO
    if structure.waves:
        yield from _likeliest_wave(at, noise, problem)
        return
    if structure.memory is not None:
        white = noise[:2].copy()
        own = correlated_size(problem.period, structure.memory)
        noise[COLOUR] = white * (own if structure.size is None else structure.size)
        noise[COLOUR_MEMORY] = structure.memory
        if structure.size is None:
            noise[:2] *= 0.1  # correlated errors stand for the rest
    yield noise


def _disturbances(at: Point, problem: Problem) -> Array:
    """Disturbance forces (2,) that move the boat as the process noise does, or as pose errors do."""
    units = noise_units(at.noise, problem.period)[DISTURBANCES]
    own = at.noise[DISTURBANCES]
    return np.asarray(np.maximum(np.hypot(own, force_for_walk(at.noise[WALKS])), units))


def force_for_walk(walk: Array) -> Array:
    """The disturbance force that moves the velocity as far as a random walk: d sqrt(2 T), T its memory."""
    return np.asarray(walk / np.sqrt(2.0 * DISTURBANCE_MEMORY))


def _likeliest_wave(at: Point, noise: Array, problem: Problem) -> Sequence[Array]:
    """The noise with the oscillating errors that are likeliest at these parameters."""
    tried = []
    for period in wave_periods(problem.period):
        for times in (3.0, 10.0, 30.0):  # the white errors
            waves = noise.copy()
            waves[COLOUR] = times * noise[:2]
            waves[COLOUR_MEMORY], waves[COLOUR_TURN] = 2.0 * period, 2.0 * np.pi / period
            tried.append((at.runs.linearised().cost(waves), waves))
    return [min(tried, key=lambda t: t[0])[1]] if tried else []


def wave_periods(period: float) -> Array:
    """Periods [s] of waves that poses with a period [s] can show; none where these are rare."""
    return np.asarray(TRIED_WAVE_PERIODS[POSES_PER_WAVE * period < TRIED_WAVE_PERIODS])
