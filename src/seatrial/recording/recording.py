# SPDX-License-Identifier: MIT
"""A recording in memory: raw, unsynchronised, in forward-left-up axes, with its faults masked."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from seatrial.recording.asynchronous import Asynchronous
from seatrial.recording.faults.pose_faults import (
    COMMANDS_UNKNOWN,
    Fault,
    FaultKind,
    in_order,
    usual_step,
)
from seatrial.recording.signal import Signal
from seatrial.recording.timing import Stream
from seatrial.util.above import above, text_by
from seatrial.util.errors import RecordingError
from seatrial.util.files import sha256
from seatrial.util.frames import Array, Index, Mask, Stamps, freeze

if TYPE_CHECKING:
    from seatrial.boat.vehicle import Vehicle
    from seatrial.util.above import DataFrame, Figure

RATE_TOLERANCE = 0.01  # a rate counts as a whole multiple of another up to here
# of the mean time between poses is their period: that of bursts has a short median
LEAST_OF_MEAN = 0.5
RESTING_COMMAND = 0.05  # of an input's largest command, below which the boat rests


@dataclass(frozen=True)
class Source:
    """A source file."""

    path: Path

    @property
    def name(self) -> str:
        """Its name, without folders."""
        return self.path.name

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of its bytes, computed on first use: a large bag takes seconds."""
        return sha256(self.path)


@dataclass(frozen=True, eq=False)
class Recording:
    """Poses and commands as recorded, in forward-left-up axes and SI units.

    name: of the file, without its ending
    stamps: (n,) of the poses [ns], rising; with a delay, of the headings
    eta: (n, 3) x, y [m], psi [rad] unwrapped
    raw: (n, 3) as read, heading not unwrapped
    valid: (n,) poses that may be used
    segment: (n,) number of the segment between gaps and jumps
    commands: of the inputs, in forward-left-up axes
    scales: known signals on which thrust depends, such as a voltage; None: there are none
    faults: intervals that are left out, and why
    sources: files it was read from
    streams: timing of its signals
    remarks: losses in salvage, rows left out
    doubts: what makes its numbers doubtful, such as rounded coordinates
    offset: [s] cut off at its start
    position_delay: [s] by which positions are older than headings of the same stamp
    parts: (n,) measured parts of each pose; None: all are whole
    asynchronous: headings and yaw rates with stamps of their own
    command_period: [s] of commands that are or may be samples; 0: none are
    command_sampled: whether they are, if the vehicle file does not state it
    """

    name: str
    stamps: Stamps
    eta: Array
    raw: Array
    valid: Mask
    segment: Index
    commands: Signal
    scales: Signal | None
    faults: tuple[Fault, ...] = ()
    sources: tuple[Source, ...] = ()
    streams: tuple[Stream, ...] = ()
    remarks: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    offset: float = 0.0
    position_delay: float = 0.0
    parts: NDArray[np.int8] | None = None
    asynchronous: Asynchronous | None = None
    command_period: float = 0.0
    command_sampled: bool = False

    def __post_init__(self) -> None:
        freeze(self, "eta", "raw")
        freeze(self, "stamps", "segment", dtype=np.int64)
        freeze(self, "valid", dtype=np.bool_)
        if int(self.valid.sum()) < 2:
            raise RecordingError(
                f"{self.name}: {int(self.valid.sum())} usable poses of {len(self.stamps)}; "
                "check the pose columns and what marks them valid"
            )
        if len(self.commands.stamps) == 0:
            raise RecordingError(
                f"{self.name}: no commands; record them for the whole run and name them "
                "in the vehicle file"
            )

    @cached_property
    def origin(self) -> int:
        """Stamp of the first pose [ns]: the zero of `t`."""
        return int(self.stamps[0])

    @cached_property
    def t(self) -> Array:
        """Pose times (n,) [s] from the recording's start."""
        return self.seconds(self.stamps)

    @cached_property
    def period(self) -> float:
        """Median time between poses [s]."""
        return float(np.median(np.diff(self.t)))

    @cached_property
    def usual_step(self) -> float:
        """90th percentile [s] of the time between poses: the period of regular stamps."""
        return usual_step(np.diff(self.t))

    @property
    def duration(self) -> float:
        """From the first to the last pose [s]."""
        return float(self.t[-1])

    @cached_property
    def usable(self) -> float:
        """Share of usable poses; those with bad stamps count as unusable.

        Poses excluded by `--without` do not count.
        """
        late = sum(f.samples for f in self.faults if f.kind is FaultKind.STAMP)
        return float(self.valid.sum()) / (int((~self.excluded).sum()) + late)

    @cached_property
    def excluded(self) -> Mask:
        """Poses (n,) excluded by `--without`."""
        inside = np.zeros(len(self.t), dtype=bool)
        for fault in self.faults:
            if fault.kind is FaultKind.EXCLUDED:
                inside |= (self.t >= fault.start) & (self.t <= fault.end)
        return inside

    def seconds(self, stamps: Stamps) -> Array:
        """Stamps [ns] as seconds from the recording's start."""
        return (stamps - self.origin).astype(np.float64) * 1e-9

    def on_clock_of(self, other: Recording) -> Recording:
        """The recording with its seconds from the start of another, whose continuation it is."""
        later = float(self.origin - other.origin) * 1e-9
        moved = tuple(replace(f, start=f.start + later, end=f.end + later) for f in self.faults)
        found = replace(self, faults=moved)
        vars(found)["origin"] = other.origin
        return found

    @cached_property
    def unknown(self) -> tuple[tuple[float, float], ...]:
        """Intervals [s] with unknown commands.

        The time before the first command is unknown unless that command is zero: a log may begin
        while the boat is driven.
        """
        found = [(f.start, f.end) for f in self.faults if f.kind in COMMANDS_UNKNOWN]
        values = np.abs(self.commands.values)
        if len(values) and (values[0] > RESTING_COMMAND * values.max(axis=0)).any():
            found.insert(0, (-np.inf, float(self.seconds(self.commands.stamps[:1])[0])))
        return tuple(found)

    def cut(self, start: float | None = None, end: float | None = None) -> Recording:
        """The part from `start` to `end` [s] from the recording's start."""
        for value in (start, end):
            if value is not None and not np.isfinite(value):
                raise RecordingError(f"{self.name}: can't cut at {value} s; give seconds")
        if start is not None and end is not None and end <= start:
            raise RecordingError(f"{self.name}: end {end:g} s is not after start {start:g} s")
        begin = self.origin if start is None else self.origin + round(start * 1e9)
        stop = int(self.stamps[-1]) + 1 if end is None else self.origin + round(end * 1e9)
        keep = (self.stamps >= begin) & (self.stamps < stop)
        if int(keep.sum()) < 2:
            raise RecordingError(
                f"{self.name}: no poses between {start or 0.0:g} s and "
                f"{self.duration if end is None else end:g} s; it lasts {self.duration:.1f} s"
            )
        shift, last = (float(s) for s in self.seconds(self.stamps[keep][[0, -1]]))
        since = round(shift * 1e9)

        def moved(time: float) -> float:
            """[s] since the cut, to the last bit equal to the time of a pose."""
            return float(np.float64(round(time * 1e9) - since) * 1e-9)

        kept = tuple(
            replace(f, start=max(0.0, moved(f.start)), end=moved(min(f.end, last)))
            for f in self.faults
            if f.end >= shift and f.start <= last
        )
        own = self.asynchronous
        return replace(
            self._with_poses(keep),
            asynchronous=own and own.kept((own.stamps >= begin) & (own.stamps < stop)),
            commands=self.commands.cut(begin, stop),
            scales=None if self.scales is None else self.scales.cut(begin, stop),
            faults=kept,
            streams=tuple(replace(s, cut=True) for s in self.streams),
            offset=self.offset + float(shift),
        )

    def thinned(self, rate: float) -> Recording:
        """The recording with about `rate` [Hz] of its usable poses, or itself where it has hardly more.

        Commands stay. Poses that are measured in parts stay, too.
        """
        if not rate > 0.0:
            raise RecordingError(f"{self.name}: rate {rate} Hz: expected a number above 0")
        used = np.flatnonzero(self.valid)
        steps = np.diff(self.t[used])
        period = max(float(np.median(steps)), LEAST_OF_MEAN * float(steps.mean()))
        every = int((1.0 + RATE_TOLERANCE) / (rate * period))
        if every < 2 or self.parts is not None or self.asynchronous is not None:
            return self
        kept = np.union1d(0, used[::every])  # the first pose is the zero of time
        return self if int(self.valid[kept].sum()) < 2 else self._with_poses(kept)

    def _with_poses(self, kept: Mask | Index) -> Recording:
        """The recording with some of its poses: a mask (n,), or their places."""
        return replace(
            self,
            stamps=self.stamps[kept],
            eta=self.eta[kept],
            raw=self.raw[kept],
            valid=self.valid[kept],
            segment=self.segment[kept],
            parts=None if self.parts is None else self.parts[kept],
        )

    def to_dataframe(self, *, velocities: bool = False) -> DataFrame:
        """Poses as a DataFrame of pandas: a row a pose, index `t` [s], forward-left-up, in SI.

        Columns x, y, psi (unwrapped), with `velocities` u, v, r of the five-point stencil, each command and
        scale as it holds at the pose's stamp, and `valid`: whether the pose may be used. A command with the name
        of another column is `command.NAME`. `attrs` has units and the first stamp. Raises RecordingError where
        pandas is not installed.
        """
        frame: DataFrame = above("io.dataframe", "frame_of")(self, velocities=velocities)
        return frame

    @staticmethod
    def from_dataframe(frame: DataFrame, vehicle: Vehicle, name: str = "dataframe") -> Recording:
        """A recording of a DataFrame whose columns the vehicle file names, read as a CSV table is.

        The index is a column, too, where it has a name or holds times; then it is called `index` without one.
        Times with a zone are taken in UTC. Raises RecordingError.
        """
        recording: Recording = above("io.dataframe", "recording_from")(frame, vehicle, name)
        return recording

    def plot(self, figure: Figure | None = None) -> Figure:
        """Track, velocities, commands, and what is left out, with Matplotlib.

        Velocities are those of the five-point stencil, which differentiates the poses. Draws on `figure` where
        one is given. Raises SeatrialError where Matplotlib is not installed.
        """
        drawn: Figure = above("display.recording_plot", "plot_recording")(self, figure)
        return drawn

    def __repr__(self) -> str:
        return f"<Recording {self.name}: {self.duration:.1f} s, {len(self.t)} poses>"

    _repr_html_ = text_by("display.tables", "recording_html")

    def without(self, start: float, end: float) -> Recording:
        """The recording without the poses from `start` to `end` [s] from its start.

        For intervals with an external disturbance (a touched boat). The velocity after it is unknown.
        Commands stay. Raises RecordingError where fewer than two poses are left.
        """
        span = f"from {start:g} s to {f'{end:g} s' if np.isfinite(end) else 'its end'}"
        refused = f"{self.name}: can't exclude {span}"
        if not end > start:
            raise RecordingError(f"{refused}: the end is not after the start")
        if start > self.duration or end < 0.0:
            raise RecordingError(f"{refused}: it lasts {self.duration:.1f} s")
        inside = (self.t >= start) & (self.t <= end)
        if int((self.valid & ~inside).sum()) < 2:
            raise RecordingError(
                f"{self.name}: no poses remain without the time {span}: leave out the whole recording"
            )
        within = max(0.0, start), min(end, self.duration)
        fault = Fault(FaultKind.EXCLUDED, *within, int(inside.sum()))
        faults = sorted((*self.faults, fault), key=lambda f: f.start)
        return replace(self, valid=self.valid & ~inside, faults=tuple(faults))


def rising(stamps: Stamps) -> Mask:
    """A longest selection of rows with rising stamps; of equal stamps the last."""
    index = np.flatnonzero(in_order(stamps, strict=False))
    last = np.append(np.diff(stamps[index]) > 0, True)
    keep = np.zeros(len(stamps), dtype=bool)
    keep[index[last]] = True
    return keep
