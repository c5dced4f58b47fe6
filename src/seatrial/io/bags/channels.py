# SPDX-License-Identifier: MIT
"""Numeric fields of a topic, and frames of a tf tree: for `init`."""

import re
from itertools import islice

from seatrial.io.bags.bag import Bag, Topic
from seatrial.io.bags.tf import frame_edges
from seatrial.io.bags.wire_walk import WireError
from seatrial.util.errors import RecordingError

INSPECTED_MESSAGES = 50  # arrays have one length in nearly all logs
MOST_FIELDS = 32
NOT_CHANNELS = ("header.", "layout.", "buttons", "rssi", "seq", "covariance")


def holds_numbers(topic: Topic, most: int) -> bool:
    """Whether its messages hold so many numbers beside their header, or fewer: Float64, FloatStamped one."""
    if not topic.readable:
        return False
    own = [p for p in topic.wire.paths() if not p.startswith(NOT_CHANNELS)]
    return 1 <= len(own) <= most and "[" not in "".join(own)


def number_fields(bag: Bag, topic: str) -> list[str]:
    """Field paths of the numbers in a topic's messages, arrays spelled out."""
    wire = bag.topic(topic, "init").layout(str(bag.path))
    first = [raw for _, _, raw in islice(bag.messages({topic}), INSPECTED_MESSAGES)]
    try:
        shapes = list(wire.shapes(first))
    except WireError as error:
        raise RecordingError(f"{bag.path}: a message on {topic} {error}") from None
    shape = max(shapes, key=lambda s: len(s.rows))
    single = set(wire.paths())  # arrays are listed there as name[]
    found = []
    for name, leaf in shape.leaves.items():
        if leaf.dtype == "S" or name.startswith(NOT_CHANNELS):
            continue
        plain = re.sub(r"\[\d+\]", "[]", name) in single
        found += [name] if plain else [f"{name}[{i}]" for i in range(leaf.count)]
    return found[:MOST_FIELDS]


def tf_frames(bag: Bag, topic: str) -> list[tuple[str, str, bool]]:
    """Parent and child of every transform, and whether it moves."""
    return sorted((parent, child, not fixed) for (parent, child), fixed in frame_edges(bag, topic))
