# SPDX-License-Identifier: MIT
"""Trials of a boat with one steered thruster, or a rudder behind it, as autopilots log them."""

from functools import cache

import numpy as np
from autopilot_logs import ARMED, DISARMED, STEP, Boat, Servo, Trial, integrated

FULL_ANGLE = np.radians(30.0)
ARM = -0.6  # [m] of the thruster from the origin


def steered_boat(
    *, turned: bool = False, steering: int = 26, trim: int = 1500, **parameters: float
) -> Boat:
    """ArduPilot's ground steering on channel 1, throttle on channel 3; turned: the steering servo's sense."""
    return Boat(
        ((ARM, 0.0, 0.0),),
        full=16.0,
        servos=(Servo(3, 70), Servo(1, steering, turned=turned, trim=trim)),
        parameters=tuple(parameters.items()),
    )


@cache
def steered_trial(
    boat: Boat,
    seconds: float = 240.0,
    seed: int = 0,
    *,
    race: float = 1.0,
    flow: float = 0.0,
    sense: float = 1.0,
) -> Trial:
    """Throttle and steering held for 1 to 4 s.

    sense: 1 where a positive steering turns to starboard, -1 to port; race: share of the thrust that the angle turns; flow: [kg/m] side force of a rudder over |u| u sin(angle).
    """
    rng = np.random.default_rng(seed)
    n = round(seconds / STEP) + 1
    commands = np.zeros((n, 2))
    t = ARMED + 1.0
    while t < seconds - DISARMED - 1.0:
        hold = rng.uniform(1.0, 4.0)
        to = min(t + hold, seconds - DISARMED - 1.0)
        commands[round(t / STEP) : round(to / STEP)] = rng.uniform([0.1, -1.0], [1.0, 1.0])
        t += hold
    thrust, angle = boat.full * commands[:, 0], -sense * FULL_ANGLE * commands[:, 1]
    across = race * thrust * np.sin(angle)
    ahead = thrust * (1.0 - race + race * np.cos(angle))
    side = flow * np.sin(angle)
    forces = np.column_stack([ahead, across, ARM * across])
    return integrated(boat, commands, forces, np.column_stack([0.0 * side, side, ARM * side]))
