# SPDX-License-Identifier: MIT
"""Gate: boats of the fleet whose vehicle file has neither thrusters nor allocation, with `structure: auto`.

    python -m benchmarks.layouts --boats 20

The boats have four thrusters in an X or in a cross, or two and a bow thruster, each with a dead zone. Each is
identified twice: with the usual layouts as candidates, and with none taken. Printed are boats whose layout was
found, the median and largest of each boat's largest relative error of X_F, Y_F and N_F, the share of 95 %
intervals of all true coefficients that hold the truth, and the median CPU time.
"""

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from unittest.mock import patch

import msgspec
import numpy as np

from benchmarks.fleet.draw import draw
from benchmarks.guided import compared
from benchmarks.harness import command
from benchmarks.harness.workers import gathered
from seatrial.boat.findings import FindingKind, of_kinds
from seatrial.boat.schema import AllocationEntry
from seatrial.identification.guided import identify_guided
from seatrial.identification.selection import thruster_layout
from seatrial.util.errors import SeatrialError
from seatrial.util.format import table
from seatrial.util.statistics import NORMAL_95
from tests.boats.hulls import CORNERS, CROSS

AIMS = ("layouts", "no layout")
LAYOUT_OF = {"X": "four in an X", "cross": "two ahead and two across", "bow thruster": "the bow"}


@dataclass(frozen=True)
class Row:
    """One boat, once."""

    kind: str
    aim: str
    right: bool  # whether its layout was found
    off: tuple[float, ...]  # standard errors
    force: float  # largest relative error of a force coefficient
    seconds: float  # CPU


def identified(seed: int, aim: str) -> Row | None:
    """Draw a boat, drive it, forget its thrusters, identify it; None: refused."""
    boat = draw(seed)
    vehicle, recordings = boat.trials()
    unknown = msgspec.structs.replace(
        vehicle.file, thrusters={}, allocation=AllocationEntry(limit=1.0)
    )
    vehicle = replace(vehicle, file=unknown).with_automatic_structure()
    angles = sorted(angle for _, _, angle in boat.hull.places)
    shapes = {"X": CORNERS, "cross": CROSS}
    kind = next(
        (k for k, s in shapes.items() if angles == sorted(angle for _, _, angle in s)),
        "bow thruster",
    )
    begun = time.process_time()
    least = thruster_layout.LEAST_LAYOUT_GAIN if aim == AIMS[0] else np.inf
    try:
        with patch.object(thruster_layout, "LEAST_LAYOUT_GAIN", least):
            model = identify_guided(recordings, vehicle).model
    except SeatrialError:
        return None
    seconds = time.process_time() - begun
    found = of_kinds(model.estimator.findings, FindingKind.THRUSTER_LAYOUT_SELECTED)
    right = any(LAYOUT_OF[kind] in str(finding.values["layout"]) for finding in found)
    off, _, _ = compared(model, boat.truth)
    force = max(abs(model.values[n] / boat.truth[n] - 1.0) for n in ("X_F", "Y_F", "N_F"))
    return Row(kind, aim, right, off, force, seconds)


def sums(rows: Sequence[Row | None]) -> str:
    """A line for each layout and aim."""
    lines = []
    for kind in LAYOUT_OF:
        for aim in AIMS:
            own = [row for row in rows if row is not None and (row.kind, row.aim) == (kind, aim)]
            if not own:
                continue
            off = np.abs([z for row in own for z in row.off])
            lines.append([
                f"{kind}, {aim}", f"{sum(row.right for row in own)}/{len(own)}",
                f"{100.0 * np.median([row.force for row in own]):.0f} %",
                f"{100.0 * max(row.force for row in own):.0f} %",
                f"{100.0 * np.mean(off < NORMAL_95):.0f} %",
                f"{np.median([row.seconds for row in own]):.1f} s",
            ])  # fmt: skip
    head = ["thrusters", "layout found", "force off: median", "largest", "intervals", "CPU"]
    refused = sum(row is None for row in rows)
    return table(head, lines) + f"\n{refused} refused"


def main(arguments: Sequence[str]) -> None:
    """Draw, drive, identify, sum up."""
    parser = command.parser("layouts", __doc__)
    parser.add_argument("--boats", type=int, default=20, help="how many, from seed 1 on")
    command.with_workers(parser)
    given = parser.parse_args(arguments)
    jobs = [(seed, aim) for seed in range(1, given.boats + 1) for aim in AIMS]
    print(sums(gathered(identified, jobs, given.workers)))


if __name__ == "__main__":
    main(sys.argv[1:])
