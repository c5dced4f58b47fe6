# SPDX-License-Identifier: MIT
"""Command line: print tables, or write them into docs/onboard.md.

`node` needs Debian's ROS 1, `jazzy-...` a ROS 2 (SEATRIAL_ROS2). They are made only when they are named, and
belong to docs/ros.md.
"""

import sys
from argparse import Namespace
from collections.abc import Sequence

import benchmarks.predictor
from benchmarks.harness import command
from benchmarks.predictor import accuracy, board, consistency, matches, ros1, ros2, unknown

MAKERS = {
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
NODE = {
    "node": ros1.cost, "jazzy-velocity": ros2.velocity, "jazzy-node": ros2.cost,
    "jazzy-compile": ros2.compiling,
}  # fmt: skip


def main(arguments: Sequence[str]) -> None:
    """Make the chosen tables."""
    parser = command.parser("predictor", benchmarks.predictor.__doc__)
    parser.add_argument("--soak", action="store_true", help="the soak, too: some minutes")
    given = command.tables(parser, arguments, {**MAKERS, **NODE}, default=MAKERS)
    if given.all and not given.soak and not given.write:
        given.tables.remove("soak")
    for makers, page in ((MAKERS, "onboard.md"), (NODE, "ros.md")):
        own = [name for name in given.tables if name in makers]
        command.show(Namespace(**{**vars(given), "tables": own}), makers, page)


if __name__ == "__main__":
    main(sys.argv[1:])
