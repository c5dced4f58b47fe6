# SPDX-License-Identifier: MIT
"""How closely the model is believed.

The likelihood weighs every pose by its own noise. A structure that is not quite right then spends
its coefficients on what happens within a few poses, where noise is smallest, and predicts a second
ahead the worse for it. So models that are believed less closely are tried as well: the filter takes
the poses for noisier than they are, by a share of the way that the boat goes in one second, and the
fit looks as much further ahead. They are compared by what they are for: the error one second
ahead. Where the filter's errors follow no pattern, structure and noise explain them, and the
likelihood's choice stays.
"""

from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import (
    DISTURBANCES,
    NOISE_LEAST,
    PROCESS,
    fitted_noise,
    likelier_noise,
    noise_entry,
)
from seatrial.boat.schema import EnvelopeEntry, Integration
from seatrial.evaluation.prediction import DEFAULT_HORIZON, predict
from seatrial.identification.diagnostics.scale_factors import thrust_and_drag
from seatrial.identification.likelihood.noise_structures import WORTH, reframed
from seatrial.identification.likelihood.optimiser import Point, search
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.whiteness import explained, pattern, white
from seatrial.identification.regression.start_lever import of_origin
from seatrial.recording.velocity import motion
from seatrial.util.errors import IdentificationError, ModelError, RecordingError
from seatrial.util.frames import AXES, Array
from seatrial.util.statistics import inverse_of

SHARES = (0.2, 0.8)  # of the way gone in one second
LOSS = 0.01  # share of the error one second ahead that a looser belief may cost
CLEAR = 1.5  # times the limit from which on a pattern is no chance
GAIN = 0.03  # share of that error that a looser belief must gain there: fits to it gain some
KNOWN = 0.3  # of the error: what the velocity is pushed about by in the meantime is no more
POOR = 0.9  # error over that of a velocity that stays, from which on a model says nothing
OBEYED = 15.0  # standard errors of a force's coefficient from which on commands move the boat
NOISY = 2.0  # errors of less than so many times their floor, squared, say nothing of the model


@dataclass(frozen=True)
class Ahead:
    """Errors one second ahead, over all recordings."""

    rms: Array  # (3,)
    floor: Array  # (3,) what pose noise alone makes
    still: Array  # (3,) of a velocity that stays as it is
    moving: Array  # (3,) of a boat at rest: the velocity itself


def believed(at: Point, *, hold: bool = False) -> tuple[Array, Point, float]:
    """The likelihood's noise (11,), the solution that predicts best, and the share it was believed to.

    A looser belief has fewer local optima, too: where the likelihood is higher there, it is followed
    from there.
    """
    problem = at.passes.problem
    if hold or not _comparable(problem) or explained(at) or white(at):
        return at.noise, at, 0.0
    may_cost = LOSS if pattern(at) > CLEAR else -GAIN
    best = _ahead(problem, at.theta, at.noise)
    if best is None or (best.rms**2 < NOISY * best.floor**2).all():
        return at.noise, at, 0.0
    chosen, share = at, 0.0
    for tried in SHARES:
        try:
            found = search(problem, chosen.theta, chosen.noise, least=least_noise(problem, tried))
        except IdentificationError:
            continue
        closer = _closer(at, found)
        if closer is not at:
            return believed(closer)
        ahead = _ahead(problem, found.theta, at.noise)
        if ahead is None:
            continue
        worse = float(np.mean(np.log(ahead.rms / best.rms)))
        if worse < may_cost:  # as good a second ahead: then what was fitted a second ahead
            chosen, share, best = found, tried, ahead if worse < 0.0 else best
    if share:  # what is more likely so may come from another side
        chosen = reframed(chosen, least_noise(problem, share))
    return at.noise, chosen, share


def worth(at: Point, share: float = 0.0) -> list[Finding]:
    """A finding where the model is no better one second ahead than no model.

    Not where errors of the poses hide how good it is: it is believed to know the velocity better than
    that, and rightly, unless it was believed to a `share` only.
    """
    if explained(at) or not _comparable(at.passes.problem):
        return []
    ahead = _ahead(at.passes.problem, at.theta, at.noise)
    if ahead is None:
        return [finding_of(FindingKind.NOT_PREDICTABLE)]
    moves = ahead.moving**2 > NOISY * ahead.floor**2
    least = np.where(moves, np.minimum(ahead.still, ahead.moving), ahead.still)
    ratio = ahead.rms / np.maximum(least, 1e-12)
    pushed = np.hypot(at.noise[PROCESS][:2], at.noise[DISTURBANCES])[[0, 0, 1]]  # in a second
    known = (pushed < KNOWN * ahead.rms) & (share == 0.0)
    known |= ahead.rms**2 < NOISY * ahead.floor**2
    known |= np.array([_obeys(at, axis) for axis in range(3)])
    poor = [axis for axis, r, k in zip(AXES, ratio, known, strict=True) if r > POOR and not k]
    if not poor:
        return []
    return [finding_of(FindingKind.NO_BETTER_THAN_CONSTANT, *poor)]


def _obeys(at: Point, axis: int) -> bool:
    """Whether thrust of an axis is so clearly seen that poses and commands do belong together."""
    problem = at.passes.problem
    thrust, _ = thrust_and_drag(problem.vehicle.structure, axis)
    free = np.array(problem.free)
    errors = np.sqrt(np.diag(inverse_of(at.passes.information)))
    own = np.array([problem.names[i] in thrust for i in free])
    return bool((np.abs(at.theta[free]) > OBEYED * errors)[own].any())


def _closer(at: Point, found: Point) -> Point:
    """A more likely solution than `at`, followed from `found`; `at` where there is none."""
    problem = at.passes.problem
    likelier = []
    for process in (at.noise, found.noise):
        noise = np.concatenate([at.noise[:2], process[2:]])
        there = Point(found.theta, noise, problem.passes(found.theta, noise))
        if np.isfinite(there.passes.cost):
            better, gain = likelier_noise(there.passes.each, problem.series, noise, problem.outlier)
            likelier.append((there.passes.cost - gain, better))
    cost, noise = min(likelier, key=lambda found: found[0], default=(np.inf, at.noise))
    if cost > at.passes.cost - WORTH:
        return at
    try:
        other = search(problem, found.theta, noise)
    except IdentificationError:
        return at
    return other if other.passes.cost < at.passes.cost - WORTH else at


def least_noise(problem: Problem, share: float) -> Array:
    """The noise (11,) below which the filter does not go."""
    least = NOISE_LEAST.copy()
    if share > 0.0:
        nu = np.concatenate([m.nu[m.valid] for m in map(motion, problem.recordings)])
        rms = np.sqrt(np.mean(nu**2, axis=0))
        way = share * np.array([np.hypot(rms[0], rms[1]), rms[2]])
        least[:2] = np.maximum(least[:2], way)
    return least


def plain_noise(at: Point, noise: Array) -> Array:
    """The likeliest noise (11,) with the parameters as they are: what a filter is to believe.

    `noise`: what the likelihood found before the model was believed less closely.
    """
    problem = at.passes.problem
    held = replace(problem, free=problem.sought)  # the filter is to know of them
    for _ in range(3):
        passes = held.passes(at.theta, noise)
        if not np.isfinite(passes.cost):  # a model that runs away is refused later, in words
            break
        noise, cost = fitted_noise(passes.each, held.series, noise, 1.0)
        if passes.cost - cost < 2.0:
            break
    return noise


def _ahead(problem: Problem, theta: Array, noise: Array) -> Ahead | None:
    """Errors of the model with these parameters, the noise being (11,); None where it runs away."""
    n, m = problem.size, problem.constants
    model = Model(
        problem.vehicle, theta[:n], np.zeros((n, n)), theta[n : n + m],
        Integration("runge-kutta", problem.step), noise_entry(noise), EnvelopeEntry({}, {}),
    )  # fmt: skip
    squares, floors, stays, moves, count = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), 0
    for i, recording in enumerate(problem.recordings):
        lever, current = np.split(theta[problem.effects(i)][:4], 2)
        try:
            found = predict(model, of_origin(recording, lever, current), DEFAULT_HORIZON)
        except RecordingError:  # too short for that
            continue
        except ModelError:
            return None
        squares += np.sum(found.errors**2, axis=0)
        floors += len(found.t) * found.floor**2
        stays += np.sum((found.measured - found.start) ** 2, axis=0)
        moves += np.sum(found.measured**2, axis=0)
        count += len(found.t)
    if count == 0:
        return None
    rms, floor, still, moving = (np.sqrt(x / count) for x in (squares, floors, stays, moves))
    return Ahead(rms + 1e-12, floor, still, moving)


def _comparable(problem: Problem) -> bool:
    """Whether predictions a second ahead know all effects: what pushes the boat is not among theirs."""
    pushes = ("trim", "wind")
    return not any(problem.names[i].startswith(pushes) for i in problem.sought)
