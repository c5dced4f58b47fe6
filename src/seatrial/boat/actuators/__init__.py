# SPDX-License-Identifier: MIT
"""The actuator models of a vehicle file."""

from seatrial.boat.actuators.constants import (
    ABSENT_AT,
    BOUNDS,
    CURVE,
    ESTIMATE,
    SHORTEST_LAG,
    STAGES,
    STARTS,
    USES,
    Constants,
)
from seatrial.boat.actuators.reader import ChainReader
from seatrial.boat.actuators.stated_values import stated

__all__ = [
    "ABSENT_AT", "BOUNDS", "CURVE", "ESTIMATE", "SHORTEST_LAG", "STAGES", "STARTS", "USES", "ChainReader",
    "Constants", "stated",
]  # fmt: skip
