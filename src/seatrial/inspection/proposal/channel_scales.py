# SPDX-License-Identifier: MIT
"""Offset and scale of a channel by its values, those of a boat that stands still, and of a disarmed autopilot."""

from collections.abc import Iterator, Sequence

import numpy as np

from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

PWM = (900.0, 2100.0)  # [us] range of servo pulses
PWM_CENTRE = 1500.0  # [us] neutral
PWM_SPANS = (400.0, 500.0, 600.0)  # [us] neutral to full: the least that holds the values
MOST_TRIM = 60.0  # [us] of a neutral pulse width from the centre
LEAST_REST_SHARE = 0.02  # of the rows, at one pulse width: that of rest
OFF_VALUES = (0.0, 65535.0)  # [us] of outputs that are not driven
OVERSHOOT = 1.05  # of full command, up to which a value still belongs to it
USUAL_FULL_COMMANDS = (1.0, 100.0, 127.0, 255.0, 500.0, 1000.0, 32767.0)
# from neutral to full
HALF_RANGES = (50.0, 100.0, 127.0, 128.0, 500.0, 512.0, 820.0, 1024.0, 2048.0, 32767.0)
# from idle to full, of thrust ahead only
RANGES = (
    50.0, 60.0, 75.0, 90.0, 100.0, 127.0, 180.0, 255.0, 400.0, 500.0, 600.0, 800.0, 900.0, 1000.0,
)  # fmt: skip
NEUTRAL_WITHIN = 0.3  # of the range, between a neutral value and either end
NEUTRAL_NOISE = 0.01  # of the range, of a stick at rest
LEAST_REACHED = 0.5  # of a usual full command; below, the scale is rounded up from the data
BIN = 1.0  # [s] over which positions are averaged
LEAST_STILL = 3  # bins, one after the other: a boat that reverses is still for less
FAST = 90.0  # [%] of the speeds: that of the drive
STILL_SHARE = 0.1  # of the drive's speed, below which a boat stands still


def off_value(raw: Array) -> float | None:
    """The value of a disarmed autopilot among pulse widths; None: there is none."""
    for value in OFF_VALUES:
        rest = raw[raw != value]
        isolated = 0 < len(rest) < len(raw)
        if isolated and rest.min() >= PWM[0] and rest.max() <= PWM[1]:
            return value
    return None


def scale_of(values: Array, full: float | None = None, idle: float = np.nan) -> dict[str, float]:
    """Offset and scale for a full command of 1; `full` where the message type defines it.

    idle: the least value while the boat stands still; NaN: not known.
    """
    least, most = float(values.min()), float(values.max())
    if least > 0.0 and abs(idle - least) <= NEUTRAL_NOISE * (most - least):  # thrust ahead only
        reached = (most - idle) / OVERSHOOT
        return {"offset": idle, "scale": next((s for s in RANGES if s >= reached), most - idle)}
    if PWM[0] <= least and most <= PWM[1]:
        neutral = _neutral(values)
        reached = max(most - neutral, neutral - least) / OVERSHOOT
        spans = (*(span for span in PWM_SPANS if span >= reached), PWM_SPANS[-1])
        return {"offset": neutral, "scale": spans[0]}
    rest = _neutral_in_the_middle(values)
    if rest is not None:
        reach = max(most - rest, rest - least)
        scale = next((x for x in HALF_RANGES if x >= reach / OVERSHOOT), reach)
        return {"offset": rest, "scale": scale}
    largest = max(abs(least), abs(most))
    usual = next((x for x in USUAL_FULL_COMMANDS if x > largest / OVERSHOOT), 0.0)
    if full is None and largest < LEAST_REACHED * usual and largest > OVERSHOOT:
        decade = 10.0 ** np.floor(np.log10(largest))
        full = float(np.ceil(largest / OVERSHOOT / decade) * decade)
    scale = full or usual or largest
    return {} if scale == 1.0 else {"scale": scale}


def _neutral_in_the_middle(values: Array) -> float | None:
    """The value of a stick at rest, with which a log begins or ends; None: it rests at its least, or is signed."""
    ends = [float(v) for v in values[[0, -1]]]
    if float(values.min()) in ends:  # thrust ahead only, whose log begins or ends during the drive
        return None
    return next((v for v in ends if _is_neutral(values, v)), None)


def _is_neutral(values: Array, value: float) -> bool:
    """Whether a value in the middle of values without a sign is the one at rest: 512 of an analogue stick."""
    least, most = float(values.min()), float(values.max())
    apart = NEUTRAL_WITHIN * (most - least)
    rests = np.mean(np.abs(values - value) < NEUTRAL_NOISE * (most - least)) >= LEAST_REST_SHARE
    inside = least + apart <= value <= most - apart
    return bool(rests and inside and least >= 0.0 and most > OVERSHOOT)


def _neutral(pulses: Array) -> float:
    """The pulse width of a boat at rest: the most frequent one near the usual centre."""
    near = np.round(pulses[np.abs(pulses - PWM_CENTRE) <= MOST_TRIM])
    widths, counts = np.unique(near, return_counts=True)
    if len(widths) == 0 or counts.max() < LEAST_REST_SHARE * len(pulses):
        return PWM_CENTRE
    return float(widths[counts.argmax()])


def idle_values(recordings: Sequence[Recording]) -> Array:
    """The least value (n,) that each input has while the boat stands still; NaN: it never does."""
    found = [np.full(recordings[0].commands.values.shape[1], np.nan)]
    for recording in recordings:
        at = recording.seconds(recording.commands.stamps)
        for begin, end in _still(recording):
            own = recording.commands.values[(at >= begin) & (at < end)]
            found += [own.min(axis=0)] if len(own) else []
    return np.asarray(np.fmin.reduce(found))


def _still(recording: Recording) -> Iterator[tuple[float, float]]:
    """Intervals [s] in which the boat stands still, against its speed elsewhere."""
    t, eta = recording.t[recording.valid], recording.eta[recording.valid]
    number = ((t - t[0]) // BIN).astype(np.int64)
    count = np.bincount(number)
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y = (np.bincount(number, weights=eta[:, i]) / count for i in (0, 1))
    speed = np.hypot(np.diff(x), np.diff(y)) / BIN
    if not np.isfinite(speed).any():
        return
    still = speed < STILL_SHARE * np.nanpercentile(speed, FAST)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(np.int8)))
    for first, last in edges.reshape(-1, 2).tolist():
        if last - first >= LEAST_STILL:  # without the last bin: a command precedes the motion
            yield float(t[0] + BIN * first), float(t[0] + BIN * (last - 1))
