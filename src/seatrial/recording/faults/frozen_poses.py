# SPDX-License-Identifier: MIT
"""Poses that repeat: frozen while the boat moves, or held in a log with more rows than poses."""

import numpy as np

from seatrial.util.frames import Array, Mask

STUCK_ROWS = 5  # least length of a run in which the position alone repeats
STUCK_CATCH_UP = 3.0  # times the usual step, least step of a position at the end of such a run
USUAL_STEP = 95.0  # percentile of the steps of a position that moves
FROZEN_CATCH_UP = 1.5  # times the step that follows, least step at the end of a frozen run
FEW_POSES = 10  # below it a log with more rows than poses is not recognised
HELD_SHARE = 0.2  # of the poses that fill two or more rows in a log with more rows than poses
HELD_PERCENTILE = 90.0  # [%] of the rows that a pose fills, for the usual number
HELD_UNEVENNESS = 1.6  # medians (plus 1), limit of that number


def poses_held(eta: Array) -> Mask:
    """Rows (n,) that repeat the last pose of (n, 3): a log with more rows than poses.

    None where repeats are rare or in long runs (a boat at rest, a frozen tracker). In a log with repeats
    a boat may also rest: of runs longer than usual one row in two usual lengths stays.
    """
    repeats = _repeats(eta)
    first = np.flatnonzero(~repeats)
    rows = np.diff(np.append(first, len(eta)))
    usual = float(np.percentile(rows, HELD_PERCENTILE, method="lower"))
    if (
        len(rows) < FEW_POSES
        or np.mean(rows > 1) < HELD_SHARE
        or usual > HELD_UNEVENNESS * float(np.median(rows)) + 1.0
    ):
        return np.zeros(len(eta), dtype=bool)
    since = np.arange(len(eta)) - first[np.cumsum(~repeats) - 1]
    return np.asarray(since % int(2 * usual) != 0)


def frozen(eta: Array) -> Mask:
    """Samples that exactly repeat the one before while the boat moved.

    A boat at rest repeats, too, in a recording without noise. So a run counts only if the step at its
    end catches up: more than `FROZEN_CATCH_UP` times the step that follows.
    """
    repeats = _repeats(eta)
    found = np.zeros(len(eta), dtype=bool)
    for first, last in runs(repeats):
        if last + 2 >= len(eta):
            continue
        catch_up = np.abs(eta[last + 1] - eta[last])
        after = np.abs(eta[last + 2] - eta[last + 1])
        if np.any((catch_up > FROZEN_CATCH_UP * after) & (catch_up > 0)):
            found[first : last + 1] = True
    return found


def stuck(eta: Array) -> Mask:
    """Positions, or headings, that repeat exactly while the other changes, and then catch up in one step.

    A receiver without a fix, a compass that hangs. Rounded positions of a slow boat repeat, too; their next step
    is a usual one.
    """
    heading = np.column_stack([np.cos(eta[:, 2]), np.sin(eta[:, 2])])
    return _part_stuck(eta[:, :2]) | _part_stuck(heading)


def _part_stuck(part: Array) -> Mask:
    """The same of positions, or of the heading's cosine and sine (n, 2)."""
    repeats = _repeats(part)
    steps = np.hypot(*np.diff(part, axis=0).T)
    found = np.zeros(len(part), dtype=bool)
    moving = steps[steps > 0]
    usual = float(np.percentile(moving, USUAL_STEP)) if len(moving) else 0.0
    for first, last in runs(repeats):
        caught_up = last < len(steps) and steps[last] > STUCK_CATCH_UP * usual
        if last - first + 1 >= STUCK_ROWS and caught_up:
            found[first : last + 1] = True
    return found


def _repeats(eta: Array) -> Mask:
    """Rows (n,) exactly equal to the one before."""
    return np.concatenate([[False], np.all(eta[1:] == eta[:-1], axis=1)])


def runs(mask: Mask) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    edges = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    return list(zip(first.tolist(), last.tolist(), strict=True))
