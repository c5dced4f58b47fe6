# SPDX-License-Identifier: MIT
"""Command lines: benchmarks that print tables, and those that store results first."""

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


def parser(name: str, text: str | None) -> argparse.ArgumentParser:
    """Of `python -m benchmarks.NAME`, with the module's own text as its help."""
    return argparse.ArgumentParser(
        prog=f"python -m benchmarks.{name}", description=text,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip


def with_seeds(given: argparse.ArgumentParser, count: int, first: int) -> None:
    """Options of how much is run."""
    given.add_argument("--seeds", type=int, default=count, help=f"how many, from {first} on")
    with_workers(given)


def with_workers(given: argparse.ArgumentParser) -> None:
    """Options of who does the work: `workers` is a number of processes, or a scheduler of Dask."""
    who = given.add_mutually_exclusive_group()
    who.add_argument(
        "--processes", dest="workers", type=int, metavar="N", help="default: as many as cores"
    )
    who.add_argument(
        "--scheduler", dest="workers", metavar="WHERE",
        help="workers of Dask elsewhere: tcp://HOST:PORT, or a scheduler's file",
    )  # fmt: skip


def with_results(given: argparse.ArgumentParser, path: str) -> None:
    """Options of where results are kept."""
    given.add_argument("--results", type=Path, default=Path(path), help="file of JSON lines")
    given.add_argument("--any-code", action="store_true", help="results of other code, too")


def tables(
    given: argparse.ArgumentParser,
    arguments: Sequence[str],
    names: Iterable[str],
    default: Iterable[str] | None = None,
) -> argparse.Namespace:
    """Names of tables, all or `default` where none is given, and whether to write them."""
    known = list(names)
    given.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(known))
    given.add_argument("--write", action="store_true", help="into their page in docs/")
    found = given.parse_args(arguments)
    if odd := set(found.tables) - set(known):
        given.error(f"no table {', '.join(sorted(odd))}; there are {', '.join(known)}")
    found.all = not found.tables
    found.tables = found.tables or list(known if default is None else default)
    return found


def show(
    given: argparse.Namespace,
    makers: Mapping[str, Callable[[], str]],
    page: str,
    picture: Callable[[], None] | None = None,
) -> None:
    """Make the chosen tables and print them; with --write into docs/`page`, too.

    The page's picture is drawn where all tables are written.
    """
    from benchmarks.harness.page import refill  # noqa: PLC0415 it imports seatrial; bags.py counts that

    made = {}
    for name in given.tables:
        made[name] = makers[name]().strip()
        print(f"## {name}\n\n{made[name]}\n", flush=True)
    if given.write and made:
        refill(DOCS / page, made)
        if picture is not None and given.all:
            picture()
