# SPDX-License-Identifier: MIT
"""Command line: run, write, figures."""

import argparse
import json
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy; the worker processes inherit it

from benchmarks.paper import figures, page
from benchmarks.paper.trials import FIRST
from benchmarks.paper.work import FINDINGS, one

RESULTS = Path("build/paper.jsonl")
PAGE = Path("docs/paper.md")


def read(path: Path) -> list[dict[str, Any]]:
    """All results; a last line that was cut off is left out."""
    if not path.exists():
        return []
    lines = path.read_text().splitlines(keepends=True)
    return [json.loads(line) for line in lines if line.endswith("\n")]


def run(path: Path, names: Sequence[str], seeds: range) -> None:
    """Add what is missing, seed by seed."""
    known = read(path)
    done = {(r["finding"], *r["key"]) for r in known}
    missing = [
        (name, key)
        for seed in seeds
        for name in names
        for key in FINDINGS[name].keys(range(seed, seed + 1))
        if (name, *key) not in done
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("".join(json.dumps(r) + "\n" for r in known))
    with path.open("a") as out:
        for i, record in enumerate(_worked(missing), start=1):
            out.write(json.dumps(record) + "\n")
            out.flush()
            print(f"{i}/{len(missing)} {record['finding']} {record['key']}", flush=True)


def _worked(items: Sequence[tuple[str, tuple[Any, ...]]]) -> Iterator[dict[str, Any]]:
    with ProcessPoolExecutor(os.cpu_count() or 1, mp_context=get_context("spawn")) as pool:
        for future in as_completed([pool.submit(one, *item) for item in items]):
            yield future.result()


def main(arguments: Sequence[str]) -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.paper", description=__doc__)
    parser.add_argument("verb", choices=("run", "write", "figures"))
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--seeds", type=int, default=4, help=f"how many, from {FIRST} on")
    parser.add_argument("--only", nargs="+", choices=FINDINGS, default=list(FINDINGS))
    parser.add_argument("--page", type=Path, default=PAGE)
    given = parser.parse_args(arguments)
    if given.verb == "run":
        run(given.results, given.only, range(FIRST, FIRST + given.seeds))
    elif given.verb == "figures":
        figures.write(given.page.parent / "images")
    else:
        records = read(given.results)
        failed = [r for r in records if "failed" in r]
        for record in failed:
            print(f"left out: {record['finding']} {record['key']}: {record['failed']}")
        page.write([r for r in records if "found" in r], given.page)


if __name__ == "__main__":
    main(sys.argv[1:])
