# SPDX-License-Identifier: MIT
"""Score dials as inline SVG: half a ring, filled by a share or by parts, with its text equivalent."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

RADIUS, WIDTH = 48.0, 13.0  # [px] of the ring
CENTRE = (60.0, 58.0)  # [px] in the picture
LONG = 6  # characters that fit in large print
GAP = 0.035  # [-] of the half turn, between parts


class Grade:
    """Classes of the style sheet: colours, never the only sign of a grade."""

    GOOD, FAIR, POOR, NONE = "good", "fair", "poor", "none"
    PLAIN, SECOND = "plain", "second"  # neither good nor poor: of A, of B


@dataclass(frozen=True)
class Dial:
    """One dial. `parts`: ends of the filled arcs as shares of the half turn, with their grades."""

    name: str  # its anchor
    title: str
    figure: str  # the short text in its middle
    meaning: str  # what the figure means
    parts: Sequence[tuple[float, float, str]]

    def html(self) -> str:
        """The drawing with title and meaning below it."""
        arcs = "".join(
            f'<path class="arc {grade}" d="{_arc(begin, end)}"/>'
            for begin, end, grade in self.parts
        )
        label = f"{self.title}: {self.figure}, {self.meaning}"
        kind = "long" if len(self.figure) > LONG else "short"
        place = f'x="{CENTRE[0]:g}" y="{CENTRE[1] - 4:g}"'
        return (
            f'<figure class="dial" id="dial-{self.name}"><svg viewBox="0 0 120 66" role="img" '
            f'aria-label="{escape(label)}"><path class="arc none" d="{_arc(0.0, 1.0)}"/>{arcs}'
            f'<text class="{kind}" {place}>{escape(self.figure)}</text></svg>'
            f"<figcaption><b>{escape(self.title)}</b> {escape(self.meaning)}</figcaption></figure>"
        )


def share_dial(
    name: str, title: str, share: float, meaning: str, limits: tuple[float, float]
) -> Dial:
    """A share of 1 as an arc; `limits`: of good and of fair."""
    shown = float(np.clip(share, 0.0, 1.0))
    good, fair = limits
    grade = Grade.GOOD if share >= good else Grade.FAIR if share >= fair else Grade.POOR
    parts = [(0.0, shown, grade)] if shown > 0.0 else []
    return Dial(name, title, f"{100.0 * shown:.0f} %", meaning, parts)


def part_dial(name: str, title: str, figure: str, meaning: str, grades: Sequence[str]) -> Dial:
    """Equal parts side by side, each with its grade."""
    each = 1.0 / max(1, len(grades))
    ends = [(k * each + GAP / 2, (k + 1) * each - GAP / 2) for k in range(len(grades))]
    parts = [(b, e, grade) for (b, e), grade in zip(ends, grades, strict=True)]
    return Dial(name, title, figure, meaning, parts)


def _arc(begin: float, end: float) -> str:
    """A path along the half ring from left (0) to right (1)."""
    turn = np.pi * (1.0 - np.array([begin, end]))
    x = CENTRE[0] + RADIUS * np.cos(turn)
    y = CENTRE[1] - RADIUS * np.sin(turn)
    return f"M{x[0]:.2f} {y[0]:.2f}A{RADIUS:g} {RADIUS:g} 0 0 1 {x[1]:.2f} {y[1]:.2f}"
