# SPDX-License-Identifier: MIT
"""Jobs over processes, with progress on standard error."""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any, TypeVar

Job = tuple[Any, ...]
T = TypeVar("T")
POLITE = 10  # niceness of the workers


def spread(
    work: Callable[..., T], jobs: Sequence[Job], processes: int | None = None
) -> Iterator[tuple[Job, T]]:
    """Each job and `work(*job)`, in the order in which they end; all cores by default."""
    count = processes or os.cpu_count() or 1
    if count == 1 or len(jobs) == 1:
        yield from ((job, work(*job)) for job in jobs)
        return
    spawn = get_context("spawn")
    with ProcessPoolExecutor(count, spawn, initializer=os.nice, initargs=(POLITE,)) as pool:
        job_of = {pool.submit(work, *job): job for job in jobs}
        for future in as_completed(job_of):
            yield job_of[future], future.result()


def gathered(work: Callable[..., T], jobs: Sequence[Job], processes: int | None = None) -> list[T]:
    """`work(*job)` of all jobs, in the jobs' order. No job may be there twice."""
    found: dict[Job, T] = {}
    for job, result in spread(work, jobs, processes):
        found[job] = result
        print(f"\r{len(found)}/{len(jobs)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return [found[job] for job in jobs]
