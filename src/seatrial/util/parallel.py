# SPDX-License-Identifier: MIT
"""Work on many items: threads for the core, which releases the interpreter lock, or a farm of processes.

The one place that knows where the work is done. Results are in the order of the items, whoever did them.
"""

import os
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from contextvars import ContextVar
from functools import cache, partial
from typing import Generic, TypeVar

from seatrial.util.progress import held, over, shared

MOST_THREADS = 256

C = TypeVar("C")
T = TypeVar("T")
R = TypeVar("R")


class Farm(ABC):
    """Processes that work on items, here or on other computers."""

    @abstractmethod
    def outcomes(
        self, work: Callable[[C, T], R], common: C, items: Sequence[T]
    ) -> Iterator[tuple[int, R | Exception]]:
        """The place of an item with `work(common, item)`, or with its error, in the order in which they end.

        `work` is a function of a module, `common` and items can be pickled; `common` travels once.
        """


class InTurn(Farm):
    """This process, one item after the other."""

    def outcomes(
        self, work: Callable[[C, T], R], common: C, items: Sequence[T]
    ) -> Iterator[tuple[int, R | Exception]]:
        """In the items' order."""
        for place, item in enumerate(items):
            try:
                yield place, work(common, item)
            except Exception as error:  # it is the outcome of the item
                yield place, error


_farm: ContextVar[Farm | None] = ContextVar("farm", default=None)
_most_cores: ContextVar[int | None] = ContextVar("most_cores", default=None)


def working_on(farm: Farm) -> AbstractContextManager[None]:
    """`farmed` inside gives its items to this farm."""
    return held(_farm, farm)


def on_one_core() -> AbstractContextManager[None]:
    """No threads inside: this process is one of many on its computer."""
    return held(_most_cores, 1)


def cores() -> int:
    """Number of cores that this process may use."""
    allowed = getattr(os, "sched_getaffinity", None)  # Linux only
    count = len(allowed(0)) if allowed else os.cpu_count() or 1
    return min(count, _most_cores.get() or count)


@cache
def _helpers() -> ThreadPoolExecutor:
    """Threads that stay, as many as were ever needed: to start one takes as long as a short item."""
    return ThreadPoolExecutor(MOST_THREADS, "spread")


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)  # a fork has no threads


def spread(work: Callable[[T], R], items: Iterable[T], name: str | None = None) -> list[R]:
    """Results of `work` on the items, in threads with more than one core. Raises the first item's error.

    `name`: of an item; with it each is a part of the progress at hand.
    """
    count, given = cores(), list(items)
    one = work if name is None else shared(work, len(given), name)
    if min(count, len(given)) <= 1:  # a thread for one item only costs time
        return [one(item) for item in given]
    return _Shared(one, given, count).results()


def beside(work: Callable[[], R]) -> Callable[[], R]:
    """Begin work on a core that is idle now and then. What is returned gives its result, or raises its error.

    With one core, or where no thread is free, the work is done when its result is wanted.
    """
    if cores() == 1:
        return work
    begun = _helpers().submit(_alone, work)
    return lambda: work() if begun.cancel() else begun.result()


def _alone(work: Callable[[], R]) -> R:
    with on_one_core():
        return work()


class _Shared(Generic[T, R]):
    """Items that this thread and its helpers take one after the other.

    This thread works, too. So it waits for no helper that has not begun, and calls may be nested.
    """

    def __init__(self, work: Callable[[T], R], items: Sequence[T], count: int) -> None:
        self._work, self._items = work, items
        self._threads = min(count, len(items))
        self._most = count // self._threads  # cores of an item
        self._left = deque(range(len(items)))  # taken in turn by all threads
        self._found: dict[int, R] = {}
        self._errors: dict[int, BaseException] = {}

    def results(self) -> list[R]:
        """The results in the items' order."""
        helping = [_helpers().submit(self._help) for _ in range(self._threads - 1)]
        try:
            self._help()
            for one in helping:
                if not one.cancel():
                    one.result()
        finally:  # interrupted: no further items
            self._left.clear()
        if self._errors:
            raise self._errors[min(self._errors)]
        return [self._found[place] for place in range(len(self._items))]

    def _help(self) -> None:
        with held(_most_cores, self._most):
            while (place := self._next()) is not None:
                try:
                    self._found[place] = self._work(self._items[place])
                except BaseException as error:  # raised by `results`; no further items
                    self._errors[place] = error
                    self._left.clear()

    def _next(self) -> int | None:
        try:
            return self._left.popleft()
        except IndexError:
            return None


def farmed(work: Callable[[C, T], R], common: C, items: Iterable[T], name: str = "") -> list[R]:
    """`work(common, item)` of all items: on the farm at hand, else as `spread`. Raises an item's error.

    For items of a second or so: an item of milliseconds costs more to send than to do.
    """
    farm, given = _farm.get(), list(items)
    if farm is None:
        return spread(partial(work, common), given, name or None)
    found: dict[int, R] = {}
    for place, outcome in over(farm.outcomes(work, common, given), name, len(given)):
        if isinstance(outcome, Exception):
            raise outcome
        found[place] = outcome
    return [found[place] for place in range(len(given))]
