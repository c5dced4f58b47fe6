# SPDX-License-Identifier: MIT
"""Velocity predicted one second ahead while the boat drives, beside the filtered one that comes.

A prediction is a copy of the on-board filter that gets the commands of its second, but no poses.
"""

import threading
from collections import deque
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from typing import Literal

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import earth_fixed
from seatrial.onboard.odometer import Odometer
from seatrial.onboard.predictor import Estimate, Health
from seatrial.poolside.state import PredictionState
from seatrial.util.errors import ModelError
from seatrial.util.frames import AXES, Array

AHEAD = 1_000_000_000  # [ns] from a start to its prediction
EVERY = 250_000_000  # [ns] from one start to the next
SETTLING = 100_000_000  # [ns] in which commands may arrive late
LENGTH = 240  # predictions: a minute
UNKNOWN = Health.NO_POSE | Health.DIVERGED | Health.REINITIALISED | Health.BEYOND_REACH


@dataclass(frozen=True)
class _Begun:
    """A prediction whose second is not over."""

    stamp: int  # [ns] of its start
    velocity: Array  # (3,) there
    onboard: Odometer


@dataclass(frozen=True)
class _Seen:
    """A prediction beside the filtered velocity; all (3,) [m/s, m/s, rad/s]."""

    stamp: int  # [ns] of the predicted time
    predicted: Array
    measured: Array
    start: Array  # velocity a second before
    variance: Array  # of predicted less measured, by the model's covariance


class LivePrediction:
    """Predictions of the last minute, four a second; methods may be called from any thread.

    prediction = LivePrediction()
    prediction.reload(model)                    # whenever the estimate changed
    prediction.use("command", stamp, values)    # as `LiveEstimator.use`: tens of microseconds
    prediction.states()                         # () without a model
    """

    def __init__(self) -> None:
        self._onboard: Odometer | None = None
        self._begun: deque[_Begun] = deque()
        self._seen: deque[_Seen] = deque(maxlen=LENGTH)
        self._first: int | None = None
        self._next = 0  # [ns] of the next start
        self._lock = threading.Lock()

    def reload(self, model: Model) -> None:
        """Predict with another model from here on; one that can't be run on board changes nothing."""
        with self._lock:
            try:
                if self._onboard is not None and _frame(self._onboard.model) == _frame(model):
                    self._onboard.reload(model)
                else:
                    self._onboard = Odometer(model, disturbance=_frame(model))
            except ModelError:
                return

    def use(self, kind: str, stamp: int, values: Sequence[float] | Array) -> None:
        """A row, as of `DriveLog.add`."""
        poses = kind in ("pose", "position")
        with self._lock:
            if poses and self._first is None:
                self._first = stamp
            if self._onboard is None:
                return
            _give(self._onboard, kind, stamp, values)
            if kind in ("command", "scale"):
                for one in self._begun:
                    _give(one.onboard, kind, stamp, values)
            elif poses:
                self._predict(self._onboard, stamp)

    def discard(self, start: int, end: int) -> None:
        """Without the predictions that reach into an interval [ns]: the boat was touched, or towed."""
        with self._lock:
            left = [s for s in self._seen if not start <= s.stamp <= end + AHEAD]
            self._seen = deque(left, maxlen=LENGTH)
            self._begun = deque(b for b in self._begun if not start - AHEAD <= b.stamp <= end)

    def states(self) -> tuple[PredictionState, ...]:
        """One for each axis; none without a prediction."""
        with self._lock:
            seen, first = list(self._seen), self._first or 0
        if not seen:
            return ()
        t = tuple((1e-9 * np.array([s.stamp - first for s in seen])).tolist())
        predicted, measured, start, variance = (
            np.array([getattr(s, name) for s in seen])
            for name in ("predicted", "measured", "start", "variance")
        )
        rms, constant = (_rms(v - measured) for v in (predicted, start))
        expected = np.sqrt(variance.mean(axis=0))
        return tuple(
            PredictionState(
                axis, float(rms[i]), float(expected[i]), float(constant[i]), t,
                tuple(predicted[:, i].tolist()), tuple(measured[:, i].tolist()),
            )
            for i, axis in enumerate(AXES)
        )  # fmt: skip

    def _predict(self, onboard: Odometer, stamp: int) -> None:
        """Ends the predictions whose second is over, and begins one where it is due."""
        while self._begun and self._begun[0].stamp + AHEAD + SETTLING <= stamp:
            begun = self._begun.popleft()
            at = begun.stamp + AHEAD
            ahead, now = begun.onboard.look(at), onboard.look(at)
            if _known(ahead) and _known(now):
                self._seen.append(
                    _Seen(at, ahead.velocity, now.velocity, begun.velocity, _variance(ahead, now))
                )
        if not 0 < self._next - stamp <= EVERY:
            self._next = (stamp // EVERY + 1) * EVERY
            here = onboard.look(stamp)
            if _known(here):
                self._begun.append(_Begun(stamp, here.velocity, copy(onboard)))


def _frame(model: Model) -> Literal["earth", "body"]:
    """That of the disturbance force."""
    return "earth" if earth_fixed(model.noise) else "body"


def _give(onboard: Odometer, kind: str, stamp: int, values: Sequence[float] | Array) -> None:
    row = np.asarray(values, dtype=float).reshape(-1)
    if kind == "heading":
        onboard.heading(stamp, float(row[0]))
    else:
        getattr(onboard, kind)(stamp, row)


def _known(estimate: Estimate) -> bool:
    return not estimate.health & UNKNOWN and bool(np.isfinite(estimate.velocity).all())


def _variance(ahead: Estimate, now: Estimate) -> Array:
    """Of a prediction less the filtered velocity, which knows more poses: that of the one less the other's."""
    before, after = (np.diag(e.covariance)[3:] for e in (ahead, now))
    return np.asarray(np.maximum(before - after, 0.0))


def _rms(errors: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(errors**2, axis=0)))
