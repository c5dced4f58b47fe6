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


def blocks(records: Sequence[Record]) -> dict[str, Callable[[], str]]:
    """The tables by name, each made when it is asked for."""
    names = {g: [s.name for s in scenes().values() if s.group == g] for g in
             ("still", "pushed", "together", "faults", "noise")}  # fmt: skip
    driven = names["still"] + names["pushed"]
    return {
        "overview": lambda: tables.overview(records, driven),
        "thrusters": lambda: tables.thrusters(records, driven + names["together"]),
        "ahead": lambda: tables.prediction(records),
        "ahead-pushed": lambda: tables.prediction(records, " pushed"),
        "faults": lambda: tables.fault_moves(records, names["faults"]),
        "noise": lambda: numbers(records),
        "believed": lambda: tables.believed(records, driven),
        "parameters": lambda: "\n".join(
            tables.recovery(records, n) for n in driven if tables.good(records, n)
        ),
        "failures": lambda: tables.failures(records) or "none\n",
    }


def shown(path: Path, *, any_code: bool) -> str:
    """All tables."""
    made = blocks(store.chosen(store.read(path), any_code=any_code))
    return "\n".join(f"## {name}\n\n{make()}" for name, make in made.items())


def filled(text: str) -> bool:
    """Does it hold more than a table's head?"""
    return text.count("\n") > len(("head", "rule"))


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
    elif given.verb == "tables":
        print(shown(given.results, any_code=given.any_code))
    elif given.verb == "write":
        made = blocks(store.chosen(store.read(given.results), any_code=given.any_code))
        texts = {name: make() for name, make in made.items()}
        refill(PAGE, {name: text for name, text in texts.items() if filled(text)})
    elif given.verb == "reachable":
        refill(PAGE, {"reachable": reachable()})
    else:
        draw(store.chosen(store.read(given.results), any_code=given.any_code), given.out)


if __name__ == "__main__":
    main(sys.argv[1:])
