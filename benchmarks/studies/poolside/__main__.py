# SPDX-License-Identifier: MIT
"""Minutes until a drive is enough, by driver. The tables of docs/poolside-study.md.

    python -m benchmarks.studies.poolside --seeds 5
    python -m benchmarks.studies.poolside --seeds 5 --write    # into the page

Every driver's drive feeds a live estimator; the same verdict ends all. The paper's S1 to S3 run to their end, and
the intervals that they reach are the goal of the second column.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.harness import command
from benchmarks.harness.markdown import table
from benchmarks.harness.page import refill
from benchmarks.harness.workers import gathered
from benchmarks.studies.poolside.drives import DRIVERS, WATERS, Outcome, compared

PAGE = Path(__file__).resolve().parents[3] / "docs" / "poolside-study.md"
FIRST = 4001  # seed
HEAD = (
    "boat", "driver", "minutes to enough", "minutes to the intervals of S1 to S3",
    "95 % intervals that hold the truth", "time at a wall",
)  # fmt: skip


def rows(water: str, seeds: Sequence[dict[str, Outcome]]) -> list[list[str]]:
    """A row a driver."""
    out = []
    for name in DRIVERS:
        all_of = [one[name] for one in seeds]
        held = [x for one in all_of for x in one.inside]
        wall = np.mean([one.touched for one in all_of])
        out.append([
            WATERS[water].name, name, spelled([o.enough for o in all_of]),
            spelled([o.same for o in all_of]), f"{100 * np.mean(held):.0f} %", f"{100 * wall:.1f} %",
        ])  # fmt: skip
    return out


def spelled(seconds: Sequence[float]) -> str:
    """Median, least and most, in minutes."""
    low, middle, high = (
        f"{x / 60:.1f}" if np.isfinite(x) else "never"
        for x in np.quantile(np.array(seconds), [0.0, 0.5, 1.0], method="nearest")
    )
    return f"{middle} ({low} to {high})"


def main(arguments: Sequence[str]) -> None:
    """Run, print, and write into the page on request."""
    parser = command.parser("studies.poolside", __doc__)
    command.with_seeds(parser, 5, FIRST)
    parser.add_argument("--waters", nargs="*", default=list(WATERS), choices=list(WATERS))
    parser.add_argument("--write", action="store_true", help="into the page")
    given = parser.parse_args(arguments)
    jobs = [(w, FIRST + s) for w in given.waters for s in range(given.seeds)]
    found = gathered(compared, jobs, given.processes)
    made = [
        row
        for w in given.waters
        for row in rows(w, [r for j, r in zip(jobs, found, strict=True) if j[0] == w])
    ]
    shown = table(HEAD, made)
    cost = np.concatenate([one["guided"].advice for one in found])
    shown += f"\n\nCPU of an advice: median {np.median(cost):.2f} s, largest {cost.max():.2f} s."
    print(shown)
    if given.write:
        refill(PAGE, {"minutes": shown})


if __name__ == "__main__":
    main(sys.argv[1:])
