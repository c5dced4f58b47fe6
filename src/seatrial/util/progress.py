# SPDX-License-Identifier: MIT
"""Progress of long work: its stage, the share done, the time left.

Work reports with `stage`, `over`, `reach` and `step`, from any depth of calls. `show_progress` around it draws one
line, or calls a function. Without that nothing happens. A thread reports to its own listener only.
"""

import os
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from itertools import islice
from math import exp
from typing import NamedTuple, TextIO, TypeVar

from seatrial.util.errors import printable

T = TypeVar("T")
R = TypeVar("R")

LINE_AFTER = 0.5  # [s] work that is shorter shows no line
LINE_EVERY = 0.25  # [s] between two drawings of the line
TIME_LEFT_AFTER = 1.0  # [s] before, the time left is not estimated
TIME_LEFT_FROM = 0.02  # share done from which on the time left is estimated
USUAL_COLUMNS = 80  # of a terminal that does not say
STEPS_KNEE = 0.8  # share of the expected steps from which on further ones count less


class Status(NamedTuple):
    """How far the work is."""

    stage: str  # names of the stages, the outer one first
    share: float  # of all the work, 0 to 1; never falls
    left: float | None  # [s] estimated; None: too early for an estimate


Report = Callable[[Status], None]


class _Work:
    """All the work: who listens, since when, how far it is."""

    def __init__(self, report: Report, line: "Line | None" = None) -> None:
        self.report, self.line = report, line
        self.begun = time.monotonic()
        self.share = 0.0
        self.lock = threading.Lock()

    def add(self, share: float, name: str) -> None:
        with self.lock:
            self.share = min(self.share + share, 1.0)
            self.report(Status(name, self.share, time_left(self.begun, self.share)))


class _Part:
    """A part of the work; its stages and steps divide it further. Parts may go on at the same time."""

    def __init__(self, work: _Work, name: str, width: float, claim: float = 1.0) -> None:
        self.work, self.name, self.width = work, name, width  # share of all the work
        self.claim = claim  # share of the part that this one divides
        self.detail = ""  # of the step at hand
        self.done, self.steps = 0.0, 0.0
        self.begin, self.end = 0.0, 1.0  # done before and after the step at hand

    def part(self, name: str, share: float | None) -> "_Part":
        left = self.end - self.done
        claim = left if share is None else min(share * (self.end - self.begin), left)
        return _Part(self.work, self._named(name), self.width * claim, claim)

    @property
    def left(self) -> float:
        """Share of the step at hand that is not done."""
        return (self.end - self.done) / max(self.end - self.begin, 1e-12)  # after very many steps

    def finish(self, part: "_Part") -> None:
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
    line = None if part is None else part.work.line
    with nullcontext() if line is None else line.hidden():
        yield


@contextmanager
def show_progress(report: Report | None = None, *, quiet: bool = False) -> Iterator[None]:
    """Show the progress of the work inside: one line on standard error, if that is a terminal and not `quiet`.

    `report`: a function that gets each `Status` instead, in the thread that works.
    """
    if report is not None:
        with _listening(_Work(report)):
            yield
    elif sys.stderr is not None and sys.stderr.isatty() and not quiet:
        with Line(sys.stderr) as line, _listening(_Work(line.update, line)):
            yield
    else:
        yield


@contextmanager
def _listening(work: _Work) -> Iterator[None]:
    before = _current.get()
    _current.set(_Part(work, "", 1.0))
    try:
        yield
    finally:
        _current.set(before)


@contextmanager
def _inside(whole: _Part, part: _Part) -> Iterator[None]:
    """Work on a part, which then is a done part of the whole."""
    before = _current.get()
    _current.set(part)
    part.tell()
    try:
        yield
    finally:
        _current.set(before)
        whole.finish(part)


class Line:
    """One line of a terminal, drawn again and again, also between two reports."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream
        self.begun = time.monotonic()
        self.status: Status | None = None
        self.width = 0  # columns in use
        self.lock = threading.RLock()
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self._redraw, name="progress", daemon=True)

    def __enter__(self) -> "Line":
        return self

    def __exit__(self, *_: object) -> None:
        self.ended.set()
        if self.thread.is_alive():
            self.thread.join()
        self.clear()

    def update(self, status: Status) -> None:
        """Show this at the next drawing."""
        self.status = status
        if not self.thread.ident and not self.ended.is_set():
            self.thread.start()

    @contextmanager
    def hidden(self) -> Iterator[None]:
        """Remove the line, and do not draw it meanwhile."""
        with self.lock:
            self.clear()
            yield

    def clear(self) -> None:
        """Remove the line."""
        with self.lock:
            if self.width:
                self.stream.write("\r" + " " * self.width + "\r")
                self.stream.flush()
                self.width = 0

    def draw(self) -> None:
        """Write the line over the one before."""
        if self.status is None or time.monotonic() - self.begun < LINE_AFTER:
            return
        text = line_text(self.status, time_left(self.begun, self.status.share))
        text = printable(text, "")[: self._columns()]
        with self.lock:
            self.stream.write("\r" + text.ljust(self.width))
            self.stream.flush()
            self.width = len(text)

    def _columns(self) -> int:
        """All but the last: some terminals wrap there."""
        try:
            columns = os.get_terminal_size(self.stream.fileno()).columns
        except OSError:  # no terminal: io.UnsupportedOperation is one, too
            columns = 0
        return (columns or USUAL_COLUMNS) - 1

    def _redraw(self) -> None:
        while not self.ended.wait(LINE_EVERY):
            self.draw()


def time_left(begun: float, share: float) -> float | None:
    """[s] Estimated from the share done since `begun` [s] on the monotonic clock; None: too early."""
    elapsed = time.monotonic() - begun
    if elapsed < TIME_LEFT_AFTER or share < TIME_LEFT_FROM:
        return None
    return elapsed * (1.0 - share) / share


def line_text(status: Status, left: float | None) -> str:
    """The line: stage, percentage, time left [s]."""
    percent = f"{status.stage}  {100 * status.share:.0f} %".lstrip()
    return percent if left is None else f"{percent}, {duration_text(left)} left"


def duration_text(seconds: float) -> str:
    """For people: 12 s, 2 min 5 s, 1 h 3 min."""
    s = round(seconds)
    if s < 60:
        return f"{s} s"
    minutes, s = divmod(s, 60)
    if minutes < 60:
        return f"{minutes} min {s} s"
    return f"{minutes // 60} h {minutes % 60} min"
