# SPDX-License-Identifier: MIT
"""Threads for the core, which lets the interpreter go."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")


def cores() -> int:
    """How many this process may use."""
    allowed = getattr(os, "sched_getaffinity", None)  # Linux only
    return len(allowed(0)) if allowed else os.cpu_count() or 1


def spread(work: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """Work on items, in threads where there is more than one core for them."""
    count = cores()
    if count == 1:
        return [work(item) for item in items]
    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(work, items))
