# SPDX-License-Identifier: MIT
"""What a bag's usual messages hold of a pose, and in which frame they state it."""

from collections import Counter
from collections.abc import Mapping

import msgspec
import numpy as np

from seatrial.boat.schema import Clock as ClockChoice
from seatrial.boat.schema import Column, PoseSource
from seatrial.boat.vehicle import Vehicle
from seatrial.io.bags.bag import Bag, Topic
from seatrial.io.bags.collect import Samples
from seatrial.io.bags.tf import FRAME_FIELDS, is_tf
from seatrial.io.bags.wire import Wire, plain
from seatrial.recording.timing import Clock
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Mask, Stamps

SECOND_FRAME = 0.01  # share of messages above which a second frame is an error
QUATERNION = ("x", "y", "z", "w")


def usual_columns(bag: Bag, vehicle: Vehicle) -> Mapping[str, Column]:
    """Columns of x, y and psi: named fields, or what the topic's message has. Raises RecordingError."""
    spec = vehicle.file.pose
    geographic = spec.latitude is not None
    found: dict[str, Column] = {}
    for key, column in spec.columns.items():
        name = column.topic or spec.topic
        if column.field or column.quaternion or name is None or (geographic and key != "psi"):
            found[key] = column
            continue
        topic = bag.topic(name, "pose: topic" if not column.topic else f"pose: {key}")
        found[key] = column if is_tf(topic) else _from_message(bag, topic, key, column)
    return found


def _from_message(bag: Bag, topic: Topic, key: str, column: Column) -> Column:
    """The column with the field or quaternion that the topic's message has for x, y or psi."""
    wire = topic.layout(str(bag.path))
    pose = pose_paths(wire)
    turn = orientation_paths(wire) if pose is None else pose[2:]
    if (pose is None and key != "psi") or not turn:
        raise RecordingError(
            f"{bag.path}: {topic.name} is {topic.type}, which has no position and orientation; name "
            "the fields in the vehicle file (pose: x: {field: ...}), or another topic"
        )
    if key != "psi" and pose is not None:
        return msgspec.structs.replace(column, field=pose["xy".index(key)])
    if len(turn) == 1:
        return msgspec.structs.replace(column, field=turn[0])
    x, y, z, w = turn
    return msgspec.structs.replace(column, quaternion=(x, y, z, w))


def pose_paths(wire: Wire) -> tuple[str, ...] | None:
    """x, y and the orientation's fields of a message; None if it has none."""
    paths = set(wire.paths())
    for position, orientation in (("position", "orientation"), ("translation", "rotation")):
        ends = [p.removesuffix(f"{orientation}.w") for p in paths if p.endswith(f"{orientation}.w")]
        for prefix in sorted(ends, key=len):
            found = [f"{prefix}{position}.x", f"{prefix}{position}.y"]
            found += [f"{prefix}{orientation}.{q}" for q in QUATERNION]
            if "[]" not in prefix and paths.issuperset(found):
                return tuple(found)
    if paths.issuperset(("x", "y", "theta")):  # Pose2D
        return "x", "y", "theta"
    return None


def array_pose_paths(wire: Wire) -> tuple[str, str, str] | None:
    """x, y and a part of the orientation in arrays: of their first pose, or position[0] and q[0]; None: none."""
    paths = set(wire.paths())
    for whole in sorted(p for p in paths if p.endswith("orientation.w") and "[]" in p):
        prefix = whole.removesuffix("orientation.w")
        found = (f"{prefix}position.x", f"{prefix}position.y", whole)
        if paths.issuperset(found):
            x, y, turn = (p.replace("[]", "[0]") for p in found)
            return x, y, turn
    if paths.issuperset(("position[]", "q[]")):  # PX4
        return "position[0]", "position[1]", "q[0]"
    return None


def orientation_paths(wire: Wire) -> tuple[str, ...]:
    """The orientation's fields of a message without a position, such as Imu's; none if it has none."""
    paths = set(wire.paths())
    ends = [p[:-1] for p in paths if p == "w" or p.endswith((".w", "orientation.w"))]
    for prefix in sorted(ends, key=len):
        found = tuple(f"{prefix}{q}" for q in QUATERNION)
        if "[]" not in prefix and paths.issuperset(found):
            return found
    return ()


def chosen_stamps(samples: Samples, choice: ClockChoice) -> tuple[Stamps, Clock]:
    """Header stamps; arrival by choice, or where all headers are zero."""
    if choice == "bag" or samples.header is None:
        return samples.arrival, Clock.ARRIVAL
    if len(samples.header) and not samples.header.any():
        return samples.arrival, Clock.ZERO
    return samples.header, Clock.HEADER


def of_one_frame(samples: Samples, spec: PoseSource, source: str) -> Mask:
    """Messages of the requested frames. Raises RecordingError where several are mixed."""
    keep = np.ones(len(samples.arrival), dtype=bool)
    for path, key, name in zip(
        FRAME_FIELDS, ("parent", "child"), (spec.parent, spec.child), strict=True
    ):
        if path not in samples.texts:
            continue
        frames = [text.lstrip("/") for text in samples.texts[path]]
        counts = Counter(frames)
        listed = ", ".join(f"'{plain(f)}' ({n})" for f, n in counts.most_common(8))
        if name is not None and frames:
            keep &= np.array([frame == name.lstrip("/") for frame in frames])
            if not keep.any():
                raise RecordingError(
                    f"{source}: no pose on {samples.topic.name} has {path} '{name}' (pose: {key}); there "
                    f"are {listed}"
                )
        elif sum(n > SECOND_FRAME * len(frames) for n in counts.values()) > 1:
            raise RecordingError(
                f"{source}: {samples.topic.name} mixes poses of several frames, {path} {listed}: two "
                f"robots, or two sources; select one with pose: {key}"
            )
    return keep
