# SPDX-License-Identifier: MIT
"""Which axis of a table is up: y in motion capture and game engines, z elsewhere."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.inspection.proposal.columns.names import Kind
from seatrial.inspection.proposal.columns.signals import Heading, Position
from seatrial.io.columns import TableSeen
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array
from seatrial.util.quaternion import rotated

VERTICAL_STEPS, VERTICAL_SHARE = 10.0, 0.1  # of ranges: z over y, z over x, where y is up
LEAST_TURNED = 0.02  # of an axis that lies: 1 - length of its mean in the body, 11 deg of yaw
UPRIGHT = 0.2  # of that of the other axis, at most, of the axis that is up
STEEP = 0.9  # vertical part of an axis that has no heading: 64 deg from level
Q_CONJUGATE = np.array([-1.0, -1.0, -1.0, 1.0])


def upright(position: Position, headings: Sequence[Heading]) -> Position:
    """The position in a plane with z up, where a quaternion shows which axis is up; else as it is.

    y up: x and -z, which with y make right-handed axes; a quaternion z, x, y, w then has the yaw about y.
    """
    third = _third(position)
    if position.kinds[0] is not Kind.X or third is None:
        return position
    position = replace(position, height=third)
    beside = [h for h in headings if h.table is position.table and len(h.names) > 1]
    known = y_is_up(position.table, beside[0].names) if beside else None
    if known is False:
        return replace(position, still="")
    if not beside or not (known or _ranges_show(position, third)):
        return position
    table, (x, y) = position.table, position.names
    spans = [_range(table, name) for name in (x, third, y)]
    return replace(
        position, names=(x, third), signs=(1, -1), y_up=True, height=y, still="",
        why=f"names; y is up: {x}, -{third} and {y} range over {', '.join(f'{span:.3g}' for span in spans)}",
    )  # fmt: skip


def refuse_y_up(position: Position) -> None:
    """Raise RecordingError where y hardly moves and the third coordinate does: y is up."""
    third = _third(position)
    if third is None or not _ranges_show(position, third):
        return
    second = position.names[1]
    y, z = (_range(position.table, name) for name in (second, third))
    raise RecordingError(
        f"{position.table.view.path}: {second} ranges over {y:.2g} m, {third} over {z:.2g} m: y is up in "
        "this log, and the boat turns about y. Log its quaternion, export it with z up, or name other columns "
        "with --pose"
    )


def about_y(heading: Heading, position: Position) -> Heading:
    """The heading about y where y is up."""
    if not position.y_up or len(heading.names) == 1 or heading.table is not position.table:
        return heading
    x, y, z, w = heading.names
    return replace(heading, names=(z, x, y, w))


def refuse_steep(heading: Heading) -> None:
    """Raise RecordingError where the axis whose heading a quaternion gives points up or down."""
    if len(heading.names) == 1:
        return
    q = _quaternions(heading.table, heading.names)
    ahead = rotated(q, np.tile([1.0, 0.0, 0.0], (len(q), 1)))
    upward = float(np.median(np.abs(ahead[:, 2]))) if len(q) else 0.0
    if upward > STEEP:
        raise RecordingError(
            f"{heading.table.view.path}: by {', '.join(heading.names)} the axis of the heading is "
            f"{np.degrees(np.arcsin(min(upward, 1.0))):.0f} deg from level, and has none; set the axes of the "
            "body to those of the room while the boat lies level"
        )


def y_is_up(table: TableSeen, quaternion: Sequence[str]) -> bool | None:
    """Whether the body turns about y, rather than about z, by its quaternion x, y, z, w; None: it hardly turns."""
    q = _quaternions(table, quaternion)
    if not len(q):
        return None
    # an axis of the world that is up stands still in the body
    y, z = (1.0 - float(np.linalg.norm(_mean_in_body(q, axis))) for axis in np.eye(3)[1:])
    if max(y, z) < LEAST_TURNED or min(y, z) > UPRIGHT * max(y, z):
        return None
    return y < z


def _quaternions(table: TableSeen, names: Sequence[str]) -> Array:
    """Those (n, 4) that are rotations."""
    q = np.column_stack([table.numbers(name) for name in names])
    return np.asarray(q[np.isfinite(q).all(axis=1) & (np.abs(q).max(axis=1, initial=0.0) > 0)])


def _mean_in_body(q: Array, axis: Array) -> Array:
    return np.asarray(rotated(q * Q_CONJUGATE, np.tile(axis, (len(q), 1))).mean(axis=0))


def _third(position: Position) -> str | None:
    """The column of z beside those of x and y."""
    second = position.names[1]
    name = re.sub(r"[yY](?!.*[yY])", lambda m: chr(ord(m[0]) + 1), second)
    known = {c.name for c in position.table.view.columns if c.changes and c.least is not None}
    return name if name != second and name in known else None


def _ranges_show(position: Position, third: str) -> bool:
    """Whether y hardly moves and the third coordinate does."""
    if position.still != position.names[1]:
        return False
    x, y, z = (_range(position.table, name) for name in (*position.names, third))
    return z > max(VERTICAL_STEPS * y, VERTICAL_SHARE * x)


def _range(table: TableSeen, name: str) -> float:
    values = table.numbers(name)
    return float(np.ptp(values[np.isfinite(values)]))
