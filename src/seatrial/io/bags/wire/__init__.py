# SPDX-License-Identifier: MIT
"""Numbers from serialised ROS messages."""

from seatrial.io.bags.wire.layout import (
    LONGEST_DEFINITION,
    MOST_FIELDS,
    Shape,
    Wire,
    parse_definition,
    plain,
    short_type,
)
from seatrial.io.bags.wire.walk import MOST_ELEMENTS, PRIMITIVES, WireError, described

__all__ = [
    "LONGEST_DEFINITION",
    "MOST_ELEMENTS",
    "MOST_FIELDS",
    "PRIMITIVES",
    "Shape",
    "Wire",
    "WireError",
    "described",
    "parse_definition",
    "plain",
    "short_type",
]
