# SPDX-License-Identifier: MIT
"""Position, heading and yaw rate of different rates: each is used where it is new.

The rows of a recording are its positions, each with the heading of its time. Headings that no position
has, and yaw rates of a gyro, are asynchronous measurements; the filter takes all in order of time.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.recording.faults.frozen_poses import poses_held
from seatrial.util.frames import Array, Index, Mask, Stamps, freeze

# of the rows with half a pose, above which position and heading have two rates
TWO_RATES_SHARE = 0.2
HEADING_HOLE = 3.0  # usual steps of the headings; in a longer one the heading is not interpolated
USUAL_PERCENTILE = 90.0  # [%] of the steps
WHOLE = _core.POSITION_PART | _core.HEADING_PART


@dataclass(frozen=True)
class Asynchronous:
    """Asynchronous measurements: headings and yaw rates with stamps of their own."""

    stamps: Stamps  # (m,) [ns], rising
    parts: NDArray[np.int8]  # (m,) HEADING_PART or RATE_PART of the core
    values: Array  # (m,) heading [rad] or yaw rate [rad/s]
    rate_deviation: float = 0.0  # [rad/s] standard deviation of the yaw rates' white noise

    def __post_init__(self) -> None:
        freeze(self, "values")
        freeze(self, "stamps", dtype=np.int64)
        freeze(self, "parts", dtype=np.int8)

    def kept(self, keep: Mask) -> "Asynchronous":
        """Those of a mask (m,)."""
        return replace(
            self, stamps=self.stamps[keep], parts=self.parts[keep], values=self.values[keep]
        )

    def between(self, stamps: Stamps) -> "Asynchronous":
        """Those between the first and the last pose, at stamps (n,)."""
        return self.kept((self.stamps > stamps[0]) & (self.stamps < stamps[-1]))

    def shifted(self, nanoseconds: int) -> "Asynchronous":
        """With later stamps."""
        return replace(self, stamps=self.stamps + nanoseconds)

    def turned(self, angle: float | Array) -> "Asynchronous":
        """With headings that are larger by an angle [rad], or by angles (m,)."""
        heading = self.parts == _core.HEADING_PART
        return replace(self, values=self.values + angle * heading)

    def mirrored(self) -> "Asynchronous":
        """With headings and rates of the opposite sense."""
        return replace(self, values=-self.values)

    def joined(self, other: "Asynchronous | None") -> "Asynchronous":
        """Both, in order of time; this one if there is no other."""
        if other is None:
            return self
        stamps = np.concatenate([self.stamps, other.stamps])
        order = np.argsort(stamps, kind="stable")
        return Asynchronous(
            stamps[order],
            np.concatenate([self.parts, other.parts])[order],
            np.concatenate([self.values, other.values])[order],
            max(self.rate_deviation, other.rate_deviation),
        )


@dataclass(frozen=True)
class Poses:
    """Poses of one recording as sensors gave them."""

    stamps: Stamps  # (n,) [ns], as recorded
    eta: Array  # (n, 3) x, y [m], psi [rad]; NaN where unknown
    parts: NDArray[np.int8] | None = None  # (n,) measured parts; None: all are whole
    asynchronous: Asynchronous | None = None
    # (n,) of the log
    rows: Index = field(default_factory=lambda: np.zeros(0, np.int64))
    remarks: tuple[str, ...] = ()


def joined(
    position_stamps: Stamps, positions: Array, heading_stamps: Stamps, headings: Array
) -> Poses:
    """Poses from positions (n, 2) and headings (m,) that have stamps of their own.

    A heading of the same stamp makes a pose whole. Else the heading of a position is interpolated, for
    everything but the filter.
    """
    good = np.isfinite(headings)
    order = np.flatnonzero(good)[np.argsort(heading_stamps[good], kind="stable")]
    at, psi = heading_stamps[order], np.unwrap(headings[order])
    if len(at) < 2:
        return Poses(position_stamps, np.column_stack([positions, np.full(len(positions), np.nan)]))
    own = np.clip(np.searchsorted(at, position_stamps, side="left"), 0, len(at) - 1)
    matched = at[own] == position_stamps
    # headings at the positions
    origin = at[0]
    seconds = (at - origin).astype(np.float64) * 1e-9
    wanted = (position_stamps - origin).astype(np.float64) * 1e-9
    heading = np.interp(wanted, seconds, psi, left=np.nan, right=np.nan)
    steps = np.diff(seconds)
    hole = HEADING_HOLE * float(np.percentile(steps, USUAL_PERCENTILE))
    after = np.clip(np.searchsorted(seconds, wanted, side="left"), 1, len(seconds) - 1)
    heading[(steps[after - 1] > hole) & ~matched] = np.nan
    heading[matched] = psi[own[matched]]
    # the others are asynchronous
    rest = np.ones(len(at), dtype=bool)
    rest[own[matched]] = False
    parts = np.where(matched, WHOLE, _core.POSITION_PART).astype(np.int8)
    kinds = np.full(int(rest.sum()), _core.HEADING_PART, dtype=np.int8)
    return Poses(
        position_stamps, np.column_stack([positions, heading]), parts,
        Asynchronous(at[rest], kinds, psi[rest]) if rest.any() else None,
    )  # fmt: skip


def split_rates(stamps: Stamps, eta: Array, marked_valid: Mask | None = None) -> Poses:
    """Rows (n, 3) of which some only repeat the position or the heading before, or lack one.

    Where position and heading have one rate, the rows stay as they are, less those that repeat a pose, and
    those that are marked bad in turn with good ones.
    """
    # 1. Rows without a pose of their own.
    rows, remarks = _own_poses(eta, marked_valid)
    # 2. Rows that repeat or lack one part.
    parts = np.split(eta[rows], [2], axis=1)
    fresh = [np.isfinite(part).all(axis=1) & ~poses_held(part) for part in parts]
    half = fresh[0] != fresh[1]
    if half.mean() < TWO_RATES_SHARE or not (fresh[0].any() and fresh[1].any()):
        return Poses(stamps[rows], eta[rows], rows=rows, remarks=tuple(remarks))
    counts = [int(f.sum()) for f in fresh]
    remarks.append(
        f"position and heading have two rates: {counts[0]} new positions and {counts[1]} new headings in "
        f"{len(rows)} rows; each is used where it is new"
    )
    first, second = rows[fresh[0]], rows[fresh[1]]
    found = joined(stamps[first], eta[first, :2], stamps[second], eta[second, 2])
    return replace(found, rows=first, remarks=tuple(remarks))


def _own_poses(eta: Array, marked_valid: Mask | None) -> tuple[NDArray[np.intp], list[str]]:
    """Rows (n, 3) that have a pose of their own, and what is left out."""
    remarks, rows = [], np.arange(len(eta))
    falls = np.zeros(1) if marked_valid is None else np.diff(marked_valid.astype(int)) < 0
    if marked_valid is not None and falls.mean() > TWO_RATES_SHARE:
        bad = f"{100 * np.mean(~marked_valid):.0f} % of the rows are marked bad"
        remarks.append(f"{bad}, in turn with good ones: left out")
        rows = rows[marked_valid]
    held = poses_held(eta[rows])
    if held.any():
        remarks.append(
            f"{100 * held.mean():.0f} % of the rows repeat the pose before (the log has more rows than "
            "poses): each pose counts once"
        )
        rows = rows[~held]
    return rows, remarks


def used_asynchronous(
    asynchronous: Asynchronous, stamps: Stamps, use: NDArray[np.int8], lost: Sequence[int]
) -> Mask:
    """Which (m,) of those between poses lie between two that the filter uses.

    stamps, use (n,): of the poses. lost: uses before which the pose is lost (a gap, a jump).
    """
    after = np.searchsorted(stamps, asynchronous.stamps, side="right")
    return np.asarray((use[after - 1] != 0) & (use[after] != 0) & ~np.isin(use[after], lost))
