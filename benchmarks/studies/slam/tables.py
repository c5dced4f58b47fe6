# SPDX-License-Identifier: MIT
"""The study's tables; all seeds of a case together."""

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from benchmarks.harness.markdown import table as markdown
from benchmarks.studies.slam.drives import STICKS
from benchmarks.studies.slam.lidar import RATE
from benchmarks.studies.slam.study import DROP_OUTS, GUESSES, OFF, Case, Outcome
from seatrial.util.frames import Array, Mask

EVERY, MIDDLE, SLOW = 1, 3, 15  # of the scans that one is matched
PACES = {"gentle": (EVERY, SLOW), "aggressive": (EVERY, MIDDLE, 7, SLOW)}
MAIN = ("constant pose", "constant velocity", "predictor")
ALONE = ("constant velocity", "predictor", "true motion")  # guesses that can undistort
REACHES = (0.5, 1.0, 2.0)  # [m]
Found = Mapping[Case, Sequence[Outcome]]


def compared(driving: str) -> list[Case]:
    """Every pace, and every third scan with gaps; all guesses where there is something to lose."""
    paces = [*((every, False) for every in PACES[driving]), (MIDDLE, True)]
    return [
        Case(driving, guess, every, gaps)
        for every, gaps in paces
        for guess in (MAIN if driving == "gentle" or every == EVERY else GUESSES)
    ]


CASES: dict[str, list[Case]] = {
    **{driving: compared(driving) for driving in STICKS},
    "undistorted": [
        Case("aggressive", guess, MIDDLE, undistort=moves)
        for guess, moves in product(ALONE, (False, True))
    ],
    "reach": [Case("aggressive", guess, SLOW, reach=r) for r, guess in product(REACHES, GUESSES)],
}


def pace(every: int, drop_outs: bool) -> str:
    """How often a scan is matched."""
    shown = f"{RATE / every:.2g} Hz"
    return f"{shown}, {DROP_OUTS.per_minute:g} gaps a minute" if drop_outs else shown


def percentile(parts: Sequence[Array]) -> list[str]:
    """The 95th of every column, times 1000, to three digits."""
    found = 1e3 * np.percentile(np.concatenate(parts), 95, axis=0)
    return [f"{float(f'{x:.3g}'):g}" for x in found]


def rms(parts: Sequence[Array]) -> list[str]:
    """Root mean square of every column, times 1000."""
    squares = np.atleast_1d(np.mean(np.concatenate(parts) ** 2, axis=0))
    return [f"{1e3 * x:.3g}" for x in np.sqrt(squares)]


def per_cent(parts: Sequence[Mask]) -> str:
    """Share that is true."""
    share = 100.0 * float(np.mean(np.concatenate(parts)))
    return "0" if share == 0.0 else f"{share:.2g}" if share < 10.0 else f"{share:.0f}"


def matched(found: Found) -> str:
    """Guess, match, pose and map by pace and guess."""
    head = (
        "scans matched", "guess", "guess error, 95 %: mm", "mrad", "iterations", "rejected, %",
        "pose false, %", "drives lost", "pose error, 95 %: mm", "mrad", "map points off, %",
    )  # fmt: skip
    rows = [
        [
            pace(case.every, case.drop_outs), case.guess, *percentile([x.guess_error for x in o]),
            f"{np.concatenate([x.iterations for x in o]).mean():.1f}", per_cent([~x.accepted for x in o]),
            *losses([x.false for x in o]), *percentile([x.error for x in o]),
            per_cent([x.map_error > OFF for x in o]),
        ]
        for case, o in found.items()
    ]  # fmt: skip
    return markdown(head, rows, text=2)


def losses(false: Sequence[Mask]) -> tuple[str, str]:
    """Share of false poses, and drives that end with one."""
    return per_cent(false), f"{sum(bool(one[-1]) for one in false)} of {len(false)}"


def undistorted(found: Found) -> str:
    """Pose and map with scans as measured, and undistorted."""
    rows = [
        [
            case.guess, "undistorted" if case.undistort else "as measured",
            *rms([x.error for x in o]), *rms([x.map_error for x in o]),
        ]
        for case, o in found.items()
    ]  # fmt: skip
    head = ("guess", "scans", "pose error, RMS: mm", "mrad", "points of the map, RMS: mm")
    return markdown(head, rows, text=2)


def reach(found: Found) -> str:
    """Losses by the matcher's farthest correspondence."""
    rows = [
        [
            f"{case.reach:g} m", case.guess, per_cent([~x.accepted for x in o]),
            *losses([x.false for x in o]), per_cent([x.map_error > OFF for x in o]),
        ]
        for case, o in found.items()
    ]  # fmt: skip
    head = (
        "farthest correspondence", "guess", "rejected, %", "pose false, %", "drives lost",
        "map points off, %",
    )  # fmt: skip
    return markdown(head, rows, text=2)


TABLES = {"gentle": matched, "aggressive": matched, "undistorted": undistorted, "reach": reach}


def table(name: str, outcomes: Sequence[Outcome]) -> str:
    """Markdown."""
    return TABLES[name]({case: [o for o in outcomes if o.case == case] for case in CASES[name]})
