# SPDX-License-Identifier: MIT
"""The steps in which coordinates and headings move: numbers that were rounded on their way into the log."""

import numpy as np

from seatrial import _core
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps

FEW_ROWS = 50
LEAST_STEPS_PERCENTILE = 10.0  # [%] of the steps between the values that occur: the resolution
COARSE_SHARE = 0.3  # of the larger range, step of a coordinate from which nothing can be identified
HELD_SHARE = 0.5  # of the rows that repeat a coordinate while the other moves: its step shows
RANGE = (5.0, 95.0)  # [%] percentiles of a coordinate
# of the positions, on lines between their neighbours, where they are interpolated
ON_LINES_SHARE = 0.6
CLEAR_OF_DIGITS = 10.0  # times the digits of the log, least step and least bend that count
FEW_BENDS = 10
ROUNDED = 10.0 ** -np.arange(7)  # digits of degrees or of radians that a log may have


def resolution(values: Array) -> float:
    """The step (>= 0) in which a coordinate (n,) moves: between values that occur, next to each other."""
    levels = np.unique(values[np.isfinite(values)])
    if len(levels) < 2:
        return 0.0
    return float(np.percentile(np.diff(levels), LEAST_STEPS_PERCENTILE))


def coarse_position(name: str, position: Array) -> str:
    """What to say of positions (n, 2) [m], as logged, that are rounded coarsely; else nothing.

    Raises RecordingError where a step is so large that nothing can be identified from that coordinate.
    """
    given = position[np.isfinite(position).all(axis=1)]
    if len(given) < FEW_ROWS:
        return ""
    given = given[np.concatenate([[True], np.any(np.diff(given, axis=0) != 0, axis=1)])]
    if len(given) < 2:
        return ""
    steps = [resolution(given[:, i]) for i in range(2)]
    ranges = np.ptp(np.percentile(given, RANGE, axis=0), axis=0)
    held = [float(np.mean(np.diff(given[:, i]) == 0)) for i in range(2)]
    text = f"x moves in steps of {steps[0]:.2g} m, y in steps of {steps[1]:.2g} m"
    cause = (
        "coordinates of a large map lose their digits as 32-bit floats or with few digits printed"
    )
    largest = float(ranges.max())
    moves = [h < 1.0 for h in held]
    if any(s > COARSE_SHARE * largest and m for s, m in zip(steps, moves, strict=True)) and largest:
        raise RecordingError(
            f"{name}: {text}, and the boat moves within {largest:.2g} m: {cause}; log them as 64-bit floats, "
            "or less a fixed origin"
        )
    if any(h > HELD_SHARE and m and s > 0 for h, s, m in zip(held, steps, moves, strict=True)):
        return (
            f"{text}, more than the boat moves between two poses: {cause}; standard errors count the "
            "rounding as noise"
        )
    return ""


def interpolated_position(stamps: Stamps, position: Array) -> str:
    """The doubt where positions (n, 2) [m] lie on straight lines between some of them; else nothing.

    A logger or a script fills the rows between the fixes of a slow receiver. stamps: (n,) [ns].
    """
    good = np.isfinite(position).all(axis=1)
    t, p = (stamps[good] - stamps[0]) * 1e-9, position[good]
    if len(t) < FEW_ROWS or np.any(np.diff(t) <= 0):
        return ""
    # 1. How far each position is from the line through its neighbours, by its time.
    share = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
    off = np.linalg.norm(p[1:-1] - (1.0 - share) * p[:-2] - share * p[2:], axis=1)
    step = np.linalg.norm(p[2:] - p[:-2], axis=1)
    digits = 3.0 * max(resolution(p[:, 0]), resolution(p[:, 1]))
    # 2. Of those that move: most on the line to the digits of the log, the others far from it.
    moving = step > CLEAR_OF_DIGITS * digits
    bent = off[moving & (off > digits)]
    if not 0 < len(bent) < (1.0 - ON_LINES_SHARE) * moving.sum() or len(bent) < FEW_BENDS:
        return ""
    if float(np.median(bent)) < CLEAR_OF_DIGITS * digits:
        return ""
    rows = moving.sum() / len(bent)
    return (
        f"only about every {rows:.0f}th position is measured; the others were interpolated, as they lie on "
        "straight lines. The boat did not move so. Log the receiver's own positions at their own stamps"
    )


def heading_step(recording: Recording) -> float:
    """The step [rad] to which headings were rounded, in degrees or radians; 0: none is visible.

    Only a step that is less than the heading turns from pose to pose: rounding errors are white then.
    """
    psi, own = recording.eta[recording.valid, 2], recording.asynchronous
    if own is not None:
        psi = own.values[own.parts == _core.HEADING_PART]
    turned = np.diff(psi)
    if not len(turned):
        return 0.0
    for step in sorted([*ROUNDED, *np.radians(ROUNDED)], reverse=True):
        visible = step < np.median(np.abs(turned))
        if visible and _on_grid(psi[:100], step) and _on_grid(psi, step):
            return float(step)
    return 0.0


def _on_grid(values: Array, step: float) -> bool:
    """Whether values (n,) are whole steps apart."""
    steps = (values - values[0]) / step
    return bool(np.abs(steps - np.round(steps)).max() < 1e-3)
