# SPDX-License-Identifier: MIT
"""Plot of a recording: track, velocities, commands, and what is left out."""

from typing import TYPE_CHECKING

import numpy as np

from seatrial.display.canvas import GREY, SMALL, drawn_on, finished, literal, symbol
from seatrial.recording.faults.pose_faults import COMMANDS_UNKNOWN, FaultKind
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.recording.velocity import motion
from seatrial.report.figures.base import BLUE, CYCLE, GREEN, ORANGE, RED, SKY
from seatrial.util.frames import AXES, SPEED_UNITS, SYMBOLS, Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, ROW_HEIGHT, HEAD_HEIGHT = 11.0, 1.3, 1.0  # [inch]
LEAST_HEIGHT = 5.0  # [inch]
MOST_SIGNALS = 12  # in one plot
FEW_SIGNALS = 6  # in one column of a legend
STILL = 1e-12  # [m/s], [rad/s] velocity of an axis that never moves


def plot_recording(recording: Recording, figure: "Figure | None" = None) -> "Figure":
    """Track on the left; velocities, commands and scales over time on the right."""
    moved = motion(recording)
    shown = [i for i in range(3) if np.nanmax(np.abs(moved.nu[:, i]), initial=0.0) > STILL]
    signals = {"commands": recording.commands}
    if recording.scales is not None and len(recording.scales.stamps):
        signals["scales"] = recording.scales
    rows = [*(SYMBOLS[i] for i in shown), *signals]
    canvas = drawn_on(figure, WIDTH, max(LEAST_HEIGHT, HEAD_HEIGHT + ROW_HEIGHT * len(rows)))
    axes = canvas.subplot_mosaic([["track", row] for row in rows], width_ratios=(4, 5))
    canvas.suptitle(
        f"{literal(recording.name, 80)}: {recording.duration:.1f} s, {len(recording.t)} poses"
    )
    _draw_track(axes["track"], recording)
    for i in shown:
        own = axes[SYMBOLS[i]]
        own.plot(recording.t, moved.nu[:, i], color=BLUE, linewidth=0.9, label="five-point stencil")
        finished(own, "", f"{SYMBOLS[i]} [{SPEED_UNITS[i]}]", f"{AXES[i]} velocity")
    for name, signal in signals.items():
        _draw_signals(axes[name], recording, signal)
        finished(axes[name], "", f"{name}\n[command units]" if name == "commands" else name)
    last = rows[-1]
    for row in rows:
        _draw_faults(axes[row], recording, labelled=row == rows[0])
        axes[row].set_xlim(0.0, recording.duration)
        if row != last:
            axes[row].sharex(axes[last])
            axes[row].tick_params(labelbottom=False)
    axes[last].set_xlabel("time [s]")
    return canvas


def _draw_track(axes: "Axes", recording: Recording) -> None:
    """Usable poses as a line that gaps and jumps break, the others as crosses."""
    eta = recording.eta
    usable, rejected = np.flatnonzero(recording.valid), ~recording.valid
    breaks = np.flatnonzero(np.diff(recording.segment[usable])) + 1
    line = np.insert(eta[usable, :2], breaks, np.nan, axis=0)
    axes.plot(line[:, 0], line[:, 1], color=BLUE, linewidth=1.0, label="track")
    excluded = eta[rejected, :2][np.isfinite(eta[rejected, :2]).all(axis=1)]
    if len(excluded):
        axes.plot(
            excluded[:, 0],
            excluded[:, 1],
            "x",
            color=ORANGE,
            markersize=4,
            label=f"left out ({len(excluded)} poses)",
        )
    if len(usable):
        _draw_end(axes, eta[usable[0]], "o", GREEN, "start")
        _draw_end(axes, eta[usable[-1]], "s", RED, "end")
    axes.set_aspect("equal", anchor="N")
    finished(axes, "x [m]", "y [m]")
    axes.legend(fontsize=SMALL, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2)


def _draw_end(axes: "Axes", pose: Array, mark: str, colour: str, label: str) -> None:
    axes.plot(pose[0], pose[1], mark, color=colour, markersize=7, label=label)


def _draw_signals(axes: "Axes", recording: Recording, signal: Signal) -> None:
    """Each value holds until the next."""
    t = recording.seconds(signal.stamps)
    for i, name in enumerate(signal.names[:MOST_SIGNALS]):
        axes.step(t, signal.values[:, i], where="post", color=CYCLE[i % len(CYCLE)], linewidth=0.9,
                  linestyle="-" if i < len(CYCLE) else "--", label=symbol(name))  # fmt: skip
    count = min(len(signal.names), MOST_SIGNALS)
    _legend_beside(axes, 1 + (count - 1) // FEW_SIGNALS)


def _legend_beside(axes: "Axes", columns: int = 1) -> None:
    axes.legend(fontsize=SMALL, loc="center left", bbox_to_anchor=(1.0, 0.5), ncols=columns)


def _draw_faults(axes: "Axes", recording: Recording, *, labelled: bool) -> None:
    """Intervals without usable poses or commands."""
    said: set[str] = set()
    for fault in recording.faults:
        name, colour = _kind(fault.kind)
        label = name if labelled and name not in said else "_"
        said.add(name)
        axes.axvspan(
            fault.start, fault.end, color=colour, alpha=0.25, linewidth=1.0, label=label, zorder=0
        )
    if labelled:
        _legend_beside(axes)


def _kind(kind: FaultKind) -> tuple[str, str]:
    if kind is FaultKind.EXCLUDED:
        return "excluded", GREEN
    return ("no commands", SKY) if kind in COMMANDS_UNKNOWN else ("poses left out", GREY)
