# SPDX-License-Identifier: MIT
"""Zero, sense and unit of a heading, from its values and from the motion of the boat."""

from dataclasses import dataclass

import numpy as np

from seatrial.util.frames import Array

TURN = 2 * np.pi
WRAP_SLACK = 0.1  # of a turn, by which a jump may differ from one
MOST_RADIANS = 7.0  # [rad] just above a turn; a heading that wraps stays below
MOST_DEGREES = 400.0  # just above a turn
MOTION_STEPS = 400  # of a recording, in which the course is taken
CLEAR_RATIO = 1.5  # between the senses' concentrations of course minus heading
CLEAR_CONCENTRATION = 0.35  # least of the better sense
LEAST_TURNED = 0.5  # [rad] standard deviation of the heading; below, both senses fit
OFFSET_STEP = 90  # [deg] zeros of headings differ by


@dataclass(frozen=True)
class Sense:
    """psi = sign (heading) + offset, counter-clockwise from the first coordinate."""

    sign: int
    offset: int  # [deg] a multiple of 90


PLAIN = Sense(1, 0)
COMPASS = Sense(-1, 90)  # clockwise from the second coordinate: from north


def unit_of(heading: Array) -> str:
    """`rad` or `deg` by the jumps at a full turn; empty: there is none."""
    given = heading[np.isfinite(heading)]
    if len(given) < 2:
        return ""
    steps, most = np.abs(np.diff(given)), float(np.abs(given).max())
    for unit, turn, limit in (("rad", TURN, MOST_RADIANS), ("deg", 360.0, MOST_DEGREES)):
        if most <= limit and np.any(np.abs(steps - turn) < WRAP_SLACK * turn):
            return unit
    return ""


def wraps_in_degrees(heading: Array) -> bool:
    """Whether a heading fills a turn of 360 and jumps by it."""
    given = heading[np.isfinite(heading)]
    return unit_of(given) == "deg" and float(np.ptp(given)) > 360.0 * (1.0 - WRAP_SLACK)


def by_motion(first: Array, second: Array, heading: Array) -> Sense | None:
    """The sense in which the heading (n,) [rad] follows the course of the positions; None: not clear.

    Boats mostly move along their longitudinal axis, forward more than astern.
    """
    good = np.isfinite(first) & np.isfinite(second) & np.isfinite(heading)
    x, y, h = first[good], second[good], np.unwrap(heading[good])
    stride = max(1, len(x) // MOTION_STEPS)
    x, y, h = x[::stride], y[::stride], h[::stride]
    if len(x) < 3 or h.std() < LEAST_TURNED:
        return None
    moved = np.diff(x) + 1j * np.diff(y)
    weights = np.abs(moved) ** 2
    if weights.sum() == 0:
        return None
    course, mid = np.angle(moved), (h[1:] + h[:-1]) / 2
    doubled = {sign: np.exp(2j * (course - sign * mid)) for sign in (1, -1)}
    along = {s: float(np.abs(np.average(x, weights=weights))) for s, x in doubled.items()}
    sign = max(along, key=lambda s: along[s])
    if along[sign] < max(CLEAR_CONCENTRATION, CLEAR_RATIO * along[-sign]):
        return None
    ahead = np.angle(np.average(np.exp(1j * (course - sign * mid)), weights=weights))
    return Sense(sign, round(float(np.degrees(ahead)) / OFFSET_STEP) * OFFSET_STEP % 360)


def rate_factor(stamps: Array, heading: Array, rate: Array) -> tuple[float, float]:
    """Slope and correlation of a yaw rate (n,) against the derivative of the heading [rad]."""
    good = np.isfinite(stamps) & np.isfinite(heading) & np.isfinite(rate)
    t, h, r = stamps[good], np.unwrap(heading[good]), rate[good]
    stride = max(1, len(t) // (4 * MOTION_STEPS))
    steps = np.diff(t[::stride])
    if len(steps) < 3 or not np.all(steps > 0):
        return 0.0, 0.0
    turned = np.diff(h[::stride]) / steps
    total = np.concatenate([[0.0], np.cumsum(r)])
    edges = np.arange(0, len(r), stride)
    mean = np.diff(total[edges]) / stride
    if mean.std() == 0 or turned.std() == 0:
        return 0.0, 0.0
    correlation = float(np.corrcoef(mean, turned)[0, 1])
    return float(mean @ turned / (mean @ mean)), correlation
