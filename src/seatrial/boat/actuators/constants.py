# SPDX-License-Identifier: MIT
"""Constants of the actuator chain: stages, units, start values and bounds; which actuator uses which."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from seatrial.util.frames import Array

ESTIMATE: Final = "estimate"
STAGES = (
    "latency", "edge_forward", "edge_reverse", "reverse_ratio", "power", "lag", "scale_power", "gain",
    "pair_offset_along", "pair_offset_across", "pair_dead_zone",
    "full_angle", "angle_offset", "slew_rate",
)  # in the order of the core's Actuator  # fmt: skip
SHORTEST_LAG = 1e-6  # [s] a smaller lag is none, as in the core
USES = ("scale", "tabulated", "partner", "across", "mirrored", "steers")  # the core's after these
CURVE = ("edge_forward", "edge_reverse", "reverse_ratio", "power")  # of a single actuator
CONSTANT_UNITS = {  # all others have none
    "latency": "s", "lag": "s", "slew_rate": "1/s",
    "steer_angle": "deg", "steer_offset": "deg", "steer_rate": "deg/s",
}  # fmt: skip
STARTS = {  # start values of estimated constants, by their name or else by their stage
    "latency": 0.0,  # [s]
    "lag": 0.05,  # [s]
    "edge_forward": 0.05,
    "edge_reverse": 0.05,
    "reverse_ratio": 1.0,
    "power": 1.0,
    "scale_power": 2.0,  # thrust grows with the square of a propeller's speed
    "pair_offset_along": 0.0,
    "pair_offset_across": 0.0,
    "pair_dead_zone": 0.05,
    "full_angle": 30.0,  # [deg]
    "angle_offset": 0.0,  # [deg]
    "slew_rate": 2.0,  # [1/s] of thrust
    "steer_rate": 60.0,  # [deg/s]
}
BOUNDS = {  # least and largest value of an estimated constant, by the first part of its name
    "latency": (-1.0, 2.0),  # [s]
    "lag": (0.002, 3.0),  # [s]
    "slew_rate": (0.1, 20.0),  # [1/s]
    "edge_forward": (0.0, 0.6),
    "edge_reverse": (0.0, 0.6),
    "reverse_ratio": (0.1, 10.0),
    "power": (0.3, 4.0),
    "scale_power": (-1.0, 5.0),
    "gain": (0.1, 10.0),
    "pair_offset_along": (-0.5, 0.5),
    "pair_offset_across": (-0.5, 0.5),
    "pair_dead_zone": (0.0, 0.6),
    "steer_angle": (3.0, 180.0),  # [deg]
    "steer_offset": (-45.0, 45.0),  # [deg]
    "steer_rate": (3.0, 1000.0),  # [deg/s]
    "steer_dead_zone": (0.0, 0.6),
}
ABSENT_AT = {  # the end of the range (0: least, 1: largest value) at which a boat has no such stage
    "lag": 0, "edge_forward": 0, "edge_reverse": 0, "pair_dead_zone": 0, "steer_dead_zone": 0,
    "slew_rate": 1, "steer_rate": 1,
}  # fmt: skip


@dataclass(frozen=True)
class Constants:
    """Constants of the actuator chain: names, values, and the index from each actuator to its own."""

    names: tuple[str, ...]
    values: Array  # (n,) given values; start values of those to be estimated
    index: NDArray[np.int32]  # (actuators, 14): STAGES -> place in `values`, -1: stage absent
    estimated: tuple[str, ...]  # names of those that the file leaves to the estimator

    def of_each(self, stage: str, values: Array) -> Array:
        """A stage's constant (actuators,) out of all values (n,); 0 where there is no such stage."""
        index = self.index[:, STAGES.index(stage)]
        return np.where(index >= 0, np.append(values, 0.0)[index], 0.0)

    @property
    def shared(self) -> dict[str, str]:
        """The constant behind each name of a stage that has none of its own: the reverse edge of equal ones."""
        found = {}
        for k, column in np.argwhere(self.index >= 0).tolist():
            stage, name = STAGES[column], self.names[self.index[k, column]]
            kind, dot, group = name.partition(".")
            if kind in STAGES and kind != stage:
                found[stage + dot + group] = name
        return found

    def bounds(self, place: int) -> tuple[float, float]:
        """Least and largest value of a constant while it is estimated."""
        return BOUNDS[self.names[place].partition(".")[0]]

    def unit(self, name: str) -> str:
        """SI unit of a constant; a suffix after the dot is its group."""
        return CONSTANT_UNITS.get(name.partition(".")[0], "-")
