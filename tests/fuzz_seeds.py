# SPDX-License-Identifier: MIT
"""Good files, small ones, that fuzz.py damages: bags, logs of autopilots, tables and vehicle files."""

import io
import json
import tempfile
from functools import cache
from pathlib import Path
from unittest.mock import patch

import autopilot_logs
import bag_tools
import mavlink_logs
import moos_logs
import numpy as np
import px4_logs
import yaml
from capture_logs import body, motive, qualisys, vicon
from mcap_writer import mcap

from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices
from seatrial.util.files import dump_yaml

Data = dict[str, bytes]  # name of a file: its content
AUTOPILOTS = {
    "run.BIN": autopilot_logs.ardupilot,
    "run.log": lambda path, run: autopilot_logs.ardupilot(path, run, text=True),
    "run.ulg": px4_logs.px4,
    "run.tlog": mavlink_logs.telemetry,
    "run.alog": moos_logs.moos,
}
SHORT_LOGS = 29  # for each of a minute, of which `init` can propose a file
PROPOSED: dict[str, Vehicle] = {}  # of whole logs, by file


def seeds(kind: str) -> dict[str, list[Data]]:
    """Good files, small ones, of a kind."""
    if kind == "log":
        return log_seeds()
    if kind in ("bag", "mcap", "db3", "inspect"):
        return bag_seeds()
    make = {
        "csv": _csvs, "capture": _captures, "parquet": _parquets, "mat": _mats, "hdf": _hdfs, "yaml": _vehicles,
    }  # fmt: skip
    return {kind: make[kind]()}


def bag_seeds() -> dict[str, list[Data]]:
    """Bags of both versions of ROS."""
    sent = bag_tools.poses_sent(1.5) + bag_tools.joy_sent(1.5, rate=60) + bag_tools.other_sent(1.5)
    frames = [
        bag_tools.Sent("/tf", "tf2_msgs/msg/TFMessage", s.time, {"transforms": [{
            "header": {"stamp": bag_tools.stamp(s.time), "frame_id": parent},
            "child_frame_id": child,
            "transform": {"translation": {"x": 1.0}, "rotation": {"w": 1.0}},
        } for parent, child in (("map", "odom"), ("odom", "base_link"))]})
        for s in bag_tools.poses_sent(1.5)
    ]  # fmt: skip
    tree = frames + bag_tools.joy_sent(1.5, rate=60)
    found: dict[str, list[Data]] = {"bag": [], "mcap": [], "db3": []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for i, content in enumerate((sent, tree)):
            for compression in ("none", "none", "bz2", "lz4"):
                path = bag_tools.ros1(folder / f"{i}.bag", content, compression, chunk=1 << 12)
                found["bag"].append({"run.bag": path.read_bytes()})
                path.unlink()
            for options in (
                {"compression": ""}, {"compression": "", "crc": False}, {"compression": "zstd"},
                {"compression": "", "crc": False, "summary": False}, {"compression": "lz4"},
                {"chunk": 0}, {"chunk": 0, "summary": False},
            ):  # fmt: skip
                path = mcap(folder / "run.mcap", content, **{"chunk": 40, **options})  # type: ignore[arg-type]
                found["mcap"].append({"run.mcap": path.read_bytes()})
            path = bag_tools.ros2(folder / f"db3-{i}", content, "sqlite3")
            found["db3"].append({"run.db3": (path / f"db3-{i}.db3").read_bytes()})
            found["db3"].append(
                {"run.db3": bag_tools.old_db3(folder / f"old-{i}", content, qos=True).read_bytes()}
            )
            for kind, mode in (("sqlite3", "MESSAGE"), ("sqlite3", "FILE"), ("mcap", "FILE")):
                path = bag_tools.ros2(folder / f"{i}-{kind}-{mode}", content, kind, mode)
                which = "db3" if kind == "sqlite3" else "mcap"
                found[which].append({p.name: p.read_bytes() for p in path.iterdir()})
    return found


def log_seeds() -> dict[str, list[Data]]:
    """Short logs of autopilots, and in `PROPOSED` the vehicle file that `init` proposes of a longer one."""
    found: list[Data] = []
    with tempfile.TemporaryDirectory() as name:
        for file, write in AUTOPILOTS.items():
            path = write(Path(name) / file, autopilot_logs.trial(seconds=60.0))
            text = init(path, choices=Choices(axes="forward-right-down")).text
            PROPOSED[file] = vehicle_from(yaml.safe_load(text), file)
            found.append({file: path.read_bytes()})
            with patch.multiple(autopilot_logs, ARMED=0.4, DISARMED=0.2):  # so that motors run
                write(path, autopilot_logs.trial(seconds=1.0))
            found += SHORT_LOGS * [{file: path.read_bytes()}]
    return {"log": found}


def vehicle_content() -> dict[str, object]:
    """Poses from PoseStamped."""
    return bag_tools.vehicle().to_mapping()


def tf_content() -> dict[str, object]:
    """Poses from tf."""
    frames = {"topic": "/tf", "parent": "map", "child": "base_link"}
    return bag_tools.vehicle(pose=frames).to_mapping()


@cache
def boat(*, tree: bool) -> tuple[Vehicle, str]:
    """What reads good files, and its file. Building one costs more than most of the reading."""
    content = tf_content() if tree else vehicle_content()
    return bag_tools.vehicle_from(content, "vehicle.yaml"), dump_yaml(content)


def _whole_vehicle() -> dict[str, object]:
    """One with nearly every key."""
    return {
        "seatrial": "vehicle 1", "name": "all", "axes": "forward-right-down",
        "pose": {"topic": "/slam/pose", "stamp": {"column": "t", "unit": "s"}, "clock": "bag",
                 "x": {"column": "x", "field": "pose.position.x", "unit": "m"},
                 "y": {"column": "y", "field": "pose.position.y", "sign": -1, "scale": 2.0},
                 "psi": {"column": "psi", "field": "pose.orientation.z", "offset": 0.1}},
        "commands": {"topic": "/joy", "stamp": {"column": "t"}, "inputs": {
            "port": {"column": "F_u", "field": "axes", "index": 0, "scale": 2.0, "offset": 0.5},
            "starboard": {"column": "F_v", "field": "axes[1]", "sign": -1}}},
        "command_timeout": 0.5,
        "scales": {"rpm": {"column": {"column": "F_r", "field": "axes[3]"}, "reference": 2.0}},
        "forces": {"F_u": {"axis": "surge", "of": {"port": 0.5, "starboard": 0.5}},
                   "F_r": {"axis": "yaw", "of": {"port": 0.2, "starboard": -0.2}}},
        "allocation": {"scheme": "direct", "limit": 1.0},
        "chain": [{"name": "all", "latency": 0.1, "dead_zone": {"forward": 0.1, "reverse": 0.2},
                   "reverse_ratio": 0.7, "lag": 0.2, "power": 1.5,
                   "scale": {"signal": "rpm", "power": 2.0},
                   "gains": {"port": 1.1, "starboard": 0.9}}],
        "structure": {"surge": ["v * r", "X_u * u", "X_F * F_u"], "sway": ["Y_v * v"],
                      "yaw": ["N_r * r", "N_F * F_r"]},
    }  # fmt: skip


def _vehicles() -> list[Data]:
    boats = [vehicle_content(), tf_content(), _whole_vehicle()]
    return [{"vehicle.yaml": dump_yaml(boat).encode()} for boat in boats]


def _csvs() -> list[Data]:
    return [tables(), one_table(), *_other_tables()]


def _captures() -> list[Data]:
    """Exports of Motive, QTM and Vicon beside the commands."""
    t, eta = bag_tools.turn(2.0)
    bodies = [body("boat", eta, lost=(3, 4)), body("buoy", eta[::-1])]
    exports = {
        "take.csv": (motive, t * 1e-9), "take.tsv": (qualisys, 15), "take.txt": (vicon, 15)
    }  # fmt: skip
    found: list[Data] = []
    with tempfile.TemporaryDirectory() as folder:
        for name, (write, clock) in exports.items():
            content = write(Path(folder) / name, clock, bodies).read_bytes()
            found.append({name: content, "commands.csv": tables()["commands.csv"]})
    return found


def tables() -> Data:
    t, eta = bag_tools.turn(2.0)
    s, axes = bag_tools.sticks(2.0, 30)
    return {
        "poses.csv": _csv("t,x,y,psi", np.column_stack([t * 1e-9, eta])),
        "commands.csv": _csv("t,F_u,F_v,F_r", np.column_stack([s * 1e-9, axes[:, [1, 0, 3]]])),
    }


def one_table() -> Data:
    t, eta = bag_tools.turn(2.0)
    rows = np.column_stack([t * 1e-9, eta, np.cos(eta)])
    return {"run.csv": _csv("t,x,y,psi,F_u,F_v,F_r", rows)}


def _other_tables() -> list[Data]:
    """Rows of several signals, other separators, decimal commas, dates, comments, nanoseconds without zeros."""
    head, *rows = one_table()["run.csv"].decode().splitlines()
    cells = [row.split(",") for row in rows]
    day = "2025-04-11 23:59:{:02d}.{:09d}"
    dated = [[day.format(i % 60, 7 * i), *row[1:]] for i, row in enumerate(cells)]
    unpadded = [[f"{i // 9}.{i % 9 * 111111111}", *row[1:]] for i, row in enumerate(cells)]
    signals = [(r[0], n, v) for r in cells for n, v in zip(head.split(",")[1:], r[1:], strict=True)]
    texts = (
        "\n".join(["t,name,value", *(",".join(signal) for signal in signals)]),
        "\n".join([head.replace(",", ";"), *(";".join(r).replace(".", ",") for r in cells)]),
        "\n".join(["# a log", f"# {head.replace(',', ' ')}", *(" ".join(r) for r in cells)]),
        "\n".join([head.replace(",", "\t"), "\t".join(["[s]"] + ["[m]"] * 6), *("\t".join(r) for r in cells)]),
        "\n".join([head, *(",".join(r) for r in dated)]),
        "\n".join([head, *(",".join(r) for r in unpadded)]),
        "\n".join([head.replace(",", "|"), *("|".join(r) for r in cells)]),
    )  # fmt: skip
    named = [dict(zip(head.split(","), map(float, row), strict=True)) for row in cells]
    columns = {name: [row[name] for row in named] for name in named[0]}
    lines = "\n".join(json.dumps({"pose": row, "on": [True, None]}) for row in named)
    more = {"run.jsonl": lines, "run.json": json.dumps(columns), "run.ndjson": json.dumps(named)}
    return [
        *({"run.csv": text.encode() + b"\n"} for text in texts),
        *({name: text.encode()} for name, text in more.items()),
    ]


def _columns() -> dict[str, np.ndarray]:
    """Those of one table, by name."""
    head, *rows = one_table()["run.csv"].decode().splitlines()
    values = np.array([[float(x) for x in row.split(",")] for row in rows])
    return dict(zip(head.split(","), values.T, strict=True))


def _parquets() -> list[Data]:
    """With every compression, a struct, times and text."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = _columns()
    stamps = pa.array((columns["t"] * 1e9).astype(np.int64), pa.timestamp("ns"))
    other = {**columns, "t": stamps, "note": ["a"] * len(stamps)}
    other["imu"] = [{"gyro": {"z": x}} for x in columns["x"].tolist()]
    found: list[Data] = []
    for content, options in (
        (columns, {"compression": "none", "use_dictionary": False}), (columns, {"compression": "snappy"}),
        (other, {"compression": "zstd"}), (other, {"compression": "gzip", "data_page_version": "2.0"}),
        (columns, {"compression": "lz4", "row_group_size": 7}),
    ):  # fmt: skip
        sink = pa.BufferOutputStream()
        pq.write_table(pa.table(content), sink, **options)
        found.append({"run.parquet": sink.getvalue().to_pybytes()})
    return found


def _mats() -> list[Data]:
    """Version 5: vectors, structs, cells, text; plain and compressed."""
    import scipy.io

    columns = _columns()
    text = np.array([f"12:00:{i % 60:02d}" for i in range(len(columns["t"]))], dtype=object)
    nested = {"log": {**columns, "more": {"when": text, "deep": {"r": columns["x"]}}}, "mass": 3.0}
    found: list[Data] = []
    for content, packed in ((columns, False), (columns, True), (nested, False), (nested, True)):
        out = io.BytesIO()
        scipy.io.savemat(out, content, do_compression=packed)
        found.append({"run.mat": out.getvalue()})
    return found


def _hdfs() -> list[Data]:
    """Version 7.3: datasets, groups, compressed pieces, a link to another file."""
    import h5py

    found: list[Data] = []
    for packed in (False, True):
        for nested in (False, True):
            out = io.BytesIO()
            with h5py.File(out, "w") as file:
                group = file.create_group("log") if nested else file
                for name, column in _columns().items():
                    more = {"chunks": (1, 8), "compression": "gzip"} if packed else {}
                    group.create_dataset(name, data=column[None, :], **more)
                if nested:
                    file["other"] = h5py.ExternalLink("/etc/passwd", "x")
            found.append({"run.mat": out.getvalue()})
    return found


def _csv(head: str, rows: np.ndarray) -> bytes:
    return "\n".join([head, *(",".join(f"{x:.6g}" for x in row) for row in rows)]).encode() + b"\n"
