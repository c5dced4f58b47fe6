# SPDX-License-Identifier: MIT
"""What each recording says of a model's parameters by itself: information, and where it pulls them.

The filter's errors along a recording have a likelihood whose slope and curvature at the model's own
values are known exactly. One step of Fisher's scoring from there is what this recording alone would
make of the parameters, as far as they are near.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial.causal import OUTLIER, believed_noise
from seatrial.errors import ModelError
from seatrial.frames import Array
from seatrial.identify.belief import least_noise
from seatrial.identify.problem import Passes, Problem
from seatrial.model import Model
from seatrial.recording import Recording

BLOCK = 10.0  # [s] over which errors may hang together
LOST = 1e-9  # share of the largest eigenvalue, of scaled information, below which nothing is said
SHARE = 1e-2  # in a direction that says nothing: a parameter with less is known all the same


@dataclass(frozen=True)
class Around:
    """A model's sought parameters and its noise: what information is counted around."""

    model: Model
    names: tuple[str, ...]  # (p,) of what was estimated
    theta: Array  # (p,) their values
    noise: Array  # (7,) what the filter believes

    def problem(self, recordings: Sequence[Recording]) -> Problem:
        """The likelihood of some recordings."""
        return _problem(self.model, recordings)

    def passes(self, recordings: Sequence[Recording]) -> Passes:
        """The filter along some recordings, at the model's values."""
        problem = self.problem(recordings)
        return problem.passes(_values(self.model, problem), self.noise)


@dataclass(frozen=True)
class Alone:
    """What one recording says by itself."""

    recording: str
    minutes: float
    information: Array  # (p, p) Fisher's
    gradient: Array  # (p,) of the log likelihood, at the model's values
    excess: float  # scatter of the scores over blocks, over what the information says of it

    @cached_property
    def step(self) -> Array:
        """Where it would move each parameter (p,); NaN where it says nothing of it."""
        inverse, known = pseudo_inverse(self.information)
        return np.where(known, inverse @ self.gradient, np.nan)

    @cached_property
    def errors(self) -> Array:
        """Standard errors (p,) from it alone; infinite where it says nothing."""
        inverse, known = pseudo_inverse(self.information)
        return np.where(known, np.sqrt(self.excess * np.diag(inverse)), np.inf)


def around(model: Model, recordings: Sequence[Recording], noise: Array | None = None) -> Around:
    """The model's estimated parameters, and the noise (7,) that it was believed with.

    A model without process noise gets `noise`, or that under which `recordings` are most likely.
    Raises ModelError where nothing was estimated, or where the model diverges.
    """
    values = np.concatenate([model.coefficients, model.constants])
    sought = np.flatnonzero(np.diag(model.covariance) > 0)
    if not len(sought):
        raise ModelError("nothing was estimated: the model's values were given")
    noise = believed_noise(model, recordings) if noise is None else noise
    share = float(model.estimator.settings.get("belief") or 0.0)
    if share > 0.0:
        noise = np.maximum(noise, least_noise(_problem(model, recordings), share))
    return Around(model, tuple(model.parameters[i] for i in sought), values[sought], noise)


def alone(point: Around, recordings: Sequence[Recording]) -> list[Alone]:
    """What each recording says by itself. Raises ModelError where the model diverges in one."""
    passes = point.passes(recordings)
    found = []
    for i, recording in enumerate(recordings):
        own = passes.each[i]
        if not own.good:
            raise ModelError(f"{recording.name}: the model diverges in its own filter")
        information = information_of(passes, i)
        scores = passes.scores(i)
        gradient = scores.sum(axis=0)
        found.append(
            Alone(
                recording.name, recording.duration / 60.0, information, gradient,
                _excess(information, scores, recording.t),
            )
        )  # fmt: skip
    return found


def information_of(passes: Passes, recording: int) -> Array:
    """Fisher's information (p, p) of one recording about the free parameters."""
    problem, own = passes.problem, np.asarray(passes.each[recording].information)
    to = problem.places(recording)
    use = to >= 0
    out = np.zeros((len(problem.free),) * 2)
    out[np.ix_(to[use], to[use])] = own[np.ix_(use, use)]
    return out


def pseudo_inverse(information: Array) -> tuple[Array, Array]:
    """Inverse (p, p) over the directions that are known, and which parameters (p,) these tell."""
    size = np.sqrt(np.diag(information))
    alive = size > 0
    out, known = np.zeros_like(information), np.zeros(len(size), dtype=bool)
    if not alive.any():
        return out, known
    scale = 1.0 / size[alive]
    spectrum, vectors = np.linalg.eigh(information[np.ix_(alive, alive)] * np.outer(scale, scale))
    told = spectrum > LOST * spectrum[-1]
    inverse = (vectors[:, told] / spectrum[told]) @ vectors[:, told].T
    out[np.ix_(alive, alive)] = inverse * np.outer(scale, scale)
    known[alive] = ~np.any(np.abs(vectors[:, ~told]) > SHARE, axis=1)
    return out, known


def _problem(model: Model, recordings: Sequence[Recording]) -> Problem:
    sought = tuple(int(i) for i in np.flatnonzero(np.diag(model.covariance) > 0))
    outlier = float(model.estimator.settings.get("outlier") or OUTLIER)
    return Problem(model.vehicle, tuple(recordings), sought, model.integration.step, outlier)


def _values(model: Model, problem: Problem) -> Array:
    """All parameters (names,) in the problem's order; effects of a recording are 0."""
    theta = np.zeros(len(problem.names))
    theta[: len(model.parameters)] = np.concatenate([model.coefficients, model.constants])
    return theta


def _excess(information: Array, scores: Array, t: Array) -> float:
    """How much more the scores scatter from block to block than information says; at least 1."""
    inverse, known = pseudo_inverse(information)
    blocks = np.floor(t / BLOCK).astype(np.int64)
    sums = np.zeros((int(blocks.max()) + 1, scores.shape[1]))
    np.add.at(sums, blocks, np.nan_to_num(scores))
    sums -= sums.mean(axis=0)
    rank = max(1, int(known.sum()))
    return max(1.0, float(np.trace(inverse @ (sums.T @ sums))) / rank)
