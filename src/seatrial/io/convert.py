# SPDX-License-Identifier: MIT
"""`convert`: any log as a folder of tables, or as a bag, with the vehicle file that reads it.

Numbers stay as they were logged, each signal at its own stamps; signs, scales and units stay in the vehicle
file, so that the new recording is the old one.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from seatrial.boat.schema import Column, PoseSource
from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.io.assemble import GEOGRAPHIC, requests
from seatrial.io.bags.write import BAG_FORMATS, BagTopic, write_bag
from seatrial.io.formats import is_log, open_log
from seatrial.io.log import Wanted
from seatrial.io.reader import open_signals, recording_name
from seatrial.io.signals import Request, Rows, in_own_unit
from seatrial.recording.sampled_commands import are_samples, sampled_commands
from seatrial.recording.timing import Clock
from seatrial.util.arguments import expect
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.files import dump_yaml, write_chunks, write_text
from seatrial.util.frames import NS_PER_S, Array, Stamps
from seatrial.util.progress import over, stage

STAMP, REST, VALID = "t", "t_ns", "valid"  # columns
EXACT = 1 << 53  # [ns] up to which a number of a table keeps whole nanoseconds
# of tables, by role; poses, commands, scales
NAMES = {"headings": "heading", "yaw rates": "yaw_rate"}
SOURCES = {"poses": "pose", "commands": "commands"}  # keys of the vehicle file, by name
VECTOR = ("vector.x", "vector.y", "vector.z")


@dataclass(frozen=True)
class _Signal:
    """A request, its rows, and the table or topic that they become."""

    request: Request
    rows: Rows
    name: str


def convert(
    path: str | Path, out: str | Path, vehicle: Vehicle | None = None, *, salvage: bool = False
) -> list[Path]:
    """The files written. `out`: a folder, or a file name that ends in .mcap, .bag or .db3.

    With a vehicle: its signals, and the vehicle file that reads them. Without: all topics of an autopilot's
    log, a table each, and its parameters. Raises RecordingError, FileError.
    """
    path, out = Path(path), Path(out)
    bag = out.suffix.lower()[1:] in BAG_FORMATS
    _guard(path, out, bag=bag)
    if vehicle is None:
        if bag:
            raise RecordingError(
                f"{out}: a bag needs names for the signals: give --vehicle, or a folder for all "
                "topics as tables"
            )
        return _all_topics(path, out)
    expect(vehicle, Vehicle, "vehicle")
    # 1. The signals of the vehicle file, as logged.
    with open_signals(path, vehicle, salvage=salvage) as signals, stage("reading", 0.5):
        request = requests(signals, vehicle)
        rows = signals.read(request)
    found = _named(zip(request, rows, strict=True))
    # 2. A table or a topic for each place that it was in.
    with stage("writing"):
        return (_as_bag if bag else _as_tables)(found, out, vehicle)


def _guard(path: Path, out: Path, *, bag: bool) -> None:
    """Refuse to write into a folder with files, or over one."""
    if not bag and out.suffix and not out.is_dir():
        raise FileError(f"{out}: expected a folder, or a file name ending in .mcap, .bag or .db3")
    if bag and out.exists():
        raise FileError(f"{out}: exists already; give another name")
    if not bag and out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise FileError(f"{out}: exists already and is not empty; give a new folder")


def _named(pairs: Iterable[tuple[Request, Rows]]) -> list[_Signal]:
    """Names by role; a second place of a role gets a number."""
    found: list[_Signal] = []
    for request, rows in pairs:
        role = NAMES.get(request.role, request.role)
        taken = sum(s.request.role == request.role for s in found)
        found.append(_Signal(request, rows, role if not taken else f"{role}_{taken + 1}"))
    return found


# Tables #


def _as_tables(found: Sequence[_Signal], out: Path, vehicle: Vehicle) -> list[Path]:
    written = []
    in_parts = any(int(np.abs(s.rows.stamps).max(initial=0)) > EXACT for s in found)
    # one name in all tables, as the vehicle file has one for all
    taken = {name for s in found for name in s.request.names}
    t, rest, valid = (_apart(name, taken) for name in (STAMP, REST, VALID))
    tables = _tables(found)
    for name, signals in over(list(tables.items())):
        names: list[str] = []
        parts: list[tuple[Stamps, Array]] = []
        for signal in signals:
            values, marked = signal.rows.values, signal.rows.marked_valid
            names += [*signal.request.names, *([] if marked is None else [valid])]
            whole = values if marked is None else np.column_stack([values, marked])
            parts.append((signal.rows.stamps, whole))
        stamps, columns = _in_rows(parts)
        table = out / f"{name}.csv"
        stamp_names = (t, rest) if in_parts else (t,)
        write_table(table, stamp_names, names, stamps, np.column_stack(columns))
        written.append(table)
    content = _content(found, vehicle)
    for key in ("pose", "commands"):
        stamp = {"column": t, "nanoseconds": rest} if in_parts else {"column": t, "unit": "ns"}
        content[key] = _without_places(content[key]) | {"stamp": stamp}
    if any(s.rows.marked_valid is not None for s in found):
        content["pose"]["valid"] = valid
    for file, signal in ((f"{table}.csv", s) for table in tables for s in tables[table]):
        if source := SOURCES.get(signal.name):
            content[source]["file"] = file
        for name, column in zip(signal.request.names, signal.request.columns, strict=True):
            _enter(content, signal.request, name, _entry(column) | {"column": name, "file": file})
    return [*written, _write_vehicle(out / "vehicle.yaml", content)]


def _tables(found: Sequence[_Signal], *, all_driven: bool = False) -> dict[str, list[_Signal]]:
    """Signals by table: a table each, but commands stay in the rows of the poses, where they may be samples.

    all_driven: only where each of these rows has commands.
    """
    tables: dict[str, list[_Signal]] = {}
    for signal in found:
        poses = tables.get("poses", [])
        beside = signal.request.role == "commands" and any(
            _together(s, signal)
            and (not all_driven or np.isin(s.rows.stamps, signal.rows.stamps).all())
            for s in poses
        )
        tables.setdefault("poses" if beside else signal.name, []).append(signal)
    return tables


def _together(poses: _Signal, commands: _Signal) -> bool:
    """Whether the log has both in the rows of one table or topic, and a row of both is known by its stamp."""
    own, its = poses.rows, commands.rows
    rising = all(bool((np.diff(rows.stamps) > 0).all()) for rows in (own, its))
    return (
        own.stream.source == its.stream.source
        and (rising or np.array_equal(own.stamps, its.stamps))
        and not set(poses.request.names) & set(commands.request.names)
    )


def _in_rows(signals: Sequence[tuple[Stamps, Array]]) -> tuple[Stamps, list[Array]]:
    """The stamps of one place, and the values of each signal in its rows; NaN where it has none."""
    first, *others = (stamps for stamps, _ in signals)
    if all(np.array_equal(first, other) for other in others):
        return first, [values for _, values in signals]
    whole = np.unique(np.concatenate([first, *others]))
    placed = []
    for stamps, values in signals:
        rows = np.full((len(whole), values.shape[1]), np.nan)
        rows[np.searchsorted(whole, stamps)] = values
        placed.append(rows)
    return whole, placed


def _content(found: Sequence[_Signal], vehicle: Vehicle) -> dict[str, Any]:
    """The vehicle file's, with what only the log shows of the commands."""
    content = vehicle.to_mapping()
    stated = vehicle.file.commands.sampled
    sampled = sampled_commands([s.rows.stream for s in found], stated)
    if sampled is not None and sampled.clock is Clock.LOG:
        content["commands"]["sampled"] = are_samples(sampled, stated) or "estimate"
    elif sampled is None and stated is None:
        content["commands"]["sampled"] = False  # a table of them would leave it open
    return content


def _entry(column: Column) -> dict[str, Any]:
    """What the vehicle file states of a column, but for where it is."""
    kept = ("unit", "sign", "scale", "offset", "off")
    entry = {k: v for k, v in msgspec.to_builtins(column).items() if k in kept}
    if column.quaternion and column.unit is not None and column.unit != "rad":
        raise RecordingError(f"a heading from a quaternion has unit '{column.unit}'; leave it out")
    return entry


def _without_places(source: dict[str, Any]) -> dict[str, Any]:
    places = ("topic", "file", "stamp", "valid", "parent", "child", "clock", "x", "y", "psi")
    return {k: v for k, v in source.items() if k not in places}


def _enter(content: dict[str, Any], request: Request, name: str, entry: dict[str, Any]) -> None:
    """Put a column where the vehicle file has it."""
    if request.role == "commands":
        content["commands"]["inputs"][name] = entry
    elif request.role == "scales":
        content["scales"][name] = content["scales"][name] | {"column": entry}
    else:
        content["pose"][name] = entry


def _write_vehicle(path: Path, content: dict[str, Any]) -> Path:
    vehicle_from(content, str(path))
    write_text(path, dump_yaml(content))
    return path


def _apart(name: str, taken: Collection[str]) -> str:
    """The name of a column, with `_` behind it for as long as a signal has that name."""
    while name in taken:
        name += "_"
    return name


def write_table(
    path: Path, stamp_names: Sequence[str], names: Sequence[str], stamps: Stamps, values: Array
) -> None:
    """A table: stamps [ns] and a column for each name, all digits kept. Raises FileError.

    stamp_names: of the stamps' column; two: whole seconds, and the nanoseconds behind them.
    """
    parts = len(stamp_names) > 1
    texts = (
        ",".join([f"{t // NS_PER_S},{t % NS_PER_S}" if parts else str(t), *map(_number, row)])
        for t, row in zip(stamps.tolist(), values.tolist(), strict=True)
    )
    head = ",".join([*stamp_names, *(f'"{n}"' if "," in n else n for n in names)])
    write_chunks(path, (f"{line}\n".encode() for line in chain([head], texts)))


def _number(x: float) -> str:
    return "" if math.isnan(x) else repr(x)


def _all_topics(path: Path, out: Path) -> list[Path]:
    """Every topic of an autopilot's log as a table, and its parameters."""
    if not is_log(path):
        raise RecordingError(
            f"{path}: without --vehicle only logs of autopilots and of MOOS are converted (.BIN, .log, .ulg, "
            ".tlog, .alog)"
        )
    written, log = [], open_log(path)
    for topic in over(list(log.topics.values()), "topic"):
        (samples,) = log.read([Wanted(topic.name, topic.fields)])
        name = "".join(c if c.isalnum() or c in "_@.-" else "_" for c in topic.name).rstrip("_")
        table = out / f"{name or 'topic'}.csv"
        stamp_name = _apart(STAMP, topic.fields)
        write_table(table, (stamp_name,), topic.fields, samples.stamps, samples.values)
        written.append(table)
    if log.parameters:
        known = sorted((k, v) for k, v in log.parameters.items() if k.isidentifier())
        rows = "".join(f"{k},{v!r}\n" for k, v in known)
        write_text(out / "parameters.csv", f"name,value\n{rows}")
        written.append(out / "parameters.csv")
    return written


# Bags #


def _as_bag(found: Sequence[_Signal], out: Path, vehicle: Vehicle) -> list[Path]:
    content, places = _content(found, vehicle), _tables(found, all_driven=True)
    # a message of poses and commands has no header
    clock = "header" if all(len(signals) == 1 for signals in places.values()) else "bag"
    for key in ("pose", "commands"):
        content[key] = _without_places(content[key]) | {"clock": clock if key == "pose" else "bag"}
    topics = [_topic(f"/{name}", signals, content) for name, signals in places.items()]
    written = write_bag(out, topics)
    return [written, _write_vehicle(out.with_name(f"{recording_name(out)}.yaml"), content)]


def _topic(topic: str, signals: Sequence[_Signal], content: dict[str, Any]) -> BagTopic:
    """The messages of one place; their fields are entered in the vehicle file."""
    type_name, fields = _message(signals)
    left, found = iter(fields), []
    for signal in signals:
        stamps, values, entries = _written(signal)
        found.append((stamps, values))
        for name, entry in zip(signal.request.names, entries, strict=True):
            place = {"field": next(left), "topic": topic}
            _enter(content, signal.request, name, entry | place)
        if source := SOURCES.get(signal.name):
            content[source]["topic"] = topic
    stamps, parts = _in_rows(found)
    columns = dict(zip(fields, np.column_stack(parts).T, strict=True))
    return BagTopic(topic, type_name, stamps, stamps, columns)


def _written(signal: _Signal) -> tuple[Stamps, Array, list[dict[str, Any]]]:
    """Valid rows in the order of their stamps, and what the vehicle file states of each column."""
    stamps, values = signal.rows.stamps, signal.rows.values
    if signal.rows.marked_valid is not None:
        stamps, values = stamps[signal.rows.marked_valid], values[signal.rows.marked_valid]
    order = np.argsort(stamps, kind="stable")
    stamps, values = stamps[order], values[order]
    columns = signal.request.columns
    if signal.request.names != GEOGRAPHIC:
        return stamps, values, [_entry(column) for column in columns]
    # others read it, too: degrees
    degrees = [in_own_unit(x, c) for x, c in zip(values.T, columns, strict=True)]
    return stamps, np.column_stack(degrees), [{}, {}]


def _message(signals: Sequence[_Signal]) -> tuple[str, tuple[str, ...]]:
    """The message that the signals of a place become, and its fields."""
    first, names = signals[0].request, [name for s in signals for name in s.request.names]
    if len(signals) > 1 or not isinstance(first.spec, PoseSource):
        return "std_msgs/msg/Float64MultiArray", tuple(f"data[{i}]" for i in range(len(names)))
    if first.names == GEOGRAPHIC:
        return "sensor_msgs/msg/NavSatFix", GEOGRAPHIC
    fields = VECTOR[-1:] if len(names) == 1 else VECTOR[: len(names)]
    return "geometry_msgs/msg/Vector3Stamped", fields
