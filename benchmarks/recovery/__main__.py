# SPDX-License-Identifier: MIT
"""Command line: run, tables, figure."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy; the worker processes inherit it

from benchmarks.recovery import store, tables
from benchmarks.recovery.figure import draw
from benchmarks.recovery.scenes import scenes

FIRST = 1001  # seed; those of the tests are others
DEFAULT = Path("build/recovery.jsonl")


def shown(path: Path, *, any_code: bool) -> str:
    """All tables."""
    records = store.chosen(store.read(path), any_code=any_code)
    names = {g: [s.name for s in scenes().values() if s.group == g] for g in
             ("still", "pushed", "together", "faults", "noise")}  # fmt: skip
    parts = ["## Overview", tables.overview(records, names["still"] + names["pushed"])]
    parts += ["## Thrusters", tables.thrusters(records, names["still"] + names["together"])]
    parts += ["## S7, 1 s ahead", tables.prediction(records)]
    parts += ["### With the unmodelled force", tables.prediction(records, " pushed")]
    parts += ["## Faults", tables.fault_moves(records, names["faults"])]
    parts += ["## Noise found", tables.believed(records, [n for g in names.values() for n in g])]
    parts += ["## Parameter by parameter"]
    drawn = [n for n in names["still"] + names["pushed"] if tables.good(records, n)]
    parts += [tables.recovery(records, n) for n in drawn]
    parts += ["## Failures", tables.failures(records) or "none\n"]
    return "\n".join(parts)


def main(arguments: Sequence[str]) -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.recovery", description=__doc__)
    parser.add_argument("verb", choices=("run", "tables", "figure"))
    parser.add_argument("--results", type=Path, default=DEFAULT)
    parser.add_argument("--seeds", type=int, default=8, help=f"how many, from {FIRST} on")
    parser.add_argument("--groups", help="still,pushed,together,faults,noise; default all")
    parser.add_argument("--scenes", help="names, with commas")
    parser.add_argument("--out", type=Path, default=Path("docs/images/noise.svg"))
    parser.add_argument("--any-code", action="store_true", help="results of other code, too")
    given = parser.parse_args(arguments)
    if given.verb == "run":
        groups = given.groups.split(",") if given.groups else None
        names = given.scenes.split(",") if given.scenes else None
        chosen = [
            s.name for s in scenes().values()
            if (groups is None or s.group in groups) and (names is None or s.name in names)
        ]  # fmt: skip
        store.run(given.results, chosen, range(FIRST, FIRST + given.seeds), print)
    elif given.verb == "tables":
        print(shown(given.results, any_code=given.any_code))
    else:
        draw(store.chosen(store.read(given.results), any_code=given.any_code), given.out)


if __name__ == "__main__":
    main(sys.argv[1:])
