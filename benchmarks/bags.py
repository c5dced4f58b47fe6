# SPDX-License-Identifier: MIT
"""Gate: time and memory of `seatrial.read` beside rosbags' own reader, in the same run.

    python -m benchmarks.bags            # 10 minutes: 60 000 commands, 9 000 poses
    python -m benchmarks.bags --long     # 10 hours: 3.6 million commands, 540 000 poses
    python -m benchmarks.bags --large    # 10 minutes beside 2 GB of images

Every measurement is a process of its own. Machines are noisy: read the ratios.
"""

# ruff: noqa: PLC0415 what is not measured is not imported either

import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from heapq import merge
from pathlib import Path

import numpy as np

from benchmarks.harness import command
from benchmarks.harness.measure import measure, measured, options

RATES = {"/joy": 100.0, "/slam/pose": 15.0}  # [Hz]
START = 1_700_000_000 * 10**9  # [ns]
IMAGE = 1 << 20  # [bytes]
FORMATS = ("bag", "mcap", "db3")
REPEATS = 5


def vehicle() -> object:
    """MallARD's."""
    import seatrial

    return seatrial.load_vehicle("mallard-mp")


def write(path: Path, seconds: float, images: int = 0) -> None:
    """A recording through rosbags' writers, one message after the other."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    ros1 = path.suffix == ".bag"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    plugin = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    folder = path.parent / path.suffix[1:]
    writer = Writer1(path) if ros1 else Writer2(folder, version=9, storage_plugin=plugin)
    types = {"/joy": "sensor_msgs/msg/Joy", "/slam/pose": "geometry_msgs/msg/PoseStamped"}
    types |= {"/camera": "sensor_msgs/msg/CompressedImage"} if images else {}
    counts = {name: round(seconds * rate) for name, rate in RATES.items()} | {"/camera": images}
    streams = [
        _stream(name, kind, counts[name], seconds, store=store, ros1=ros1)
        for name, kind in types.items()
    ]
    with writer:
        known = {n: writer.add_connection(n, t, typestore=store) for n, t in types.items()}
        for stamp, name, raw in merge(*streams):
            writer.write(known[name], stamp, raw)
    if not ros1:
        next(folder.glob(f"*{path.suffix}")).rename(path)


def _stream(
    name: str, kind: str, count: int, seconds: float, *, store: object, ros1: bool
) -> Iterator[tuple[int, str, bytes]]:
    """Messages of one topic: one serialised, the others with other numbers at its places."""
    from seatrial.io.bags.wire import Wire

    made = dict(store.types)  # type: ignore[attr-defined]
    stamp = made["builtin_interfaces/msg/Time"](0, 0)
    header = made["std_msgs/msg/Header"](*((0, stamp, "map") if ros1 else (stamp, "map")))
    if name == "/joy":
        message = made[kind](header, np.zeros(4, np.float32), np.zeros(11, np.int32))
        places = ("axes[0]", "axes[1]", "axes[3]")
    elif name == "/camera":
        noise = np.random.default_rng(0).integers(0, 256, IMAGE, dtype=np.uint8)
        message, places = made[kind](header, "jpeg", noise), ()
    else:
        point = made["geometry_msgs/msg/Point"](0.0, 0.0, 0.0)
        turn = made["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
        message = made[kind](header, made["geometry_msgs/msg/Pose"](point, turn))
        places = ("pose.position.x", "pose.position.y", "pose.orientation.z", "pose.orientation.w")
    serialise = store.serialize_ros1 if ros1 else store.serialize_cdr  # type: ignore[attr-defined]
    raw = bytearray(serialise(message, kind))
    wire = Wire(kind, store.fielddefs, cdr=not ros1)  # type: ignore[attr-defined]
    shape = next(wire.shapes([bytes(raw)]))
    views = [_view(raw, *shape.place(p)) for p in places]
    clock = [_view(raw, *shape.place(f"header.stamp.{p}")) for p in ("sec", "nanosec")]
    for i in range(count):
        t = i * seconds / count
        at = START + round(t * 1e9)
        clock[0][0], clock[1][0] = divmod(at, 10**9)
        numbers = (np.sin(0.4 * t), np.cos(0.5 * t), np.sin(0.1 * t), np.cos(0.1 * t))
        for view, number in zip(views, numbers, strict=False):
            view[0] = number
        yield at, name, bytes(raw)


def _view(raw: bytearray, offset: int, dtype: str) -> np.ndarray:
    return np.frombuffer(raw, dtype, 1, offset)


def with_seatrial(path: Path) -> dict[str, float]:
    """`seatrial.read`, after its imports."""
    import seatrial

    boat = vehicle()
    begin = time.perf_counter()
    record = seatrial.read(path, boat)  # type: ignore[arg-type]
    took = time.perf_counter() - begin
    arrays = (record.stamps, record.eta, record.raw, record.valid, record.segment,
              record.commands.stamps, record.commands.values)  # fmt: skip
    return {
        "seconds": took, "arrays": sum(a.nbytes for a in arrays), "messages":
        len(record.stamps) + len(record.commands.stamps),
    }  # fmt: skip


def with_rosbags(path: Path) -> dict[str, float]:
    """rosbags' reader and its deserialisation of the same topics, nothing kept."""
    from rosbags.highlevel import AnyReader

    begin = time.perf_counter()
    count = 0
    with AnyReader([path]) as reader:
        wanted = [c for c in reader.connections if c.topic in RATES]
        for connection, _, raw in reader.messages(wanted):
            reader.deserialize(raw, connection.msgtype)
            count += 1
    return {"seconds": time.perf_counter() - begin, "messages": count}


def opened_by_rosbags(path: Path) -> dict[str, float]:
    """rosbags' reader opened and closed, no message read."""
    from rosbags.highlevel import AnyReader

    begin = time.perf_counter()
    with AnyReader([path]):
        return {"seconds": time.perf_counter() - begin}


def nothing(path: Path) -> dict[str, float]:
    """What Python, numpy and seatrial take by themselves."""
    vehicle()
    return {"seconds": 0.0}


WORK: dict[str, Callable[[Path], dict[str, float]]] = {
    "seatrial.read": with_seatrial, "rosbags, deserialised": with_rosbags,
    "rosbags, opened only": opened_by_rosbags, "nothing": nothing,
}  # fmt: skip


def compare(paths: dict[str, Path], repeats: int) -> None:
    """One table."""
    print(f"  {'':<28}{'time [s]':>10}{'ratio':>8}{'peak [MB]':>11}{'arrays [MB]':>13}")
    for kind, path in paths.items():
        size = path.stat().st_size
        print(f"  .{kind}, {size / 1e6:.0f} MB")
        base = measured("bags", "seatrial.read", path, repeats=repeats)
        for what in WORK:
            mine = what == "seatrial.read"
            got = base if mine else measured("bags", what, path, repeats=repeats)
            arrays = f"{got['arrays'] / 1e6:13.1f}" if "arrays" in got else ""
            print(
                f"    {what:<26}{got['seconds']:10.3f}{got['seconds'] / base['seconds']:8.1f}"
                f"{got['peak'] / 1e6:11.0f}{arrays}"
            )


def ten_minutes() -> None:
    """What most people have."""
    print("10 minutes: 60 000 commands, 9 000 poses")
    with tempfile.TemporaryDirectory() as name:
        paths = {kind: Path(name) / f"run.{kind}" for kind in FORMATS}
        for path in paths.values():
            write(path, 600.0)
        compare(paths, REPEATS)


def one_by_one(title: str, seconds: float, images: int, formats: tuple[str, ...]) -> None:
    """Bags too large to keep several."""
    print(title)
    for kind in formats:
        with tempfile.TemporaryDirectory() as name:
            path = Path(name) / f"run.{kind}"
            write(path, seconds, images)
            compare({kind: path}, 1)


def main(arguments: Sequence[str]) -> None:
    """Run."""
    parser = command.parser("bags", __doc__)
    parser.add_argument("--long", action="store_true", help="10 hours; takes minutes")
    parser.add_argument("--large", action="store_true", help="2 GB of images; takes minutes")
    parser.add_argument("--formats", nargs="+", default=FORMATS, choices=FORMATS)
    options(parser)
    given = parser.parse_args(arguments)
    if measure(given, WORK):
        return
    formats = tuple(given.formats)
    if given.long:
        title = "10 hours: 3.6 million commands, 540 000 poses"
        one_by_one(title, 36_000.0, 0, formats)
    if given.large:
        one_by_one("10 minutes beside 2 GB of images", 600.0, 2000, formats)
    if not given.long and not given.large:
        ten_minutes()


if __name__ == "__main__":
    main(sys.argv[1:])
