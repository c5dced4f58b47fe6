# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them into docs/onboard.md.

`node` needs Debian's ROS 1 and is left out unless it is asked for; it goes into docs/ros.md.
"""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy

from benchmarks.blocks import fill, refill
from benchmarks.predictor import accuracy, board, consistency, matches, ros1, unknown

DOCS = Path(__file__).parents[2] / "docs"
PAGE, NODE_PAGE = DOCS / "onboard.md", DOCS / "ros.md"
BLOCKS: dict[str, Callable[[], str]] = {
    "velocity": accuracy.velocity_table,
    "reckoning": accuracy.reckoning_table,
    "consistency": consistency.nees_table,
    "correlated": consistency.correlated_table,
    "ship": consistency.ship_table,
    "matches": matches.table,
    "current": unknown.table,
    "speed": board.speed,
    "soak": board.soak,
}
NODE = {"node": ros1.cost}


def main(arguments: Sequence[str]) -> None:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.predictor", description=__doc__)
    every = {**BLOCKS, **NODE}
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(every))
    parser.add_argument("--soak", action="store_true", help="the soak, too: some minutes")
    parser.add_argument("--write", action="store_true", help="into the page")
    given = parser.parse_args(arguments)
    if odd := set(given.tables) - set(every):
        parser.error(f"no table {', '.join(sorted(odd))}; there are {', '.join(every)}")
    if given.write:
        if "node" in given.tables:
            fill(NODE_PAGE, NODE)
        own = [name for name in given.tables if name in BLOCKS]
        if given.tables and not own:
            return
        refill(PAGE, {name: BLOCKS[name]() for name in own or BLOCKS})
        return
    default = [name for name in BLOCKS if name != "soak" or given.soak]
    for name in given.tables or default:
        print(f"## {name}\n\n{every[name]()}\n", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
