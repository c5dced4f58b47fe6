# SPDX-License-Identifier: MIT
"""A recording in memory: raw, unsynchronised, in forward-left-up axes, with its faults masked."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial.errors import RecordingError
from seatrial.frames import Array, frozen_array

Stamps = NDArray[np.int64]
Mask = NDArray[np.bool_]

GAP_FACTOR = 2.5  # a gap is longer than this many median periods
JUMP_SPREADS = 10.0  # a jump's rate is off its neighbours by this many robust spreads,
JUMP_USUAL = 5.0  # by this many times the 90th percentile of all steps,
JUMP_SPEED = 0.3  # and by this share of the 90th percentile of the boat's speed
LEVER = 0.25  # [m] by which speed and yaw rate are compared
EXCURSION = 1.5  # [s] a shorter stay between two jumps is a false match


class FaultKind(str, Enum):
    """What can be wrong with poses, and what was done about it."""

    MARKED = "marked bad in the recording: left out"
    NOT_FINITE = "not a number: left out"
    STAMP = "stamp not after the one before: left out"
    FROZEN = "frozen while the boat moved: left out"
    EXCURSION = "jumped away and back: left out"
    JUMP = "jumped for good: not bridged"
    GAP = "no poses: not bridged"


@dataclass(frozen=True)
class Fault:
    """One stretch of bad poses."""

    kind: FaultKind
    start: float  # [s] from the recording's start
    end: float  # [s]
    samples: int


@dataclass(frozen=True)
class Signal:
    """Rows of values with integer stamps; a row holds until the next."""

    names: tuple[str, ...]
    stamps: Stamps  # (n,) [ns], rising
    values: Array  # (n, names)

    def __post_init__(self) -> None:
        object.__setattr__(self, "stamps", frozen_array(self.stamps, np.int64))
        object.__setattr__(self, "values", frozen_array(self.values))
        if self.values.shape != (len(self.stamps), len(self.names)):
            raise RecordingError(
                f"signal {', '.join(self.names)}: {len(self.stamps)} stamps but values of shape "
                f"{self.values.shape}"
            )
        if np.any(np.diff(self.stamps) <= 0):
            raise RecordingError(f"signal {', '.join(self.names)}: stamps must rise")

    def cut(self, start: int, end: int) -> "Signal":
        """Rows in [start, end) [ns], with the row that holds at the start moved to it."""
        first = int(np.searchsorted(self.stamps, start, side="right")) - 1
        keep = (self.stamps >= start) & (self.stamps < end)
        stamps, values = self.stamps[keep], self.values[keep]
        if first >= 0 and self.stamps[first] < start:
            stamps = np.concatenate([[start], stamps])
            values = np.concatenate([self.values[first : first + 1], values])
        return Signal(self.names, stamps, values)


@dataclass(frozen=True)
class Source:
    """The file that something came from."""

    name: str
    sha256: str


@dataclass(frozen=True)
class Recording:
    """Poses and commands as recorded, in forward-left-up axes and SI units."""

    name: str
    stamps: Stamps  # (n,) of the poses [ns], rising
    eta: Array  # (n, 3) x, y [m], psi [rad] unwrapped
    valid: Mask  # (n,) poses that may be used
    segment: NDArray[np.int64]  # (n,) number of the stretch between gaps and jumps
    commands: Signal
    scales: Signal | None
    faults: tuple[Fault, ...] = ()
    sources: tuple[Source, ...] = ()

    def __post_init__(self) -> None:
        for name, dtype in (
            ("stamps", np.int64),
            ("eta", np.float64),
            ("valid", np.bool_),
            ("segment", np.int64),
        ):
            object.__setattr__(self, name, frozen_array(getattr(self, name), dtype))
        if int(self.valid.sum()) < 2:
            raise RecordingError(
                f"{self.name}: {int(self.valid.sum())} usable poses of {len(self.stamps)}; "
                "check the pose columns and what marks them valid"
            )
        if len(self.commands.stamps) == 0:
            raise RecordingError(
                f"{self.name}: no commands; record them for the whole run and name them "
                "in the vehicle file"
            )

    @cached_property
    def origin(self) -> int:
        """Stamp of the first pose [ns]: the zero of `t`."""
        return int(self.stamps[0])

    @cached_property
    def t(self) -> Array:
        """Pose times (n,) [s] from the recording's start."""
        return self.seconds(self.stamps)

    @cached_property
    def period(self) -> float:
        """Median time between poses [s]."""
        return float(np.median(np.diff(self.t)))

    @property
    def duration(self) -> float:
        """From the first to the last pose [s]."""
        return float(self.t[-1])

    def seconds(self, stamps: Stamps) -> Array:
        """Stamps [ns] as seconds from the recording's start."""
        return (stamps - self.origin).astype(np.float64) * 1e-9

    def cut(self, start: float | None = None, end: float | None = None) -> "Recording":
        """The part from `start` to `end` [s] from the recording's start."""
        begin = self.origin if start is None else self.origin + round(start * 1e9)
        stop = int(self.stamps[-1]) + 1 if end is None else self.origin + round(end * 1e9)
        keep = (self.stamps >= begin) & (self.stamps < stop)
        if int(keep.sum()) < 2:
            raise RecordingError(
                f"{self.name}: no poses between {start or 0.0:g} s and "
                f"{self.duration if end is None else end:g} s; it lasts {self.duration:.1f} s"
            )
        shift = self.seconds(self.stamps[keep])[0]
        kept = tuple(
            replace(f, start=max(0.0, f.start - shift), end=f.end - shift)
            for f in self.faults
            if f.end >= shift and f.start <= self.seconds(self.stamps[keep])[-1]
        )
        return replace(
            self,
            stamps=self.stamps[keep],
            eta=self.eta[keep],
            valid=self.valid[keep],
            segment=self.segment[keep],
            commands=self.commands.cut(begin, stop),
            scales=None if self.scales is None else self.scales.cut(begin, stop),
            faults=kept,
        )


def make_recording(
    name: str,
    stamps: Stamps,
    eta: Array,
    commands: Signal,
    *,
    scales: Signal | None = None,
    marked_valid: Mask | None = None,
    sources: Sequence[Source] = (),
) -> Recording:
    """A recording from raw poses: heading unwrapped, faults found and masked.

    stamps (n,) [ns]; eta (n, 3) x, y [m], psi [rad], forward-left-up.
    """
    if len(stamps) < 2:
        raise RecordingError(
            f"{name}: {len(stamps)} poses; at least a few seconds of them are needed"
        )
    bad: dict[FaultKind, Mask] = {}
    if marked_valid is not None:
        bad[FaultKind.MARKED] = ~marked_valid
    bad[FaultKind.NOT_FINITE] = np.asarray(~np.isfinite(eta).all(axis=1))
    bad[FaultKind.STAMP] = stamps <= np.concatenate(
        [[stamps[0] - 1], np.maximum.accumulate(stamps)[:-1]]
    )
    usable = np.asarray(np.all([~mask for mask in bad.values()], axis=0), dtype=np.bool_)
    if int(usable.sum()) < 2:
        worst = max(bad, key=lambda k: int(bad[k].sum()))
        raise RecordingError(
            f"{name}: {int(usable.sum())} usable poses of {len(stamps)}, most {worst.value}; "
            "check the pose columns and what marks them valid"
        )
    bad[FaultKind.FROZEN] = np.zeros(len(stamps), dtype=bool)
    frozen = _frozen(eta[usable])
    bad[FaultKind.FROZEN][np.flatnonzero(usable)[frozen]] = True
    usable &= ~bad[FaultKind.FROZEN]

    index = np.flatnonzero(usable)
    whole = np.array(eta, dtype=float)
    whole[index, 2] = np.unwrap(whole[index, 2])
    t = (stamps - stamps[0]).astype(float) * 1e-9
    jumps = _jumps(t[index], whole[index])
    excursion, lasting = _excursions(t[index], jumps)
    bad[FaultKind.EXCURSION] = np.zeros(len(stamps), dtype=bool)
    bad[FaultKind.EXCURSION][index[excursion]] = True

    faults = [f for kind, mask in bad.items() for f in _stretches(kind, mask, t)]
    good = index[~excursion]
    period = float(np.median(np.diff(t[good]))) if len(good) > 1 else 0.0
    gaps = np.diff(t[good]) > GAP_FACTOR * period
    faults += [
        Fault(FaultKind.GAP, float(t[good[i]]), float(t[good[i + 1]]), 0)
        for i in np.flatnonzero(gaps)
    ]
    faults += [
        Fault(FaultKind.JUMP, float(t[index[i]]), float(t[index[i + 1]]), 0) for i in lasting
    ]
    ends = gaps.copy()
    ends[[int(np.searchsorted(good, index[i + 1])) - 1 for i in lasting]] = True
    kept = np.sort(np.flatnonzero(~bad[FaultKind.STAMP]))
    segment = np.zeros(len(stamps), dtype=np.int64)
    segment[good[1:]] = np.cumsum(ends)
    valid = np.zeros(len(stamps), dtype=bool)
    valid[good] = True
    return Recording(
        name, stamps[kept], whole[kept], valid[kept], segment[kept], commands, scales,
        tuple(sorted(faults, key=lambda f: f.start)), tuple(sources),
    )  # fmt: skip


def rising(stamps: Stamps) -> Mask:
    """Rows that are not before an earlier one; of rows with one stamp, the last."""
    index = np.flatnonzero(stamps >= np.maximum.accumulate(stamps))
    last = np.append(np.diff(stamps[index]) > 0, True)
    keep = np.zeros(len(stamps), dtype=bool)
    keep[index[last]] = True
    return keep


def _frozen(eta: Array) -> Mask:
    """Samples that repeat the one before exactly although the boat moved on meanwhile.

    A boat at rest repeats too, in a recording without noise; so a run counts only where the step
    that ends it catches up: more than 1.5 times the step that follows.
    """
    repeats = np.concatenate([[False], np.all(eta[1:] == eta[:-1], axis=1)])
    frozen = np.zeros(len(eta), dtype=bool)
    for first, last in _runs(repeats):
        if last + 2 >= len(eta):
            continue
        catch_up = np.abs(eta[last + 1] - eta[last])
        after = np.abs(eta[last + 2] - eta[last + 1])
        if np.any((catch_up > 1.5 * after) & (catch_up > 0)):
            frozen[first : last + 1] = True
    return frozen


def _jumps(t: Array, eta: Array) -> list[int]:
    """Steps i -> i + 1 at a rate that neither the step before nor the one after comes near.

    A boat's rate changes little by little; a false match makes one step, and one back.
    """
    if len(t) < 7:
        return []
    rate = np.diff(eta, axis=0) / np.diff(t)[:, None]
    usual = np.percentile([np.hypot(rate[:, 0], rate[:, 1]), np.abs(rate[:, 2])], 90, axis=1)
    # an axis that rests is measured by the other: a point of the hull moves by both
    least = JUMP_SPEED * np.array(
        [max(usual[0], usual[1] * LEVER), max(usual[1], usual[0] / LEVER)]
    )
    found: set[int] = set()
    for parts, floor in ((rate[:, :2], least[0]), (rate[:, 2:], least[1])):
        change = np.linalg.norm(np.diff(parts, axis=0), axis=1)
        apart = np.minimum(np.append(np.inf, change), np.append(change, np.inf))
        spread = 1.4826 * float(np.median(apart))
        limit = max(JUMP_SPREADS * spread, JUMP_USUAL * float(np.percentile(apart, 90)), floor)
        found |= set(np.flatnonzero(apart > limit).tolist()) if limit > 0 else set()
    return sorted(found)


def _excursions(t: Array, jumps: Sequence[int]) -> tuple[Mask, list[int]]:
    """Samples between two jumps close in time, and the jumps that lead somewhere for good."""
    away = np.zeros(len(t), dtype=bool)
    lasting: list[int] = []
    i = 0
    while i < len(jumps):
        j = i + 1
        while j < len(jumps) and t[jumps[j]] - t[jumps[i] + 1] < EXCURSION:
            j += 1
        if j - i >= 2:
            away[jumps[i] + 1 : jumps[j - 1] + 1] = True
        else:
            lasting.append(jumps[i])
        i = j
    return away, lasting


def _runs(mask: Mask) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    edges = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    return list(
        zip(
            np.flatnonzero(edges == 1).tolist(),
            (np.flatnonzero(edges == -1) - 1).tolist(),
            strict=True,
        )
    )


def _stretches(kind: FaultKind, mask: Mask, t: Array) -> list[Fault]:
    return [Fault(kind, float(t[a]), float(t[b]), b - a + 1) for a, b in _runs(mask)]
