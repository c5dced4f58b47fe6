# SPDX-License-Identifier: MIT
"""What one pass of the filter tells about terms that are in the model, and about those that are not.

The likelihood's gradient and Fisher's information, at the model as it is: a Gauss-Newton step is a
refit, a part of the gradient that the others can't explain is a test for a term that is not there
(Rao's score test). Scores are summed over blocks, over which errors may be correlated.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import earth_fixed, noise_vector
from seatrial.boat.structure import Term
from seatrial.identification.estimator import OutputErrorSettings
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.terms.candidates import with_terms
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

TINY = 1e-12  # relative ridge: parameters that a recording says nothing of


@dataclass(frozen=True)
class Slopes:
    """Gradient and information of the free parameters, recording by recording."""

    names: tuple[str, ...]  # (p,) coefficients, then constants of the chain
    values: Array  # (p,) where the model is
    bounds: tuple[Array, Array]  # (p,) the lowest and highest that each may be
    information: Array  # (g, p, p)
    gradient: Array  # (g, p)
    scores: Array  # (blocks, p) of all recordings
    shares: Array  # (blocks, p, p) that each block has of the information
    recording: NDArray[np.int64]  # (blocks,) that each block is of

    @property
    def blocks(self) -> int:
        """Number of blocks."""
        return len(self.scores)

    @cached_property
    def total(self) -> Array:
        """Information of all recordings (p, p)."""
        return np.asarray(self.information.sum(axis=0))

    def left(self, step: Array) -> Array:
        """Scores (blocks, p) that are left after a step (p,) of the parameters.

        By each block's own share of the information. Without this a term that is plainly missing
        would count as scatter of the scores, and hide itself.
        """
        return np.asarray(self.scores - self.shares @ step)

    def place(self, name: str) -> int:
        """Column of a parameter."""
        return self.names.index(name)

    def only(self, names: Sequence[str]) -> "Slopes":
        """The same of some parameters; the others are as they are."""
        at = [self.place(name) for name in names]
        return replace(
            self,
            names=tuple(names),
            values=self.values[at],
            bounds=(self.bounds[0][at], self.bounds[1][at]),
            information=self.information[np.ix_(range(len(self.information)), at, at)],
            gradient=self.gradient[:, at],
            scores=self.scores[:, at],
            shares=self.shares[np.ix_(range(self.blocks), at, at)],
        )


def slopes(model: Model, recordings: Sequence[Recording], extra: Sequence[Term] = ()) -> Slopes:
    """Of the model's free parameters, and of coefficients of further terms, which are 0 in it."""
    whole = with_terms(model.vehicle, (*model.structure.terms, *extra))
    free_names = [name for name, error in model.standard_errors.items() if error > 0]
    free_names += [str(term.coefficient) for term in extra]
    settings = OutputErrorSettings()
    given = {**model.values, **dict(zip(whole.constants.names, model.constants, strict=True))}
    problem = Problem(
        whole, tuple(recordings), (), model.integration.step, settings.outlier, settings.block
    )
    free = tuple(i for i, name in enumerate(problem.names) if name in free_names)
    problem = replace(problem, free=free, earth_fixed=earth_fixed(model.noise))
    theta = np.array([given.get(name, 0.0) for name in problem.names])
    noise = noise_vector(model.noise)
    if noise is None:
        raise IdentificationError("selection needs a model with process noise: output-error's")
    passes = problem.passes(theta, noise, repeatable=False, shares=True)
    if not np.isfinite(passes.cost):
        raise IdentificationError("the boat diverges; look at the recordings with inspect")
    owner = [np.full(int(b[-1]) + 1, i) for i, b in enumerate(problem.blocks)]
    return Slopes(
        tuple(problem.names[i] for i in free),
        theta[list(free)],
        problem.bounds,
        np.array([p.information for p in passes.each]),
        np.array([p.gradient for p in passes.each]),
        passes.scores,
        np.concatenate([p.share.reshape(-1, len(free), len(free)) for p in passes.each]),
        np.concatenate(owner),
    )


def solve(matrix: Array, right: Array) -> Array:
    """matrix^-1 right of a symmetric matrix, scaled to a unit diagonal, never singular."""
    scale = np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
    scaled = matrix / np.outer(scale, scale) + TINY * np.eye(len(matrix))
    inner = right / scale if right.ndim == 1 else right / scale[:, None]
    found = np.linalg.solve(scaled, inner)
    return np.asarray(found / scale if right.ndim == 1 else found / scale[:, None])
