# SPDX-License-Identifier: MIT
"""Cross-validation over blocks of time: prediction of left-out blocks, with and without a term.

Up to `FOLD_BLOCKS` blocks in a row are in one fold. The parameters without a fold are a Gauss-Newton
step away, by the information in its blocks.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.model import Model
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.score_information import ScoreInformation, solve_within
from seatrial.identification.selection.terms.held_out import Targets, at_parameters, targets_of
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array
from seatrial.util.parallel import spread

BLOCK_FOLDS = 4
FOLD_BLOCKS = 6  # in a row
LEAST_GAIN = 0.002  # of the log RMS errors, summed over the axes
LEAST_GAIN_Z = 2.0  # standard errors of the gain


@dataclass(frozen=True)
class Gain:
    """The fall of prediction errors by a term."""

    log: float  # of the log RMS errors of blocks, summed over the axes: no block dominates
    z: float  # in standard errors

    @property
    def clear(self) -> bool:
        """Whether prediction improves beyond chance."""
        return self.log > LEAST_GAIN and self.z > LEAST_GAIN_Z


@dataclass(frozen=True)
class BlockPrediction:
    """Starts and ends of predictions along all recordings, by fold."""

    recordings: Sequence[Recording]
    blocks: Sequence[NDArray[np.int32]]  # of every recording, the number of each pose's block
    targets: Sequence[Targets]

    @staticmethod
    def of(model: Model, problem: Problem, horizon: float) -> "BlockPrediction":
        """Predictions `horizon` [s] ahead, from the model's filter."""
        recordings = problem.recordings
        targets = spread(lambda r: targets_of(model, r, horizon), recordings)
        return BlockPrediction(recordings, problem.blocks, targets)

    def squares(self, models: Sequence[Model]) -> Array:
        """Mean squared errors (blocks, 3) of all recordings, each fold by its own model (`trained`)."""
        counts = [int(numbers[-1]) + 1 for numbers in self.blocks]
        folds = np.split(_folds(sum(counts)), np.cumsum(counts)[:-1])
        found = []
        for i, (recording, aim) in enumerate(zip(self.recordings, self.targets, strict=True)):
            own = folds[i][self.blocks[i][aim.start]]
            nu = np.empty((len(own), 3))
            for k in np.unique(own).tolist():
                nu[own == k] = aim.only(own == k).predict(models[k], recording)
            found.append(aim.squares(nu))
        return np.concatenate(found)

    def gain(self, before: Array, after: Array) -> Gain:
        """The gain from squared errors (blocks, 3) to others."""
        if not np.isfinite([before, after]).all():  # one that diverges is no measure of the other
            return Gain(-np.inf, 0.0)
        falls = 0.5 * np.log((before + 1e-24) / (after + 1e-24)).sum(axis=1)
        error = float(falls.std(ddof=1) / np.sqrt(len(falls))) if len(falls) > 1 else np.inf
        return Gain(float(falls.mean()), float(falls.mean()) / error if error > 0.0 else 0.0)


def trained(model: Model, information: ScoreInformation) -> list[Model]:
    """For each fold the model with the parameters of the others."""
    fold = _folds(information.blocks)
    left_out = [_without(information, fold == k) for k in range(BLOCK_FOLDS)]
    return [at_parameters(model, information, theta) for theta in left_out]


def _folds(blocks: int) -> NDArray[np.int64]:
    """The fold of every block of all recordings."""
    together = max(1, min(FOLD_BLOCKS, blocks // (2 * BLOCK_FOLDS)))
    return np.asarray(np.arange(blocks) // together % BLOCK_FOLDS)


def _without(information: ScoreInformation, left_out: NDArray[np.bool_]) -> Array:
    """Parameters (p,) from all blocks but some, within their bounds."""
    rest = information.information - information.shares[left_out].sum(axis=0)
    gradient = information.scores[~left_out].sum(axis=0)
    return solve_within(information, rest, gradient)
