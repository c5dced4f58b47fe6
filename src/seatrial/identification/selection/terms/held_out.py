# SPDX-License-Identifier: MIT
"""Cross-validation: folds of recordings with the same excitation, and the prediction of left-out ones.

Each with and without a term.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.filtering import run_filter
from seatrial.evaluation.starts_and_ends import starts_and_ends
from seatrial.identification.selection.score_information import ScoreInformation, solve_within
from seatrial.recording.excitation import effort, excitation, least_share
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import motion
from seatrial.util.frames import Array
from seatrial.util.parallel import cores, farmed
from seatrial.util.statistics import BLOCK

START_SPACING = 1 / 3  # [s] between starts of predictions: closer ones are nearly the same
PART_NAME = " part"
FOLD_NAMES = ("odd parts", "even parts")
PART_COUNTS = (2, 4, 8, 16, 32)  # of a recording
SHORTEST_PART = 2 * BLOCK  # [s]
BALANCED_SHARE = 0.2  # of every effort that either fold has


@dataclass(frozen=True)
class PredictionChange:
    """The effect of a term on the prediction of left-out recordings."""

    percent: float  # how much worse the RMS error in its axis is without; negative: better without
    z: float  # the same in standard errors of the mean square, from blocks
    moves: float  # [%] RMS by which it moves the prediction, of RMS by which the velocity changes
    size: float  # RMS of the coefficient in the models that predicted: each fold's own


@dataclass(frozen=True)
class Predicted:
    """Predictions of all recordings, each by a model from the others."""

    squares: Array  # (blocks, 3) mean squared errors; infinite where the model diverges
    nu: Array  # (m, 3) velocities


@dataclass(frozen=True)
class FoldPrediction:
    """Predictions of every fold, each by its own model; can be sent to other processes."""

    folds: Sequence[Sequence[int]]  # indices of each fold's recordings, fold after fold
    recordings: Sequence[Recording]
    targets: Sequence["Targets"]

    def by(self, models: Sequence[Model]) -> Predicted:
        """By one model for each fold."""
        squares, nu = [], []
        for members, model in zip(self.folds, models, strict=True):
            for i in members:
                nu.append(self.targets[i].predict(model, self.recordings[i]))
                squares.append(self.targets[i].squares(nu[-1]))
        return Predicted(np.concatenate(squares), np.concatenate(nu))


@dataclass(frozen=True)
class HeldOut:
    """Every fold is predicted by a model of the other folds, which one Gauss-Newton step finds."""

    model: Model
    information: ScoreInformation  # about the model's parameters
    folds: Sequence[Sequence[int]]  # indices of each fold's recordings, fold after fold
    recordings: Sequence[Recording]
    horizon: float  # [s]

    def without(self, axes: Mapping[str, int]) -> dict[str, PredictionChange]:
        """The effect of each of these terms of the model, with its axis."""
        trained = [self._trained(self.model, self.information, name) for name in axes]
        removed = farmed(FoldPrediction.by, self._prediction, trained)
        return {
            name: self._change(self._plain, found, axis, self._size(self.information, name))
            for (name, axis), found in zip(axes.items(), removed, strict=True)
        }

    def with_each(
        self, tried: Mapping[str, tuple[Model, ScoreInformation, int]]
    ) -> dict[str, PredictionChange]:
        """The effect of each term that the model lacks: a model and information that have it, and its axis."""
        trained = [self._trained(model, own, None) for model, own, _ in tried.values()]
        there = farmed(FoldPrediction.by, self._prediction, trained)
        return {
            name: self._change(found, self._plain, axis, self._size(own, name))
            for (name, (_, own, axis)), found in zip(tried.items(), there, strict=True)
        }

    @cached_property
    def _targets(self) -> list["Targets"]:
        return [targets_of(self.model, recording, self.horizon) for recording in self.recordings]

    @property
    def _prediction(self) -> FoldPrediction:
        return FoldPrediction(self.folds, self.recordings, self._targets)

    @cached_property
    def _plain(self) -> Predicted:
        """Predictions by the unchanged model."""
        return self._prediction.by(self._trained(self.model, self.information, None))

    def _trained(
        self, model: Model, information: ScoreInformation, removed: str | None
    ) -> list[Model]:
        """For each fold the model of the others."""
        rests = [retrained(information, self._rest(fold), removed) for fold in self.folds]
        return [at_parameters(model, information, theta) for theta in rests]

    def _size(self, information: ScoreInformation, name: str) -> float:
        """RMS over all predictions of the coefficient in the models that made them."""
        k, squares, count = information.place(name), 0.0, 0
        for members in self.folds:
            there = sum(len(self._targets[i].start) for i in members)
            squares += there * float(retrained(information, self._rest(members), None)[k]) ** 2
            count += there
        return float(np.sqrt(squares / count))

    def _rest(self, members: Sequence[int]) -> list[int]:
        return [i for i in range(len(self.recordings)) if i not in members]

    def _change(
        self, with_it: Predicted, without: Predicted, axis: int, size: float
    ) -> PredictionChange:
        a, b = with_it.squares[:, axis], without.squares[:, axis]
        stable = np.isfinite(a).all(), np.isfinite(b).all()
        if not any(stable):  # neither says anything
            return PredictionChange(0.0, 0.0, np.inf, size)
        if not all(stable):
            better = np.inf if stable[0] else -np.inf
            return PredictionChange(better, better, np.inf, size)
        begin = np.concatenate([aim.x0[:, 3:] for aim in self._targets])
        moved = _rms(with_it.nu[:, axis] - without.nu[:, axis])
        changed = _rms(with_it.nu[:, axis] - begin[:, axis])
        apart = b - a
        spread = float(np.std(apart, ddof=1) / np.sqrt(len(apart))) if len(apart) > 1 else 0.0
        return PredictionChange(
            float(100.0 * (np.sqrt(b.mean() / a.mean()) - 1.0)),
            float(apart.mean()) / spread if spread > 0 else 0.0,
            100.0 * moved / changed if changed > 0 else 0.0,
            size,
        )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


@dataclass(frozen=True)
class Targets:
    """Starts and ends of the predictions: the same for every model."""

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

    def only(self, chosen: NDArray[np.bool_]) -> "Targets":
        """Some of the predictions, as one block."""
        one = np.zeros(1, dtype=np.int64)
        return Targets(
            self.start[chosen], np.ascontiguousarray(self.x0[chosen]), self.end[chosen],
            self.measured[chosen], one, one + int(chosen.sum()),
        )  # fmt: skip

    def squares(self, nu: Array) -> Array:
        """Mean squared errors (blocks, 3); infinite where the model diverges."""
        errors = np.where(np.isfinite(nu), self.measured - nu, np.inf)
        return np.asarray(np.add.reduceat(errors**2, self.blocks, axis=0) / self.sizes[:, None])


def targets_of(model: Model, recording: Recording, horizon: float) -> Targets:
    """Starts from the model's filter: noise of the stencil would bias quadratic drag."""
    begin, seen = run_filter(model, recording).motion, motion(recording)
    every = max(1, round(START_SPACING / recording.period))
    start, end = starts_and_ends(recording, begin, seen, horizon, every)
    x0 = np.ascontiguousarray(np.column_stack([begin.eta[start], begin.nu[start]]))
    blocks = np.flatnonzero(np.diff((recording.t[end] // BLOCK).astype(np.int64), prepend=-1))
    sizes = np.diff(np.append(blocks, len(start)))
    return Targets(start.astype(np.int32), x0, end.astype(np.int32), seen.nu[end], blocks, sizes)


def retrained(information: ScoreInformation, rest: Sequence[int], removed: str | None) -> Array:
    """Parameters (p,) from some recordings, within their bounds.

    `removed`: a parameter that is held at 0, the others at their best then.
    """
    from_rest = information.of_recordings[list(rest)].sum(axis=0)
    gradient = information.gradient[list(rest)].sum(axis=0)
    held = None if removed is None else information.place(removed)
    return solve_within(information, from_rest, gradient, held)


def at_parameters(model: Model, information: ScoreInformation, theta: Array) -> Model:
    """The model with other values of its parameters."""
    found = dict(zip(information.names, theta.tolist(), strict=True))
    constants = dict(zip(model.vehicle.constants.names, model.constants.tolist(), strict=True))
    return replace(
        model,
        coefficients=np.array([found.get(n, v) for n, v in model.values.items()]),
        constants=np.array([found.get(n, v) for n, v in constants.items()]),
    )


@dataclass(frozen=True)
class Fold:
    """One repeat of the experiment."""

    name: str
    recordings: tuple[Recording, ...]


def folds(vehicle: Vehicle, recordings: Sequence[Recording]) -> tuple[Fold, ...]:
    """S1-S3 against S4-S6: the k-th recording of every kind is in the k-th fold.

    Recordings are of a kind if their commands are mostly in the same axis, or in none. Where a kind has no
    repeat, every recording is cut in parts: odd ones against even ones. There are the fewest, from two on, with
    which either fold has a share of every effort.
    """
    kinds: dict[int | None, list[Recording]] = {}
    for recording in recordings:
        kinds.setdefault(excitation(vehicle, recording).dominant, []).append(recording)
    count = min(len(same) for same in kinds.values())
    if count < 2:
        return _parts(vehicle, recordings)
    groups: list[list[Recording]] = [[] for _ in range(count)]
    for same in kinds.values():
        for i, recording in enumerate(same):
            groups[i % count].append(recording)
    return tuple(Fold(_name(group), tuple(group)) for group in groups)


def _parts(vehicle: Vehicle, recordings: Sequence[Recording]) -> tuple[Fold, ...]:
    tried: list[tuple[float, int]] = []
    for count in PART_COUNTS:
        if tried and min(r.duration for r in recordings) < count * SHORTEST_PART:
            break
        by_fold = [[effort(vehicle, p) for p in own] for own in _cut(recordings, count)]
        tried.append((least_share(np.sum(by_fold[0], axis=0), np.sum(by_fold[1], axis=0)), count))
        if tried[-1][0] >= BALANCED_SHARE:
            break
    count = max(tried, key=lambda one: one[0])[1]
    return tuple(
        Fold(name, tuple(own))
        for name, own in zip(FOLD_NAMES, _cut(recordings, count), strict=True)
    )


def _cut(recordings: Sequence[Recording], count: int) -> tuple[list[Recording], list[Recording]]:
    """Odd parts and even parts of every recording, each cut in so many."""
    found: tuple[list[Recording], list[Recording]] = [], []
    for recording in recordings:
        edges: list[float | None] = [recording.duration * k / count for k in range(count + 1)]
        edges[0] = edges[-1] = None
        for k in range(count):
            part = recording.cut(edges[k], edges[k + 1])
            found[k % 2].append(
                replace(part, name=f"{recording.name}{PART_NAME} {k + 1} of {count}")
            )
    return found


def whole_name(part: str) -> str:
    """The name of the recording that a part is of."""
    return re.sub(rf"{PART_NAME} \d+ of \d+$", "", part)


def _name(group: Sequence[Recording]) -> str:
    names = sorted(recording.name for recording in group)
    return names[0] if len(names) == 1 else ", ".join(names)
