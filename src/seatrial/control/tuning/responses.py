# SPDX-License-Identifier: MIT
"""Curves of a tuning, with the band of its draws: Bode, sensitivity, step."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.control.tuning.design import Tuning
from seatrial.control.tuning.linear import Complex, LinearBoat
from seatrial.control.tuning.loops import Feedback, frequencies, open_loop
from seatrial.control.tuning.robustness import draws_of
from seatrial.util.frames import Array, frozen_array

RESPONSE_DRAWS = 40  # draws in a band
BODE_FREQUENCIES = 160  # frequencies of a Bode plot
STEP_DURATION = 12.0  # [knobs] of a step response
STEP_TIMES = 240  # of a step response
FREQUENCY_STEP = 0.05  # [1/knob] resolution of a step response; finer has no visible effect
STEP_BANDWIDTH = 10.0  # [1/knob] or over the delay: highest frequency of a step response


@dataclass(frozen=True)
class Curves:
    """Over x (n,): of the model (3, n), and the minimum and maximum of its draws."""

    x: Array
    y: Array
    low: Array
    high: Array

    def __post_init__(self) -> None:
        for name in ("x", "y", "low", "high"):
            object.__setattr__(self, name, frozen_array(getattr(self, name)))


@dataclass(frozen=True)
class Responses:
    """At rest, each axis with the others closed."""

    gain: Curves  # |L| over [rad/s]
    phase: Curves  # [deg]
    sensitivity: Curves  # |S|
    step: Curves  # pose after a step of the reference of 1, without feed-forward, over [s]


def responses(tuning: Tuning) -> Responses:
    """All curves. A band is that of the first `RESPONSE_DRAWS` draws."""
    omega = frequencies(tuning.knob, float(tuning.delay.max()), BODE_FREQUENCIES)
    omega = omega[
        (omega > 0.05 / tuning.knob) & (omega < 10.0 / min(tuning.knob, tuning.delay.max()))
    ]
    draws = min(RESPONSE_DRAWS, tuning.draws)
    boats = [_at_rest(boat) for boat in draws_of(tuning.boat, tuning.model, draws, tuning.seed)]
    loops = np.array(list(_single_loops(tuning, boats, omega)))  # (draws, 3, n)
    phase = np.degrees(np.unwrap(np.angle(loops), axis=-1))
    phase -= 360.0 * np.round((phase[..., :1] + 180.0) / 360.0)  # starts near -180 or -270
    t = np.linspace(0.0, STEP_DURATION * tuning.knob, STEP_TIMES)
    return Responses(
        _banded(omega, np.abs(loops)),
        _banded(omega, phase),
        _banded(omega, 1.0 / np.abs(1.0 + loops)),
        _banded(t, steps_of(tuning, boats, t)),
    )


def steps_of(tuning: Tuning, boats: list[LinearBoat], t: Array) -> Array:
    """Poses (boats, 3, n) at times t [s] after a step of 1, by the closed loop's frequency response T.

    y(t) = 2 / pi times the integral of Re T(i w) sin(w t) / w over w from 0 on: T is stable.
    """
    most = STEP_BANDWIDTH / min(tuning.knob, float(tuning.delay.min()))
    width = FREQUENCY_STEP / tuning.knob
    midpoints = np.arange(0.5, most * tuning.knob / FREQUENCY_STEP)
    omega = midpoints * FREQUENCY_STEP / tuning.knob
    sines = np.sin(np.outer(omega, t)) / omega[:, None]
    return np.array(
        [
            2.0 / np.pi * width * (a / (1.0 + a)).real @ sines
            for a in _single_loops(tuning, boats, omega)
        ]
    )


def _single_loops(tuning: Tuning, boats: list[LinearBoat], omega: Array) -> Iterator[Complex]:
    """Loops (3, n) at rest, each axis with the others closed."""
    feedback = Feedback(tuning.gains, boats[0].speeds, omega, tuning.hold)
    for boat in boats:
        S = np.linalg.inv(np.eye(3) + open_loop(boat, feedback)[0])
        yield np.asarray(1.0 / np.diagonal(S, axis1=1, axis2=2).T - 1.0)


def _at_rest(boat: LinearBoat) -> LinearBoat:
    return LinearBoat(
        boat.mix, boat.authority, boat.actuators, boat.speeds[:1], boat.slopes[:1], boat.steepest
    )  # fmt: skip


def _banded(x: Array, found: Array) -> Curves:
    return Curves(x, found[0], found.min(axis=0), found.max(axis=0))
