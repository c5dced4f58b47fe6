# SPDX-License-Identifier: MIT
"""Progress of long work: its stage, the share done, the time left.

Work reports with `stage`, `over`, `reach` and `step`, from any depth of calls. `show_progress` around it draws one
line (console/progress_line.py), or calls a function. Without that nothing happens.
A thread reports to its own listener only.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from itertools import islice
from math import exp
from typing import TYPE_CHECKING, TypeVar

from seatrial.util.status import Status, time_left

if TYPE_CHECKING:
    from seatrial.util.console.progress_line import ProgressLine

T = TypeVar("T")
R = TypeVar("R")

STEPS_KNEE = 0.8  # share of the expected steps from which on further ones count less


Report = Callable[[Status], None]


class _Work:
    """All the work: who listens, since when, how far it is."""

    def __init__(self, report: Report, line: ProgressLine | None = None) -> None:
        self.report, self.line = report, line
        self.begun: float | None = None  # when the first stage began, after what it imports
        self.share = 0.0
        self.lock = threading.Lock()
        self.covers = 0  # how often it is hidden at the moment

    def add(self, share: float, name: str) -> None:
        with self.lock:
            if self.begun is None:
                self.begun = time.monotonic()
            self.share = min(self.share + share, 1.0)
            self.report(Status(name, self.share, time_left(self.begun, self.share)))

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Without the line; this time, in which the user may answer, is none of the work's."""
        since, self.covers = time.monotonic(), self.covers + 1
        try:
            with nullcontext() if self.line is None else self.line.hidden():
                yield
        finally:
            self.covers -= 1
            if self.covers == 0 and self.begun is not None:
                self.begun += time.monotonic() - since


class _Part:
    """A part of the work; its stages and steps divide it further. Parts may go on at the same time."""

    def __init__(self, work: _Work, name: str, width: float, claim: float = 1.0) -> None:
        self.work, self.name, self.width = work, name, width  # share of all the work
        self.claim = claim  # share of the part that this one divides
        self.detail = ""  # of the step at hand
        self.done, self.steps = 0.0, 0.0
        self.begin, self.end = 0.0, 1.0  # done before and after the step at hand

    def part(self, name: str, share: float | None) -> _Part:
        left = self.end - self.done
        claim = left if share is None else min(share * (self.end - self.begin), left)
        return _Part(self.work, self._named(name), self.width * claim, claim)

    @property
    def left(self) -> float:
        """Share of the step at hand that is not done."""
        return (self.end - self.done) / max(self.end - self.begin, 1e-12)  # after very many steps

    def finish(self, part: _Part) -> None:
        with self.work.lock:
            self.done = min(self.done + part.claim, 1.0)
        self.work.add((1.0 - part.done) * part.width, self._named(""))

    def reach(self, done: float) -> None:
        more = max(min(done, 1.0) - self.done, 0.0)
        self.done += more
        self.work.add(more * self.width, self._named(""))

    def tell(self) -> None:
        self.work.add(0.0, self._named(""))

    def _named(self, name: str) -> str:
        return ": ".join(word for word in (self.name, self.detail, name) if word)


_current: ContextVar[_Part | None] = ContextVar("progress", default=None)


@contextmanager
def held(variable: ContextVar[T], value: T) -> Iterator[None]:
    """A variable of the context has this value inside."""
    token = variable.set(value)
    try:
        yield
    finally:
        variable.reset(token)


@contextmanager
def stage(name: str, share: float | None = None) -> Iterator[None]:
    """A part of the work at hand: `share` of it, at most what is left; None: all that is left."""
    whole = _current.get()
    if whole is None:
        yield
        return
    with _inside(whole, whole.part(name, share)):
        yield


def over(items: Iterable[T], name: str = "", total: int | None = None) -> Iterator[T]:
    """The items; each is an equal part of the work at hand. `total`: their number, where they have no length."""
    whole = _current.get()
    if whole is None:
        yield from items
        return
    count = len(items) if isinstance(items, Collection) else total
    if count is None:
        raise ValueError("progress over items without a length needs their total")
    share, rest = whole.left / max(count, 1), iter(items)
    for i in range(count):
        part = whole.part(f"{name} {i + 1}/{count}" if name else "", share)
        _current.set(part)
        part.tell()
        try:
            yield from islice(rest, 1)  # making the item is part of the work
        finally:  # a loop that was left may end here much later, when other work is at hand
            if _current.get() is part:
                _current.set(whole)
        whole.finish(part)
    yield from rest


def shared(work: Callable[[T], R], count: int, name: str) -> Callable[[T], R]:
    """`work` on one of `count` items, in any thread; each is an equal part of the work at hand."""
    whole = _current.get()
    if whole is None:
        return work
    share = whole.left / max(count, 1)

    def one(item: T) -> R:
        with _inside(whole, whole.part(name, share)):
            return work(item)

    return one


def reach(done: float) -> None:
    """This share of the stage is done."""
    part = _current.get()
    if part is not None:
        part.reach(done)


def step(expected: float, name: str = "") -> None:
    """One more of about `expected` steps is done. Where there are more, each counts less and less.

    `name`: of the next one. Stages that begin before the next call divide that step.
    """
    part = _current.get()
    if part is not None:
        part.detail = name
        part.steps += 1.0 / expected
        part.end = slowing(part.steps + 1.0 / expected)
        part.reach(slowing(part.steps))
        part.begin = part.done


def slowing(steps: float) -> float:
    """Share done (below 1) after this share of the expected steps, which may pass 1."""
    rest = 1.0 - STEPS_KNEE
    return min(steps, STEPS_KNEE) + rest * (1.0 - exp(-max(steps - STEPS_KNEE, 0.0) / rest))


@contextmanager
def hidden() -> Iterator[None]:
    """Without the line on the terminal, for what is printed meanwhile."""
    part = _current.get()
    with nullcontext() if part is None else part.work.hidden():
        yield


@contextmanager
def show_progress(report: Report | None = None, *, quiet: bool = False) -> Iterator[None]:
    """Show the progress of the work inside: one line on standard error, if that is a terminal and not `quiet`.

    `report`: a function that gets each `Status` instead, in the thread that works: `stage`, `share` (0 to 1) and
    `left`, the time left [s] or None. An exception that it raises ends the work.

        def report(status):
            print(f"{status.stage}: {100 * status.share:.0f} %")

        with seatrial.show_progress(report):
            model = seatrial.identify(recordings, vehicle)
    """
    if report is not None:
        with _listening(_Work(report)):
            yield
    elif sys.stderr is not None and sys.stderr.isatty() and not quiet:
        from seatrial.util.console.progress_line import ProgressLine

        with ProgressLine(sys.stderr) as line, _listening(_Work(line.update, line)):
            yield
    else:
        yield


def _listening(work: _Work) -> AbstractContextManager[None]:
    return held(_current, _Part(work, "", 1.0))


@contextmanager
def _inside(whole: _Part, part: _Part) -> Iterator[None]:
    """Work on a part, which then is a done part of the whole."""
    try:
        with held(_current, part):
            part.tell()
            yield
    finally:
        whole.finish(part)
