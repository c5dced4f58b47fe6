# SPDX-License-Identifier: MIT
"""Command line: run, tables, write (into their pages), reachable (its block), figure."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import benchmarks.recovery
from benchmarks.harness import command, store
from benchmarks.harness.page import refill
from benchmarks.recovery import moved, tables, terms
from benchmarks.recovery.figure import draw, numbers
from benchmarks.recovery.reachable import reachable
from benchmarks.recovery.work import FIRST, Record, groups, one

PAGES = (command.DOCS / "recovery.md", command.DOCS / "identify.md")
Block = tuple[list[str], Callable[[], str]]  # scenes that it is of, and what makes it


def blocks(records: Sequence[Record]) -> dict[str, Block]:
    """The tables by name, each made on request."""
    names = groups()
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
        "bumps": ([], lambda: moved.table(records)),
        "terms": ([], lambda: terms.summary(records)),
    }


def made(records: Sequence[Record]) -> dict[str, str]:
    """Those tables whose scenes all have results."""
    there = {r["scene"] for r in records if "failed" not in r}
    found = {n: make() for n, (wanted, make) in blocks(records).items() if there >= {*wanted}}
    return {name: text for name, text in found.items() if text}


def main(arguments: Sequence[str]) -> None:
    """Run, print or write."""
    parser = command.parser("recovery", benchmarks.recovery.__doc__)
    parser.add_argument("verb", choices=("run", "tables", "write", "reachable", "figure"))
    command.with_results(parser, "build/recovery.jsonl")
    command.with_seeds(parser, 8, FIRST)
    parser.add_argument("--groups", help=f"{','.join(groups())}; default all")
    parser.add_argument("--scenes", help="names, with commas")
    parser.add_argument("--out", type=Path, default=command.DOCS / "images" / "noise.svg")
    given = parser.parse_args(arguments)
    present = store.code("recovery")
    if given.verb == "run":
        wanted = given.groups.split(",") if given.groups else list(groups())
        names = [name for group in wanted for name in groups()[group]]
        if given.scenes:
            names = [name for name in names if name in given.scenes.split(",")]
        jobs = [(n, s) for s in range(FIRST, FIRST + given.seeds) for n in names]  # even if stopped
        store.run(given.results, jobs, one, present, given.workers)
        return
    if given.verb == "reachable":
        refill(PAGES[0], {"reachable": reachable()})
        return
    records = store.chosen(store.read(given.results), present, any_code=given.any_code)
    if given.verb == "tables":
        print("\n".join(f"## {name}\n\n{text}" for name, text in made(records).items()))
        print(tables.failures(records))
    elif given.verb == "write":
        for page in PAGES:
            refill(page, made(records))
    else:
        draw(records, given.out)


if __name__ == "__main__":
    main(sys.argv[1:])
