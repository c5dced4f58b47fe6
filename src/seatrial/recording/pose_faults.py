# SPDX-License-Identifier: MIT
"""Pose faults: invalid and frozen samples, false matches, jumps, gaps. Detected, named, masked."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from seatrial.recording.other_clock import other_epoch, other_unit, other_zone
from seatrial.recording.timing import (
    SHORTEST_SILENCE,
    longest_rising,
    only_changes,
    regular_period,
    silence_length,
)
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Mask, Stamps

TWO_PLACES_POSES = 20  # fewest poses that show two mixed sources
TWO_PLACES_SHARE = 0.12  # of the steps that leap where two sources of poses are mixed
TWO_PLACES_STEPS = 20.0  # usual steps, least size of such a leap
TWO_PLACES_BACK = 0.7  # least cosine between a leap and the reverse of the one before
TWO_PLACES_APART = 0.05  # [m] least size of such a leap
DAYS_AWAY = 86400.0  # [s] from all other stamps: a clock that is not set
GAP_FACTOR = 2.5  # usual periods, above which a step is a gap
USUAL_PERCENTILE = 90.0  # [%] of the steps for the usual step: uneven stamps are no gaps
MOST_MEDIAN_STEPS = 4.0  # medians, limit of the usual step: bursts of poses leave gaps between them
JUMP_POSES = 7  # fewest poses for a jump test: neighbours on both sides
JUMP_SPREADS = 5.0  # robust spreads by which a jump's rate differs from its neighbours'
JUMP_USUAL = 4.0  # times the 90th percentile of all steps, least size of a jump
JUMP_SPEED = 0.3  # of the 90th percentile of the boat's speed, least rate of a jump
JUMP_LEVER = 0.25  # [m] converts yaw rate to speed: a point of a small hull
EXCURSION = 1.5  # [s] longest stay between two jumps of one false match
EXCURSION_HALF = 0.5  # of the first jump: a sum of jumps below it is a return
EXCURSION_REST = 0.1  # of the largest jump: rest of the sum of jumps that cancel well
TWIN_REST = 0.35  # of a jump: rest after a step that cancels it but is no jump by itself
TWIN_LEAST = 2.5  # robust spreads of all steps, least size of a jump with such a twin
NEIGHBOURS = 3  # steps to either side for the boat's own motion (median)
STUCK_ROWS = 5  # least length of a run in which the position alone repeats
STUCK_CATCH_UP = 3.0  # times the usual step, least step of a position at the end of such a run
USUAL_STEP = 95.0  # percentile of the steps of a position that moves
FROZEN_CATCH_UP = 1.5  # times the step that follows, least step at the end of a frozen run
FEW_POSES = 10  # below it a log with more rows than poses is not recognised
HELD_SHARE = 0.2  # of the poses that fill two or more rows in a log with more rows than poses
HELD_UNEVENNESS = 1.6  # medians (plus 1), limit of the 90th percentile of the rows a pose fills
RESTING_SILENCES = 3  # silences after zero commands: a joystick that is released, not a fault
SHORT_SEGMENT = 0.5  # [s] a shorter segment next to a jump is a false match
MAD_TO_SD = 1.4826  # standard deviation of a normal distribution over its median absolute deviation


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
    EXCLUDED = "excluded (--without)"


# faults during which the commands are unknown
COMMANDS_UNKNOWN = (FaultKind.SILENT, FaultKind.NO_NUMBER, FaultKind.EXCLUDED)


@dataclass(frozen=True)
class Fault:
    """One interval of bad poses."""

    kind: FaultKind
    start: float  # [s] from the recording's start
    end: float  # [s]
    samples: int


@dataclass(frozen=True)
class ExaminedPoses:
    """Poses with their faults masked."""

    t: Array  # (n,) [s] from the first stamp in order; those out of order between their neighbours
    eta: Array  # (n, 3) heading unwrapped over the usable samples
    valid: Mask  # (n,) poses that may be used
    segment: NDArray[np.int64]  # (n,) number of the segment between gaps and jumps
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
    bad[FaultKind.FROZEN] = _mask_of(len(t), good[_frozen(eta[good]) | _stuck(eta[good])])
    good = _faultless(name, bad, t)
    whole = np.array(eta, dtype=float)
    whole[good, 2] = np.unwrap(whole[good, 2])
    bad[FaultKind.EXCURSION] = np.zeros(len(t), dtype=bool)
    # 4. False matches, one round after another: each hides others next to it.
    while True:
        away, lasting = _excursions(t[good], whole[good], _jumps(t[good], whole[good]))
        if not away.any():
            break
        bad[FaultKind.EXCURSION][good[away]] = True
        good = _faultless(name, bad, t)
    # 5. Segments between gaps and lasting jumps; short ones next to a jump are false matches.
    breaks = t[good[np.array(lasting, dtype=int) + 1]]  # [s] first pose after a lasting jump
    number, gaps = _segments(t[good], breaks)
    island, breaks = _isolated_segments(t[good], number, breaks)
    bad[FaultKind.EXCURSION][good[island]] = True
    segment = np.zeros(len(t), dtype=np.int64)
    segment[good] = number
    # 6. The list of faults.
    faults = [f for kind, mask in bad.items() for f in _fault_runs(kind, mask, t)]
    faults += [Fault(FaultKind.GAP, float(a), float(b), 0) for a, b in gaps]
    faults += [Fault(FaultKind.JUMP, float(b), float(b), 0) for b in breaks]
    return ExaminedPoses(
        t,
        whole,
        _mask_of(len(t), _faultless(name, bad, t)),
        segment,
        ~bad[FaultKind.STAMP],
        tuple(sorted(faults, key=lambda f: f.start)),
    )


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
    unit = other_unit(poses, commands)
    if unit:
        raise RecordingError(f"{name}: {unit}")
    if commands[0] > poses.max() or commands[-1] + hole < poses[0]:
        cause = (
            other_zone(poses, commands)
            or other_epoch(poses, commands)
            or "check the units of both stamps, and that both were recorded together"
        )
        raise RecordingError(
            f"{name}: poses and commands do not overlap: commands run from {commands[0]:.6g} s to "
            f"{commands[-1]:.6g} s, poses from 0 s to {poses.max():.6g} s by the same clock; {cause}"
        )
    found = [(poses[0], commands[0])] if commands[0] > poses[0] + SHORTEST_SILENCE else []
    holes = np.flatnonzero(steps > hole)
    if len(holes) < RESTING_SILENCES or values[holes].any():
        found += [(commands[i] + period, commands[i + 1]) for i in holes]
    if commands[-1] + hole < poses.max():
        found.append((commands[-1] + period, np.inf))
    return found


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


def _faultless(name: str, bad: dict[FaultKind, Mask], t: Array) -> NDArray[np.int64]:
    """Indices of the samples without a fault."""
    good = np.flatnonzero(~np.any(list(bad.values()), axis=0))
    if len(good) < 2:
        worst = max(bad, key=lambda kind: int(bad[kind].sum()))
        raise RecordingError(
            f"{name}: {len(good)} usable poses of {len(t)}, most {worst.value}; "
            "check the pose columns and what marks them valid"
        )
    return good


def _mask_of(n: int, index: NDArray[np.int64]) -> Mask:
    mask = np.zeros(n, dtype=bool)
    mask[index] = True
    return mask


def _segments(t: Array, breaks: Array) -> tuple[NDArray[np.int64], list[tuple[float, float]]]:
    """Number of each sample's segment, and the gaps between segments."""
    steps = np.diff(t)
    gap = steps > GAP_FACTOR * usual_step(steps)
    ends = gap | np.isin(t[1:], breaks)
    return np.concatenate([[0], np.cumsum(ends)]), list(zip(t[:-1][gap], t[1:][gap], strict=True))


def usual_step(steps: Array) -> float:
    """90th percentile [s] of the steps between poses (n - 1,), at most `MOST_MEDIAN_STEPS` medians."""
    if not len(steps):
        return 0.0
    usual = float(np.percentile(steps, USUAL_PERCENTILE, method="lower"))
    return min(usual, MOST_MEDIAN_STEPS * float(np.median(steps)))


def _isolated_segments(t: Array, segment: NDArray[np.int64], breaks: Array) -> tuple[Mask, Array]:
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
    for a, b in _runs(short):
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


def poses_held(eta: Array) -> Mask:
    """Rows (n,) that repeat the last pose of (n, 3): a log with more rows than poses.

    None where repeats are rare or in long runs (a boat at rest, a frozen tracker). In a log with repeats
    a boat may also rest: of runs longer than usual one row in two usual lengths stays.
    """
    repeats = _repeats(eta)
    first = np.flatnonzero(~repeats)
    rows = np.diff(np.append(first, len(eta)))
    usual = float(np.percentile(rows, USUAL_PERCENTILE, method="lower"))
    if (
        len(rows) < FEW_POSES
        or np.mean(rows > 1) < HELD_SHARE
        or usual > HELD_UNEVENNESS * float(np.median(rows)) + 1.0
    ):
        return np.zeros(len(eta), dtype=bool)
    since = np.arange(len(eta)) - first[np.cumsum(~repeats) - 1]
    return np.asarray(since % int(2 * usual) != 0)


def _repeats(eta: Array) -> Mask:
    """Rows (n,) exactly equal to the one before."""
    return np.concatenate([[False], np.all(eta[1:] == eta[:-1], axis=1)])


def _frozen(eta: Array) -> Mask:
    """Samples that exactly repeat the one before while the boat moved.

    A boat at rest repeats, too, in a recording without noise. So a run counts only if the step at its
    end catches up: more than `FROZEN_CATCH_UP` times the step that follows.
    """
    repeats = _repeats(eta)
    frozen = np.zeros(len(eta), dtype=bool)
    for first, last in _runs(repeats):
        if last + 2 >= len(eta):
            continue
        catch_up = np.abs(eta[last + 1] - eta[last])
        after = np.abs(eta[last + 2] - eta[last + 1])
        if np.any((catch_up > FROZEN_CATCH_UP * after) & (catch_up > 0)):
            frozen[first : last + 1] = True
    return frozen


def _stuck(eta: Array) -> Mask:
    """Positions, or headings, that repeat exactly while the other goes on, and then catch up.

    A receiver without a fix, a compass that hangs. Rounded positions of a slow boat repeat, too; their next step
    is a usual one.
    """
    heading = np.column_stack([np.cos(eta[:, 2]), np.sin(eta[:, 2])])
    return _part_stuck(eta[:, :2]) | _part_stuck(heading)


def _part_stuck(part: Array) -> Mask:
    """The same of positions, or of the heading's cosine and sine (n, 2)."""
    repeats = _repeats(part)
    steps = np.hypot(*np.diff(part, axis=0).T)
    stuck = np.zeros(len(part), dtype=bool)
    moving = steps[steps > 0]
    usual = float(np.percentile(moving, USUAL_STEP)) if len(moving) else 0.0
    for first, last in _runs(repeats):
        if (
            last - first + 1 >= STUCK_ROWS
            and last < len(steps)
            and steps[last] > STUCK_CATCH_UP * usual
        ):
            stuck[first : last + 1] = True
    return stuck


def _jumps(t: Array, eta: Array) -> list[int]:
    """Steps i -> i + 1 whose rate differs from both neighbours and from their interpolation.

    A boat's rate changes continuously. A false match makes one step, and one back.
    """
    if len(t) < JUMP_POSES:
        return []
    steps = np.diff(t)
    rate = np.diff(eta, axis=0) / steps[:, None]
    gap = steps > GAP_FACTOR * usual_step(steps)
    usual = np.percentile([np.hypot(rate[:, 0], rate[:, 1]), np.abs(rate[:, 2])], 90, axis=1)
    # for a resting axis the other sets the scale: a point of the hull moves with both
    least = JUMP_SPEED * np.array(
        [max(usual[0], usual[1] * JUMP_LEVER), max(usual[1], usual[0] / JUMP_LEVER)]
    )
    found: set[int] = set()
    period = float(np.median(steps))
    for parts, floor in ((rate[:, :2], least[0]), (rate[:, 2:], least[1])):
        change = np.linalg.norm(np.diff(parts, axis=0), axis=1)
        bend = np.append(
            np.append(np.inf, np.linalg.norm(_rate_curvature(t, parts), axis=1)), np.inf
        )
        apart = np.minimum(np.append(np.inf, change), np.append(change, np.inf))
        apart[gap] = 0.0  # a gap is a fault of its own
        # close stamps: the rate is noise; distant stamps: the displacement is the boat's
        displacement = apart * np.minimum(steps, period)
        spread = MAD_TO_SD * float(np.median(displacement))
        limit = max(JUMP_SPREADS * spread, JUMP_USUAL * float(np.percentile(displacement, 90)))
        far = (displacement > limit) & (apart > floor) & (bend * np.minimum(steps, period) > limit)
        found |= set(np.flatnonzero(far).tolist()) if max(limit, floor) > 0 else set()
    return sorted(found)


def _rate_curvature(t: Array, rate: Array) -> Array:
    """Rates (n - 1, k) of the steps minus the interpolation between their neighbours; inner steps only."""
    middle = 0.5 * (t[1:] + t[:-1])
    share = ((middle[1:-1] - middle[:-2]) / (middle[2:] - middle[:-2]))[:, None]
    return rate[1:-1] - (1.0 - share) * rate[:-2] - share * rate[2:]


def _excursions(t: Array, eta: Array, jumps: Sequence[int]) -> tuple[Mask, list[int]]:
    """Samples between a jump and the one that cancels it, and the jumps that last."""
    away = np.zeros(len(t), dtype=bool)
    if not jumps:
        return away, []
    steps = np.diff(t)[:, None]
    rate = np.diff(eta, axis=0) / steps
    padded = np.pad(rate, ((NEIGHBOURS, NEIGHBOURS), (0, 0)), mode="edge")
    around = [padded[k : k + len(rate)] for k in range(2 * NEIGHBOURS + 1)]
    usual = np.median(np.stack(around), axis=0)
    shift = (rate - usual) * steps * [1.0, 1.0, JUMP_LEVER]  # [m] beyond the boat's own motion
    spans = []  # jumps that cancel: badly?, how many, the rest, first and last
    for i, first in enumerate(jumps):
        left, size = shift[first].copy(), float(np.linalg.norm(shift[first]))
        largest = size
        for j in range(i + 1, len(jumps)):
            if t[jumps[j] + 1] - t[first] > EXCURSION:
                break
            left += shift[jumps[j]]
            largest = max(largest, float(np.linalg.norm(shift[jumps[j]])))
            rest = float(np.linalg.norm(left))
            if rest < EXCURSION_HALF * size:
                spans.append((rest > EXCURSION_REST * largest, j - i, rest, i, j))
    free = np.ones(len(jumps), dtype=bool)
    for *_, i, j in sorted(spans):  # first those that cancel well, then the shortest
        if free[i : j + 1].all():
            free[i : j + 1] = False
            away[jumps[i] + 1 : jumps[j] + 1] = True
    lasting = [jump for jump, lasts in zip(jumps, free, strict=True) if lasts]
    for jump in lasting:
        twin = _twin_of(t, shift, jump)
        if twin is not None and not away[min(jump, twin) + 1 : max(jump, twin) + 1].any():
            away[min(jump, twin) + 1 : max(jump, twin) + 1] = True
            lasting = [j for j in lasting if j not in (jump, twin)]
    return away, lasting


def _twin_of(t: Array, shift: Array, jump: int) -> int | None:
    """The step, no jump by itself, that cancels a jump before or after it; None: there is none."""
    near = np.flatnonzero(np.abs(t[1:] - t[jump + 1]) <= EXCURSION)
    near = near[near != jump]
    sizes = np.linalg.norm(shift, axis=1)
    spread = MAD_TO_SD * float(np.median(sizes))
    if not len(near) or sizes[jump] < TWIN_LEAST * spread:  # within the noise
        return None
    left = np.linalg.norm(shift[near] + shift[jump], axis=1)
    best = int(np.argmin(left))
    return int(near[best]) if left[best] < TWIN_REST * sizes[jump] else None


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


def _fault_runs(kind: FaultKind, mask: Mask, t: Array) -> list[Fault]:
    return [Fault(kind, float(t[a]), float(t[b]), b - a + 1) for a, b in _runs(mask)]
