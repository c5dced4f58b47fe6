# SPDX-License-Identifier: MIT
"""Poses from a bag: from any message with a position and an orientation, or from tf."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from seatrial.boat.schema import TO_SI, Column, PoseSource
from seatrial.boat.schema import Clock as ClockChoice
from seatrial.boat.vehicle import Vehicle, as_column
from seatrial.io.bags.bag import Bag, Topic
from seatrial.io.bags.collect import Collector, Samples
from seatrial.io.bags.tf import FRAME_FIELDS, is_tf, tf_pose, yaw
from seatrial.io.bags.wire import Wire, WireError, plain
from seatrial.io.table import ANGLE_UNITS, LENGTH_UNITS, scaled
from seatrial.recording.delays import heading_at_positions
from seatrial.recording.timing import Clock, Stream, describe
from seatrial.util.errors import RecordingError
from seatrial.util.frames import POSE_SIGNS, Array, Axes, Mask, Stamps, earth_offset

LARGEST_POSE = 1e9  # [m], [rad] a larger value is not a pose
SECOND_FRAME = 0.01  # share of messages above which a second frame is an error
QUATERNION = ("x", "y", "z", "w")


@dataclass(frozen=True)
class RawPoses:
    """Poses in SI units and forward-left-up axes, unprocessed."""

    stamps: Stamps  # (n,) [ns]
    eta: Array  # (n, 3) x, y [m], psi [rad], not unwrapped
    stream: Stream


@dataclass(frozen=True)
class PoseFields:
    """Topic and fields of the pose."""

    topic: Topic
    x: str
    y: str
    heading: tuple[str, ...]  # an angle, or a quaternion x y z w
    frames: tuple[str, ...]  # fields that name the frames

    def collector(self, source: str, *, salvage: bool) -> Collector:
        """Gathers the fields."""
        paths = (self.x, self.y, *self.heading)
        return Collector(self.topic, paths, source, text_paths=self.frames, salvage=salvage)


def pose_fields(bag: Bag, vehicle: Vehicle) -> PoseFields | None:
    """Topic and fields of the pose; None if it is from tf. Raises RecordingError."""
    spec = vehicle.file.pose
    if spec.topic is None:
        raise RecordingError(
            f"{vehicle.source}: pose: no topic; name one for bags, or let 'seatrial init {bag.path}' "
            "write a vehicle file"
        )
    topic = bag.topic(spec.topic, "pose: topic")
    if is_tf(topic):
        return None
    try:
        wire = topic.wire
    except WireError as error:
        raise RecordingError(f"{bag.path}: topic {topic.name}: {error}") from None
    found = pose_paths(wire)
    given = [as_column(c).field for c in (spec.x, spec.y, spec.psi)]
    if found is None and not all(given):
        raise RecordingError(
            f"{bag.path}: {topic.name} is {topic.type}, which has no position and orientation; name "
            "the fields in the vehicle file (pose: x: {field: ...}), or another topic"
        )
    x, y, *heading = found or ("", "", "")
    return PoseFields(
        topic, given[0] or x, given[1] or y, (given[2],) if given[2] else tuple(heading),
        tuple(f for f in FRAME_FIELDS if wire.has_text(f)),
    )  # fmt: skip


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


def raw_poses(fields: PoseFields, samples: Samples, vehicle: Vehicle, source: str) -> RawPoses:
    """Poses from the fields gathered."""
    keep = _of_one_frame(samples, vehicle.file.pose, source)
    stamps, clock = chosen_stamps(samples, vehicle.file.pose.clock)
    values = samples.values
    plain_angle = len(fields.heading) == 1
    heading = values[:, 2] if plain_angle else heading_of(values[:, 2:], vehicle)
    topic = fields.topic
    stream = describe(
        "poses", topic.name, topic.type, clock=clock, stamps=stamps[keep],
        arrival=samples.arrival[keep], publishers=topic.publishers,
    )  # fmt: skip
    eta = np.column_stack([values[:, 0], values[:, 1], heading])[keep]
    return RawPoses(stamps[keep], in_vehicle_terms(eta, vehicle, stamps[keep]), stream)


def poses_from_tf(bag: Bag, vehicle: Vehicle, *, salvage: bool) -> RawPoses:
    """Poses from transforms."""
    spec = vehicle.file.pose
    topic = bag.topic(spec.topic or "", "pose: topic")
    if spec.parent is None or spec.child is None:
        raise RecordingError(
            f"{vehicle.source}: pose: topic {topic.name} carries transforms: name parent and child, "
            "for instance parent: map and child: base_link"
        )
    found = tf_pose(bag, topic.name, spec.parent, spec.child, salvage=salvage)
    stream = describe(
        "poses", topic.name, f"{topic.type} {spec.parent} -> {spec.child}", clock=Clock.HEADER,
        stamps=found.stamps, arrival=found.arrival,
    )  # fmt: skip
    eta = np.column_stack([found.values[:, :2], heading_of(found.values[:, 3:], vehicle)])
    # undefined before the first and after the last transform of the path
    known = np.isfinite(eta).all(axis=1)
    own = found.stamps[known]
    return RawPoses(own, in_vehicle_terms(eta[known], vehicle, own), stream)


def heading_of(quaternion: Array, vehicle: Vehicle) -> Array:
    """Heading (n,) of quaternions, in the unit of psi."""
    return yaw(quaternion) / TO_SI[pose_columns(vehicle)[2].unit or "rad"]


def in_vehicle_terms(raw: Array, vehicle: Vehicle, stamps: Stamps | None = None) -> Array:
    """Poses (n, 3) of the boat's origin, forward-left-up, from raw x, y and heading.

    With the vehicle file's signs and units, and its lever arm subtracted. stamps: (n,) [ns], to turn the
    lever arm by the heading of the position's time.
    """
    columns = pose_columns(vehicle)
    eta = np.column_stack([scaled(raw[:, i], column) for i, column in enumerate(columns)])
    eta[np.abs(eta) > LARGEST_POSE] = np.nan
    psi, (position, heading) = eta[:, 2], vehicle.delays
    if stamps is not None and position != heading:
        psi = heading_at_positions(stamps, psi, position - heading)
    eta[:, :2] -= earth_offset(psi, *(vehicle.file.pose.lever or (0.0, 0.0)))
    return eta * POSE_SIGNS if vehicle.axes is Axes.FRD else eta


def pose_columns(vehicle: Vehicle) -> list[Column]:
    """x, y and psi of the vehicle file, their units checked."""
    spec = vehicle.file.pose
    columns = [as_column(c) for c in (spec.x, spec.y, spec.psi)]
    for name, column, units in zip(
        ("x", "y", "psi"), columns, (LENGTH_UNITS, LENGTH_UNITS, ANGLE_UNITS), strict=True
    ):
        if column.unit is not None and column.unit not in units:
            raise RecordingError(
                f"{vehicle.source}: pose: {name} has unit '{column.unit}'; use {', '.join(units)}"
            )
    return columns


def chosen_stamps(samples: Samples, choice: ClockChoice) -> tuple[Stamps, Clock]:
    """Header stamps; arrival by choice, or where all headers are zero."""
    if choice == "bag" or samples.header is None:
        return samples.arrival, Clock.ARRIVAL
    if len(samples.header) and not samples.header.any():
        return samples.arrival, Clock.ZERO
    return samples.header, Clock.HEADER


def _of_one_frame(samples: Samples, spec: PoseSource, source: str) -> Mask:
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
