# SPDX-License-Identifier: MIT
"""Jobs on the package's farms of workers, with progress on standard error."""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeVar

from seatrial.util.parallel import Farm, InTurn

Job = tuple[Any, ...]
T = TypeVar("T")
Workers = int | str | None  # local processes, None: one a core; or a scheduler of Dask
POLITE = 10  # niceness of local processes


def spread(
    work: Callable[..., T], jobs: Sequence[Job], workers: Workers = None
) -> Iterator[tuple[Job, T]]:
    """Each job and `work(*job)`, in the order in which they end. Raises a job's error."""
    with _farm(1 if len(jobs) == 1 else workers) as (farm, niceness):
        for place, outcome in farm.outcomes(partial(_done, work), niceness, jobs):
            if isinstance(outcome, Exception):
                raise outcome
            yield jobs[place], outcome


@contextmanager
def _farm(workers: Workers) -> Iterator[tuple[Farm, int]]:
    """The workers, and the niceness of their processes."""
    if workers == 1:
        yield InTurn(), 0
        return
    from seatrial.fleet.dask_cluster import cluster  # noqa: PLC0415 Dask takes a second

    if isinstance(workers, str):
        with cluster(workers) as farm:
            yield farm, 0
        return
    with cluster(workers=workers) as farm:
        yield farm, POLITE


def _done(work: Callable[..., T], niceness: int, job: Job) -> T:
    """One job, in a process of this niceness at least."""
    os.nice(max(0, niceness - os.nice(0)))
    return work(*job)


def gathered(work: Callable[..., T], jobs: Sequence[Job], workers: Workers = None) -> list[T]:
    """`work(*job)` of all jobs, in the jobs' order. No job may be there twice."""
    found: dict[Job, T] = {}
    for job, result in spread(work, jobs, workers):
        found[job] = result
        print(f"\r{len(found)}/{len(jobs)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return [found[job] for job in jobs]
