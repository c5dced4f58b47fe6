# SPDX-License-Identifier: MIT
"""Threads for the core, which releases the interpreter lock."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from seatrial.util.progress import shared

T = TypeVar("T")
R = TypeVar("R")


def cores() -> int:
    """Number of cores that this process may use."""
    allowed = getattr(os, "sched_getaffinity", None)  # Linux only
    return len(allowed(0)) if allowed else os.cpu_count() or 1


def spread(work: Callable[[T], R], items: Iterable[T], name: str | None = None) -> list[R]:
    """Results of `work` on the items, in threads with more than one core.

    `name`: of an item; with it each is a part of the progress at hand.
    """
    count, given = cores(), list(items)
    one = work if name is None else shared(work, len(given), name)
    if count == 1:
        return [one(item) for item in given]
    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(one, given))
