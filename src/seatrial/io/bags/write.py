# SPDX-License-Identifier: MIT
"""Bags, written through rosbags, atomically.

rosbags serialises one message of a topic. The others are copies of its bytes with other numbers
in the varying fields.
"""

import heapq
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from seatrial.io.bags.bag import COMMON, standard_definitions
from seatrial.io.bags.wire import Shape, Wire, short_type
from seatrial.io.bags.wire_walk import described
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.files import sync_folder, writable
from seatrial.util.frames import Array, Stamps

if TYPE_CHECKING:
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys.store import Typestore

BAG_FORMATS = ("bag", "mcap", "db3")
CLASSES = {  # the message of a command's field, by the first name of its path
    "axes": "sensor_msgs/msg/Joy",
    "data": "std_msgs/msg/Float64MultiArray",
    "channels": "mavros_msgs/msg/RCOut",
    "wrench": "geometry_msgs/msg/WrenchStamped",
    "force": "geometry_msgs/msg/Wrench",
    "torque": "geometry_msgs/msg/Wrench",
    "twist": "geometry_msgs/msg/TwistStamped",
    "linear": "geometry_msgs/msg/Twist",
    "angular": "geometry_msgs/msg/Twist",
}


@dataclass(frozen=True)
class BagTopic:
    """A topic to be written."""

    name: str
    type_name: str
    arrival: Stamps  # (n,) [ns] by the recorder's clock
    stamps: Stamps  # (n,) [ns] for the header, if the message has one
    columns: Mapping[str, Array]  # by field path: (n,)
    texts: Mapping[str, str] = field(default_factory=dict)


def write_bag(path: Path, topics: Sequence[BagTopic]) -> Path:
    """A .bag, .mcap or .db3 with these topics. Raises FileError."""
    path = path.resolve()
    kind = path.suffix[1:]
    if kind not in BAG_FORMATS:
        raise FileError(f"{path}: expected a file name ending in .bag, .mcap or .db3")
    if path.is_dir():
        raise FileError(f"{path}: is a folder; give a file name")
    times = [s for topic in topics for s in (topic.arrival, topic.stamps) if len(s)]
    first = min((int(s.min()) for s in times), default=0)
    if first < 0:
        raise FileError(
            f"{path}: stamps begin at {1e-9 * first:g} s, and a bag has none before 0. Give a folder, for tables, "
            "or add the same time to all stamps"
        )
    with writable(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
            made = _write(Path(folder) / path.stem, kind, topics)
            with made.open("rb") as file:
                os.fsync(file.fileno())
            made.replace(path)
        sync_folder(path.parent)
    return path


def message_for(field_path: str, where: str) -> str:
    """The usual message with a command's field."""
    first = field_path.split(".", maxsplit=1)[0].split("[", maxsplit=1)[0]
    if first not in CLASSES:
        raise RecordingError(
            f"{where}: no usual message has a field '{field_path}'; to write bags use one of "
            f"{', '.join(f'{name} ({short_type(t)})' for name, t in CLASSES.items())}"
        )
    return CLASSES[first]


def _write(path: Path, kind: str, topics: Sequence[BagTopic]) -> Path:
    """The file, written next to its final path."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2

    if kind == "bag":
        with Writer1(path.with_suffix(".bag")) as first:
            _fill(first, topics, ros1=True)
        return path.with_suffix(".bag")
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    second = Writer2(path, version=9, storage_plugin=plugin)
    if kind == "mcap":
        second.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with second:
        _fill(second, topics, ros1=False)
    return next(path.glob(f"*.{kind}"))


def _fill(writer: "Writer1 | Writer2", topics: Sequence[BagTopic], *, ros1: bool) -> None:
    store = _store(ros1=ros1)
    connections = [writer.add_connection(t.name, t.type_name, typestore=store) for t in topics]
    streams = [_messages(t, store, i, ros1=ros1) for i, t in enumerate(topics)]
    for arrival, i, raw in heapq.merge(*streams):
        writer.write(connections[i], arrival, raw)


def _messages(
    topic: BagTopic, store: "Typestore", index: int, *, ros1: bool
) -> Iterator[tuple[int, int, bytes]]:
    wire = Wire(topic.type_name, store.fielddefs, cdr=not ros1)
    for path in topic.columns:
        wire.require(path, f"topic {topic.name}")
    first = _first(topic, store)
    serialise = store.serialize_ros1 if ros1 else store.serialize_cdr
    raw = bytes(serialise(first, topic.type_name))
    shape = next(wire.shapes([raw]))
    rows = np.tile(shape.data, (len(topic.arrival), 1))
    columns = dict(topic.columns)
    if wire.stamped:
        columns["header.stamp.sec"] = (topic.stamps // 10**9).astype(np.float64)
        columns["header.stamp.nanosec"] = (topic.stamps % 10**9).astype(np.float64)
    for path, values in columns.items():
        _put(rows, shape, path, values, f"topic {topic.name}")
    for arrival, row in zip(topic.arrival.tolist(), rows, strict=True):
        yield arrival, index, row.tobytes()


def _put(
    rows: np.ndarray[Any, np.dtype[np.uint8]], shape: Shape, path: str, values: Array, where: str
) -> None:
    begin, dtype = shape.place(path)
    kind = np.dtype(dtype)
    exact = np.rint(values) if kind.kind in "iu" else values
    if kind.kind in "iu" and len(exact):
        least, most = np.iinfo(kind).min, np.iinfo(kind).max
        if not (exact.min() >= least and exact.max() <= most):
            raise RecordingError(
                f"{where}: '{path}' gets {values.min():g} to {values.max():g}; its range is "
                f"{least} to {most}"
            )
    block = np.ascontiguousarray(exact.astype(kind)).view(np.uint8)
    rows[:, begin : begin + kind.itemsize] = block.reshape(len(rows), kind.itemsize)


def _first(topic: BagTopic, store: "Typestore") -> object:
    """A message with sequences of the needed length and all texts, its numbers 0."""
    lengths: dict[str, int] = {}
    for path in topic.columns:
        array, bracket, index = path.rpartition("[")
        if bracket:
            lengths[array] = max(lengths.get(array, 0), int(index[:-1]) + 1)
    return _empty(topic.type_name, "", store, lengths, topic.texts)


def _empty(
    name: str, path: str, store: "Typestore", lengths: Mapping[str, int], texts: Mapping[str, str]
) -> object:
    values: list[Any] = []
    for part, kind in store.fielddefs[name][1]:
        here = f"{path}.{part}".lstrip(".")
        tag, detail = described(kind)
        if tag == "name":
            values.append(_empty(detail, here, store, lengths, texts))
        elif tag == "base":
            values.append(texts.get(here, "") if detail == "string" else 0)
        else:
            element, fixed, is_sequence = detail
            count = lengths.get(here, 0) if is_sequence else fixed
            inner, primitive = described(element)
            is_number = inner == "base" and primitive != "string"
            dtype = "uint8" if primitive in ("octet", "byte", "char") else primitive
            values.append(np.zeros(count, dtype=dtype) if is_number else [])
    return store.types[name](*values)


def _store(*, ros1: bool) -> "Typestore":
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    known = standard_definitions()
    store.register({name: known[name] for name in COMMON if name not in store.fielddefs})
    return store
