# SPDX-License-Identifier: MIT
"""Maximisation of the likelihood over parameters and noise: a damped Gauss-Newton search in two loops.

The outer loop takes full filter passes, which integrate the model. The inner one works on the last pass'
linearisation, without integration: there it alternates Gauss-Newton steps of the parameters with Fisher scoring of
the noise, until neither promises more. So full passes are needed only as often as the model is not linear in its
parameters. Levenberg-Marquardt damping is the trust region (Nocedal and Wright, Numerical Optimization, 2nd ed.,
section 10.3).
"""

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from seatrial import _core
from seatrial.boat.noise_parameters import COLOUR, PROCESS, loosened
from seatrial.boat.noise_scoring import NoiseBox
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.linearised import (
    START_DAMPING,
    Point,
    bounded_step,
    linearised_optimum,
    noise_box,
)
from seatrial.identification.likelihood.problem import Problem
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array, Mask
from seatrial.util.progress import step

# All gains and costs are falls of -2 log likelihood.
CONVERGED_GAIN = 0.05  # that parameters and noise together still promise at convergence
EXACT_FALL = 0.3  # between a promised fall and the real one: the linearisation was as good as exact
UNSETTLING_FALL = 10.0  # by the parameters: then other noise may be likelier, too
LITTLE_GAIN = 0.5  # of a pass, or promised to one: the search may be at its maximum
MOST_DAMPING_AT_ONCE = 10.0  # after one trial that does not fall
STUCK_GAIN = 1000.0  # promised, and yet no trial falls: there is no solution
MOST_PASSES = 40  # full ones of a search
FAR_COST_PER_POSE = 100.0  # -2 log likelihood a pose: a model so far off has useless sensitivities
# times the usual process noise, where the model is far off
MORE_PROCESS_NOISE = 10.0  # and again, as long as that is likelier
HELD_PROCESS_NOISE = (10.0, 3.0, 1.0)  # one after the other, where the search keeps the noise
AT_BOUND_SHARE = 1e-4  # of a parameter's range: within it of a bound it counts as at the bound


class Outcome(Enum):
    """How a search ends."""

    CONVERGED = "converged"
    STUCK = "no step improves the likelihood, far from its maximum"
    OUT_OF_STEPS = "no solution: the search does not converge"
    DIVERGED = "the boat diverges from the start values"


def maximise_likelihood(
    problem: Problem,
    theta: Array,
    noise: Array,
    *,
    hold: bool = False,
    least: Array | None = None,
) -> Point:
    """The maximum-likelihood parameters and, unless `hold`, noise levels not below `least` (12,).

    least: by default the problem's own. Raises IdentificationError where the model diverges, or where the search
    does not converge.
    """
    return converged(search(problem, theta, noise, hold=hold, least=least))


def converged(found: tuple[Point, Outcome], *, or_near: bool = False) -> Point:
    """The point of a search. Raises IdentificationError where it did not converge.

    or_near: out of steps, but near the poses counts as well: under model mismatch searches are slow.
    """
    at, outcome = found
    near = or_near and outcome is Outcome.OUT_OF_STEPS and not far_from_poses(at)
    if near or outcome is Outcome.CONVERGED:
        return at
    if outcome is Outcome.DIVERGED:
        raise IdentificationError(
            f"{outcome.value}; are the commands what was sent to the thrusters, not a measured speed? "
            "inspect shows their signs, units and clocks"
        )
    more = "drive more, or state" if outcome is Outcome.OUT_OF_STEPS else "state"
    raise IdentificationError(
        f"{outcome.value}; do poses and commands belong together, by one clock? If so, {more} known "
        "constants of the thrusters in the vehicle file (chain)"
    )


def search(
    problem: Problem,
    theta: Array,
    noise: Array,
    *,
    hold: bool = False,
    least: Array | None = None,
    free: Mask | None = None,
    passes: int = MOST_PASSES,
) -> tuple[Point, Outcome]:
    """The last point of a search and its outcome.

    free: (12,) noise parameters that are scored, by default all; passes: full ones, at most.
    """
    box = noise_box(problem, noise, least, free)
    # start inside the bounds; with much process noise where the model is far from the poses
    begin = _within_bounds(full_pass(problem, theta, np.clip(noise, box.least, box.most)))
    if far_from_poses(begin):
        begin = _with_more_process_noise(begin, box, hold=hold)
    return _descent(begin, box, hold=hold, passes=passes)


def continued(at: Point) -> Point:
    """The end of a search that goes on from a point. Raises IdentificationError where it does not converge."""
    return converged(_descent(at, noise_box(at.runs.problem, at.noise), hold=False))


def full_pass(problem: Problem, theta: Array, noise: Array) -> Point:
    """The point with its full filter pass."""
    return Point(theta, noise, filter_along(problem, theta, noise))


def far_from_poses(at: Point) -> bool:
    """Whether the model misses the poses by far, or diverges."""
    poses = sum(len(r.t) for r in at.runs.problem.recordings)
    return not at.runs.cost < FAR_COST_PER_POSE * poses


def at_bounds(at: Point) -> Mask:
    """Which free parameters (p,) are at a bound, or as good as that."""
    problem = at.runs.problem
    low, high = problem.bounds
    theta = at.theta[list(problem.free)]
    reach = np.where(np.isfinite(high - low), AT_BOUND_SHARE * (high - low), 0.0)
    return np.asarray((theta <= low + reach) | (theta >= high - reach))


def has_correlated_poses(noise: Array) -> bool:
    """Whether the noise has correlated pose errors."""
    return bool((noise[COLOUR] > _core.NO_COLOUR).any())


def _within_bounds(at: Point) -> Point:
    """The same point, or if it is outside the bounds, the likelier of two inside: a Gauss-Newton step into
    them, which moves the other parameters along, or the nearest point."""
    problem = at.runs.problem
    nearest = problem.clipped(at.theta)
    if (nearest == at.theta).all():
        return at
    if not np.isfinite(at.runs.cost):  # its gradient is useless
        return full_pass(problem, nearest, at.noise)
    stepped = problem.clipped(at.theta + bounded_step(at, 0.0)[0])
    tried = [full_pass(problem, theta, at.noise) for theta in (stepped, nearest)]
    return min(tried, key=lambda p: p.runs.cost if np.isfinite(p.runs.cost) else np.inf)


def _with_more_process_noise(at: Point, box: NoiseBox, *, hold: bool) -> Point:
    """The same with more process noise, which the search reduces again; where the noise is held, the
    parameters found with less and less of it."""
    problem, theta = at.runs.problem, at.theta
    if not hold:
        return _with_likeliest_process_noise(at, box)
    for times in HELD_PROCESS_NOISE:
        loose = full_pass(problem, theta, loosened(at.noise, times))
        theta = _descent(loose, box, hold=True)[0].theta
    return full_pass(problem, theta, at.noise)


def _with_likeliest_process_noise(at: Point, box: NoiseBox) -> Point:
    """The same with 10 times the usual process noise; or 100, 1000 times, as long as more is likelier.

    A gust that moves a boat of 10 kg a little moves one of 0.5 kg by far.
    """
    best, times = None, MORE_PROCESS_NOISE
    while True:
        noise = np.minimum(loosened(at.noise, times), box.most)
        tried = full_pass(at.runs.problem, at.theta, noise)
        if best is not None and not tried.runs.cost < best.runs.cost:
            return best
        best, times = tried, MORE_PROCESS_NOISE * times


@dataclass
class Damping:
    """Levenberg-Marquardt damping, relative to the diagonal (Nielsen, IMM-REP-1999-05, eq. 2.3)."""

    value: float = START_DAMPING
    growth: float = 2.0

    def after_a_fall(self, ratio: float) -> None:
        """By how well the fall was foretold: ratio of the real one to the promised one."""
        self.value *= max(1.0 / 3.0, 1.0 - (2.0 * ratio - 1.0) ** 3)
        self.growth = 2.0

    def after_none(self, ratio: float) -> None:
        """After a trial without a fall: so much that the step ends where the cost is least, by a parabola.

        The parabola has the promised slope at the point and passes through the trial, `ratio` as above.
        """
        parabola = min(1.0 - ratio, MOST_DAMPING_AT_ONCE)
        self.value, self.growth = max(self.growth * self.value, parabola), 2.0 * self.growth


@dataclass
class _Patience:
    """When a search is at its end although its linearised problem promises more."""

    flat: int = 0  # passes in a row that gain little
    failed: int = 0  # passes in a row that do not fall

    def ends(self, fall: float, promised: float) -> bool:
        """After a pass: two little gains in a row, six failures in a row, or one where little was promised."""
        if fall > 0.0:
            self.flat, self.failed = self.flat + 1 if fall < LITTLE_GAIN else 0, 0
        else:
            self.failed += 1
        in_vain = self.failed > 0 and promised < LITTLE_GAIN
        return self.flat == 2 or self.failed == 6 or in_vain


def _descent(
    at: Point, box: NoiseBox, *, hold: bool, passes: int = MOST_PASSES
) -> tuple[Point, Outcome]:
    """Downhill from a point, until its linearised problem promises less than `CONVERGED_GAIN`."""
    if not np.isfinite(at.runs.cost):
        return at, Outcome.DIVERGED
    damping, patience = Damping(), _Patience()
    settled = hold  # the noise is, until the parameters are
    trusted = box  # which noise the linearisation is good for
    for _ in range(passes):
        promise = linearised_optimum(at, trusted, damping.value, hold=settled)
        if settled and not hold and promise.fall < CONVERGED_GAIN:
            promise = linearised_optimum(at, trusted, damping.value)
        if promise.fall < CONVERGED_GAIN:
            return at, Outcome.CONVERGED
        theta = at.runs.problem.clipped(at.theta + promise.move)  # rounding may leave the bounds
        tried = full_pass(at.runs.problem, theta, promise.noise)
        step(8.0)  # passes, usually
        fall = at.runs.cost - tried.runs.cost
        if fall > 0.0:
            kept = bool((promise.noise == at.noise).all()) or abs(fall - promise.fall) < EXACT_FALL
            settled, trusted = hold or (kept and fall < UNSETTLING_FALL), box
            at.runs.drop_poses()
            at = tried
            damping.after_a_fall(fall / promise.fall)
        else:
            tried.runs.drop_poses()
            trusted = replace(box, least=_halfway(at.noise, promise.noise, box.least))
            damping.after_none(fall / promise.fall)
        if patience.ends(fall, promise.fall):
            return at, Outcome.STUCK if promise.fall > STUCK_GAIN else Outcome.CONVERGED
    return at, Outcome.OUT_OF_STEPS


def _halfway(noise: Array, tried: Array, least: Array) -> Array:
    """Lower bounds (12,) of noise that falls half as far, in its logarithm, as a trial that did not gain."""
    process = np.zeros(len(noise), dtype=bool)
    process[PROCESS] = True
    return np.where(process, np.maximum(least, np.sqrt(noise * np.minimum(tried, noise))), least)
