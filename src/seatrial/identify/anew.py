# SPDX-License-Identifier: MIT
"""Searches that ended in a corner of the noise begin anew.

Three corners hold a search though the likelihood is higher elsewhere, above all where a boat is pushed and
errors of its poses hang together. Such errors that were let go, since they looked like motion as long as
parameters were far off, have no states any more to come back by. Where they last for seconds, as those of
GNSS do, a wandering velocity stands for them, and coefficients that follow it. And where a random walk of the
velocity stands for a push that comes and goes, a little of the latter beside it explains nothing more. So
where there are signs of it the search begins anew from the corner opposite, and the likelier solution is kept.
"""

import numpy as np

from seatrial.errors import IdentificationError
from seatrial.filter_noise import (
    COLOUR,
    MEMORY,
    NOISE_LEAST,
    NOISE_START,
    RAISED,
    WALKS_AND_DISTURBANCES,
    fitted_noise,
)
from seatrial.frames import Array
from seatrial.identify.first_noise import LASTING, all_hanging, half_hanging, lasting
from seatrial.identify.search import NOTHING, Point, descend, hangs
from seatrial.identify.whiteness import white

WORTH = 20.0  # -2 log likelihood by which another solution must be more likely


def anew(at: Point, theta: Array) -> Point:
    """The most likely of `at` and what is found from the corners opposite.

    `theta` (p,): where the search began.
    """
    let_go = not hangs(at.noise) and not white(at)
    if let_go and _promises(at, half_hanging(at.noise)):
        at = _likelier(at, theta, all_hanging(at.passes.problem.recordings))
    for walk, disturbance in WALKS_AND_DISTURBANCES:
        other = exchanged(at.noise, walk, disturbance)
        if other is not None and _promises(at, other):
            at = _likelier(at, at.theta, other)
    for times, memory in LASTING:
        if not white(at):
            at = _likelier(at, theta, lasting(at.passes.problem.recordings, times, memory))
    if not white(at) and (other := pushed(at.noise)) is not None:
        at = _likelier(at, at.theta, other)
    return at


def pushed(noise: Array) -> Array | None:
    """The noise (10,) with disturbances for all walks, and white errors; None where nothing walks."""
    walks = [walk for walk, _ in WALKS_AND_DISTURBANCES]
    if (noise[walks] < NOTHING * RAISED[walks]).all():
        return None
    other = noise.copy()
    other[MEMORY] = NOISE_START[MEMORY]
    for walk, disturbance in WALKS_AND_DISTURBANCES:
        made = other[walk] / np.sqrt(2.0 * other[MEMORY])
        other[disturbance] = max(other[disturbance], made, RAISED[disturbance])
        other[walk] = NOISE_LEAST[walk]
    other[COLOUR[0] :] = NOISE_START[COLOUR[0] :]
    return other


def exchanged(noise: Array, walk: int, disturbance: int) -> Array | None:
    """The noise (10,) with a disturbance for the walk of the same motion; None where there is one.

    One of size d and memory T makes the velocity walk by d sqrt(2 T) in times longer than T.
    """
    makes = np.sqrt(2.0 * noise[MEMORY])
    idle = noise[walk] < NOTHING * RAISED[walk]
    if idle or noise[disturbance] * makes > NOTHING * noise[walk]:
        return None
    other = noise.copy()
    other[disturbance] = noise[walk] / makes
    other[walk] = NOISE_LEAST[walk]
    return np.asarray(other)


def _promises(at: Point, noise: Array) -> bool:
    """Whether other noise makes likelier what the parameters are as they are."""
    passes = at.passes.each
    _, cost = fitted_noise(passes, at.passes.problem.series, noise, WORTH)
    return cost < sum(p.cost for p in passes) - WORTH


def _likelier(at: Point, theta: Array, noise: Array) -> Point:
    """The more likely of `at` and what is found from other parameters and noise."""
    try:
        other = descend(at.passes.problem, theta, noise, at.passes.cost)
    except IdentificationError:
        return at
    return other if other.passes.cost < at.passes.cost - WORTH else at
