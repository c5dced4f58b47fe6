# SPDX-License-Identifier: MIT
"""A recording from a bag: fields, signals and clocks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from seatrial.boat.schema import Column
from seatrial.boat.vehicle import Vehicle, as_column
from seatrial.io.bags.bag import Bag, Topic
from seatrial.io.bags.collect import Collector, Samples, collect
from seatrial.io.bags.opening import open_bag
from seatrial.io.bags.poses import chosen_stamps, pose_fields, poses_from_tf, raw_poses
from seatrial.io.table import checked_unit, scaled
from seatrial.recording.delays import stamps_of_headings
from seatrial.recording.recording import Recording, Signal, Source, make_recording, rising
from seatrial.recording.timing import Stream, describe
from seatrial.util.errors import RecordingError
from seatrial.util.progress import stage

ALL_READ, COMMANDS_READ = 0.9, 0.3  # of the time of a recording; poses from tf are read apart


@dataclass(frozen=True)
class _Part:
    """Columns of a signal from one topic."""

    topic: Topic
    names: tuple[str, ...]
    columns: tuple[Column, ...]

    def collector(self, source: str, *, salvage: bool) -> Collector:
        """Gathers them."""
        return Collector(self.topic, tuple(map(field_path, self.columns)), source, salvage=salvage)


def read_bag(path: Path, vehicle: Vehicle, *, salvage: bool = False) -> Recording:
    """A recording in forward-left-up axes. Raises RecordingError, FileError."""
    with open_bag(path, salvage=salvage) as bag:
        commands = _parts(bag, vehicle, vehicle.file.commands.inputs, "commands: inputs")
        known = {name: scale.column for name, scale in vehicle.file.scales.items()}
        scales = _parts(bag, vehicle, known, "scales")
        fields = pose_fields(bag, vehicle)
        wanted = [part.collector(str(path), salvage=salvage) for part in (*commands, *scales)]
        if fields is not None:
            wanted.append(fields.collector(str(path), salvage=salvage))
        with stage("", ALL_READ if fields is not None else COMMANDS_READ):
            samples = collect(bag, wanted)
        unreadable = [
            f"{s.dropped} unreadable messages on {s.topic.name}" for s in samples if s.dropped
        ]
        poses = (
            poses_from_tf(bag, vehicle, salvage=salvage)
            if fields is None
            else raw_poses(fields, samples.pop(), vehicle, str(path))
        )
        driven, streams = _signal(vehicle, commands, samples, "commands")
        factors, more = _signal(vehicle, scales, samples, "scales")
    position, heading = vehicle.delays
    return make_recording(
        recording_name(path), stamps_of_headings(poses.stamps, heading), poses.eta,
        driven,
        scales=_finite(factors) if scales else None, timeout=vehicle.file.command_timeout,
        sources=[Source(file) for file in bag.files], streams=(poses.stream, *streams, *more),
        remarks=(*bag.remarks, *unreadable), position_delay=position - heading,
    )  # fmt: skip


def recording_name(path: Path) -> str:
    """A recording's name: the file's or folder's, without the suffix."""
    full = path.resolve()
    name = full.name.removesuffix(".active").removesuffix(".zstd")
    return full.name if full.is_dir() else name.rpartition(".")[0]


def field_path(column: Column) -> str:
    """The path to a column's field in a message."""
    return column.field if column.index is None else f"{column.field}[{column.index}]"


def _parts(
    bag: Bag, vehicle: Vehicle, entries: Mapping[str, str | Column], where: str
) -> list[_Part]:
    """The columns by topic."""
    found: dict[str, dict[str, Column]] = {}
    for name, entry in entries.items():
        column = as_column(entry)
        topic = column.topic or vehicle.file.commands.topic
        if topic is None or not column.field:
            lacks = "topic" if topic is None else "field"
            raise RecordingError(
                f"{vehicle.source}: {where}: {name} has no {lacks}; name one for bags, or let "
                f"'seatrial init {bag.path}' write a vehicle file"
            )
        checked_unit(column, f"{vehicle.source}: {where}: {name}")
        found.setdefault(bag.topic(topic, f"{where}: {name}").name, {})[name] = column
    return [
        _Part(bag.topics[topic], tuple(part), tuple(part.values())) for topic, part in found.items()
    ]


def _signal(
    vehicle: Vehicle, parts: Sequence[_Part], samples: list[Samples], role: str
) -> tuple[Signal, list[Stream]]:
    """One signal out of the topics' columns: each value holds until its topic's next.

    Removes the samples from the list, so that ten hours of them are in memory once.
    """
    names = vehicle.inputs if role == "commands" else vehicle.scales
    signs = (
        dict(zip(vehicle.inputs, vehicle.input_signs, strict=True)) if role == "commands" else {}
    )
    signals, streams = [], []
    for part in parts:
        found = samples.pop(0)
        stamps, clock = chosen_stamps(found, vehicle.file.commands.clock)
        streams.append(
            describe(
                role, part.topic.name, part.topic.type, clock=clock, stamps=stamps,
                arrival=found.arrival, publishers=part.topic.publishers,
            )
        )  # fmt: skip
        keep = rising(stamps)
        values = np.empty((int(keep.sum()), len(part.names)))
        for i, (name, column) in enumerate(zip(part.names, part.columns, strict=True)):
            values[:, i] = signs.get(name, 1.0) * scaled(found.values[:, i], column)[keep]
        signals.append(Signal(part.names, stamps[keep], values))
    return _merged(signals, names), streams


def _merged(signals: Sequence[Signal], names: tuple[str, ...]) -> Signal:
    """Signals as one, in the order of `names`, from the time when all are known."""
    if not signals:
        return Signal((), np.zeros(0, np.int64), np.zeros((0, 0)))
    if len(signals) == 1 and signals[0].names == names:
        return signals[0]
    begin = max(s.stamps[0] for s in signals)
    stamps = np.unique(np.concatenate([s.stamps for s in signals]))
    stamps = stamps[stamps >= begin]
    values = np.empty((len(stamps), len(names)))
    for signal in signals:
        row = np.searchsorted(signal.stamps, stamps, side="right") - 1
        for i, name in enumerate(signal.names):
            values[:, names.index(name)] = signal.values[row, i]
    return Signal(names, stamps, values)


def _finite(signal: Signal) -> Signal:
    """Rows of finite numbers; without the others the previous row holds."""
    good = np.isfinite(signal.values).all(axis=1)
    return Signal(signal.names, signal.stamps[good], signal.values[good])
