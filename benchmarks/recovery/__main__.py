# SPDX-License-Identifier: MIT
"""Command line: run, tables, write (docs/recovery.md), reachable (its block there), figure."""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy; the worker processes inherit it

from benchmarks.blocks import refill
from benchmarks.recovery import store, tables
from benchmarks.recovery.figure import draw, numbers
from benchmarks.recovery.reachable import reachable
from benchmarks.recovery.scenes import scenes
from benchmarks.recovery.work import Record

FIRST = 1001  # seed; those of the tests are others
DEFAULT = Path("build/recovery.jsonl")
PAGE = Path("docs/recovery.md")


Block = tuple[list[str], Callable[[], str]]  # scenes that it is of, and what makes it


def blocks(records: Sequence[Record]) -> dict[str, Block]:
    """The tables by name, each made when it is asked for."""
    names = {g: [s.name for s in scenes().values() if s.group == g] for g in
             ("still", "pushed", "together", "faults", "noise")}  # fmt: skip
    driven = names["still"] + names["pushed"]
    delayed = driven + names["together"]
    return {
        "overview": (driven, lambda: tables.overview(records, driven)),
        "further": (driven, lambda: tables.further(records, driven)),
        "thrusters": (delayed, lambda: tables.thrusters(records, delayed)),
        "ahead": (names["still"], lambda: tables.prediction(records)),
        "ahead-pushed": (names["pushed"], lambda: tables.prediction(records, " pushed")),
        "faults": (names["faults"], lambda: tables.fault_moves(records, names["faults"])),
        "noise": (names["noise"], lambda: numbers(records)),
        "noise-levels": (driven, lambda: tables.noise_levels(records, driven)),
        "parameters": (driven, lambda: "\n".join(tables.recovery(records, n) for n in driven)),
    }


def made(records: Sequence[Record]) -> dict[str, str]:
    """Those tables whose scenes all have results."""
    there = {r["scene"] for r in records if "failed" not in r}
    return {name: make() for name, (wanted, make) in blocks(records).items() if there >= {*wanted}}


def main(arguments: Sequence[str]) -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.recovery", description=__doc__)
    parser.add_argument("verb", choices=("run", "tables", "write", "reachable", "figure"))
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
        return
    if given.verb == "reachable":
        refill(PAGE, {"reachable": reachable()})
        return
    records = store.chosen(store.read(given.results), any_code=given.any_code)
    if given.verb == "tables":
        print("\n".join(f"## {name}\n\n{text}" for name, text in made(records).items()))
        print(tables.failures(records))
    elif given.verb == "write":
        refill(PAGE, made(records))
    else:
        draw(records, given.out)


if __name__ == "__main__":
    main(sys.argv[1:])
