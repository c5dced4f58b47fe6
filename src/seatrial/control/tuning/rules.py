# SPDX-License-Identifier: MIT
"""Gains of one axis by internal model control, in closed form. Derived in docs/tune.md.

The axis is e^(-theta s) / (s (s + d)) from a commanded acceleration to the position, and e^(-theta s) is
approximated by 1 - theta s, as Skogestad (2003) does. Each gain places one closed-loop pole at -1/lambda.
That is IMC with the filter of Morari and Zafiriou (1989, ch. 5) whose numerator cancels the plant's
slow poles out of the response to a disturbance.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Gains:
    """Of one axis, in accelerations.

    proportional: [1/s^2] of the error
    integral: [1/s^3] of its integral
    derivative: [1/s] of its rate
    """

    proportional: float
    integral: float
    derivative: float


NO_GAINS = Gains(0.0, 0.0, 0.0)  # of an axis without thrust


def pd_gains(knob: float, delay: float, drag: float) -> Gains:
    """Without integral action. knob lambda [s], delay theta [s] and drag d [1/s], all >= 0.

    Where the boat's drag exceeds the required damping, the derivative gain is 0: one pole is at
    -1/lambda, the other is faster.
    """
    w = (1.0 + delay * drag) / (knob + delay) ** 2
    derivative = (2.0 * knob + delay) * w - drag
    if derivative >= 0.0:
        return Gains(w, 0.0, derivative)
    return Gains((drag - 1.0 / knob) / (knob + delay), 0.0, 0.0)


def pid_gains(knob: float, delay: float, drag: float) -> Gains:
    """With integral action; arguments as of `pd_gains`."""
    w = (1.0 + delay * drag) / (knob + delay) ** 3
    derivative = (3.0 * knob**2 + 3.0 * knob * delay + delay**2) * w - drag
    if derivative >= 0.0:
        return Gains((3.0 * knob + delay) * w, w, derivative)
    a = 1.0 / knob
    left = drag - 2.0 * a  # of the drag after two poles are placed
    p = (a * a + left * (2.0 * a + a * a * delay)) / (1.0 + a * delay) ** 2
    return Gains(p, a * a * (left - p * delay), 0.0)
