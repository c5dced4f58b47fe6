# SPDX-License-Identifier: MIT
"""Curves of a tuning, with the band of its draws: Bode, sensitivity, step."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from seatrial.control.tuning.design import Tuning
from seatrial.control.tuning.linear import Complex, LinearBoat
from seatrial.control.tuning.loops import Feedback, frequencies, single_loops
from seatrial.control.tuning.robustness import draws_of
from seatrial.util.frames import Array, freeze

RESPONSE_DRAWS = 40  # draws in a band
BODE_FREQUENCIES = 160  # frequencies of a Bode plot
STEP_DURATION = 12.0  # [time constants of the slowest loop] of a step response
STEP_TIMES = 240  # of a step response
# [1/time constant] resolution of a step response; finer has no visible effect
FREQUENCY_STEP = 0.05
STEP_BANDWIDTH = 10.0  # [1/knob] or over the delay: highest frequency of a step response


@dataclass(frozen=True)
class Curves:
    """Over x (n,): of the model (3, n), and the minimum and maximum of its draws."""

    x: Array
    y: Array
    low: Array
    high: Array

    def __post_init__(self) -> None:
        freeze(self, "x", "y", "low", "high")


@dataclass(frozen=True)
class Responses:
    """At rest, each axis with the others closed; with guidance, ahead at full speed."""

    gain: Curves  # |L| over [rad/s]
    phase: Curves  # [deg]
    sensitivity: Curves  # |S|
    step: Curves  # pose after a step of the reference of 1, without feed-forward, over [s]


def responses(tuning: Tuning) -> Responses:
    """All curves. A band is that of the first `RESPONSE_DRAWS` draws."""
    omega = frequencies(tuning.knob, float(tuning.delay.max()), BODE_FREQUENCIES, tuning.slowest)
    omega = omega[
        (omega > 0.05 / tuning.slowest) & (omega < 10.0 / min(tuning.knob, tuning.delay.max()))
    ]
    draws = min(RESPONSE_DRAWS, tuning.draws)
    boats = [
        _about(boat, tuning) for boat in draws_of(tuning.boat, tuning.model, draws, tuning.seed)
    ]
    loops = np.array(list(_single_loops(tuning, boats, omega)))  # (draws, 3, n)
    phase = np.degrees(np.unwrap(np.angle(loops), axis=-1))
    phase -= 360.0 * np.round((phase[..., :1] + 180.0) / 360.0)  # starts near -180 or -270
    t = np.linspace(0.0, STEP_DURATION * tuning.slowest, STEP_TIMES)
    return Responses(
        _banded(omega, np.abs(loops)),
        _banded(omega, phase),
        _banded(omega, 1.0 / np.abs(1.0 + loops)),
        _banded(t, steps_of(tuning, boats, t)),
    )


def steps_of(tuning: Tuning, boats: list[LinearBoat], t: Array) -> Array:
    """Poses (boats, 3, n) at times t [s] after a step of 1, by the frequency response T from reference to pose.

    y(t) = 2 / pi times the integral of Re T(i w) sin(w t) / w over w from 0 on: T is stable.
    """
    most = STEP_BANDWIDTH / min(tuning.knob, float(tuning.delay.min()))
    width = FREQUENCY_STEP / tuning.slowest
    midpoints = np.arange(0.5, most * tuning.slowest / FREQUENCY_STEP)
    omega = midpoints * FREQUENCY_STEP / tuning.slowest
    sines = np.sin(np.outer(omega, t)) / omega[:, None]
    step = _step_share(tuning, omega)
    loops = _single_loops(tuning, boats, omega)
    return np.array([2.0 / np.pi * width * (step * a / (1.0 + a)).real @ sines for a in loops])


def _step_share(tuning: Tuning, omega: Array) -> Complex:
    """Share (3, n) of each controller that acts on a step of the reference, whose velocity, for D, stays 0."""
    surge, sway, yaw = tuning.gains
    s, found = 1j * omega, []
    for own in (surge, sway if tuning.guidance is None else yaw, yaw):
        pi = own.proportional + own.integral / s
        found.append(pi / (pi + own.derivative * s))
    return np.array(found)


def _single_loops(tuning: Tuning, boats: list[LinearBoat], omega: Array) -> Iterator[Complex]:
    """Loops (3, n) about the first motion of each boat, each with the others closed."""
    feedback = Feedback(tuning.gains, boats[0].speeds, omega, tuning.hold, tuning.guidance)
    for boat in boats:
        yield single_loops(boat, feedback)[0][0]


def _about(boat: LinearBoat, tuning: Tuning) -> LinearBoat:
    """About rest or, with guidance, which needs way on, about the fastest motion ahead."""
    at = 0 if tuning.guidance is None else int(np.argmax(boat.speeds[:, 0]))
    return replace(boat, speeds=boat.speeds[at : at + 1], slopes=boat.slopes[at : at + 1])


def _banded(x: Array, found: Array) -> Curves:
    return Curves(x, found[0], found.min(axis=0), found.max(axis=0))
