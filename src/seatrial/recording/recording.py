# SPDX-License-Identifier: MIT
"""A recording in memory: raw, unsynchronised, in forward-left-up axes, with its faults masked."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from seatrial.recording.pose_faults import (
    UNKNOWN,
    Fault,
    FaultKind,
    examine,
    in_order,
    poses_held,
    silences,
    usual_step,
)
from seatrial.recording.timing import Stream, only_changes
from seatrial.util.errors import RecordingError
from seatrial.util.files import sha256
from seatrial.util.frames import Array, Mask, Stamps, frozen_array

BEFORE = 10.0  # [s] of the commands before a cut are kept: latency and lag;
AFTER = 1.0  # [s] and after it: their clock may be late, which looks like a negative latency
AT_REST = 0.05  # of an input's largest command: less is nothing


@dataclass(frozen=True)
class Signal:
    """Rows of values with integer stamps; a row holds until the next."""

    names: tuple[str, ...]
    stamps: Stamps  # (n,) [ns], rising
    values: Array  # (n, names)

    def __post_init__(self) -> None:
        object.__setattr__(self, "stamps", frozen_array(self.stamps, np.int64))
        object.__setattr__(self, "values", frozen_array(self.values))
        if self.values.shape != (len(self.stamps), len(self.names)):
            raise RecordingError(
                f"signal {', '.join(self.names)}: {len(self.stamps)} stamps but values of shape "
                f"{self.values.shape}"
            )
        if np.any(np.diff(self.stamps) <= 0):
            raise RecordingError(f"signal {', '.join(self.names)}: stamps must rise")

    def cut(self, start: int, end: int) -> "Signal":
        """Rows in [start, end) [ns], those `BEFORE` it, which still act at the start, and those `AFTER`; the
        row that holds where they begin is moved there.
        """
        start -= round(BEFORE * 1e9)
        end += round(AFTER * 1e9)
        first = int(np.searchsorted(self.stamps, start, side="right")) - 1
        keep = (self.stamps >= start) & (self.stamps < end)
        stamps, values = self.stamps[keep], self.values[keep]
        if first >= 0 and self.stamps[first] < start:
            stamps = np.concatenate([[start], stamps])
            values = np.concatenate([self.values[first : first + 1], values])
        return Signal(self.names, stamps, values)


@dataclass(frozen=True)
class Source:
    """The file that something came from."""

    path: Path

    @property
    def name(self) -> str:
        """Its name, without folders."""
        return self.path.name

    @cached_property
    def sha256(self) -> str:
        """SHA-256 of its bytes; a large bag takes seconds, so only when asked for."""
        return sha256(self.path)


@dataclass(frozen=True)
class Recording:
    """Poses and commands as recorded, in forward-left-up axes and SI units."""

    name: str
    stamps: Stamps  # (n,) of the poses [ns], rising
    eta: Array  # (n, 3) x, y [m], psi [rad] unwrapped
    raw: Array  # (n, 3) the same before anything was made of it: heading as it was read
    valid: Mask  # (n,) poses that may be used
    segment: NDArray[np.int64]  # (n,) number of the stretch between gaps and jumps
    commands: Signal
    scales: Signal | None
    faults: tuple[Fault, ...] = ()
    sources: tuple[Source, ...] = ()
    streams: tuple[Stream, ...] = ()  # how its signals arrived
    remarks: tuple[str, ...] = ()  # what was lost when salvaged, what was left out of its rows
    offset: float = 0.0  # [s] that `cut` took from its start

    def __post_init__(self) -> None:
        for name, dtype in (
            ("stamps", np.int64),
            ("eta", np.float64),
            ("raw", np.float64),
            ("valid", np.bool_),
            ("segment", np.int64),
        ):
            object.__setattr__(self, name, frozen_array(getattr(self, name), dtype))
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
        """Time [s] between poses that most do not exceed: the period, where stamps are even."""
        return usual_step(np.diff(self.t))

    @property
    def duration(self) -> float:
        """From the first to the last pose [s]."""
        return float(self.t[-1])

    @cached_property
    def usable(self) -> float:
        """Share of the recorded poses that may be used; those with bad stamps count, too.

        Not those that were left out as was asked for.
        """
        late = sum(f.samples for f in self.faults if f.kind is FaultKind.STAMP)
        asked = np.zeros(len(self.t), dtype=bool)
        for fault in self.faults:
            if fault.kind is FaultKind.UNWANTED:
                asked |= (self.t >= fault.start) & (self.t <= fault.end)
        return float(self.valid.sum()) / (int((~asked).sum()) + late)

    def seconds(self, stamps: Stamps) -> Array:
        """Stamps [ns] as seconds from the recording's start."""
        return (stamps - self.origin).astype(np.float64) * 1e-9

    @cached_property
    def unknown(self) -> tuple[tuple[float, float], ...]:
        """Stretches [s] in which it is not known what is commanded.

        Before the first command, too, unless that is nothing: a log that begins while the boat is
        driven does not tell what its thrusters did until then.
        """
        found = [(f.start, f.end) for f in self.faults if f.kind in UNKNOWN]
        values = np.abs(self.commands.values)
        if len(values) and (values[0] > AT_REST * values.max(axis=0)).any():
            found.insert(0, (-np.inf, float(self.seconds(self.commands.stamps[:1])[0])))
        return tuple(found)

    def cut(self, start: float | None = None, end: float | None = None) -> "Recording":
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
            """[s] since the cut, to the last bit what the stamp of a pose then is."""
            return float(np.float64(round(time * 1e9) - since) * 1e-9)

        kept = tuple(
            replace(f, start=max(0.0, moved(f.start)), end=moved(min(f.end, last)))
            for f in self.faults
            if f.end >= shift and f.start <= last
        )
        return replace(
            self,
            stamps=self.stamps[keep],
            eta=self.eta[keep],
            raw=self.raw[keep],
            valid=self.valid[keep],
            segment=self.segment[keep],
            commands=self.commands.cut(begin, stop),
            scales=None if self.scales is None else self.scales.cut(begin, stop),
            faults=kept,
            streams=tuple(replace(s, cut=True) for s in self.streams),
            offset=self.offset + float(shift),
        )

    def without(self, start: float, end: float) -> "Recording":
        """Without the poses from `start` to `end` [s] from the recording's start.

        For when something else than its thrusters moved the boat: what it did there says nothing, and after
        it velocity is unknown. Commands stay. Raises RecordingError where less than two poses are left.
        """
        last = float(self.t[-1])
        span = f"from {start:g} s to {f'{end:g} s' if np.isfinite(end) else 'its end'}"
        if not end > start:
            raise RecordingError(
                f"{self.name}: can't leave out {span}: the end is not after the start"
            )
        if start > last or end < 0.0:
            raise RecordingError(
                f"{self.name}: can't leave out {span}: it lasts {self.duration:.1f} s"
            )
        inside = (self.t >= start) & (self.t <= end)
        if int((self.valid & ~inside).sum()) < 2:
            raise RecordingError(
                f"{self.name}: nothing is left without what is {span}: leave the recording out altogether"
            )
        fault = Fault(FaultKind.UNWANTED, max(0.0, start), min(end, last), int(inside.sum()))
        faults = sorted((*self.faults, fault), key=lambda f: f.start)
        return replace(self, valid=self.valid & ~inside, faults=tuple(faults))


def make_recording(
    name: str,
    stamps: Stamps,
    eta: Array,
    commands: Signal,
    *,
    scales: Signal | None = None,
    marked_valid: Mask | None = None,
    timeout: float | None = None,
    sources: Sequence[Source] = (),
    streams: Sequence[Stream] = (),
    remarks: Sequence[str] = (),
) -> Recording:
    """A recording from raw poses: heading unwrapped, faults found and masked.

    stamps (n,) [ns]; eta (n, 3) x, y [m], psi [rad], forward-left-up. After `timeout` seconds of
    silence, and while a command is not a number, it is not known what the thrusters do.
    """
    if len(stamps) < 2:
        raise RecordingError(
            f"{name}: {len(stamps)} poses; at least a few seconds of them are needed"
        )
    held = poses_held(eta)
    if held.any():
        remarks = [*remarks, _held_text(held)]
        stamps, eta = stamps[~held], eta[~held]
        marked_valid = None if marked_valid is None else marked_valid[~held]
    found = examine(name, stamps, eta, marked_valid)
    t = found.t
    origin = stamps[found.in_order][0]
    driven, unknown = _known(commands)
    hidden = np.zeros(len(t), dtype=bool)
    faults = list(found.faults)
    if len(driven.stamps):
        held = (driven.stamps - origin).astype(float) * 1e-9
        holes = [(FaultKind.SILENT, *s) for s in silences(name, t, held, driven.values, timeout)]
        odd = (unknown - origin).astype(float) * 1e-9
        holes += [(FaultKind.NO_NUMBER, *s) for s in odd.tolist() if s[0] < t[-1] and s[1] > 0]
        for kind, begin, end in holes:
            inside = (t >= begin) & (t < end)
            hidden |= inside
            until = float(min(end, t[-1]))
            faults.append(Fault(kind, max(0.0, float(begin)), until, int(inside.sum())))
        streams = [replace(s, on_change=_changes(s, held, driven.values)) for s in streams]
    kept = found.in_order
    return Recording(
        name, stamps[kept], found.eta[kept], eta[kept], (found.valid & ~hidden)[kept],
        found.segment[kept], driven, scales, tuple(sorted(faults, key=lambda f: f.start)),
        tuple(sources), tuple(streams), tuple(remarks),
    )  # fmt: skip


def _held_text(held: Mask) -> str:
    return (
        f"{100 * held.mean():.0f} % of the rows repeat the pose before, as they are written more often than poses "
        "come: each pose counts once"
    )


def _changes(stream: Stream, held: Array, values: Array) -> bool:
    return stream.on_change or (stream.role == "commands" and only_changes(held, values))


def _known(commands: Signal) -> tuple[Signal, Stamps]:
    """The rows that are numbers, and the stretches (k, 2) [ns] from others to the next of them."""
    good = np.asarray(np.isfinite(commands.values).all(axis=1))
    if good.all():
        return commands, np.zeros((0, 2), dtype=np.int64)
    rows = np.flatnonzero(~good)
    first = rows[np.diff(rows, prepend=-2) > 1]
    later = np.append(np.flatnonzero(good), len(good))
    after = later[np.searchsorted(later, first)]
    ends = np.append(commands.stamps, np.iinfo(np.int64).max // 2)[after]
    known = Signal(commands.names, commands.stamps[good], commands.values[good])
    return known, np.column_stack([commands.stamps[first], ends])


def rising(stamps: Stamps) -> Mask:
    """Rows in the order of their stamps, as many as there can be; of one stamp, the last."""
    index = np.flatnonzero(in_order(stamps, strict=False))
    last = np.append(np.diff(stamps[index]) > 0, True)
    keep = np.zeros(len(stamps), dtype=bool)
    keep[index[last]] = True
    return keep
