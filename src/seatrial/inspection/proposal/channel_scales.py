# SPDX-License-Identifier: MIT
"""Offset and scale of a channel, and the value of a disarmed autopilot, by its values."""

import numpy as np

from seatrial.util.frames import Array

PWM = (900.0, 2100.0)  # [us] range of servo pulses
PWM_CENTRE = 1500.0  # [us] neutral
PWM_SPANS = (400.0, 500.0, 600.0)  # [us] neutral to full: the least that holds the values
MOST_TRIM = 60.0  # [us] of a neutral pulse width from the centre
LEAST_REST_SHARE = 0.02  # of the rows, at one pulse width: that of rest
OFF_VALUES = (0.0, 65535.0)  # [us] of outputs that are not driven
OVERSHOOT = 1.05  # of full command, up to which a value still belongs to it
USUAL_FULL_COMMANDS = (1.0, 100.0, 127.0, 255.0, 500.0, 1000.0, 32767.0)
LEAST_REACHED = 0.5  # of a usual full command; below, the scale is rounded up from the data


def off_value(raw: Array) -> float | None:
    """The value of a disarmed autopilot among pulse widths; None: there is none."""
    for value in OFF_VALUES:
        rest = raw[raw != value]
        isolated = 0 < len(rest) < len(raw)
        if isolated and rest.min() >= PWM[0] and rest.max() <= PWM[1]:
            return value
    return None


def scale_of(values: Array, full: float | None = None) -> dict[str, float]:
    """Offset and scale for a full command of 1; `full` where the message type defines it."""
    least, most = float(values.min()), float(values.max())
    if PWM[0] <= least and most <= PWM[1]:
        neutral = _neutral(values)
        reached = max(most - neutral, neutral - least) / OVERSHOOT
        spans = (*(span for span in PWM_SPANS if span >= reached), PWM_SPANS[-1])
        return {"offset": neutral, "scale": spans[0]}
    largest = max(abs(least), abs(most))
    usual = next((x for x in USUAL_FULL_COMMANDS if x > largest / OVERSHOOT), 0.0)
    if full is None and largest < LEAST_REACHED * usual and largest > OVERSHOOT:
        decade = 10.0 ** np.floor(np.log10(largest))
        full = float(np.ceil(largest / OVERSHOOT / decade) * decade)
    scale = full or usual or largest
    return {} if scale == 1.0 else {"scale": scale}


def _neutral(pulses: Array) -> float:
    """The pulse width of a boat at rest: the most frequent one near the usual centre."""
    near = np.round(pulses[np.abs(pulses - PWM_CENTRE) <= MOST_TRIM])
    widths, counts = np.unique(near, return_counts=True)
    if len(widths) == 0 or counts.max() < LEAST_REST_SHARE * len(pulses):
        return PWM_CENTRE
    return float(widths[counts.argmax()])
