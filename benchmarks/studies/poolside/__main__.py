# SPDX-License-Identifier: MIT
"""Minutes until a drive is enough, by driver. The tables of docs/poolside-study.md.

    python -m benchmarks.studies.poolside --seeds 5
    python -m benchmarks.studies.poolside --seeds 5 --write    # into the page

Every driver's drive feeds a live estimator; the same verdict ends all. The paper's S1 to S3 run to their end, and
the intervals that they reach are the goal of the second column.
"""

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields
from functools import partial
from typing import Any

import numpy as np

from benchmarks.harness import command, store
from benchmarks.harness.markdown import table
from benchmarks.harness.page import refill
from benchmarks.harness.workers import Job, spread
from benchmarks.studies.poolside.drives import DRIVERS, WATERS, Outcome, record

PAGE = command.DOCS / "poolside-study.md"
FIRST = 4001  # seed
HEAD = (
    "boat", "driver", "drives", "minutes to enough", "minutes to the intervals of S1 to S3",
    "95 % intervals that hold the truth", "time at a wall",
)  # fmt: skip


def row(water: str, name: str, drives: Sequence[Outcome]) -> list[str]:
    """A driver's drives of a boat."""
    held = [x for one in drives for x in one.inside]
    wall = np.mean([one.touched for one in drives])
    return [
        WATERS[water].name, name, str(len(drives)), spelled([one.enough for one in drives]),
        spelled([one.same for one in drives]), f"{100 * np.mean(held):.0f} %", f"{100 * wall:.1f} %",
    ]  # fmt: skip


def spelled(seconds: Sequence[float]) -> str:
    """Median, least and most, in minutes."""
    low, middle, high = (
        f"{x / 60:.1f}" if np.isfinite(x) else "never"
        for x in np.quantile(np.array(seconds), [0.0, 0.5, 1.0], method="nearest")
    )
    return f"{middle} ({low} to {high})"


def of_waters(name: str, text: str | None, seeds: int) -> argparse.ArgumentParser:
    """A command that drives each boat with a number of seeds."""
    parser = command.parser(name, text)
    command.with_seeds(parser, seeds, FIRST)
    parser.add_argument("--waters", nargs="*", default=list(WATERS), choices=list(WATERS))
    return parser


def by_water(
    given: argparse.Namespace, work: Callable[[str, int], Any]
) -> Iterator[tuple[str, list[Any]]]:
    """Each chosen boat with what the work makes of all seeds."""
    for water in given.waters:
        jobs = [(water, seed) for seed in range(FIRST, FIRST + given.seeds)]
        yield water, [one for _, one in spread(work, jobs, given.workers)]


def _done(given: argparse.Namespace, present: str) -> list[tuple[Job, store.Record]]:
    """The stored drives, with their water, seed and driver."""
    records = store.chosen(store.read(given.results), present, any_code=given.any_code)
    return [(tuple(one["job"]), one) for one in records]


def _outcome(one: store.Record) -> Outcome:
    return Outcome(**{field.name: one[field.name] for field in fields(Outcome)})


def main(arguments: Sequence[str]) -> None:
    """Run, print, and write into the page on request."""
    parser = of_waters("studies.poolside", __doc__, 5)
    parser.add_argument("--write", action="store_true", help="into the page")
    command.with_results(parser, "build/poolside.jsonl")
    given = parser.parse_args(arguments)
    seeds = range(FIRST, FIRST + given.seeds)
    present = store.code("studies/poolside")
    first, *others = DRIVERS
    for names in ([first], others):
        goals = {f"{w} {s}": r["widths"] for (w, s, n), r in _done(given, present) if n == first}
        jobs = [(w, s, n) for s in seeds for w in given.waters for n in names]
        jobs = [job for job in jobs if names == [first] or f"{job[0]} {job[1]}" in goals]
        if not given.any_code:
            store.run(given.results, jobs, partial(record, goals), present, given.workers)
    done = [(job, _outcome(one)) for job, one in _done(given, present)]
    made = [
        row(water, name, own)
        for water in given.waters for name in DRIVERS
        if (own := [one for (w, _, n), one in done if (w, n) == (water, name)])
    ]  # fmt: skip
    found = [one for (_, _, name), one in done if name == "guided"]
    shown = table(HEAD, made)
    cost = np.concatenate([one.advice for one in found])
    shown += f"\n\nCPU of an advice: median {np.median(cost):.2f} s, largest {cost.max():.2f} s."
    print(shown)
    if given.write:
        refill(PAGE, {"minutes": shown})


if __name__ == "__main__":
    main(sys.argv[1:])
