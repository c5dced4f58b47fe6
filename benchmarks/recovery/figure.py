# SPDX-License-Identifier: MIT
"""Error against pose noise, this method and the paper's, as an SVG."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.recovery.scenes import SIGMAS
from benchmarks.recovery.tables import good, rms, stack, table
from benchmarks.recovery.work import Record
from seatrial.util.frames import Array

WIDTH, HEIGHT = 860, 380  # [px]
PANEL = (330, 250)  # [px] plotting area of each of the two
LEFT, TOP, BETWEEN = 70, 60, 90  # [px]
LEGEND = (0, 165, 385, 565)  # [px] where each entry begins
COEFFICIENTS = 11
COLOURS = {"white": "#1f6feb", "correlated": "#d1242f"}
DASHES = {"ours": "", "paper": "6 4"}
SAID = {"ours": "output-error", "paper": "the paper's method"}
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
            [f"{NOISE[line.colour]}, {SAID[line.method]}", *(f"{v:.3g}" for v in line.y)]
            for line in lines(records, measure)
        ]
        parts.append(table([title, *(f"{1e3 * s:g} mm" for s in SIGMAS)], rows))
    return "\n".join(parts)


def draw(records: Sequence[Record], path: Path) -> None:
    """Write the figure."""
    body = [_panel(i, title, lines(records, m)) for i, (title, m) in enumerate(PANELS)]
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'font-family="sans-serif" font-size="12" fill="#1f2328">\n'
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>\n'
        + "\n".join([*body, _legend()])
        + "\n</svg>\n"
    )


def _panel(number: int, title: str, drawn: Sequence[Line]) -> str:
    x0 = LEFT + number * (PANEL[0] + BETWEEN)
    values = np.concatenate([line.y for line in drawn])
    values = values[np.isfinite(values)]
    low, high = np.floor(np.log10(values.min())), np.ceil(np.log10(values.max()))

    def px(sigma: float) -> float:
        a, b = np.log10(SIGMAS[0]), np.log10(SIGMAS[-1])
        return float(x0 + PANEL[0] * (np.log10(sigma) - a) / (b - a))

    def py(value: float) -> float:
        return float(TOP + PANEL[1] * (high - np.log10(value)) / (high - low))

    out = [f'<text x="{x0}" y="{TOP - 12}" font-weight="bold">{title}</text>']
    for power in np.arange(low, high + 1):
        y = py(10.0**power)
        out.append(f'<path d="M{x0} {y:.1f}h{PANEL[0]}" stroke="#d0d7de"/>')
        out.append(f'<text x="{x0 - 6}" y="{y + 4:.1f}" text-anchor="end">{10.0**power:g}</text>')
    for sigma in SIGMAS:
        x, bottom = px(sigma), TOP + PANEL[1]
        out.append(f'<path d="M{x:.1f} {TOP}v{PANEL[1]}" stroke="#eaeef2"/>')
        out.append(
            f'<text x="{x:.1f}" y="{bottom + 16}" text-anchor="middle">{1e3 * sigma:g}</text>'
        )
    out.append(
        f'<text x="{x0 + PANEL[0] / 2}" y="{TOP + PANEL[1] + 34}" text-anchor="middle">'
        "pose noise, mm and mrad</text>"
    )
    for line in drawn:
        points = " ".join(
            f"{px(s):.1f},{py(v):.1f}"
            for s, v in zip(SIGMAS, line.y, strict=True)
            if np.isfinite(v)
        )
        out.append(f'<polyline points="{points}" {_stroke(line.colour, line.method)}/>')
    return "\n".join(out)


def _stroke(colour: str, method: str) -> str:
    dash = f' stroke-dasharray="{DASHES[method]}"' if DASHES[method] else ""
    return f'fill="none" stroke="{COLOURS[colour]}" stroke-width="2"{dash}'


def _legend() -> str:
    out = []
    for i, (colour, method) in enumerate((c, m) for c in COLOURS for m in DASHES):
        x, y = LEFT + LEGEND[i], 20
        out.append(f'<path d="M{x} {y}h28" {_stroke(colour, method)}/>')
        short = "white" if colour == "white" else "over 0.3 s"
        out.append(f'<text x="{x + 34}" y="{y + 4}">{SAID[method]}, {short}</text>')
    return "\n".join(out)
