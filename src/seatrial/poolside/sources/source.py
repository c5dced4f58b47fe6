# SPDX-License-Identifier: MIT
"""The contract of a source of events at the poolside."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from threading import Event
from time import time_ns
from typing import Literal, get_args

from seatrial.util.frames import Array

EventKind = Literal["pose", "position", "heading", "command", "scale"]
EVENT_KINDS: tuple[EventKind, ...] = get_args(EventKind)
LARGEST = 1e9  # [m], [rad], command units: a larger value is no measurement


@dataclass(frozen=True)
class SourceEvent:
    """A pose, a part of one, a row of commands or of scales."""

    kind: EventKind
    stamp: int  # [ns]
    values: Array  # finite; forward-left-up, SI; of poses those of the measured point
    arrival: int  # [ns] by the clock of `EventSource.now`
    covariance: Array | None = None  # (3, 3) of a pose that states one


@dataclass
class Mistakes:
    """Inputs that could not be used: how many, and the newest."""

    what: str  # lines, rows, frames
    total: int = 0
    bad: int = 0
    newest: str = ""

    def add(self, text: str) -> None:
        """One more."""
        self.bad += 1
        self.newest = text

    def __str__(self) -> str:
        """As text; empty without a mistake."""
        if not self.bad:
            return ""
        return f"{self.bad} of {self.total} {self.what} could not be used; the last: {self.newest}"


class EventSource(ABC):
    """Events as they arrive. Iteration blocks; it ends when the source ends, or is closed.

    One thread iterates; `close` and `problems` may be called from any thread.
    """

    name: str  # as given
    # values are read by the vehicle file's columns, so that its edits mend them
    by_columns: bool = True
    recorded: bool = False  # a replay: arrivals are by the clock of the log

    @abstractmethod
    def __iter__(self) -> Iterator[SourceEvent]:
        """The events, in the order of their arrival."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._closed = Event()
        self._handled: int | None = None  # [ns] arrival of what is at work

    def close(self) -> None:
        """End the iteration, and free what is open."""
        self._closed.set()

    @property
    def problems(self) -> tuple[str, ...]:
        """What could not be used so far, as text."""
        return ()

    def now(self) -> int:
        """[ns] by the clock of the arrivals."""
        return time_ns()

    @property
    def behind(self) -> float:
        """Seconds since the row arrived that is used now: how far this computer falls behind."""
        handled = self._handled
        return 0.0 if handled is None else max(0.0, 1e-9 * (time_ns() - handled))

    def __enter__(self) -> "EventSource":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def usable(values: Array) -> bool:
    """Whether all values are finite and may be measurements."""
    return all(abs(value) < LARGEST for value in values.tolist())  # False for NaN
