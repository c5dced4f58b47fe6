# SPDX-License-Identifier: MIT
"""Parameters of the likelihood beside the coefficients: their names, bounds, step limits and typical sizes."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from seatrial.boat.structure import Structure
from seatrial.util.frames import SYMBOLS

LEVER_NAMES = ("lever_x", "lever_y")  # [m] the measured point from the origin
DELAY_NAMES = ("delay_position", "delay_heading")  # [s] beyond what the vehicle file states
EFFECT_NAMES = (  # of one recording, in the order of the core's Effects between lever arm and delays
    "current_x", "current_y",  # [m/s] earth-fixed
    "trim_u", "trim_v", "trim_r",  # [m/s^2, rad/s^2] body-fixed
    "wind_x", "wind_y",  # [m/s^2] earth-fixed
    "wind_turn_x", "wind_turn_y",  # [rad/s^2] earth-fixed; the part across the boat turns it
    "wind_side_x", "wind_side_y",  # [m/s^2] earth-fixed; what sway has beyond wind_x, wind_y
)  # fmt: skip
EFFECT_KINDS = ("lever", "current", "trim", "wind", "delay")
LONGEST_DELAY = 5.0  # [s] of position or heading, as a vehicle file takes it
START_DELAY = 0.01  # [s] with it position and heading are two measurements from the first step on
DELAY_STEP = 0.3  # [s] largest change of a delay in one Gauss-Newton step


@dataclass(frozen=True)
class ChainConstant:
    """What is assumed of one kind of constant of the actuator chain."""

    step: float = np.inf  # largest change in one Gauss-Newton step: the chain is far from linear
    # size that its error is relative to, at the least: a latency of 0 is as good as any
    typical: float = 0.0


CHAIN_CONSTANTS = {
    "latency": ChainConstant(step=0.1, typical=0.1),  # [s]
    "lag": ChainConstant(step=0.1, typical=0.1),  # [s]
    "slew_rate": ChainConstant(step=1.0),  # [1/s]
    "edge_forward": ChainConstant(step=0.1, typical=0.1),
    "edge_reverse": ChainConstant(step=0.1, typical=0.1),
    "reverse_ratio": ChainConstant(step=0.5),
    "power": ChainConstant(step=0.5),
    "scale_power": ChainConstant(step=0.5),
    "gain": ChainConstant(step=0.5),
    "pair_offset_along": ChainConstant(typical=0.1),
    "pair_offset_across": ChainConstant(typical=0.1),
    "pair_dead_zone": ChainConstant(typical=0.1),
    "steer_angle": ChainConstant(step=10.0),  # [deg]
    "steer_offset": ChainConstant(step=10.0, typical=5.0),  # [deg]
    "steer_rate": ChainConstant(step=20.0),  # [deg/s]
    "steer_dead_zone": ChainConstant(step=0.1, typical=0.1),
}


def typical_size(name: str) -> float:
    """The size that the error of a parameter is relative to, at the least; 0: its own value."""
    constant = CHAIN_CONSTANTS.get(name.partition(".")[0])
    return 0.0 if constant is None else constant.typical


def quadratic_drag(structure: Structure) -> set[str]:
    """Coefficients of |u| u in surge, |v| v in sway, |r| r in yaw: a positive one makes the boat unstable,
    as no other term of the axis outgrows it."""
    terms = [t for t in structure.terms if t.coefficient is not None]
    used = Counter(t.coefficient for t in terms)
    return {
        t.coefficient
        for t in terms
        if t.coefficient is not None
        and used[t.coefficient] == 1
        and t.number > 0.0
        and t.acceleration is None
        and sorted(t.factors) == sorted([f"|{SYMBOLS[t.axis]}|", SYMBOLS[t.axis]])
    }
