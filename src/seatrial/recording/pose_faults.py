# SPDX-License-Identifier: MIT
"""What can be wrong with poses: drop-outs, frozen samples, jumps, gaps. Found, named, masked."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from seatrial.recording.timing import SHORTEST_SILENCE, beat, longest_rising, only_changes, silence
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Mask, Stamps

TWO_PLACES_SHARE = 0.12  # of the steps leap where two sources of poses are mixed,
TWO_PLACES_STEPS = 20.0  # by this many usual steps,
TWO_PLACES_BACK = 0.7  # each opposite to the one before (cosine),
TWO_PLACES_APART = 0.05  # [m] and by this much
DAYS_AWAY = 86400.0  # [s] stamps that far from the others are of an unset clock
GAP_FACTOR = 2.5  # a gap is longer than this many usual periods,
USUAL = 90.0  # [%] of the steps are no longer than which: uneven stamps are no gaps,
MOST_UNEVEN = 4.0  # but bursts of poses are no stretch: it is this many median steps at most
JUMP_SPREADS = 5.0  # a jump's rate is off its neighbours by this many robust spreads,
JUMP_USUAL = 4.0  # by this many times the 90th percentile of all steps,
JUMP_SPEED = 0.3  # and by this share of the 90th percentile of the boat's speed
LEVER = 0.25  # [m] by which speed and yaw rate are compared
EXCURSION = 1.5  # [s] a shorter stay between two jumps is a false match
UNDONE = 0.1  # of the largest of several jumps: what may be left where they belong together
BACK = 0.35  # of a jump: what may be left where a step undoes it that is not seen to be one itself
STANDS_OUT = 2.5  # usual steps, beyond the boat's own way, that such a jump is larger than
FEW_POSES = 10  # of fewer it can't be seen whether a log has more rows than poses;
HELD = 0.2  # of the poses stand in two rows or more where it has, in about as many each:
ALIKE = 1.6  # their 90th percentile is at most one more than this many medians
HABIT = 3  # silences from which on they may be one, of a joystick that is let go
ISLAND = 0.5  # [s] a shorter stretch that a jump leads to or from is not trusted


class FaultKind(str, Enum):
    """What can be wrong with poses, and what was done about it."""

    MARKED = "marked bad in the recording: left out"
    NOT_FINITE = "not a number: left out"
    STAMP = "stamp out of order or days away: left out"
    FROZEN = "frozen while the boat moved: left out"
    EXCURSION = "jumped away and back: left out"
    JUMP = "jumped for good: not bridged"
    GAP = "no poses: not bridged"
    SILENT = "no commands: left out"
    NO_NUMBER = "command not a number: left out"
    UNWANTED = "left out as was asked for"


# what drove the boat there is not known
UNKNOWN = (FaultKind.SILENT, FaultKind.NO_NUMBER, FaultKind.UNWANTED)


@dataclass(frozen=True)
class Fault:
    """One stretch of bad poses."""

    kind: FaultKind
    start: float  # [s] from the recording's start
    end: float  # [s]
    samples: int


@dataclass(frozen=True)
class Findings:
    """Poses with their faults masked."""

    t: Array  # (n,) [s] from the first stamp in order; those out of order between their neighbours
    eta: Array  # (n, 3) heading unwrapped over the usable samples
    valid: Mask  # (n,) poses that may be used
    segment: NDArray[np.int64]  # (n,) number of the stretch between gaps and jumps
    in_order: Mask  # (n,) stamps that rise
    faults: tuple[Fault, ...]


def examine(name: str, stamps: Stamps, eta: Array, marked_valid: Mask | None) -> Findings:
    """Find what is wrong with poses (n, 3) at stamps (n,) [ns]. Raises RecordingError if all is."""
    bad = _plain_faults(stamps, eta, marked_valid)
    t = _times(stamps, ~bad[FaultKind.STAMP])
    good = _left(name, bad, t)
    _refuse_two_places(name, eta[good])
    bad[FaultKind.FROZEN] = _at(len(t), good[_frozen(eta[good])])
    good = _left(name, bad, t)
    whole = np.array(eta, dtype=float)
    whole[good, 2] = np.unwrap(whole[good, 2])
    bad[FaultKind.EXCURSION] = np.zeros(len(t), dtype=bool)
    while True:  # a false match is seen better without another beside it
        away, lasting = _excursions(t[good], whole[good], _jumps(t[good], whole[good]))
        if not away.any():
            break
        bad[FaultKind.EXCURSION][good[away]] = True
        good = _left(name, bad, t)
    breaks = t[good[np.array(lasting, dtype=int) + 1]]  # [s] where a jump for good leads to
    stretch, gaps = _stretches(t[good], breaks)
    island, breaks = _islands(t[good], stretch, breaks)
    bad[FaultKind.EXCURSION][good[island]] = True
    segment = np.zeros(len(t), dtype=np.int64)
    segment[good] = stretch
    faults = [f for kind, mask in bad.items() for f in _listed(kind, mask, t)]
    faults += [Fault(FaultKind.GAP, float(a), float(b), 0) for a, b in gaps]
    faults += [Fault(FaultKind.JUMP, float(b), float(b), 0) for b in breaks]
    return Findings(
        t,
        whole,
        _at(len(t), _left(name, bad, t)),
        segment,
        ~bad[FaultKind.STAMP],
        tuple(sorted(faults, key=lambda f: f.start)),
    )


def silences(
    name: str, poses: Array, commands: Array, values: Array, timeout: float | None = None
) -> list[tuple[float, float]]:
    """Stretches [s] in which no command is known. poses, commands: their times [s].

    Before the first command; in holes of a steady log, and after its end. A log that is written
    only on changes has no holes: silence means that nothing changed. With a `timeout` [s] a command
    is in force for so long, and then none is known, in any log. A topic that falls silent again and
    again, each time after a command of nothing at all, does so where the boat is at rest: that stays.
    values (n, inputs): of the commands.
    Raises RecordingError where poses and commands do not overlap.
    """
    steps = np.diff(commands)
    period = beat(steps) or np.inf
    hole = np.inf if only_changes(commands, values) else silence(period)
    if timeout is not None:
        hole = period = timeout
    if commands[0] > poses.max() or commands[-1] + hole < poses[0]:
        raise RecordingError(
            f"{name}: poses and commands do not overlap: commands run from {commands[0]:.6g} s to "
            f"{commands[-1]:.6g} s, poses from 0 s to {poses.max():.6g} s by the same clock; check the "
            "units of both stamps, and that both were recorded together"
        )
    found = [(poses[0], commands[0])] if commands[0] > poses[0] + SHORTEST_SILENCE else []
    holes = np.flatnonzero(steps > hole)
    if len(holes) < HABIT or values[holes].any():
        found += [(commands[i] + period, commands[i + 1]) for i in holes]
    if commands[-1] + hole < poses.max():
        found.append((commands[-1] + period, np.inf))
    return found


def in_order(stamps: Stamps, *, strict: bool = True) -> Mask:
    """The most stamps (n,) that rise, out of those without days between them."""
    if len(stamps) == 0:
        return np.zeros(0, dtype=bool)
    order = np.argsort(stamps, kind="stable")
    group = np.concatenate([[0], np.cumsum(np.diff(stamps[order]) > DAYS_AWAY * 1e9)])
    together = np.sort(order[group == np.argmax(np.bincount(group))])
    return _at(len(stamps), together[longest_rising(stamps[together], strict=strict)])


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


def _left(name: str, bad: dict[FaultKind, Mask], t: Array) -> NDArray[np.int64]:
    """Indices of the samples without a fault."""
    good = np.flatnonzero(~np.any(list(bad.values()), axis=0))
    if len(good) < 2:
        worst = max(bad, key=lambda kind: int(bad[kind].sum()))
        raise RecordingError(
            f"{name}: {len(good)} usable poses of {len(t)}, most {worst.value}; "
            "check the pose columns and what marks them valid"
        )
    return good


def _at(n: int, index: NDArray[np.int64]) -> Mask:
    mask = np.zeros(n, dtype=bool)
    mask[index] = True
    return mask


def _stretches(t: Array, breaks: Array) -> tuple[NDArray[np.int64], list[tuple[float, float]]]:
    """Number of the stretch that each sample is in, and the gaps between them."""
    steps = np.diff(t)
    gap = steps > GAP_FACTOR * usual_step(steps)
    ends = gap | np.isin(t[1:], breaks)
    return np.concatenate([[0], np.cumsum(ends)]), list(zip(t[:-1][gap], t[1:][gap], strict=True))


def usual_step(steps: Array) -> float:
    """The step [s] between poses (n - 1,) that most do not exceed: the period of even stamps."""
    if not len(steps):
        return 0.0
    usual = float(np.percentile(steps, USUAL, method="lower"))
    return min(usual, MOST_UNEVEN * float(np.median(steps)))


def _islands(t: Array, stretch: NDArray[np.int64], breaks: Array) -> tuple[Mask, Array]:
    """Samples of stretches too short to be trusted after or before a jump; the jumps that remain.

    A false match beside a gap jumps once: what undoes it is in the gap. Only between two stretches
    that are trusted did the poses jump for good.
    """
    first = np.searchsorted(stretch, np.arange(stretch[-1] + 1))
    last = np.append(first[1:], len(t)) - 1
    begins = np.isin(t[first], breaks)
    ends = np.append(begins[1:], False)
    short = (begins | ends) & (t[last] - t[first] < ISLAND)
    lasting = begins & ~short
    for a, b in _runs(short):
        lasting[a : b + 1] = False
        if b + 1 < len(first):
            lasting[b + 1] = begins[a : b + 2].all()
    return np.asarray(short[stretch]), t[first[lasting]]


def _refuse_two_places(name: str, eta: Array) -> None:
    """Raise RecordingError where the poses leap to and fro all the time between two tracks."""
    if len(eta) < 20:
        return
    one, two = (np.linalg.norm(eta[k:, :2] - eta[:-k, :2], axis=1) for k in (1, 2))
    # along one track the steps that do not leap are alike, be they between neighbours or not
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
        f"{name}: {100 * leaps.mean():.0f} % of the steps between poses leap by about {apart:.2g} m to "
        "and fro: are two robots, or two sources of poses, on one topic or in one table? Record them "
        "apart, or name the frame (pose: parent, child)"
    )


def poses_held(eta: Array) -> Mask:
    """Rows (n,) that hold the last pose of (n, 3) until there is a new one: a log with more rows than poses.

    None where repeats are rare, or come in long runs: a boat at rest, a tracker that hangs. In a log that
    holds poses, too, a boat may be at rest: of what repeats for longer than usual a row stays now and then.
    """
    repeats = _repeats(eta)
    first = np.flatnonzero(~repeats)
    rows = np.diff(np.append(first, len(eta)))
    usual = float(np.percentile(rows, USUAL, method="lower"))
    if (
        len(rows) < FEW_POSES
        or np.mean(rows > 1) < HELD
        or usual > ALIKE * float(np.median(rows)) + 1.0
    ):
        return np.zeros(len(eta), dtype=bool)
    since = np.arange(len(eta)) - first[np.cumsum(~repeats) - 1]
    return np.asarray(since % int(2 * usual) != 0)


def _repeats(eta: Array) -> Mask:
    """Rows (n,) that are exactly the one before."""
    return np.concatenate([[False], np.all(eta[1:] == eta[:-1], axis=1)])


def _frozen(eta: Array) -> Mask:
    """Samples that repeat the one before exactly although the boat moved on meanwhile.

    A boat at rest repeats too, in a recording without noise; so a run counts only where the step
    that ends it catches up: more than 1.5 times the step that follows.
    """
    repeats = _repeats(eta)
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
    """Steps i -> i + 1 at a rate that neither the step before nor the one after comes near, nor what lies between.

    A boat's rate changes little by little, quickly in a quick boat's turn; a false match makes one step, and
    one back.
    """
    if len(t) < 7:
        return []
    steps = np.diff(t)
    rate = np.diff(eta, axis=0) / steps[:, None]
    gap = steps > GAP_FACTOR * usual_step(steps)
    usual = np.percentile([np.hypot(rate[:, 0], rate[:, 1]), np.abs(rate[:, 2])], 90, axis=1)
    # an axis that rests is measured by the other: a point of the hull moves by both
    least = JUMP_SPEED * np.array(
        [max(usual[0], usual[1] * LEVER), max(usual[1], usual[0] / LEVER)]
    )
    found: set[int] = set()
    period = float(np.median(steps))
    for parts, floor in ((rate[:, :2], least[0]), (rate[:, 2:], least[1])):
        change = np.linalg.norm(np.diff(parts, axis=0), axis=1)
        bend = np.append(np.append(np.inf, np.linalg.norm(_bends(t, parts), axis=1)), np.inf)
        apart = np.minimum(np.append(np.inf, change), np.append(change, np.inf))
        apart[gap] = 0.0  # a gap is a fault of its own
        # of stamps that are close together the rate is noise, of those far apart the way is the boat's
        way = apart * np.minimum(steps, period)
        spread = 1.4826 * float(np.median(way))
        limit = max(JUMP_SPREADS * spread, JUMP_USUAL * float(np.percentile(way, 90)))
        far = (way > limit) & (apart > floor) & (bend * np.minimum(steps, period) > limit)
        found |= set(np.flatnonzero(far).tolist()) if max(limit, floor) > 0 else set()
    return sorted(found)


def _bends(t: Array, rate: Array) -> Array:
    """What rates (n - 1, k) of steps are off the line between their neighbours'; not the first and the last."""
    middle = 0.5 * (t[1:] + t[:-1])
    share = ((middle[1:-1] - middle[:-2]) / (middle[2:] - middle[:-2]))[:, None]
    return rate[1:-1] - (1.0 - share) * rate[:-2] - share * rate[2:]


def _excursions(t: Array, eta: Array, jumps: Sequence[int]) -> tuple[Mask, list[int]]:
    """Samples between a jump and the one that undoes it, and the jumps that nothing undoes."""
    away = np.zeros(len(t), dtype=bool)
    if not jumps:
        return away, []
    steps = np.diff(t)[:, None]
    rate = np.diff(eta, axis=0) / steps
    padded = np.pad(rate, ((3, 3), (0, 0)), mode="edge")
    usual = np.median(np.stack([padded[k : k + len(rate)] for k in range(7)]), axis=0)
    shift = (rate - usual) * steps * [1.0, 1.0, LEVER]  # [m] beyond the boat's own motion
    spans = []  # jumps that undo each other: badly?, how many, what is left, first and last
    for i, first in enumerate(jumps):
        left, size = shift[first].copy(), float(np.linalg.norm(shift[first]))
        largest = size
        for j in range(i + 1, len(jumps)):
            if t[jumps[j] + 1] - t[first] > EXCURSION:
                break
            left += shift[jumps[j]]
            largest = max(largest, float(np.linalg.norm(shift[jumps[j]])))
            rest = float(np.linalg.norm(left))
            if rest < 0.5 * size:
                spans.append((rest > UNDONE * largest, j - i, rest, i, j))
    free = np.ones(len(jumps), dtype=bool)
    for *_, i, j in sorted(spans):  # what undoes each other well, then what does so soon
        if free[i : j + 1].all():
            free[i : j + 1] = False
            away[jumps[i] + 1 : jumps[j] + 1] = True
    lasting = [jump for jump, lasts in zip(jumps, free, strict=True) if lasts]
    for jump in lasting:
        twin = _undone_by(t, shift, jump)
        if twin is not None and not away[min(jump, twin) + 1 : max(jump, twin) + 1].any():
            away[min(jump, twin) + 1 : max(jump, twin) + 1] = True
            lasting = [j for j in lasting if j not in (jump, twin)]
    return away, lasting


def _undone_by(t: Array, shift: Array, jump: int) -> int | None:
    """The step, large though no jump by itself, that undoes one before or after; None: there is none."""
    near = np.flatnonzero(np.abs(t[1:] - t[jump + 1]) <= EXCURSION)
    near = near[near != jump]
    sizes = np.linalg.norm(shift, axis=1)
    spread = 1.4826 * float(np.median(sizes))
    if not len(near) or sizes[jump] < STANDS_OUT * spread:  # noise has such steps everywhere
        return None
    left = np.linalg.norm(shift[near] + shift[jump], axis=1)
    best = int(np.argmin(left))
    return int(near[best]) if left[best] < BACK * sizes[jump] else None


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


def _listed(kind: FaultKind, mask: Mask, t: Array) -> list[Fault]:
    return [Fault(kind, float(t[a]), float(t[b]), b - a + 1) for a, b in _runs(mask)]
