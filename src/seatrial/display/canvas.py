# SPDX-License-Identifier: MIT
"""Common to all plots: the figure, and text from files that Matplotlib must not read as mathematics."""

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from seatrial.report.figures.base import log_ticks
from seatrial.util.errors import SeatrialError, printable
from seatrial.util.frames import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INSTALL = "pip install 'seatrial[plot]'"
LONGEST_LABEL = 32  # [characters] of a name in a plot
GREY = "#666666"
COEFFICIENT = re.compile(r"([A-Za-z])_([A-Za-z0-9]{1,8})")
SMALL = 8  # [pt] text in a legend
MARGIN = 0.1  # [decades] above and below the values


def drawn_on(figure: "Figure | None", width: float, height: float) -> "Figure":
    """The given figure, or a new one of this size [inch] that shows itself in a notebook.

    Raises SeatrialError where Matplotlib is not installed.
    """
    try:
        from seatrial.display.shown_figure import ShownFigure  # noqa: PLC0415 (needs Matplotlib)
    except ImportError:
        raise SeatrialError(f"plots need Matplotlib 3.7 or later: {INSTALL}") from None
    if figure is None:
        return ShownFigure(figsize=(width, height), layout="constrained")
    if figure.get_layout_engine() is None:
        figure.set_layout_engine("constrained")
    return figure


def literal(text: str, most: int = LONGEST_LABEL) -> str:
    """A name as text: no mathematics in it, no line breaks, of limited length; never hidden from a legend."""
    shown = printable(text, keep="").strip() or "–"
    if len(shown) > most:
        shown = f"{shown[: most // 2]}…{shown[most // 2 + 1 - most :]}"
    shown = shown.replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def symbol(name: str) -> str:
    """A coefficient or force as mathematics, `X_uu` with its subscript; another name as text."""
    found = COEFFICIENT.fullmatch(name)
    return literal(name) if found is None else f"${found[1]}_{{{found[2]}}}$"


def finished(axes: "Axes", x: str, y: str, title: str = "") -> None:
    """Titles and grid of one plot."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, fontsize="medium", loc="left")
    axes.grid(alpha=0.3)
    axes.spines[["top", "right"]].set_visible(False)


def logarithmic(axes: "Axes", values: Array) -> None:
    """A logarithmic y axis with plain numbers: 1, 2, 5 where values span few decades."""
    low, high = float(values.min()), float(values.max())
    ends = 10.0**-MARGIN * low, 10.0**MARGIN * high
    shown = [tick for tick in log_ticks(low, high) if ends[0] <= tick <= ends[1]]
    axes.set_yscale("log")
    axes.set_yticks(shown, [f"{tick:g}" for tick in shown])
    axes.set_yticks([], minor=True)


def below(figure: "Figure", axes: Sequence["Axes"], columns: int) -> None:
    """One legend under the figure, with every label once."""
    handles: dict[str, Any] = {}
    for one in axes:
        handles |= dict(zip(*reversed(one.get_legend_handles_labels()), strict=True))
    figure.legend(
        [*handles.values()], [*handles], loc="outside lower center", ncols=columns, frameon=False
    )
