# SPDX-License-Identifier: MIT
"""The signals of the drive so far, in memory, as a recording."""

import math
import threading
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.monitoring.recent_log import HELD, KINDS, recording_of_signals
from seatrial.recording.averaging import with_enough_poses
from seatrial.recording.bursts import on_even_clock
from seatrial.recording.faults.pose_faults import Fault, FaultKind
from seatrial.recording.recording import Recording
from seatrial.recording.resolution import coarse_position
from seatrial.recording.signal import KEPT_BEFORE
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Stamps

MOST_ROWS = 1_000_000  # of a signal: 5.5 h at 50 Hz; 32 MB of poses
DROPPED_SHARE = 0.1  # of the rows, when there is no room for another
POSES = KINDS[:3]
FIRST_ROWS = 1024  # of a signal that begins
GROWTH = 1.5  # of its room
# [s] of the length, between two poses: a longer one is a pause, or the clock was set
LONGEST_STEP = 5.0


class SignalRows:
    """Rows of a signal, in order of their stamps: 8 (1 + width) bytes a row, and at most half as much again."""

    def __init__(self, width: int, most: int = MOST_ROWS) -> None:
        self._stamps = np.zeros(min(FIRST_ROWS, most), dtype=np.int64)
        self._values = np.zeros((len(self._stamps), width))
        self._most = most
        self.n = 0
        self.dropped = 0  # rows

    def add(self, stamp: int, values: Array) -> None:
        """A row at its place: after all with the same stamp."""
        if self.n == self._most:
            self._drop(max(1, int(DROPPED_SHARE * self.n)))
        if self.n == len(self._stamps):
            self._grow()
        at = self.n
        if at and stamp < self._stamps[at - 1]:
            at = int(np.searchsorted(self.stamps, stamp, side="right"))
            self._stamps[at + 1 : self.n + 1] = self._stamps[at : self.n].copy()
            self._values[at + 1 : self.n + 1] = self._values[at : self.n].copy()
        self._stamps[at], self._values[at] = stamp, values
        self.n += 1

    @property
    def stamps(self) -> Stamps:
        """Stamps (n,) [ns], a view."""
        return self._stamps[: self.n]

    @property
    def bytes(self) -> int:
        """Memory of its arrays."""
        return self._stamps.nbytes + self._values.nbytes

    def between(self, start: int | None, end: int | None) -> tuple[Stamps, Array]:
        """Copies of the rows of an interval [ns], ends included; None: from the first, to the last."""
        first = 0 if start is None else int(np.searchsorted(self.stamps, start, side="left"))
        last = self.n if end is None else int(np.searchsorted(self.stamps, end, side="right"))
        return self._stamps[first:last].copy(), self._values[first:last].copy()

    def holding(self, start: int | None, end: int | None) -> tuple[Stamps, Array]:
        """The same, with the row that holds where they begin."""
        if start is not None and (before := int(np.searchsorted(self.stamps, start, "right"))):
            start = int(self._stamps[before - 1])
        return self.between(start, end)

    def _grow(self) -> None:
        size = min(self._most, int(GROWTH * self.n))
        stamps, values = self._stamps, self._values
        self._stamps = np.zeros(size, dtype=np.int64)
        self._values = np.zeros((size, values.shape[1]))
        self._stamps[: self.n], self._values[: self.n] = stamps, values

    def _drop(self, rows: int) -> None:
        self._stamps[: self.n - rows] = self._stamps[rows : self.n].copy()
        self._values[: self.n - rows] = self._values[rows : self.n].copy()
        self.n -= rows
        self.dropped += rows


class DriveLog:
    """Signals of the drive so far, in any order of their stamps [ns], forward-left-up.

    Poses are of the measured point, as the vehicle states it. A row that is not finite is dropped. Threads may add
    rows while others read. A signal keeps `most_rows` rows; then its oldest tenth is dropped, and `message`
    says so.
    """

    def __init__(self, vehicle: Vehicle, most_rows: int = MOST_ROWS) -> None:
        self.vehicle = vehicle
        widths = (3, 2, 1, len(vehicle.inputs), len(vehicle.scales))
        self._rows = {
            kind: SignalRows(width, most_rows) for kind, width in zip(KINDS, widths, strict=True)
        }
        self._most = most_rows
        self._discarded: list[tuple[int, int]] = []
        self._newest: int | None = None  # [ns] stamp of the pose that arrived last
        self._length = 0.0  # [s]
        self.doubt = ""  # what the last recording of the whole drive shows of the poses
        self.coarse = False  # whether that is a rounding by which estimates are off
        self._lock = threading.Lock()

    def add(self, kind: str, stamp: int, values: Sequence[float] | Array) -> bool:
        """A row: pose (3,), position (2,), heading (1,), command (inputs,) or scale (scales,).

        False where it is not finite.
        """
        row = np.asarray(values, dtype=float).reshape(-1)
        if not all(map(math.isfinite, row.tolist())):
            return False
        with self._lock:
            self._rows[kind].add(stamp, row)
            if kind in ("pose", "position"):
                self._lengthen(stamp)
        return True

    def discard(self, start: int, end: int) -> None:
        """Leave out the poses of an interval [ns]: the boat was touched, or towed."""
        with self._lock:
            self._discarded.append((start, end))

    @property
    def discarded(self) -> tuple[tuple[int, int], ...]:
        """Intervals [ns] that are left out."""
        return tuple(self._discarded)

    @property
    def span(self) -> tuple[int, int] | None:
        """Stamps [ns] of the first and the newest pose or position; None: there is none."""
        with self._lock:
            found = [
                self._rows[kind].stamps[[0, -1]]
                for kind in ("pose", "position")
                if self._rows[kind].n
            ]
        return (int(min(s[0] for s in found)), int(max(s[1] for s in found))) if found else None

    @property
    def length(self) -> float:
        """Seconds of poses, in the order of their arrival; a clock that jumps adds `LONGEST_STEP` at most."""
        return self._length

    @property
    def newest(self) -> int | None:
        """Stamp [ns] of the pose that arrived last; None: there is none."""
        return self._newest

    def _lengthen(self, stamp: int) -> None:
        step = 0.0 if self._newest is None else 1e-9 * (stamp - self._newest)
        self._length += min(max(step, 0.0), LONGEST_STEP)
        self._newest = stamp

    def before(self, stamp: int, rows: int) -> int:
        """The stamp [ns] of the pose so many rows before another stamp; of the first, where there are fewer."""
        with self._lock:
            kind = "position" if self._rows["position"].n else "pose"
            stamps = self._rows[kind].stamps
            return int(stamps[max(0, int(np.searchsorted(stamps, stamp, side="right")) - rows)])

    def rows(self, kind: str) -> int:
        """Number of rows of a kind."""
        return self._rows[kind].n

    @property
    def poses(self) -> int:
        """Number of poses or positions."""
        return self.rows("pose") + self.rows("position")

    @property
    def bytes(self) -> int:
        """Memory [bytes] of the rows."""
        return sum(rows.bytes for rows in self._rows.values())

    @property
    def message(self) -> str:
        """What was dropped for want of room; empty: nothing."""
        lost = {kind: rows.dropped for kind, rows in self._rows.items() if rows.dropped}
        if not lost:
            return ""
        what = ", ".join(f"{n} of {kind}" for kind, n in lost.items())
        return (
            f"the oldest rows were dropped ({what}): the memory keeps {self._most} rows of a signal. "
            "The estimate no longer uses them. Identify from the saved recording for all of the drive"
        )

    def recording(self, start: int | None = None, end: int | None = None) -> Recording:
        """The recording that reading the saved log would give, or that of an interval [ns] of the poses.

        Raises RecordingError where there are too few poses, or no commands.
        """
        with self._lock:
            tables = {kind: self._table(kind, start, end) for kind in KINDS}
            discarded = list(self._discarded)
        texts = []
        for kind in POSES:
            stamps, text = on_even_clock(tables[kind][0])
            tables[kind] = stamps, tables[kind][1]
            texts.append(text)
        if start is None and end is None:
            self.doubt = next((text for text in texts if text), "")
            coarse = self._coarse(tables)
            self.coarse, self.doubt = bool(coarse), coarse or self.doubt
        whole = with_enough_poses(recording_of_signals(self.vehicle, lambda kind, _: tables[kind]))
        return _without(whole, discarded)

    def _coarse(self, tables: Mapping[str, tuple[Stamps, Array]]) -> str:
        """What to say of positions that are rounded coarsely. Raises RecordingError where none can be used."""
        places = np.vstack([tables[kind][1][:, :2] for kind in POSES[:2]])
        try:
            return coarse_position(self.vehicle.name, places)
        except RecordingError as error:
            self.coarse, self.doubt = True, str(error)
            raise

    def _table(self, kind: str, start: int | None, end: int | None) -> tuple[Stamps, Array]:
        rows = self._rows[kind]
        if kind not in HELD:
            return rows.between(start, end)
        return rows.holding(None if start is None else start - round(1e9 * KEPT_BEFORE), end)


def _without(recording: Recording, intervals: Sequence[tuple[int, int]]) -> Recording:
    """The recording without poses in intervals [ns]. Raises RecordingError where fewer than two are left."""
    for start, end in intervals:
        inside = (recording.stamps >= start) & (recording.stamps <= end)
        if not inside.any():
            continue
        begin, stop = recording.seconds(recording.stamps[inside][[0, -1]]).tolist()
        fault = Fault(FaultKind.EXCLUDED, begin, stop, int(inside.sum()))
        recording = replace(
            recording, valid=recording.valid & ~inside,
            faults=tuple(sorted((*recording.faults, fault), key=lambda f: f.start)),
        )  # fmt: skip
    return recording
