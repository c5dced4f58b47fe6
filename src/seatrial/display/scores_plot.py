# SPDX-License-Identifier: MIT
"""Plot of scores: error over horizon, beside noise floor, expected error and constant velocity."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from seatrial.display.canvas import GREY, below, drawn_on, finished, literal, logarithmic
from seatrial.evaluation.scores import AxisScore, HorizonScore, Scored, Scores, Start, main_start
from seatrial.report.figures.base import BLUE, GREEN, ORANGE, SKY
from seatrial.util.errors import ModelError
from seatrial.util.frames import AXES, ERROR_UNITS, SYMBOLS, Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 3.7, 4.2  # [inch] of one velocity's plot
MOST_RECORDINGS = 12  # drawn beside their pooled error
AT_CONSTANT = 1e-12  # [m/s], [rad/s] error of constant velocity of an axis that never moves


def plot_scores(scores: Scores, figure: "Figure | None" = None) -> "Figure":
    """One plot for each velocity. Raises ModelError where there is no score."""
    start = main_start([one for row in scores.recordings for one in row.horizons])
    whole, parts = _scored(scores, start)
    axes_shown = [i for i, symbol in enumerate(SYMBOLS) if _moves(whole, symbol)]
    if not axes_shown:
        raise ModelError(f"{scores.model}: no scores to plot; validate it with a recording")
    canvas = drawn_on(figure, WIDTH * len(axes_shown), HEIGHT)
    grid = canvas.subplots(1, len(axes_shown), squeeze=False)[0]
    for axes, axis in zip(grid, axes_shown, strict=True):
        _draw(axes, axis, whole, parts)
    count = len(parts) or 1
    names = scores.recordings[0].recording if len(scores.recordings) == 1 else f"{count} recordings"
    canvas.suptitle(f"{literal(scores.model, 60)}: error ahead, {literal(names, 60)}")
    below(canvas, list(grid), 5)
    return canvas


def _scored(scores: Scores, start: Start) -> tuple[list[Scored], list[list[Scored]]]:
    """All recordings that judge the model together, by horizon; and each of them, where there are several."""
    unseen = [row for row in scores.recordings if not row.seen] or scores.recordings
    each: list[list[Scored]] = []
    for row in unseen:
        own: list[Scored] = sorted(
            (one for one in row.horizons if one.start == start), key=lambda one: one.horizon
        )
        if not own and row.scores:  # a file of an older version: the chosen horizon only
            own = [HorizonScore(scores.horizon, 1, start, row.predictions, row.scores)]
        each.append(own)
    pooled: list[Scored] = sorted(
        (one for one in scores.pooled if one.start == start), key=lambda one: one.horizon
    )
    if len(each) == 1 or not pooled:
        return (each[0] if each else []), (each if len(each) > 1 else [])
    return pooled, each


def _moves(scored: Sequence[Scored], symbol: str) -> bool:
    """Whether the boat moves along this axis, and there is a score."""
    found = [one.scores[symbol] for one in scored if symbol in one.scores]
    return any(np.isfinite(one.rms) and one.stays_constant > AT_CONSTANT for one in found)


def _draw(
    axes: "Axes", axis: int, whole: Sequence[Scored], parts: Sequence[Sequence[Scored]]
) -> None:
    symbol, (name, scale) = SYMBOLS[axis], ERROR_UNITS[axis]
    found = [(one.horizon, one.scores[symbol]) for one in whole if symbol in one.scores]
    t = np.array([horizon for horizon, _ in found])
    scores = [score for _, score in found]
    for i, part in enumerate(parts[:MOST_RECORDINGS]):
        own = [(one.horizon, one.scores[symbol].rms) for one in part if symbol in one.scores]
        if own:
            x, y = np.array(own).T
            label = "each recording" if i == 0 else "_"
            axes.plot(x, scale * y, color=SKY, linewidth=0.8, label=label, zorder=1)
    constant = scale * np.array([one.stays_constant for one in scores])
    axes.plot(t, constant, "s--", color=ORANGE, markersize=4, label="constant velocity")
    expected = np.array(
        [np.nan if one.expected_rms is None else one.expected_rms for one in scores]
    )
    if np.isfinite(expected).any():
        axes.plot(t, scale * expected, "^:", color=GREEN, markersize=4, label="expected error")
    floor = scale * np.array([one.floor for one in scores])
    axes.plot(t, floor, "-", color=GREY, linewidth=1.0, label="noise floor")
    rms = scale * np.array([one.rms for one in scores])
    axes.errorbar(
        t, rms, yerr=_whiskers(scores, scale), fmt="o-", color=BLUE, capsize=3, markersize=5,
        label="model (95 % interval)", zorder=3,
    )  # fmt: skip
    positive = np.concatenate([rms, constant, floor])
    if (positive > 0).all():
        logarithmic(axes, positive)
    if len(t) > 1:
        axes.set_xscale("log")
    axes.set_xticks(t, [f"{x:g}" for x in t.tolist()])
    axes.set_xticks([], minor=True)
    finished(axes, "horizon [s]", f"RMS error of {symbol} [{name}]", AXES[axis])


def _whiskers(scores: Sequence[AxisScore], scale: float) -> Array:
    """Lengths (2, n) of the 95 % intervals, down and up; 0 where there is none."""
    ends = np.array([one.rms_interval or (one.rms, one.rms) for one in scores])
    rms = np.array([one.rms for one in scores])
    return np.asarray(scale * np.maximum([rms - ends[:, 0], ends[:, 1] - rms], 0.0))
