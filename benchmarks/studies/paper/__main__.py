# SPDX-License-Identifier: MIT
"""Command line: run, write, figures."""

import sys
from collections.abc import Sequence
from pathlib import Path

import benchmarks.studies.paper
from benchmarks.harness import command, store
from benchmarks.studies.paper import figures, page
from benchmarks.studies.paper.trials import FIRST
from benchmarks.studies.paper.work import FINDINGS, one


def main(arguments: Sequence[str]) -> None:
    """Run or write."""
    parser = command.parser("studies.paper", benchmarks.studies.paper.__doc__)
    parser.add_argument("verb", choices=("run", "write", "figures"))
    command.with_results(parser, "build/paper.jsonl")
    command.with_seeds(parser, 4, FIRST)
    parser.add_argument("--only", nargs="+", choices=FINDINGS, default=list(FINDINGS))
    parser.add_argument("--page", type=Path, default=command.DOCS / "paper.md")
    given = parser.parse_args(arguments)
    present = store.code("studies/paper")
    if given.verb == "run":
        seeds = (range(s, s + 1) for s in range(FIRST, FIRST + given.seeds))
        jobs = [(n, *key) for each in seeds for n in given.only for key in FINDINGS[n].keys(each)]
        store.run(given.results, jobs, one, present, given.workers)
    elif given.verb == "figures":
        figures.write(given.page.parent / "images")
    else:
        records = store.chosen(store.read(given.results), present, any_code=given.any_code)
        for record in records:
            if "failed" in record:
                print(f"left out: {record['finding']} {record['key']}: {record['failed']}")
        page.write([r for r in records if "found" in r], given.page)


if __name__ == "__main__":
    main(sys.argv[1:])
