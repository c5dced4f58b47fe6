# SPDX-License-Identifier: MIT
"""The optimum of the likelihood by the linearisation of a full filter pass, without integration.

Gauss-Newton steps of the parameters alternate with Fisher scoring of the noise, until neither promises more.
"""

from dataclasses import dataclass, field

import numpy as np

from seatrial.boat.noise_parameters import most_noise
from seatrial.boat.noise_scoring import NoiseBox, Value, scored
from seatrial.identification.likelihood.filter_runs import FilterRuns
from seatrial.identification.likelihood.problem import Problem
from seatrial.util.box import box_minimum
from seatrial.util.frames import Array, Mask

INNER_GAIN = 0.05  # of one round of the inner loop, at its end
# of the fall so far that a round must gain: more is in vain far from the maximum
INNER_SHARE = 0.02
MOST_ROUNDS = 6  # of the inner loop: one or two do near the maximum
START_DAMPING = 1e-6  # Levenberg-Marquardt, relative to the diagonal


@dataclass(frozen=True)
class Point:
    """Parameters, noise, and the filter run with them."""

    theta: Array  # (p,) all parameters
    noise: Array  # (12,)
    runs: FilterRuns


@dataclass(frozen=True)
class Promise:
    """The optimum of a linearised problem."""

    move: Array  # (names,) of the parameters
    noise: Array  # (12,)
    fall: float  # of the cost


def noise_box(
    problem: Problem, noise: Array, least: Array | None = None, free: Mask | None = None
) -> NoiseBox:
    """The box of a search that begins with this noise (12,).

    least: (12,) lower bounds, by default the problem's; free: (12,) parameters that are scored, or all.
    """
    low = problem.least_noise if least is None else least
    every = np.ones(len(noise), dtype=bool)
    return NoiseBox(low, np.maximum(most_noise(noise), low), every if free is None else free)


def linearised_optimum(
    at: Point,
    box: NoiseBox,
    damping: float = START_DAMPING,
    *,
    noise: Array | None = None,
    hold: bool = False,
    needed: float = -np.inf,
) -> Promise:
    """Parameters and noise that are likeliest by the linearisation of a point's full pass.

    damping: of the parameters' steps, relative to the diagonal of their information; noise: (12,) where the search
    of the noise begins, by default the point's own; needed: a lesser fall is of no use, so the search ends where
    the pace of its last round does not reach it. Every noise is valued with the parameters a step on from it.
    """
    profile = _Profile(at, damping)
    best = profile.begin() if noise is None else profile.at(noise)
    if hold:
        return best
    for round_ in range(MOST_ROUNDS):
        before = best.fall
        here, value = at.runs.linearised(best.move), Value(profile.value, -best.fall)
        scored(here, best.noise, box, value, absent=round_ == 0)
        best = profile.best
        gain = best.fall - before
        reach = best.fall + gain * (MOST_ROUNDS - 1 - round_)
        if not gain > max(INNER_GAIN, INNER_SHARE * best.fall) or reach < needed:
            break
    return best


def by_linearisation(at: Point, noise: Array | None = None) -> Point:
    """The likeliest point by the linearisation of a full pass, with its relinearised runs.

    noise: (12,) where its search begins, by default the point's own.
    """
    promise = linearised_optimum(at, noise_box(at.runs.problem, at.noise), noise=noise)
    runs = at.runs.relinearised(promise.noise, promise.move)
    return Point(at.theta + promise.move, promise.noise, runs)


@dataclass
class _Profile:
    """The likelihood of the noise by a linearisation, the parameters being at their best for it."""

    about: Point
    damping: float
    best: Promise = field(init=False)

    def begin(self) -> Promise:
        """With the point's own noise."""
        move, fall = bounded_step(self.about, self.damping)
        self.best = Promise(move, self.about.noise, fall)
        return self.best

    def at(self, noise: Array) -> Promise:
        """With another noise (12,), from the point's parameters."""
        self.best = self._promise(noise, np.zeros(len(self.about.theta)))
        return self.best

    def value(self, noise: Array) -> float:
        """Cost, less the point's own, with the parameters a step on from the best so far."""
        found = self._promise(noise, self.best.move)
        if found.fall > self.best.fall:
            self.best = found
        return -found.fall

    def _promise(self, noise: Array, move: Array) -> Promise:
        at = self.about
        there = Point(at.theta + move, noise, at.runs.relinearised(noise, move))
        if not np.isfinite(there.runs.cost):
            return Promise(move, noise, -np.inf)
        further, promised = bounded_step(there, self.damping, at)
        return Promise(move + further, noise, at.runs.cost - there.runs.cost + promised)


def bounded_step(at: Point, damping: float, origin: Point | None = None) -> tuple[Array, float]:
    """A Gauss-Newton step (names,) within bounds and step limits, and the fall of the cost that it promises.

    origin: where the limits and the damping count from; by default `at`.
    """
    begin = at if origin is None else origin
    gradient, information = at.runs.gradient, at.runs.information
    free = list(at.runs.problem.free)
    moved = (at.theta - begin.theta)[free]
    trust = damping * (np.diag(begin.runs.information) + 1e-12)  # some have no information
    move = boxed_step(at, gradient - trust * moved, information + np.diag(trust), moved)
    taken = move[free]
    return move, float(2.0 * taken @ gradient - taken @ information @ taken)


def boxed_step(at: Point, gradient: Array, information: Array, moved: Array | None = None) -> Array:
    """The step (names,) from a point to the optimum of a quadratic likelihood, within bounds and step limits.

    gradient: (p,), information: (p, p) of the free parameters; moved: (p,) steps so far, within the limits, too.
    """
    problem = at.runs.problem
    free = np.array(problem.free)
    so_far = np.zeros(len(free)) if moved is None else moved
    low, high = (bound - at.theta[free] for bound in problem.bounds)
    diagonal = np.diag(information) + 1e-12
    scale = 1.0 / np.sqrt(diagonal)
    move = np.zeros(len(at.theta))
    # a damping that keeps the step unique where two terms are the same
    move[free] = scale * box_minimum(
        (information + np.diag(1e-12 * diagonal)) * np.outer(scale, scale),
        scale * gradient,
        np.minimum(np.maximum(low, -problem.step_limits - so_far), 0.0) / scale,
        np.maximum(np.minimum(high, problem.step_limits - so_far), 0.0) / scale,
    )
    return move
