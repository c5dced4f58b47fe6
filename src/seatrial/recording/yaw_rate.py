# SPDX-License-Identifier: MIT
"""The yaw rate of a gyro: its sense and unit checked against the heading, its bias removed, its noise."""

from dataclasses import replace

import numpy as np

from seatrial import _core
from seatrial.recording.asynchronous import Asynchronous
from seatrial.recording.averaging import at_middle
from seatrial.recording.faults.pose_jumps import MAD_TO_SD
from seatrial.recording.recording import Recording, rising
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps

# [Hz] of yaw rates; faster ones are averaged, which keeps what they say of the boat
MOST_RATE = 20.0
INTERVAL = 1.0  # [s] least time over which the integrated rate is compared with the heading
FEWEST_INTERVALS = 8
TURNS = 0.1  # [rad/s] by which the heading's rate varies, from which on it can judge a gyro
MOST_UNEXPLAINED = 0.5  # of the spread of the heading's rate, that the gyro may leave
OUTLIER_SPREADS = 4.0  # of an interval from the others: the heading jumped
GAIN = 0.25  # of 1, by which the heading over the integrated rate may differ
LARGEST_RATE = 1e4  # [rad/s] more than any gyro measures, also in a wrong unit
LEAST_DEVIATION = 1e-5  # [rad/s] of the noise: less is a simulated gyro
DIFFERENCE = np.array([1.0, -3.0, 3.0, -1.0])  # zero for parabolas: smooth motion cancels


class YawRateError(RecordingError):
    """A yaw rate that is not the heading's."""


def with_yaw_rate(recording: Recording, stamps: Stamps, rates: Array, where: str) -> Recording:
    """The recording with yaw rates (m,) [rad/s] of a gyro at stamps (m,) [ns], forward-left-up.

    The bias is removed: the heading shows it over the whole recording. where: the column, for messages.
    Raises YawRateError where the rate is not that of the heading: another sense, axis or unit.
    """
    good = np.abs(rates) < LARGEST_RATE
    stamps, rates = stamps[good], rates[good]
    keep = rising(stamps) if len(stamps) else np.zeros(0, dtype=bool)
    stamps, rates = stamps[keep], rates[keep]
    inside = (stamps > recording.stamps[0]) & (stamps < recording.stamps[-1])
    if inside.sum() < FEWEST_INTERVALS:
        raise YawRateError(
            f"{recording.name}: {where} has {int(inside.sum())} yaw rates during the poses; leave it out"
        )
    t, r = _averaged(recording.seconds(stamps), rates)
    gain, bias = _gain_and_bias(*_turns(recording, t, r))
    if gain is not None and abs(gain - 1.0) > GAIN:
        raise YawRateError(f"{recording.name}: {where} {_said(gain)}")
    return replace(recording, asynchronous=_joined(recording, t, r - bias))


def _joined(recording: Recording, t: Array, r: Array) -> Asynchronous:
    asynchronous = Asynchronous(
        recording.origin + np.rint(1e9 * t).astype(np.int64),
        np.full(len(t), _core.RATE_PART, dtype=np.int8), r, _deviation(r),
    )  # fmt: skip
    known = recording.asynchronous
    return asynchronous if known is None else known.joined(asynchronous)


def _averaged(t: Array, r: Array) -> tuple[Array, Array]:
    """Means of neighbours, so that there are at most `MOST_RATE` of them a second."""
    count = int(np.floor(1.0 / (MOST_RATE * float(np.median(np.diff(t))))))
    if count < 2:
        return t, r
    whole = len(t) // count * count
    groups = t[:whole].reshape(-1, count)
    close = np.ptp(groups, axis=1) < 2.0 / MOST_RATE  # no gap within
    middle, means = groups.mean(axis=1)[close], r[:whole].reshape(-1, count).mean(axis=1)[close]
    return middle, at_middle(np.rint(1e9 * middle).astype(np.int64), means[:, None], count)[:, 0]


def _turns(recording: Recording, t: Array, r: Array) -> tuple[Array, Array, Array]:
    """Heading turned [rad], integrated rate [rad] and length [s] (k,) of intervals without a gap in either."""
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (r[1:] + r[:-1]) * np.diff(t))])
    steps = np.diff(t)
    gap = np.concatenate([[0], np.cumsum(steps > 4.0 / MOST_RATE + 3.0 * np.median(steps))])
    inside = recording.valid & (recording.t >= t[0]) & (recording.t <= t[-1])
    at = np.flatnonzero(inside)
    at = at[np.concatenate([[True], np.diff(np.floor(recording.t[at] / INTERVAL)) > 0])]
    first, last = at[:-1], at[1:]
    begin, end = (np.searchsorted(t, recording.t[i], side="right") - 1 for i in (first, last))
    whole = recording.segment[first] == recording.segment[last]
    whole &= gap[begin] == gap[np.minimum(end + 1, len(t) - 1)]
    first, last = first[whole], last[whole]
    summed = np.interp(recording.t[last], t, angle) - np.interp(recording.t[first], t, angle)
    turned = recording.eta[last, 2] - recording.eta[first, 2]
    return turned, summed, recording.t[last] - recording.t[first]


def _gain_and_bias(turned: Array, summed: Array, length: Array) -> tuple[float | None, float]:
    """Heading over integrated rate, and the bias [rad/s]; the gain is None where the boat hardly turned.

    It is 0 where the rate explains less than half of what the heading turns: another axis.
    """
    if len(turned) < FEWEST_INTERVALS:
        return None, 0.0
    swing = _spread(turned / length)
    # heading = gain * integrated + offset * time, without outliers
    near = np.ones(len(turned), dtype=bool)
    x = np.column_stack([summed, length])
    for _ in range(3):
        found = np.linalg.lstsq(x[near], turned[near], rcond=None)[0]
        rest = np.abs(turned - x @ found)
        near = rest <= OUTLIER_SPREADS * MAD_TO_SD * float(np.median(rest[near])) + 1e-9
    bias = float(np.sum((summed - turned)[near]) / np.sum(length[near]))
    if swing < TURNS:  # only a rate that claims clearly more is judged
        return float(found[0]) if _spread(summed / length) > 2.0 * TURNS else None, bias
    unlike = _spread((turned - x @ found) / length) > MOST_UNEXPLAINED * swing
    return 0.0 if unlike else float(found[0]), bias


def _spread(rates: Array) -> float:
    """90th percentile [rad/s] of the distance from the median."""
    return float(np.percentile(np.abs(rates - np.median(rates)), 90))


def _said(gain: float) -> str:
    """What a gain means, and what to do."""
    for factor, meaning in (
        (-1.0, "turns the other way than the heading: give it sign: -1"),
        (np.pi / 180, "is in deg/s: give it unit: deg"),
        (
            -np.pi / 180,
            "is in deg/s and turns the other way than the heading: give it unit: deg, sign: -1",
        ),
        (180 / np.pi, "is in rad/s, and the file says deg: leave out its unit"),
    ):
        if abs(gain / factor - 1.0) < GAIN:
            return meaning
    if gain == 0.0:
        return "does not follow the heading: it is of another axis or boat. Name another column, or none"
    return f"is not the rate of the heading, which turns {gain:.2g} times as much: name another column, or none"


def _deviation(r: Array) -> float:
    """Standard deviation [rad/s] of the white noise, by third differences."""
    third = np.convolve(r, DIFFERENCE, "valid")
    white = MAD_TO_SD * float(np.median(np.abs(third))) / float(np.sqrt(np.sum(DIFFERENCE**2)))
    return max(white, LEAST_DEVIATION)
