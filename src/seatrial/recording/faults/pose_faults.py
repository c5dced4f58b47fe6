# SPDX-License-Identifier: MIT
"""Pose faults: invalid and frozen samples, false matches, jumps, gaps. Detected, named, masked."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from seatrial.recording.faults.frozen_poses import frozen, runs, stuck
from seatrial.recording.faults.pose_jumps import excursions, jumps, reversals
from seatrial.recording.other_clock import (
    OtherEpochError,
    OtherZoneError,
    other_epoch,
    other_unit,
    other_zone,
    same_length,
    zones_apart,
)
from seatrial.recording.timing import (
    SHORTEST_SILENCE,
    longest_rising,
    only_changes,
    regular_period,
    silence_length,
)
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Index, Mask, Stamps

TWO_PLACES_POSES = 20  # fewest poses that show two mixed sources
TWO_PLACES_SHARE = 0.12  # of the steps that leap where two sources of poses are mixed
TWO_PLACES_STEPS = 20.0  # usual steps, least size of such a leap
TWO_PLACES_BACK = 0.7  # least cosine between a leap and the reverse of the one before
TWO_PLACES_APART = 0.05  # [m] least size of such a leap
DAYS_AWAY = 86400.0  # [s] from all other stamps: a clock that is not set
GAP_FACTOR = 2.5  # usual periods, above which a step is a gap
USUAL_PERCENTILE = 90.0  # [%] of the steps for the usual step: uneven stamps are no gaps
MOST_MEDIAN_STEPS = 4.0  # medians, limit of the usual step: bursts of poses leave gaps between them
RESTING_SILENCES = 3  # silences after zero commands: a joystick that is released, not a fault
SHORT_SEGMENT = 0.5  # [s] a shorter segment next to a jump is a false match


class FaultKind(str, Enum):
    """Kinds of pose faults, and their treatment."""

    MARKED = "marked bad in the recording: left out"
    NOT_FINITE = "not a number: left out"
    STAMP = "stamp out of order or days away: left out"
    FROZEN = "frozen while the boat moved: left out"
    EXCURSION = "jumped away and back: left out"
    JUMP = "jumped for good: not bridged"
    GAP = "no poses: not bridged"
    SILENT = "no commands: left out"
    NO_NUMBER = "command not a number: left out"
    PAUSED = "recorder paused or started again, commands unknown to the next one: left out"
    EXCLUDED = "excluded (--without)"


# faults during which the commands are unknown
COMMANDS_UNKNOWN = (FaultKind.SILENT, FaultKind.NO_NUMBER, FaultKind.PAUSED, FaultKind.EXCLUDED)


@dataclass(frozen=True)
class Fault:
    """One interval of bad poses.

    kind: what is wrong with them
    start: [s] from the recording's start
    end: [s]
    samples: poses in it
    """

    kind: FaultKind
    start: float
    end: float
    samples: int


@dataclass(frozen=True)
class ExaminedPoses:
    """Poses with their faults masked."""

    t: Array  # (n,) [s] from the first stamp in order; those out of order between their neighbours
    eta: Array  # (n, 3) heading unwrapped over the usable samples
    valid: Mask  # (n,) poses that may be used
    segment: Index  # (n,) number of the segment between gaps and jumps
    in_order: Mask  # (n,) stamps that rise
    faults: tuple[Fault, ...]


def examine(name: str, stamps: Stamps, eta: Array, marked_valid: Mask | None) -> ExaminedPoses:
    """Detect faults of poses (n, 3) at stamps (n,) [ns]. Raises RecordingError if no pose is usable."""
    # 1. Marked poses, numbers that are not finite, stamps out of order.
    bad = _plain_faults(stamps, eta, marked_valid)
    t = _times(stamps, ~bad[FaultKind.STAMP])
    good = _faultless(name, bad, t)
    # 2. Two mixed sources of poses, be it with equal stamps: refused.
    bad_but_stamps = bad[FaultKind.MARKED] | bad[FaultKind.NOT_FINITE]
    _refuse_two_places(name, eta[~bad_but_stamps & in_order(stamps, strict=False)])
    # 3. Frozen samples; then the heading is unwrapped over the usable ones.
    bad[FaultKind.FROZEN] = _mask_of(len(t), good[frozen(eta[good]) | stuck(eta[good])])
    good = _faultless(name, bad, t)
    whole = np.array(eta, dtype=float)
    whole[good, 2] = np.unwrap(whole[good, 2])
    bad[FaultKind.EXCURSION] = np.zeros(len(t), dtype=bool)
    # 4. False matches, one round after another: each hides others next to it.
    while True:
        found = jumps(t[good], whole[good], _gaps(t[good]))
        away, lasting = excursions(t[good], whole[good], found)
        if not away.any():
            break
        bad[FaultKind.EXCURSION][good[away]] = True
        good = _faultless(name, bad, t)
    wrong, lasting = reversals(t[good], whole[good], lasting, _gaps(t[good]))
    breaks = t[good[np.array(lasting, dtype=int) + 1]]  # [s] first pose after a lasting jump
    if wrong.any():
        bad[FaultKind.EXCURSION][good[wrong]] = True
        good = _faultless(name, bad, t)
        whole[good, 2] = np.unwrap(whole[good, 2])
    # 5. Segments between gaps and lasting jumps; short ones next to a jump are false matches.
    number, gaps = _segments(t[good], breaks)
    island, breaks = _isolated_segments(t[good], number, breaks)
    bad[FaultKind.EXCURSION][good[island]] = True
    segment = np.zeros(len(t), dtype=np.int64)
    segment[good] = number
    # 6. The list of faults.
    usable = _mask_of(len(t), _faultless(name, bad, t))
    faults = _listed(bad, t, gaps, breaks)
    return ExaminedPoses(t, whole, usable, segment, ~bad[FaultKind.STAMP], faults)


def silences(
    name: str, poses: Array, commands: Array, values: Array, timeout: float | None = None
) -> list[tuple[float, float]]:
    """Intervals [s] in which the commands are unknown. poses, commands: their times [s].

    Unknown is the time before the first command, in the holes of a periodic log, and after its end.
    A log on change has no holes: silence means no change. With a `timeout` [s] a command holds for
    that time, in any log. Repeated silences that all follow zero commands are rest, and stay known.
    values (n, inputs): of the commands.
    Raises RecordingError where poses and commands do not overlap.
    """
    steps = np.diff(commands)
    period = regular_period(steps) or np.inf
    hole = np.inf if only_changes(commands, values) else silence_length(period)
    if timeout is not None:
        hole = period = timeout
    _refuse_other_times(name, poses, commands, hole)
    found = [(poses[0], commands[0])] if commands[0] > poses[0] + SHORTEST_SILENCE else []
    # the time after the last command is a silence like those before it
    silent = np.flatnonzero(np.append(steps, max(0.0, poses.max() - commands[-1])) > hole)
    driven = np.any(values[silent] != 0.0, axis=1)
    rest = (~driven).sum() >= RESTING_SILENCES and not driven[silent < len(steps)].any()
    until = np.append(commands[1:], np.inf)
    unknown = silent[driven] if rest else silent
    found += [(commands[i] + period, until[i]) for i in unknown]
    return found


def _refuse_other_times(name: str, poses: Array, commands: Array, hole: float) -> None:
    """Raise RecordingError where commands, which hold for `hole` [s], are of another clock, unit or drive."""
    unit = other_unit(poses, commands)
    if unit:
        raise RecordingError(f"{name}: {unit}")
    if commands[0] > poses.max() or commands[-1] + hole < poses[0]:
        cause = (
            other_zone(poses, commands)
            or other_epoch(poses, commands)
            or "check the units of both stamps, and that both were recorded together"
        )
        text = (
            f"{name}: poses and commands do not overlap: commands run from {commands[0]:.6g} s to "
            f"{commands[-1]:.6g} s, poses from 0 s to {poses.max():.6g} s by the same clock; {cause}"
        )
        if apart := zones_apart(poses, commands):
            raise OtherZoneError(text, apart)
        of_start = other_epoch(poses, commands) and same_length(poses, commands)
        raise OtherEpochError(text) if of_start else RecordingError(text)


def in_order(stamps: Stamps, *, strict: bool = True) -> Mask:
    """A longest rising selection (n,) of the stamps, out of the largest group without days in between."""
    if len(stamps) == 0:
        return np.zeros(0, dtype=bool)
    order = np.argsort(stamps, kind="stable")
    group = np.concatenate([[0], np.cumsum(np.diff(stamps[order]) > DAYS_AWAY * 1e9)])
    together = np.sort(order[group == np.argmax(np.bincount(group))])
    return _mask_of(len(stamps), together[longest_rising(stamps[together], strict=strict)])


def _plain_faults(stamps: Stamps, eta: Array, marked_valid: Mask | None) -> dict[FaultKind, Mask]:
    return {
        FaultKind.MARKED: np.zeros(len(eta), bool) if marked_valid is None else ~marked_valid,
        FaultKind.NOT_FINITE: np.asarray(~np.isfinite(eta).all(axis=1)),
        FaultKind.STAMP: ~in_order(stamps),
    }


def _times(stamps: Stamps, in_order: Mask) -> Array:
    good = np.flatnonzero(in_order)
    t = (stamps[good] - stamps[good[0]]).astype(float) * 1e-9
    return np.asarray(np.interp(np.arange(len(stamps)), good, t))


def _faultless(name: str, bad: dict[FaultKind, Mask], t: Array) -> Index:
    """Indices of the samples without a fault."""
    good = np.flatnonzero(~np.any(list(bad.values()), axis=0))
    if len(good) < 2:
        worst = max(bad, key=lambda kind: int(bad[kind].sum()))
        raise RecordingError(
            f"{name}: {len(good)} usable poses of {len(t)}, most {worst.value}; "
            "check the pose columns and what marks them valid"
        )
    return good


def _mask_of(n: int, index: Index) -> Mask:
    mask = np.zeros(n, dtype=bool)
    mask[index] = True
    return mask


def _segments(t: Array, breaks: Array) -> tuple[Index, list[tuple[float, float]]]:
    """Number of each sample's segment, and the gaps between segments."""
    gap = _gaps(t)
    ends = gap | np.isin(t[1:], breaks)
    return np.concatenate([[0], np.cumsum(ends)]), list(zip(t[:-1][gap], t[1:][gap], strict=True))


def _gaps(t: Array) -> Mask:
    """Steps (n - 1,) between the samples that are gaps."""
    steps = np.diff(t)
    return np.asarray(steps > GAP_FACTOR * usual_step(steps))


def usual_step(steps: Array) -> float:
    """90th percentile [s] of the steps between poses (n - 1,), at most `MOST_MEDIAN_STEPS` medians."""
    usual = float(np.percentile(steps, USUAL_PERCENTILE, method="lower"))
    return min(usual, MOST_MEDIAN_STEPS * float(np.median(steps)))


def _isolated_segments(t: Array, segment: Index, breaks: Array) -> tuple[Mask, Array]:
    """Samples of segments that are too short next to a jump, and the jumps that remain.

    A false match next to a gap jumps once: the return is in the gap. A jump lasts only between two
    segments of sufficient length.
    """
    first = np.searchsorted(segment, np.arange(segment[-1] + 1))
    last = np.append(first[1:], len(t)) - 1
    begins = np.isin(t[first], breaks)
    ends = np.append(begins[1:], False)
    short = (begins | ends) & (t[last] - t[first] < SHORT_SEGMENT)
    lasting = begins & ~short
    for a, b in runs(short):
        lasting[a : b + 1] = False
        if b + 1 < len(first):
            lasting[b + 1] = begins[a : b + 2].all()
    return np.asarray(short[segment]), t[first[lasting]]


def _refuse_two_places(name: str, eta: Array) -> None:
    """Raise RecordingError where the poses alternate between two tracks."""
    if len(eta) < TWO_PLACES_POSES:
        return
    one, two = (np.linalg.norm(eta[k:, :2] - eta[:-k, :2], axis=1) for k in (1, 2))
    # on one track the steps without a leap are similar, over one pose or over two
    usual = float(min(np.percentile(one, 25), np.percentile(two, 25)))
    leaps = one > max(TWO_PLACES_APART, TWO_PLACES_STEPS * usual)
    if leaps.mean() < TWO_PLACES_SHARE:
        return
    leap = np.diff(eta[:, :2], axis=0)[leaps]
    back = -np.sum(leap[1:] * leap[:-1], axis=1) / (one[leaps][1:] * one[leaps][:-1])
    if float(np.median(back)) < TWO_PLACES_BACK:  # a fast boat's steps follow each other
        return
    apart = float(np.median(one[leaps]))
    raise RecordingError(
        f"{name}: {100 * leaps.mean():.0f} % of the steps between poses leap by about {apart:.2g} m and "
        "back: are two robots, or two sources of poses, on one topic or in one table? Record them "
        "separately, or name the frame (pose: parent, child)"
    )


def _listed(
    bad: dict[FaultKind, Mask], t: Array, gaps: list[tuple[float, float]], breaks: Array
) -> tuple[Fault, ...]:
    """Faults in the order of time: runs of bad samples, gaps, and lasting jumps at `breaks` [s]."""
    faults = [
        Fault(kind, float(t[a]), float(t[b]), b - a + 1)
        for kind, mask in bad.items()
        for a, b in runs(mask)
    ]
    faults += [Fault(FaultKind.GAP, float(a), float(b), 0) for a, b in gaps]
    faults += [Fault(FaultKind.JUMP, float(b), float(b), 0) for b in breaks]
    return tuple(sorted(faults, key=lambda f: f.start))
