# SPDX-License-Identifier: MIT
"""Error against pose noise, this method and the paper's, as an SVG."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.harness import pictures
from benchmarks.harness.markdown import table
from benchmarks.harness.store import Record
from benchmarks.recovery.tables import good, rms, stack
from seatrial.report.figures.base import BLUE, RED, Figure, figure, line, logarithmic
from seatrial.util.frames import Array
from tests.boats.scenes import SIGMAS

COEFFICIENTS = 11
COLOURS = {"white": BLUE, "correlated": RED}
DASHES = {"ours": "", "paper": "dash"}
METHOD = {"ours": "output-error", "paper": "the paper's method"}
NOISE = {"white": "white noise", "correlated": "noise correlated over 0.3 s"}


@dataclass(frozen=True)
class Line:
    """One curve."""

    colour: str  # of the noise
    method: str
    y: Array  # (sigmas,) NaN where there is no result


def coefficient_error(records: Sequence[Record], method: str) -> float:
    """Median over the coefficients of the RMS error in per cent of the truth."""
    truth = stack(records, "truth", COEFFICIENTS)
    found = stack(records, "found" if method == "ours" else "paper", COEFFICIENTS)
    return float(100.0 * np.median(rms(found / truth - 1.0)))


def speed_error(records: Sequence[Record], method: str) -> float:
    """RMS of u and v on S7 1 s ahead from true starts [cm/s]."""
    return float(
        100.0 * np.sqrt(np.mean([np.square(r["ahead"][f"{method} true"][:2]) for r in records]))
    )


PANELS: tuple[tuple[str, Callable[[Sequence[Record], str], float]], ...] = (
    ("error of the coefficients, % (median of 11)", coefficient_error),
    ("error of u and v 1 s ahead, cm/s", speed_error),
)


def lines(
    records: Sequence[Record], measure: Callable[[Sequence[Record], str], float]
) -> list[Line]:
    """The four curves of one panel."""
    out = []
    for colour in COLOURS:
        for method in DASHES:
            y = np.full(len(SIGMAS), np.nan)
            for i, sigma in enumerate(SIGMAS):
                mine = good(records, f"{colour} {1e3 * sigma:g} mm")
                if mine:
                    y[i] = measure(mine, method)
            out.append(Line(colour, method, y))
    return out


def numbers(records: Sequence[Record]) -> str:
    """The same as a table."""
    parts = []
    for title, measure in PANELS:
        rows = [
            [f"{NOISE[one.colour]}, {METHOD[one.method]}", *(f"{v:.3g}" for v in one.y)]
            for one in lines(records, measure)
        ]
        parts.append(table([title, *(f"{1e3 * s:g} mm" for s in SIGMAS)], rows))
    return "\n".join(parts)


def draw(records: Sequence[Record], path: Path) -> None:
    """Write the figure."""
    pictures.write(path, [[_panel(title, lines(records, m)) for title, m in PANELS]])


def _panel(title: str, drawn: Sequence[Line]) -> Figure:
    sigma = 1e3 * np.array(SIGMAS)
    curves = [
        line(f"{METHOD[one.method]}, {NOISE[one.colour]}", sigma, one.y, COLOURS[one.colour],
             dash=DASHES[one.method])
        for one in drawn
    ]  # fmt: skip
    high = np.concatenate([one.y for one in drawn])
    ends = 10.0 ** np.floor(np.log10(np.nanmin(high))), 10.0 ** np.ceil(np.log10(np.nanmax(high)))
    return figure(
        curves, "pose noise [mm, mrad]", title, showlegend=True,
        xaxis=logarithmic(sigma[0], sigma[-1]), yaxis=logarithmic(*ends),
    )  # fmt: skip
