# SPDX-License-Identifier: MIT
"""Bags for tests: written by rosbags' writers, and by a small writer of .mcap made from its
specification, in every shape that recorders leave behind."""

import shutil
import sqlite3
import struct
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

import seatrial
from seatrial.boat.vehicle import vehicle_from

SECOND = 10**9  # [ns]
START = 1_700_000_000 * SECOND  # [ns]
OTHERS = {  # as their packages have them
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "tf/msg/tfMessage": "geometry_msgs/TransformStamped[] transforms",
    "mavros_msgs/msg/RCOut": "std_msgs/Header header\nuint16[] channels",
    "mavros_msgs/msg/RCIn": "std_msgs/Header header\nuint8 rssi\nuint16[] channels",
    "mavros_msgs/msg/ManualControl": (
        "std_msgs/Header header\nfloat32 x\nfloat32 y\nfloat32 z\nfloat32 r\nuint16 buttons\n"
        "uint16 buttons2\nuint8 enabled_extensions\nfloat32 s\nfloat32 t\n"
        + "\n".join(f"float32 aux{i}" for i in range(1, 7))
    ),
    "uuv_gazebo_ros_plugins_msgs/msg/FloatStamped": "std_msgs/Header header\nfloat64 data",
    "auv_msgs/msg/NED": "float64 north\nfloat64 east\nfloat64 depth",
    "auv_msgs/msg/RPY": "float64 roll\nfloat64 pitch\nfloat64 yaw",
    "auv_msgs/msg/NavSts": "std_msgs/Header header\nauv_msgs/NED position\nauv_msgs/RPY orientation",
    "px4_msgs/msg/VehicleOdometry": "uint64 timestamp\nfloat32[3] position\nfloat32[4] q",
    "px4_msgs/msg/ActuatorMotors": "uint64 timestamp\nfloat32[12] control",
    "boat_msgs/msg/Azimuth": "int16 throttle\nint16 angle",
    "boat_msgs/msg/Motor": "string name\nfloat32[2] raw\nint16 duty",
    "boat_msgs/msg/Motors": "uint8 id\nboat_msgs/Motor[] motors\nboat_msgs/Motor[2] spare",
}


class Sent(NamedTuple):
    """One message: its topic, its type, when it arrived [ns], its fields."""

    topic: str
    type: str
    time: int
    fields: dict[str, Any]


@lru_cache(maxsize=2)
def store(*, ros1: bool) -> Typestore:
    """Types of a distribution, and those above."""
    found = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    for name, text in OTHERS.items():
        if name not in found.fielddefs:
            found.register(get_types_from_msg(text, name))
    return found


def build(types: Typestore, name: str, given: dict[str, Any]) -> Any:
    """A message with some fields, the others zero, empty or absent."""
    values = []
    for field, kind in types.fielddefs[name][1]:
        values.append(_value(types, kind, given.get(field)))
    return types.types[name](*values)


def _value(types: Typestore, kind: Any, given: Any) -> Any:
    tag, detail = int(kind[0]), kind[1]
    if tag == 1:
        return given if given is not None else "" if detail[0] == "string" else 0
    if tag == 2:
        return build(types, detail, given or {})
    element, count = detail[0], detail[1]
    items = given if given is not None else [None] * (count if tag == 3 else 0)
    if int(element[0]) == 1 and element[1][0] != "string":
        code = {"byte": "uint8", "char": "uint8", "octet": "uint8"}.get(
            element[1][0], element[1][0]
        )
        return np.array([0 if x is None else x for x in items], dtype=code)
    return [_value(types, element, item) for item in items]


def raw(sent: Sent, *, ros1: bool) -> bytes:
    """The message as it is recorded."""
    types = store(ros1=ros1)
    message = build(types, sent.type, sent.fields)
    serialise = types.serialize_ros1 if ros1 else types.serialize_cdr
    return bytes(serialise(message, sent.type))


def stamp(time: int) -> dict[str, int]:
    """[ns] as a header has it."""
    return {"sec": time // SECOND, "nanosec": time % SECOND}


def header(time: int, frame: str = "") -> dict[str, Any]:
    return {"stamp": stamp(time), "frame_id": frame}


def quaternion(psi: float) -> dict[str, float]:
    return {"x": 0.0, "y": 0.0, "z": float(np.sin(psi / 2)), "w": float(np.cos(psi / 2))}


def pose(x: float, y: float, psi: float, z: float = 0.0) -> dict[str, Any]:
    return {"position": {"x": float(x), "y": float(y), "z": z}, "orientation": quaternion(psi)}


# What is recorded in most tests: a turn, and sticks that move. #


def turn(seconds: float, rate: float = 15.0) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [ns] from 0, and x, y, psi (n, 3), smooth and never at rest."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    eta = np.column_stack([0.5 * np.sin(0.4 * t), 0.3 * np.cos(0.5 * t), 0.2 * t - 0.3])
    return np.rint(t * 1e9).astype(np.int64), eta


def sticks(seconds: float, rate: float = 100.0) -> tuple[np.ndarray, np.ndarray]:
    """Times (m,) [ns] from 0, and axes (m, 4)."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    axes = np.column_stack([np.sin(t), np.cos(2 * t), np.zeros(len(t)), np.sign(np.sin(3 * t))])
    return np.rint(t * 1e9).astype(np.int64), axes.astype(np.float32)


def poses_sent(seconds: float, topic: str = "/slam/pose", frame: str = "map") -> list[Sent]:
    return [
        Sent(topic, "geometry_msgs/msg/PoseStamped", START + t + 3_000_000,
             {"header": header(START + t, frame), "pose": pose(*eta)})
        for t, eta in zip(*(a.tolist() for a in turn(seconds)), strict=True)
    ]  # fmt: skip


def joy_sent(seconds: float, topic: str = "/joy", rate: float = 100.0) -> list[Sent]:
    return [
        Sent(topic, "sensor_msgs/msg/Joy", START + t + 1_000_000,
             {"header": header(START + t), "axes": axes, "buttons": [0, 1]})
        for t, axes in zip(*(a.tolist() for a in sticks(seconds, rate)), strict=True)
    ]  # fmt: skip


def other_sent(seconds: float, size: int = 40) -> list[Sent]:
    """A topic that nobody asks for, with texts of many lengths."""
    return [
        Sent(
            "/rosout", "std_msgs/msg/String", START + i * 70_000_000, {"data": "x" * (i * 7 % size)}
        )
        for i in range(int(seconds / 0.07))
    ]


def drive(seconds: float = 3.0) -> list[Sent]:
    """Poses, commands and something else."""
    return poses_sent(seconds) + joy_sent(seconds) + other_sent(seconds)


def vehicle(**changes: Any) -> seatrial.Vehicle:
    """MallARD with other keys; pose and commands are changed key by key."""
    content = seatrial.load_vehicle("mallard-mp").to_mapping()
    for key, value in changes.items():
        merge = key in ("pose", "commands") and isinstance(value, dict)
        content[key] = {**content[key], **value} if merge else value
    return vehicle_from(content, "vehicle.yaml")


# Writers. Each makes a bag of these messages in a folder, and returns what to read. #


def by_time(sent: Sequence[Sent]) -> list[Sent]:
    return sorted(sent, key=lambda s: s.time)


def ros1(path: Path, sent: Sequence[Sent], compression: str = "none", chunk: int = 1 << 14) -> Path:
    """A .bag by rosbags."""
    writer = Writer1(path)
    writer.chunk_threshold = chunk
    if compression != "none":
        writer.set_compression(Writer1.CompressionFormat[compression.upper()])
    with writer:
        known: dict[str, Any] = {}
        for s in by_time(sent):
            if s.topic not in known:
                known[s.topic] = writer.add_connection(s.topic, s.type, typestore=store(ros1=True))
            writer.write(known[s.topic], s.time, raw(s, ros1=True))
    return path


def ros2(
    folder: Path, sent: Sequence[Sent], plugin: str = "mcap", mode: str = "NONE", *,
    chunk: int = 100, version: Any = 9,
) -> Path:  # fmt: skip
    """A folder by rosbags; an .mcap gets a chunk for so many messages."""
    writer = Writer2(folder, version=version, storage_plugin=StoragePlugin[plugin.upper()])
    writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    with writer:
        known: dict[str, Any] = {}
        for i, s in enumerate(by_time(sent)):
            if s.topic not in known:
                known[s.topic] = writer.add_connection(s.topic, s.type, typestore=store(ros1=False))
            writer.write(known[s.topic], s.time, raw(s, ros1=False))
            if plugin == "mcap" and i % chunk == chunk - 1:
                writer.storage.close_chunk()  # type: ignore[union-attr]
    return folder


def alone(folder: Path) -> Path:
    """The one storage file of a folder, without its metadata."""
    (file,) = (p for p in folder.iterdir() if p.name != "metadata.yaml")
    return file.rename(folder.parent / f"{folder.name}-alone{file.suffix}")


def parts(sent: Sequence[Sent], n: int) -> list[list[Sent]]:
    """Cut in n, by time."""
    ordered = by_time(sent)
    return [ordered[i * len(ordered) // n : (i + 1) * len(ordered) // n] for i in range(n)]


def split1(folder: Path, sent: Sequence[Sent], n: int = 12) -> Path:
    """rosbag record --split: more than ten files, so that _10 comes after _9."""
    folder.mkdir()
    for i, part in enumerate(parts(sent, n)):
        ros1(folder / f"run_{i}.bag", part)
    return folder


def split2(
    folder: Path, sent: Sequence[Sent], plugin: str, *, metadata: bool = True, n: int = 12
) -> Path:
    """ros2 bag record -d: several files and one metadata.yaml; without it as after a crash."""
    folder.mkdir()
    infos = []
    for i, part in enumerate(parts(sent, n)):
        made = ros2(folder.parent / f"{folder.name}_{i}", part, plugin)
        infos.append(yaml.safe_load((made / "metadata.yaml").read_text()))
        file = next(p for p in made.iterdir() if p.suffix in (".mcap", ".db3"))
        file.rename(folder / file.name)
        shutil.rmtree(made)
    if metadata:
        key = "rosbag2_bagfile_information"
        whole = infos[0]
        whole[key]["relative_file_paths"] = [
            name for info in infos for name in info[key]["relative_file_paths"]
        ]
        whole[key]["files"] = [file for info in infos for file in info[key]["files"]]
        whole[key]["message_count"] = len(sent)
        counts: dict[str, Any] = {}
        for info in infos:
            for topic in info[key]["topics_with_message_count"]:
                name = topic["topic_metadata"]["name"]
                if name in counts:
                    counts[name]["message_count"] += topic["message_count"]
                else:
                    counts[name] = topic
        whole[key]["topics_with_message_count"] = list(counts.values())
        (folder / "metadata.yaml").write_text(yaml.safe_dump(whole))
    return folder


def old_db3(folder: Path, sent: Sequence[Sent], *, qos: bool) -> Path:
    """A .db3 as ROS 2 wrote it before Iron: no definitions, no schema table."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "old_0.db3"
    base = sqlite3.connect(path)
    extra = ", offered_qos_profiles TEXT NOT NULL" if qos else ""
    base.executescript(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
        f"serialization_format TEXT NOT NULL{extra});"
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, "
        "timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
        "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
    )
    known: dict[str, int] = {}
    for s in by_time(sent):
        if s.topic not in known:
            known[s.topic] = len(known) + 1
            row = (known[s.topic], s.topic, s.type, "cdr", *(("",) if qos else ()))
            base.execute(f"INSERT INTO topics VALUES({','.join('?' * len(row))})", row)
        base.execute(
            "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)",
            (known[s.topic], s.time, raw(s, ros1=False)),
        )
    base.commit()
    base.close()
    return path


def mcap_records(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Of an .mcap: each record's kind, where its content begins, where it ends."""
    at = 8
    while at + 9 <= len(content) - 8:
        kind, length = struct.unpack_from("<BQ", content, at)
        yield kind, at + 9, at + 9 + length
        at += 9 + length


def bag_records(content: bytes) -> Iterator[tuple[int, int, int]]:
    """Of a .bag: each record's op, where it begins, where it ends."""
    at = 13
    while at < len(content):
        (head,) = struct.unpack_from("<I", content, at)
        (body,) = struct.unpack_from("<I", content, at + 4 + head)
        op = content[content.index(b"op=", at) + 3]
        yield op, at, at + 8 + head + body
        at += 8 + head + body
