# SPDX-License-Identifier: MIT
"""What a session is made of."""

from dataclasses import dataclass
from typing import Protocol

import msgspec

from seatrial.boat.model import Model
from seatrial.onboard.boat_change import Detector
from seatrial.poolside.coverage import Coverage
from seatrial.poolside.live_estimator import LiveEstimator
from seatrial.poolside.live_prediction import LivePrediction
from seatrial.poolside.recorder import Recorder
from seatrial.poolside.signal_health import SignalHealth
from seatrial.poolside.sources import EventSource
from seatrial.poolside.state import ManoeuvreState, ParameterState, PredictionState, UseState
from seatrial.util.frames import Array


class Advice(msgspec.Struct, frozen=True):
    """What is known well enough, and what to drive next."""

    parameters: tuple[ParameterState, ...] = ()
    uses: tuple[UseState, ...] = ()
    enough: bool = False
    next: ManoeuvreState | None = None
    others: tuple[ManoeuvreState, ...] = ()


@dataclass(frozen=True)
class Seen:
    """The drive as it is now."""

    time: float  # [s] since the first pose
    pose: tuple[float, float, float] | None  # x, y [m], psi [rad] in the vehicle's own axes
    nu: Array  # (3,) u, v [m/s], r [rad/s], forward-left-up; NaN: not known
    period: float  # [s] of the poses
    predictions: tuple[PredictionState, ...]
    trust: float = 1.0  # information that driving turned out to have, over what the noise promises
    whole: bool = True  # whether the drive is long enough for `identify`
    resting: bool = False  # whether nothing was driven since the last advice


class Guide(Protocol):
    """Gives advice."""

    def advise(self, model: Model | None, seen: Seen) -> Advice:
        """By the model so far; without a pose no manoeuvre."""


@dataclass(frozen=True)
class Parts:
    """All of a session."""

    source: EventSource
    estimator: LiveEstimator
    health: SignalHealth
    recorder: Recorder
    prediction: LivePrediction
    coverage: Coverage
    guide: Guide
    detector: Detector | None = None

    def leave_out(self, start: int, end: int) -> None:
        """The poses of an interval [ns]: from estimate, predictions and recording. Raises FileError."""
        self.estimator.discard(start, end)
        self.prediction.discard(start, end)
        self.recorder.discard(start, end)
