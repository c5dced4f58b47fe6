# SPDX-License-Identifier: MIT
"""Gate: the guided path on boats drawn at random, with a lever arm, a current, both or neither.

python -m benchmarks.guided [--boats 10]

Every boat of the fleet (benchmarks/fleet) is identified in each case with `structure: auto`: by the guided path,
which finds the effects first, and by `identify`, which is told none. Printed are boats whose effects were found,
and that were said to have others; boats whose true terms were all found, and significant terms that they do not
have; the share of 95 % intervals that hold the truth; the largest error in standard errors; CPU seconds.
"""

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.fleet.draw import draw
from benchmarks.fleet.work import in_errors
from benchmarks.harness import command
from benchmarks.harness.workers import gathered
from seatrial.boat.model import Model
from seatrial.identification.guided import identify_guided
from seatrial.identification.methods import identify
from seatrial.recording.origin import poses_of_origin
from seatrial.recording.recording import Recording
from seatrial.util.errors import SeatrialError
from seatrial.util.format import table
from seatrial.util.statistics import NORMAL_95

CASES = {"neither": (), "lever": ("lever",), "current": ("current",), "both": ("lever", "current")}
LEVER = (0.2, 0.6)  # of the boat's length
CURRENT = (0.05, 0.2)  # of full speed
FULL_SPEED = 0.6  # [m/s] per root of a metre: the middle of the fleet's
AIMS = ("guided", "identify")


@dataclass(frozen=True)
class Row:
    """One boat, once."""

    case: str
    aim: str
    off: tuple[float, ...]  # standard errors of what is in truth and model
    found: tuple[str, ...]  # effects
    terms: bool  # whether all coefficients of the hull are among the model's
    extra: int  # coefficients that the hull has not, and that differ from 0 by more than two standard errors
    seconds: float  # CPU
    refused: str = ""


def moved(recording: Recording, case: str, length: float, seed: int) -> Recording:
    """The recording of a point off the origin, over ground."""
    rng = np.random.default_rng([5, seed])
    angles = rng.uniform(0.0, 2.0 * np.pi, size=2)
    sizes = length * rng.uniform(*LEVER), FULL_SPEED * np.sqrt(length) * rng.uniform(*CURRENT)
    lever, current = (
        size * np.array([np.cos(angle), np.sin(angle)]) * (kind in CASES[case])
        for kind, size, angle in zip(("lever", "current"), sizes, angles, strict=True)
    )
    return poses_of_origin(recording, -lever, -current)


def identified(seed: int, case: str, aim: str) -> Row:
    """Draw a boat, drive it, identify it, compare with the truth."""
    boat = draw(seed)
    vehicle, recordings = boat.trials()
    length = float(np.hypot(*np.ptp([place[:2] for place in boat.hull.places], axis=0)))
    seen = [moved(r, case, length, seed) for r in recordings]
    vehicle = vehicle.with_automatic_structure()
    begun = time.process_time()
    try:
        if aim == "guided":
            guided = identify_guided(seen, vehicle)
            model, found = guided.model, guided.effects
        else:
            model, found = identify(seen, vehicle), ()
    except SeatrialError as error:
        return Row(case, aim, (), (), False, 0, time.process_time() - begun, str(error))
    seconds = time.process_time() - begun
    off, terms, extra = compared(model, boat.truth)
    return Row(case, aim, off, tuple(found), terms, extra, seconds)


def compared(model: Model, truth: dict[str, float]) -> tuple[tuple[float, ...], bool, int]:
    """Errors in standard errors, whether all terms are there, and the number of significant others.

    Coefficients that the structure holds at 1 and -1 count beside these.
    """
    held = {"X_vr": 1.0, "Y_ur": -1.0}
    truth = {n: x - held.get(n, 0.0) for n, x in truth.items()}
    off, errors = in_errors(model, truth), model.standard_errors
    hull = {n for n in truth if n[:2] in ("X_", "Y_", "N_")}
    more = [n for n in model.values if n not in hull and abs(model.values[n]) > 2.0 * errors[n]]
    return tuple(off.values()), hull <= set(model.values), len(more)


def sums(rows: Sequence[Row]) -> str:
    """A line for each case and aim."""
    lines = []
    for case, effects in CASES.items():
        for aim in AIMS:
            own = [row for row in rows if (row.case, row.aim) == (case, aim)]
            off = np.abs([z for row in own for z in row.off])
            lines.append([
                f"{case}, {aim}",
                f"{sum(set(effects) <= set(row.found) for row in own)}/{len(own)}",
                f"{sum(bool(set(row.found) - set(effects)) for row in own)}",
                f"{sum(row.terms for row in own)}",
                f"{np.mean([row.extra for row in own]):.1f}",
                f"{100.0 * np.mean(off < NORMAL_95):.0f} %",
                f"{off.max():.1f}",
                f"{np.median([row.seconds for row in own]):.1f} s",
                f"{sum(bool(row.refused) for row in own)}",
            ])  # fmt: skip
    head = [
        "case", "effects found", "imagined", "terms found", "extra terms", "intervals", "largest", "CPU",
        "refused",
    ]  # fmt: skip
    return table(head, lines)


def main(arguments: Sequence[str]) -> None:
    """Draw, drive, identify, sum up."""
    parser = command.parser("guided", __doc__)
    parser.add_argument("--boats", type=int, default=10, help="how many, from seed 1 on")
    command.with_workers(parser)
    given = parser.parse_args(arguments)
    seeds = range(1, given.boats + 1)
    jobs = [(seed, case, aim) for seed in seeds for case in CASES for aim in AIMS]
    print(sums(gathered(identified, jobs, given.workers)))


if __name__ == "__main__":
    main(sys.argv[1:])
