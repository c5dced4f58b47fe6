# SPDX-License-Identifier: MIT
"""What a session is made of, as it uses it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import msgspec

from seatrial.boat.model import Model
from seatrial.onboard.boat_change import Detector
from seatrial.poolside.state import (
    CoverageState,
    ManoeuvreState,
    ParameterState,
    PredictionState,
    SignalState,
    UseState,
)
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array


class Event(Protocol):
    """An input: `seatrial.poolside.sources.SourceEvent`."""

    @property
    def kind(self) -> str:
        """pose, position, heading, command, scale."""

    @property
    def stamp(self) -> int:
        """[ns]."""

    @property
    def values(self) -> Array:
        """Forward-left-up; poses of the measured point."""

    @property
    def arrival(self) -> int:
        """[ns]."""


class Source(Protocol):
    """Events as they arrive: `seatrial.poolside.sources.EventSource`."""

    name: str

    def __iter__(self) -> Iterator[Event]:
        """Blocks; ends when the source ends, or is closed."""

    def close(self) -> None:
        """End the iteration."""

    @property
    def problems(self) -> tuple[str, ...]:
        """What could not be used so far."""

    def now(self) -> int:
        """[ns] by the clock of the arrivals."""


class Log(Protocol):
    """The drive so far."""

    def recording(self) -> Recording:
        """As a recording. Raises RecordingError."""


class Estimator(Protocol):
    """The model so far: `seatrial.poolside.live_estimator.LiveEstimator`."""

    @property
    def log(self) -> Log:
        """The drive so far."""

    def use(self, kind: str, stamp: int, values: Array) -> bool:
        """An event."""

    def discard(self, start: int, end: int) -> None:
        """Leave out the poses of an interval [ns]."""

    def work(self) -> bool:
        """Do what is due; whether the estimate changed."""

    def model(self) -> Model | None:
        """The estimate."""

    @property
    def problem(self) -> str:
        """What hinders it."""

    @property
    def lag(self) -> float:
        """[s] that it is behind."""


class Health(Protocol):
    """Health of the signals."""

    def use(self, kind: str, stamp: int, values: Array, arrival: int) -> None:
        """An event."""

    def check(self, recording: Recording) -> None:
        """Signs, units and order; tenths of a second."""

    def states(self, now: int) -> tuple[SignalState, ...]:
        """At a time [ns] of the source's clock."""


class Keeper(Protocol):
    """The recording on the disk."""

    def use(self, kind: str, stamp: int, values: Array) -> None:
        """An event. Raises FileError."""

    def mark(self, stamp: int, text: str) -> None:
        """Mark a moment [ns]."""

    def discard(self, start: int, end: int) -> None:
        """Leave out the poses of an interval [ns]."""

    def finish(self) -> Path:
        """End; the folder, which has the vehicle file that reads it."""

    def close(self) -> None:
        """End; what was written stays."""


class Forecast(Protocol):
    """Velocity, and its prediction one second ahead, by the model so far."""

    def use(self, kind: str, stamp: int, values: Array) -> None:
        """An event."""

    def reload(self, model: Model) -> None:
        """A new estimate."""

    def predictions(self) -> tuple[PredictionState, ...]:
        """Of every axis."""

    def coverage(self) -> tuple[CoverageState, ...]:
        """Of every driven axis."""


class Advice(msgspec.Struct, frozen=True):
    """What is known well enough, and what to drive next."""

    parameters: tuple[ParameterState, ...] = ()
    uses: tuple[UseState, ...] = ()
    enough: bool = False
    next: ManoeuvreState | None = None
    others: tuple[ManoeuvreState, ...] = ()


class Guide(Protocol):
    """Gives advice."""

    def advise(self, model: Model | None, pose: Sequence[float] | None) -> Advice:
        """By the model so far, from a pose (3,) x, y [m], psi [rad] in the vehicle's own axes."""


@dataclass(frozen=True)
class Parts:
    """All of a session."""

    source: Source
    estimator: Estimator
    health: Health
    keeper: Keeper
    forecast: Forecast
    guide: Guide
    detector: Detector | None = None
