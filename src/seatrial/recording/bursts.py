# SPDX-License-Identifier: MIT
"""Stamps of arrival: poses leave evenly, wait in a queue, and arrive together."""

import numpy as np

from seatrial.util.frames import Array, Stamps

LATE = 1.5  # periods: a step from which on poses may have waited
CLOSE = 0.5  # periods, most of the step after it: the queue arrives at once
FEWEST_QUEUES = 5
FEWEST_POSES = 50
QUEUE_SHARE = 0.6  # of the long steps that a queue follows, in a log of arrivals
ON_TIME = 0.1  # periods, by which the step before a pose that did not wait differs from one
SLACK = 0.25  # periods, by which a pose may arrive before its own time on the even clock
AROUND = 40  # poses on time on either side, whose median sets the clock


def on_even_clock(stamps: Stamps) -> tuple[Stamps, str]:
    """Stamps (n,) [ns] as if the poses had not waited, and what was found; as they are where none did.

    A wireless network stalls for some periods, then a queue arrives at once: a long step is followed by
    close ones. The poses are put back on the even clock of those that did not wait.
    """
    steps = np.diff(stamps).astype(np.float64) * 1e-9
    if len(stamps) < FEWEST_POSES or np.any(steps < 0):
        return stamps, ""
    period = float(np.median(steps))
    long = np.flatnonzero(steps[:-1] > LATE * period)
    queues = int((steps[long + 1] < CLOSE * period).sum())
    if queues < FEWEST_QUEUES or queues < QUEUE_SHARE * len(long):
        return stamps, ""
    seconds = (stamps - stamps[0]).astype(np.float64) * 1e-9
    on_time = np.flatnonzero(np.abs(steps / period - 1.0) < ON_TIME) + 1
    if len(on_time) < 2 * AROUND:
        return stamps, ""
    # 1. The even clock: the times of poses that did not wait, against their numbers.
    number = np.concatenate([[0], np.cumsum(np.rint(np.diff(seconds[on_time]) / period))])
    period = float(np.polyfit(number, seconds[on_time], 1)[0])
    level = _median_around(seconds[on_time] - period * number)
    phase = np.interp(seconds, seconds[on_time], level)
    # 2. The latest number of each pose: in a queue they follow each other.
    latest = np.floor((seconds - phase) / period + SLACK).astype(np.int64)
    for i in range(len(latest) - 2, -1, -1):
        latest[i] = min(latest[i], latest[i + 1] - 1)
    even = period * latest + phase
    late = float(np.max(seconds - even))
    text = (
        f"poses arrive in {queues} bursts: they are stamped on arrival, up to {1e3 * late:.0f} ms late; put "
        f"on the even clock of {1.0 / period:.3g} Hz that they left with"
    )
    return np.asarray(stamps[0] + np.rint(1e9 * even).astype(np.int64)), text


def _median_around(values: Array) -> Array:
    """Running median over `AROUND` values on either side."""
    padded = np.pad(values, AROUND, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * AROUND + 1)
    return np.asarray(np.median(windows, axis=1))
