# SPDX-License-Identifier: MIT
"""The pose of one frame in another from the transforms in a bag, static ones composed."""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.io.bags.bag import SALVAGE, Bag, Topic
from seatrial.io.bags.wire import Shape, plain
from seatrial.io.bags.wire_walk import WireError
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps
from seatrial.util.progress import reach, stage
from seatrial.util.quaternion import product, rotated, slerp, unit

TYPES = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
TF_BATCH = 4096  # messages decoded at once
NUMBERS = (
    "translation.x", "translation.y", "translation.z",
    "rotation.x", "rotation.y", "rotation.z", "rotation.w",
)  # fmt: skip
STAMP = ("header.stamp.sec", "header.stamp.nanosec")
FRAME_FIELDS = ("header.frame_id", "child_frame_id")
MOST_EDGES = 30  # edges in a message
Edge = tuple[str, str]  # parent, child


@dataclass(frozen=True)
class Transforms:
    """One edge of the tree over time: the child's pose in the parent."""

    stamps: Stamps  # (n,) [ns]
    arrival: Stamps  # (n,) [ns]
    values: Array  # (n, 7) position [m], quaternion x y z w


def is_tf(topic: Topic) -> bool:
    """Whether a topic carries transforms."""
    return topic.type_name in TYPES


def tf_pose(bag: Bag, name: str, parent: str, child: str) -> Transforms:
    """The pose of `child` in `parent`, at the stamps of the moving transform nearest the child."""
    names = _topics(bag, name)
    with stage("", 0.5):
        edges = frame_edges(bag, name)
    path = _path(bag, {edge for edge, _ in edges}, parent.lstrip("/"), child.lstrip("/"))
    wanted = {edge for edge, _ in path}
    with stage(""):
        found = _collect(bag, names, wanted)
    static = {edge for edge, is_fixed in edges if is_fixed}
    moving = [edge for edge, _ in path if edge not in static]
    if not moving:
        raise RecordingError(
            f"{bag.path}: the transforms from {parent} to {child} are all static; name frames that move"
        )
    base = found[moving[-1]]
    pose = np.tile([0.0, 0, 0, 0, 0, 0, 1], (len(base.stamps), 1))
    with np.errstate(over="ignore", invalid="ignore"):  # NaN is dropped later
        for edge, forward in path:
            step = found[edge]
            # a static transform: the last one
            at = step.values[-1:] if edge in static else _interpolated(step, base.stamps)
            at = np.broadcast_to(at if forward else _inverse(at), pose.shape)
            moved = pose[:, :3] + rotated(pose[:, 3:], at[:, :3])  # T_pose T_at
            pose = np.column_stack([moved, product(pose[:, 3:], at[:, 3:])])
    return Transforms(base.stamps, base.arrival, pose)


def frame_edges(bag: Bag, name: str) -> set[tuple[Edge, bool]]:
    """Parent and child of every transform, and whether it is static."""
    return {
        (edge, topic.endswith("_static"))
        for topic, batch in _batches(bag, _topics(bag, name))
        for shape in _shapes(bag, topic, batch)
        for _, edges in _frames(shape)
        for edge in edges
    }


def _topics(bag: Bag, name: str) -> list[str]:
    """The topic and its static topic."""
    found = [t for t in bag.topics.values() if is_tf(t) and t.name in (name, f"{name}_static")]
    for topic in found:
        _check_definition(bag, topic)
    return [topic.name for topic in found]


def _check_definition(bag: Bag, topic: Topic) -> None:
    """Raise RecordingError where a topic's definition is not that of transforms."""
    where = f"{bag.path}: topic {topic.name}"
    try:
        for path in (*STAMP, *(f"transform.{number}" for number in NUMBERS)):
            topic.wire.require(f"transforms[0].{path}", where)
    except WireError as error:
        raise RecordingError(f"{where}: {error}") from None
    if not all(topic.wire.has_text(f"transforms.{frame}") for frame in FRAME_FIELDS):
        raise RecordingError(f"{where}: its transforms do not name their frames")


def _batches(bag: Bag, names: Iterable[str]) -> Iterator[tuple[str, list[tuple[int, bytes]]]]:
    waiting: dict[str, list[tuple[int, bytes]]] = {}
    counts = dict.fromkeys(names, 0)
    messages = sum(bag.topics[name].messages for name in counts)
    for topic, arrival, raw in bag.messages(counts.keys()):
        batch = waiting.setdefault(topic, [])
        batch.append((arrival, raw))
        counts[topic] += 1
        if len(batch) >= TF_BATCH:
            reach(sum(counts.values()) / max(messages, 1))
            yield topic, waiting.pop(topic)
    yield from waiting.items()
    for topic, count in counts.items():
        bag.check(topic, count)


def _shapes(bag: Bag, topic: str, batch: list[tuple[int, bytes]]) -> Iterator[Shape]:
    wire = bag.topics[topic].wire
    messages = [raw for _, raw in batch]
    try:
        yield from list(wire.shapes(messages))
    except WireError as error:
        if not bag.salvage:
            raise RecordingError(f"{bag.path}: a message on {topic} {error}; {SALVAGE}") from None
        good = wire.readable(messages)
        for shape in wire.shapes([messages[i] for i in good]):
            yield Shape(np.array(good)[shape.rows], shape.data, shape.leaves)


def _frames(shape: Shape) -> Iterator[tuple[int, list[Edge]]]:
    """For every transform in the messages: its number, and parent and child in each."""
    number = 0
    while f"transforms[{number}].child_frame_id" in shape.leaves:
        parents = shape.texts(f"transforms[{number}].header.frame_id") or []
        children = shape.texts(f"transforms[{number}].child_frame_id") or []
        pairs = zip(parents, children, strict=True)
        yield number, [(p.lstrip("/"), c.lstrip("/")) for p, c in pairs]
        number += 1


def _path(bag: Bag, edges: set[Edge], parent: str, child: str) -> list[tuple[Edge, bool]]:
    """Edges from parent to child, and whether each is traversed from its own parent."""
    reached: dict[str, tuple[Edge, bool, str]] = {}
    waiting = deque([parent])
    while waiting:
        frame = waiting.popleft()
        for edge in sorted(edges):
            for begin, end, forward in ((*edge, True), (edge[1], edge[0], False)):
                if begin == frame and end != parent and end not in reached:
                    reached[end] = (edge, forward, frame)
                    waiting.append(end)
    if child not in reached:
        listed = ", ".join(f"{plain(p)} -> {plain(c)}" for p, c in sorted(edges)[:MOST_EDGES])
        listed = listed or "none"
        if len(edges) > MOST_EDGES:
            listed += f" and {len(edges) - MOST_EDGES} more"
        raise RecordingError(
            f"{bag.path}: no transforms lead from '{parent}' to '{child}'; the bag has {listed}{_no_static(bag)}"
        )
    path: list[tuple[Edge, bool]] = []
    frame = child
    while frame != parent:
        edge, forward, frame = reached[frame]
        path.append((edge, forward))
    return path[::-1]


def _no_static(bag: Bag) -> str:
    """Where static transforms may be, if there are none in the bag."""
    if any(is_tf(t) and t.name.endswith("_static") and t.messages for t in bag.topics.values()):
        return ""
    return (
        ", and no tf_static. Of a recording in several files the first one alone may have it: give the folder "
        "with all of them, or record /tf_static"
    )


def _collect(bag: Bag, names: Iterable[str], wanted: set[Edge]) -> dict[Edge, Transforms]:
    parts: dict[Edge, list[Transforms]] = {edge: [] for edge in wanted}
    for topic, batch in _batches(bag, names):
        arrival = np.array([a for a, _ in batch], dtype=np.int64)
        for shape in _shapes(bag, topic, batch):
            for number, edges in _frames(shape):
                for edge in wanted.intersection(edges):
                    mine = np.array([e == edge for e in edges])
                    stamps, values = _numbers(shape, f"transforms[{number}]")
                    own = Transforms(stamps[mine], arrival[shape.rows][mine], values[mine])
                    parts[edge].append(own)
    return {edge: _joined(found) for edge, found in parts.items()}


def _numbers(shape: Shape, path: str) -> tuple[Stamps, Array]:
    columns = [shape.numbers(f"{path}.transform.{number}") for number in NUMBERS]
    seconds, nanoseconds = (shape.integers(f"{path}.{part}") for part in STAMP)
    if seconds is None or nanoseconds is None:
        raise RecordingError(f"{path} has no stamp")
    values = np.column_stack([c for c in columns if c is not None])
    return seconds * 10**9 + nanoseconds, values


def _joined(parts: list[Transforms]) -> Transforms:
    """All parts, in the order in which they arrived."""
    arrival = np.concatenate([p.arrival for p in parts])
    order = np.argsort(arrival, kind="stable")
    return Transforms(
        np.concatenate([p.stamps for p in parts])[order], arrival[order],
        np.concatenate([p.values for p in parts])[order],
    )  # fmt: skip


def _interpolated(step: Transforms, at: Stamps) -> Array:
    """Between the two nearest, as tf2 does; NaN before the first and after the last."""
    stamps, first = np.unique(step.stamps, return_index=True)
    values = step.values[first]
    if len(stamps) < 2:
        return np.where((at == stamps[0])[:, None], values[0], np.nan)
    right = np.clip(np.searchsorted(stamps, at, side="left"), 1, len(stamps) - 1)
    share = ((at - stamps[right - 1]) / (stamps[right] - stamps[right - 1]))[:, None]
    a, b = values[right - 1], values[right]
    inside = (share >= 0) & (share <= 1)
    moved = a[:, :3] + share * (b[:, :3] - a[:, :3])
    between = np.column_stack([moved, slerp(a[:, 3:], b[:, 3:], share)])
    between = np.where(share <= 0, a, np.where(share >= 1, b, between))  # also next to a NaN
    return np.where(inside, between, np.nan)


def _inverse(a: Array) -> Array:
    q = unit(a[:, 3:]) * [-1.0, -1.0, -1.0, 1.0]
    return np.column_stack([-rotated(q, a[:, :3]), q])
