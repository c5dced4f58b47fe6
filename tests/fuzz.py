# SPDX-License-Identifier: MIT
"""Damaged bags, tables and vehicle files: mutations of good ones, the same for the same number.

    python -W error tests/fuzz.py bag 0 1000        # cases 0 to 999 of a kind
    python -W error tests/fuzz.py db3 417 1 --keep /tmp/case

Every case must end in a recording (or a vehicle), or in a SeatrialError of one line, in time and
within the memory that a worker has. Anything else is printed as a finding.
"""

import argparse
import contextlib
import hashlib
import io
import json
import random
import resource
import shutil
import signal
import sqlite3
import struct
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import bag_tools
import numpy as np

import seatrial
from seatrial.errors import SeatrialError
from seatrial.files import dump_yaml

MEMORY = 3 << 29  # [bytes] 1.5 GB of addresses for a worker, libraries included
PATIENCE = 10.0  # [s] of the processor for one case, however busy the machine is
LONGEST = 3000  # [characters] of a line that somebody is to read
ODD_NUMBERS = (
    0, 1, 2, 3, 4, 7, 8, 0x7F, 0x80, 0xFF, 0x100, 0x7FFF, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000,
    0xFFFFFFFF, 1 << 32, 1 << 40, (1 << 63) - 1, 1 << 63, (1 << 64) - 1,
)  # fmt: skip
ODD_WORDS = (
    "", "nan", "inf", "-inf", "1e400", "-1e308", "1e308", "abc", "1,5", "--", "0x10", "9" * 400, "é",
    '"', "1_000", "-0", "1e-400", " ", "\x00", "NULL", "#", "9007199254740993", "-9e18", "9.3e18",
)  # fmt: skip
ODD_YAML = (
    "", "null", "~", "[]", "{}", "[1, 2]", "{a: 1}", "-1", "0", "1e308", "-1e308", "1e-320", ".nan",
    ".inf", "true", "'", '"', "*a", "&a 1", "!!python/object:os.system x", "\t", "|", ">", "? x", "-",
    "x" * 5000, "é\u2028", "9" * 400, "0x10", "1_0", "2020-01-01", "<<: *a", "axes[99]", "axes[-1]",
    "axes[1][2]", "header.frame_id", "header", "buttons[0]", "a.b.c", "axes[999999999999999999999]",
    "mm", "deg", "forward-right-down", "always-forward", "direct", "/tf", "/rosout", "F_u", "!", "%",
    "{field: axes, index: 1}", "{field: 'axes[0]', scale: 1e-300}", "{column: t, unit: ns}",
    "{field: 'axes[0]', offset: 1e308, scale: 1e-5}", "{column: t, scale: 1e-300}",
)  # fmt: skip
Data = dict[str, bytes]  # name of a file: its content


class SlowError(Exception):
    """A case that takes too long."""


# Mutations of bytes #


def flip(rng: random.Random, data: bytearray) -> None:
    for _ in range(rng.choice((1, 1, 2, 8, 64))):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def scribble(rng: random.Random, data: bytearray) -> None:
    at = rng.randrange(len(data))
    size = rng.choice((1, 2, 4, 16, 256))
    data[at : at + size] = rng.randbytes(size)


def truncate(rng: random.Random, data: bytearray) -> None:
    del data[rng.randrange(len(data)) :]


def remove(rng: random.Random, data: bytearray) -> None:
    at, size = _block(rng, data)
    del data[at : at + size]


def duplicate(rng: random.Random, data: bytearray) -> None:
    at, size = _block(rng, data)
    data[at:at] = data[at : at + size]


def move(rng: random.Random, data: bytearray) -> None:
    at, size = _block(rng, data)
    block = data[at : at + size]
    del data[at : at + size]
    to = rng.randrange(len(data) + 1)
    data[to:to] = block


def blank(rng: random.Random, data: bytearray) -> None:
    at, size = _block(rng, data)
    size = min(size, len(data) - at)
    data[at : at + size] = bytes([rng.choice((0, 0, 0xFF))]) * size


def number(rng: random.Random, data: bytearray) -> None:
    """A length, a count or an offset that is not true."""
    form = rng.choice(("<H", "<I", "<I", "<Q", ">I"))
    size = struct.calcsize(form)
    if len(data) <= size:
        return
    at = rng.randrange(len(data) - size)
    value = rng.choice(ODD_NUMBERS)
    if rng.random() < 0.4:
        (value,) = struct.unpack_from(form, data, at)
        value += rng.choice((-8, -4, -1, 1, 4, 8, 256))
    struct.pack_into(form, data, at, value % (1 << 8 * size))


def _block(rng: random.Random, data: bytearray) -> tuple[int, int]:
    """Where a block begins, and its size; often a page of a database."""
    if rng.random() < 0.3:
        return rng.randrange(len(data)) // 4096 * 4096, 4096 * rng.choice((1, 1, 2, 4))
    return rng.randrange(len(data)), rng.choice((1, 3, 8, 50, 400, 3000, len(data) // 3 + 1))


BYTES = (flip, flip, scribble, truncate, remove, duplicate, move, blank, number, number, number)


def damaged(rng: random.Random, content: bytes, others: list[bytes]) -> bytes:
    """One or more mutations, or two files glued together."""
    data = bytearray(content)
    if rng.random() < 0.05:
        other = rng.choice(others)
        data = data[: rng.randrange(len(data))] + other[rng.randrange(len(other)) :]
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        if data:
            rng.choice(BYTES)(rng, data)
    return bytes(data)


# Mutations of text #


def edited(rng: random.Random, content: bytes, words: tuple[str, ...], separators: str) -> bytes:
    """Lines and words changed as a tired person or a broken script would."""
    lines = content.decode().split("\n")
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(lines))
        how = rng.randrange(9)
        if how == 0:
            del lines[at]
        elif how == 1:
            lines.insert(at, rng.choice(lines or [""]))
        elif how == 2:
            lines[at] = lines[at][: rng.randrange(len(lines[at]) + 1)]
        elif how == 3:
            lines[at] = " " * rng.randrange(4) + lines[at] + rng.choice(words)
        elif how == 4:
            cut = rng.randrange(len(lines[at]) + 1)
            lines[at] = (
                lines[at][:cut] + rng.choice(",;:\t\"'[]{}#&*!|>%@` \x00é-") + lines[at][cut:]
            )
        else:
            lines[at] = _swapped(rng, lines[at], words, separators)
        lines = lines or [""]
    return "\n".join(lines).encode()


def _swapped(rng: random.Random, line: str, words: tuple[str, ...], separators: str) -> str:
    """One word of a line replaced."""
    starts = [0, *(i + 1 for i, c in enumerate(line) if c in separators)]
    begin = rng.choice(starts)
    end = next((i for i in range(begin, len(line)) if line[i] in separators), len(line))
    return line[:begin] + rng.choice(words) + line[end:]


def bomb(rng: random.Random) -> bytes:
    """YAML that grows, or goes deep."""
    depth = rng.choice((50, 1000, 20000))
    head = rng.choice(("", "seatrial: vehicle 1\n"))
    return rng.choice(
        (
            f"{head}a: &a [x,x,x,x,x,x,x,x,x]\n"
            + "".join(f"{chr(98 + i)}: &{chr(98 + i)} [{','.join([f'*{chr(97 + i)}'] * 9)}]\n" for i in range(9)),
            "seatrial: vehicle 1\nname: &a [*a]\n",
            "seatrial: vehicle 1\nname: &a {b: *a}\n",
            "seatrial: vehicle 1\nname: " + "[" * depth + "]" * depth,
            "seatrial: vehicle 1\nname: " + "{a: " * depth + "}" * depth,
            "seatrial: " + "x" * 1_000_000,
            "- " * depth,
        )
    ).encode()  # fmt: skip


def queried(rng: random.Random, content: bytes) -> bytes:
    """A database that is whole, with rows that no recorder writes."""
    values = ("NULL", "'text'", "x'00'", "1.5", "-1", "9223372036854775807", "-9223372036854775808",
              "''", "zeroblob(5)", "zeroblob(100000)", "x'00010000ffffffff'", "'/joy'", "17")  # fmt: skip
    columns = {
        "messages": ("id", "topic_id", "timestamp", "data"),
        "topics": ("id", "name", "type", "serialization_format", "offered_qos_profiles"),
        "message_definitions": ("topic_type", "encoding", "encoded_message_definition"),
        "schema": ("schema_version",),
    }
    base = sqlite3.connect(":memory:")
    base.deserialize(content)
    for _ in range(rng.choice((1, 1, 3))):
        table = rng.choice(list(columns))
        value, column = rng.choice(values), rng.choice(columns[table])
        which = rng.choice(("1", "rowid = 1", "rowid % 7 = 3", f"rowid > {rng.randrange(400)}"))
        relaxed = column == "id" or rng.random() < 0.5
        if relaxed:  # a table without its constraints, as another program might make it
            names = ", ".join(columns[table])
            statements = [
                f"CREATE TABLE t AS SELECT {names} FROM {table}", f"DROP TABLE {table}",
                f"ALTER TABLE t RENAME TO {table}",
            ]  # fmt: skip
        else:
            statements = []
        statements.append(
            rng.choice(
                (
                    f"UPDATE {table} SET {column} = {value} WHERE {which}",
                    f"UPDATE {table} SET {column} = {value} WHERE {which}",
                    f"DELETE FROM {table} WHERE {which}",
                    f"DROP TABLE {table}",
                    f"ALTER TABLE {table} DROP COLUMN {column}",
                    f"INSERT INTO {table} SELECT * FROM {table} WHERE {which}",
                )
            )
        )
        with contextlib.suppress(sqlite3.Error):
            for statement in statements:
                base.execute(statement)
        with contextlib.suppress(sqlite3.Error):
            base.commit()
    return bytes(base.serialize())


# What is damaged #


def seeds() -> dict[str, list[Data]]:
    """Good files, small ones, by kind."""
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
                path = bag_tools.mcap(folder / "run.mcap", content, **{"chunk": 40, **options})  # type: ignore[arg-type]
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
    found["csv"] = [_tables(), _one_table()]
    boats = [vehicle_content(), tf_content(), _whole_vehicle()]
    found["yaml"] = [{"vehicle.yaml": dump_yaml(v).encode()} for v in boats]
    return found


def vehicle_content() -> dict[str, object]:
    """Poses from PoseStamped."""
    return bag_tools.vehicle().to_mapping()


def tf_content() -> dict[str, object]:
    """Poses from tf."""
    frames = {"topic": "/tf", "parent": "map", "child": "base_link"}
    return bag_tools.vehicle(pose=frames).to_mapping()


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


def _tables() -> Data:
    t, eta = bag_tools.turn(2.0)
    s, axes = bag_tools.sticks(2.0, 30)
    return {
        "poses.csv": _csv("t,x,y,psi", np.column_stack([t * 1e-9, eta])),
        "commands.csv": _csv("t,F_u,F_v,F_r", np.column_stack([s * 1e-9, axes[:, [1, 0, 3]]])),
    }


def _one_table() -> Data:
    t, eta = bag_tools.turn(2.0)
    rows = np.column_stack([t * 1e-9, eta, np.cos(eta)])
    return {"run.csv": _csv("t,x,y,psi,F_u,F_v,F_r", rows)}


def _csv(head: str, rows: np.ndarray) -> bytes:
    return "\n".join([head, *(",".join(f"{x:.6g}" for x in row) for row in rows)]).encode() + b"\n"


# One case #


def made(kind: str, case: int, good: dict[str, list[Data]]) -> tuple[Data, bool]:
    """The damaged files of a case, and whether they are to be salvaged."""
    rng = random.Random(f"{kind} {case}")
    family = good["bag" if kind == "inspect" else kind]
    files = dict(rng.choice(family))
    target = rng.choice(sorted(files))
    content = files[target]
    others = [other for seed in family for other in seed.values()]
    if target == "metadata.yaml" and rng.random() < 0.7:
        files[target] = edited(rng, content, ODD_YAML, " :")
    elif kind == "db3" and target.endswith(".db3") and rng.random() < 0.4:
        files[target] = queried(rng, content)
    elif kind == "csv" and rng.random() < 0.7:
        files[target] = edited(rng, content, ODD_WORDS, ",")
    elif kind == "yaml" and rng.random() < 0.9:
        files[target] = (
            bomb(rng) if rng.random() < 0.02 else edited(rng, content, ODD_YAML, " ,:[]{}")
        )
    else:
        files[target] = damaged(rng, content, others)
    return files, rng.random() < 0.5


def attempt(kind: str, folder: Path, files: Data, *, salvage: bool) -> str:
    """What came of it, in a word. Raises what must not be raised."""
    for name, content in files.items():
        (folder / name).write_bytes(content)
    whole = len(files) > 1
    path = folder if whole else folder / next(iter(files))
    try:
        if kind == "yaml":
            vehicle = seatrial.load_vehicle(path)
            (folder / "tables").mkdir()
            for name, content in {**_tables(), **_one_table()}.items():
                (folder / "tables" / name).write_bytes(content)
            seatrial.read(folder / "tables", vehicle)
            return "read"
        tree = any(b"TFMessage" in content for content in files.values())
        vehicle = bag_tools.vehicle_from(
            tf_content() if tree else vehicle_content(), "vehicle.yaml"
        )
        if kind == "inspect":
            return _inspected(path, tree=tree)
        seatrial.read(path, vehicle, salvage=salvage)
    except SeatrialError as error:
        _one_line(str(error))
        return "salvage refused" if salvage else "refused"
    return "salvaged" if salvage else "read"


def _inspected(path: Path, *, tree: bool) -> str:
    """Through the command line."""
    from seatrial.cli import main as command_line

    vehicle = path.parent / "vehicle.yaml"
    vehicle.write_text(dump_yaml(tf_content() if tree else vehicle_content()))
    said, told = io.StringIO(), io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(told):
        code = command_line(["inspect", "-q", str(path), "--vehicle", str(vehicle)])
    if code == 0:
        return "inspected"
    assert code == 1, code
    _one_line(said.getvalue().rstrip("\n"))
    return "refused"


def _one_line(text: str) -> None:
    assert text.strip(), "an error without words"
    assert text.isprintable(), f"not one line of text: {text!r}"
    assert len(text) < LONGEST, f"{len(text)} characters: {text[:300]}"


def _late(_signal: int, _frame: FrameType | None) -> None:
    raise SlowError


def cases(
    kind: str, first: int, count: int, keep: Path | None = None
) -> Iterator[dict[str, object]]:
    """Run them; yields one finding each, and last what came of all."""
    good = seeds()
    outcomes: Counter[str] = Counter()
    slowest, which = 0.0, 0
    signal.signal(signal.SIGPROF, _late)
    with tempfile.TemporaryDirectory() as name:
        for case in range(first, first + count):
            files, salvage = made(kind, case, good)
            folder = Path(name) / "case"
            folder.mkdir()
            begin = time.perf_counter()
            signal.setitimer(signal.ITIMER_PROF, PATIENCE)
            try:
                outcomes[attempt(kind, folder, files, salvage=salvage)] += 1
            except BaseException as error:
                if isinstance(error, KeyboardInterrupt):
                    raise
                signal.setitimer(signal.ITIMER_PROF, 0.0)
                where = traceback.format_exception(error)
                yield {
                    "kind": kind,
                    "case": case,
                    "salvage": salvage,
                    "error": "".join(where)[-3000:],
                }
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            took = time.perf_counter() - begin
            if took > slowest:
                slowest, which = took, case
            if keep is not None:
                shutil.copytree(folder, keep, dirs_exist_ok=True)
            shutil.rmtree(folder)
    yield {
        "kind": kind, "first": first, "count": count, "outcomes": dict(outcomes),
        "slowest": [slowest, which], "peak [MB]": peak(),
    }  # fmt: skip


def peak() -> int:
    """Largest memory of this program [MB]; `getrusage` has that of its parent before exec, too."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) >> 10


def main() -> int:
    """Run cases of one kind with bounded memory."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=("bag", "mcap", "db3", "csv", "yaml", "inspect"))
    parser.add_argument("first", type=int)
    parser.add_argument("count", type=int)
    parser.add_argument("--keep", type=Path, help="folder for the files of the last case")
    parser.add_argument("--digest", action="store_true", help="only say what the first case is")
    args = parser.parse_args()
    if args.digest:
        files, _ = made(args.kind, args.first, seeds())
        digest = hashlib.sha256(b"".join(name.encode() + c for name, c in sorted(files.items())))
        sys.stdout.write(json.dumps({"case": args.first, "digest": digest.hexdigest()}) + "\n")
        return 0
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    found = 0
    for line in cases(args.kind, args.first, args.count, args.keep):
        found += "error" in line
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()
    return min(found, 1)


Mutation = Callable[[random.Random, bytearray], None]

if __name__ == "__main__":
    sys.exit(main())
