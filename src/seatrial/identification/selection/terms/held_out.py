# SPDX-License-Identifier: MIT
"""Prediction of recordings that were left out, with and without a term."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.evaluation.filtering import causal
from seatrial.evaluation.prediction import predict
from seatrial.identification.selection.terms.score_information import Slopes, solve
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array
from seatrial.util.parallel import cores
from seatrial.util.statistics import BLOCK

SPACING = 1 / 3  # [s] between starts of predictions: closer ones say little that is new


@dataclass(frozen=True)
class Change:
    """What a term does to the prediction of recordings that no model was fitted to."""

    percent: float  # how much worse the RMS error in its axis is without; negative: better without
    z: float  # the same in standard errors of the mean square, from blocks
    moves: float  # [%] RMS by which it moves the prediction, of RMS by which the velocity changes
    size: float  # RMS of the coefficient in the models that predicted: each fold's own


@dataclass(frozen=True)
class Predicted:
    """Predictions of all recordings, each by a model from the others."""

    squares: Array  # (blocks, 3) mean squared errors; infinite where the model runs away
    nu: Array  # (m, 3) velocities


@dataclass(frozen=True)
class HeldOut:
    """Every fold in turn is predicted by a model from the others: one Gauss-Newton step away."""

    model: Model
    slopes: Slopes  # of the model's parameters
    folds: Sequence[Sequence[int]]  # indices of each fold's recordings, fold after fold
    recordings: Sequence[Recording]
    horizon: float  # [s]

    def without(self, name: str, axis: int) -> Change:
        """Of a term that the model has."""
        gone = self._predicted(self.model, self.slopes, name)
        return self._change(self._plain, gone, axis, self._size(self.slopes, name))

    def with_it(self, model: Model, slopes: Slopes, name: str, axis: int) -> Change:
        """Of a term that the model has not: `model` and `slopes` are those with it."""
        there = self._predicted(model, slopes, None)
        return self._change(there, self._plain, axis, self._size(slopes, name))

    @cached_property
    def _aims(self) -> list["Aim"]:
        return [_aim(self.model, recording, self.horizon) for recording in self.recordings]

    @cached_property
    def _plain(self) -> Predicted:
        """By the model as it is."""
        return self._predicted(self.model, self.slopes, None)

    def _predicted(self, model: Model, slopes: Slopes, gone: str | None) -> Predicted:
        squares, nu = [], []
        for members in self.folds:
            trained = _at(model, slopes, retrained(slopes, self._rest(members), gone))
            for i in members:
                nu.append(self._aims[i].predict(trained, self.recordings[i]))
                squares.append(self._aims[i].squares(nu[-1]))
        return Predicted(np.concatenate(squares), np.concatenate(nu))

    def _size(self, slopes: Slopes, name: str) -> float:
        """RMS over all predictions of the coefficient that each fold's rest says."""
        k, squares, count = slopes.place(name), 0.0, 0
        for members in self.folds:
            there = sum(len(self._aims[i].start) for i in members)
            squares += there * float(retrained(slopes, self._rest(members), None)[k]) ** 2
            count += there
        return float(np.sqrt(squares / count))

    def _rest(self, members: Sequence[int]) -> list[int]:
        return [i for i in range(len(self.recordings)) if i not in members]

    def _change(self, with_it: Predicted, without: Predicted, axis: int, size: float) -> Change:
        a, b = with_it.squares[:, axis], without.squares[:, axis]
        if not (np.isfinite(a).all() and np.isfinite(b).all()):
            better = np.inf if np.isfinite(a).all() else -np.inf
            return Change(better, better, np.inf, size)
        begin = np.concatenate([aim.x0[:, 3:] for aim in self._aims])
        moved = _rms(with_it.nu[:, axis] - without.nu[:, axis])
        changed = _rms(with_it.nu[:, axis] - begin[:, axis])
        apart = b - a
        spread = float(np.std(apart, ddof=1) / np.sqrt(len(apart))) if len(apart) > 1 else 0.0
        return Change(
            float(100.0 * (np.sqrt(b.mean() / a.mean()) - 1.0)),
            float(apart.mean()) / spread if spread > 0 else 0.0,
            100.0 * moved / changed if changed > 0 else 0.0,
            size,
        )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


@dataclass(frozen=True)
class Aim:
    """What is predicted from where: the same for every model."""

    start: NDArray[np.int32]  # (m,) poses
    x0: Array  # (m, 6) states there
    end: NDArray[np.int32]  # (m,) the poses at the horizon
    measured: Array  # (m, 3) velocities there
    blocks: NDArray[np.int64]  # (blocks,) first prediction of each
    sizes: NDArray[np.int64]  # (blocks,)

    def predict(self, model: Model, recording: Recording) -> Array:
        """Velocities (m, 3) by a model."""
        states, _ = _core.predict(
            model.boat, model.trace(recording), recording.t, self.start, self.end, self.x0,
            threads=cores(),
        )  # fmt: skip
        return np.asarray(states[:, 3:])

    def squares(self, nu: Array) -> Array:
        """Mean squared errors (blocks, 3); infinite where the model ran away."""
        errors = np.where(np.isfinite(nu), self.measured - nu, np.inf)
        return np.asarray(np.add.reduceat(errors**2, self.blocks, axis=0) / self.sizes[:, None])


def _aim(model: Model, recording: Recording, horizon: float) -> Aim:
    """Starts by the model's filter: the stencil's noise would make quadratic drag look too strong."""
    begin = causal(model, recording).motion
    every = max(1, round(SPACING / recording.period))
    found = predict(model, recording, horizon, starts=begin, every=every)
    start = found.begun
    x0 = np.ascontiguousarray(np.column_stack([begin.eta[start], begin.nu[start]]))
    blocks = np.flatnonzero(np.diff((found.t // BLOCK).astype(np.int64), prepend=-1))
    sizes = np.diff(np.append(blocks, len(start)))
    end = found.index.astype(np.int32)
    return Aim(start.astype(np.int32), x0, end, found.measured, blocks, sizes)


def retrained(slopes: Slopes, rest: Sequence[int], gone: str | None) -> Array:
    """Parameters from some recordings, within their bounds: one step may go too far.

    With one held at 0, the others moved as they then must.
    """
    information = slopes.information[list(rest)].sum(axis=0)
    theta = slopes.values + solve(information, slopes.gradient[list(rest)].sum(axis=0))
    if gone is not None:
        j = slopes.place(gone)
        unit = np.zeros(len(theta))
        unit[j] = 1.0
        row = solve(information, unit)
        theta = theta - row * theta[j] / row[j]
    return np.asarray(np.clip(theta, *slopes.bounds))


def _at(model: Model, slopes: Slopes, theta: Array) -> Model:
    """The model with other values of its parameters."""
    found = dict(zip(slopes.names, theta.tolist(), strict=True))
    constants = dict(zip(model.vehicle.constants.names, model.constants.tolist(), strict=True))
    return replace(
        model,
        coefficients=np.array([found.get(n, v) for n, v in model.values.items()]),
        constants=np.array([found.get(n, v) for n, v in constants.items()]),
    )
