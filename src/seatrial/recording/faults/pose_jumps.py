# SPDX-License-Identifier: MIT
"""Poses that jump: false matches, which jump back, and jumps that last."""

from collections.abc import Sequence

import numpy as np

from seatrial.util.frames import Array, Mask

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
HALF_TURN_SLACK = 0.3  # [rad] by which a heading that is reversed may miss half a turn
MAD_TO_SD = 1.4826  # standard deviation of a normal distribution over its median absolute deviation
NEIGHBOURS = 3  # steps to either side for the boat's own motion (median)


def jumps(t: Array, eta: Array, gap: Mask) -> list[int]:
    """Steps i -> i + 1 whose rate differs from both neighbours and from their interpolation.

    A boat's rate changes continuously. A false match makes one step, and one back. gap: steps (n - 1,) that are.
    """
    if len(t) < JUMP_POSES:
        return []
    steps = np.diff(t)
    rate = np.diff(eta, axis=0) / steps[:, None]
    fast, turn = np.percentile([np.hypot(rate[:, 0], rate[:, 1]), np.abs(rate[:, 2])], 90, axis=1)
    # for a resting axis the other sets the scale: a point of the hull moves with both
    least = JUMP_SPEED * np.array([max(fast, turn * JUMP_LEVER), max(turn, fast / JUMP_LEVER)])
    found: set[int] = set()
    period = float(np.median(steps))
    for parts, floor in ((rate[:, :2], least[0]), (rate[:, 2:], least[1])):
        change = np.linalg.norm(np.diff(parts, axis=0), axis=1)
        bend = np.pad(np.linalg.norm(_rate_curvature(t, parts), axis=1), 1, constant_values=np.inf)
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


def excursions(t: Array, eta: Array, jumps: Sequence[int]) -> tuple[Mask, list[int]]:
    """Samples between a jump and the one that cancels it, and the jumps that last."""
    away = np.zeros(len(t), dtype=bool)
    if not jumps:
        return away, []
    shift = _shift(t, eta) * [1.0, 1.0, JUMP_LEVER]  # [m]
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


def reversals(t: Array, eta: Array, lasting: Sequence[int], gap: Mask) -> tuple[Mask, list[int]]:
    """Samples whose heading is reversed, and the lasting jumps that are no reversal.

    A reversal is half a turn of the heading alone: two antennas, or markers, that are taken for each other.
    Between gaps and other jumps the heading is right for the longer time.
    """
    wrong = np.zeros(len(t), dtype=bool)
    turn = np.abs(_shift(t, eta)[:, 2]) if lasting else np.empty(0)
    turns = [j for j in lasting if abs(turn[j] - np.pi) < HALF_TURN_SLACK]
    moved = set(jumps(t, eta * [1.0, 1.0, 0.0], gap)) if turns else set()
    turns = [j for j in turns if j not in moved]
    others = [j for j in lasting if j not in turns]
    if not turns:
        return wrong, others
    ends = gap.copy()
    ends[others] = True
    part = np.concatenate([[0], np.cumsum(ends)])
    turned = np.concatenate([[0], np.cumsum(np.isin(np.arange(len(t) - 1), turns))]) % 2 == 1
    for number in np.unique(part[turns]):
        inside = part == number
        wrong |= inside & (turned if 2 * turned[inside].sum() <= inside.sum() else ~turned)
    return wrong, others


def _shift(t: Array, eta: Array) -> Array:
    """Steps (n - 1, 3) beyond the boat's own motion, which is that of the neighbours."""
    steps = np.diff(t)[:, None]
    rate = np.diff(eta, axis=0) / steps
    padded = np.pad(rate, ((NEIGHBOURS, NEIGHBOURS), (0, 0)), mode="edge")
    around = [padded[k : k + len(rate)] for k in range(2 * NEIGHBOURS + 1)]
    return np.asarray((rate - np.median(np.stack(around), axis=0)) * steps)


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
