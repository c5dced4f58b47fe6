# SPDX-License-Identifier: MIT
"""The last minute of a boat's signals, as a recording."""

from collections import deque
from collections.abc import Callable, Sequence
from threading import Lock

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.recording.asynchronous import Poses, joined
from seatrial.recording.delays import stamps_of_headings
from seatrial.recording.from_poses import make_recording
from seatrial.recording.origin import poses_of_origin
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.util.frames import Array, Stamps

Rows = deque[tuple[int, Array]]  # stamp [ns], values
Table = Callable[[str, int], tuple[Stamps, Array]]
KINDS = ("pose", "position", "heading", "command", "scale")
HELD = ("command", "scale")  # signals that hold until their next row
LATE = 8  # rows that may arrive after a newer one
MOST_ROWS = 60_000  # of one signal: a minute at 1 kHz; bounds memory whatever arrives


class RecentLog:
    """Signals of the last `length` seconds, in any order of their stamps [ns], forward-left-up.

    Poses are of the measured point, as the vehicle states it. A row that is not finite is dropped. One thread may
    add rows while another reads and drops.
    """

    def __init__(self, vehicle: Vehicle, length: float) -> None:
        self.vehicle = vehicle
        self._length = round(1e9 * length)
        self._rows: dict[str, Rows] = {kind: deque(maxlen=MOST_ROWS) for kind in KINDS}
        self._lock = Lock()  # of changes; a deque is read in one step

    def add(self, kind: str, stamp: int, values: Sequence[float] | Array) -> None:
        """A row: pose (3,), position (2,), heading (1,), command (inputs,) or scale (scales,)."""
        row = np.array(values, dtype=float).reshape(-1)
        if not np.isfinite(row).all():
            return
        with self._lock:
            rows = self._rows[kind]
            rows.append((stamp, row))
            # of a signal that holds, one row before the log stays
            held = int(kind in HELD)
            while len(rows) > held + 1 and rows[held][0] < stamp - self._length:
                rows.popleft()

    def drop_after(self, stamp: int) -> None:
        """Forget rows with later stamps [ns]: of a clock that was set back."""
        with self._lock:
            for kind, rows in self._rows.items():
                kept = [row for row in rows if row[0] <= stamp]
                self._rows[kind] = deque(kept, maxlen=MOST_ROWS)

    @property
    def newest(self) -> int | None:
        """Stamp [ns] of the newest pose or position; None: there is none."""
        stamps = [
            stamp for kind in ("pose", "position") for stamp, _ in list(self._rows[kind])[-LATE:]
        ]
        return max(stamps, default=None)

    def recording(self, start: int, end: int) -> Recording:
        """What is known of the interval between two stamps [ns]. Raises RecordingError."""
        return recording_of_signals(
            self.vehicle, lambda kind, width: self._table(kind, width, *_span(kind, start, end))
        )

    def _table(
        self, kind: str, width: int, start: int | None, end: int | None
    ) -> tuple[Stamps, Array]:
        """Stamps (n,) in order, and values (n, width)."""
        found = list(self._rows[kind])  # in one step: another thread may add rows
        rows = [
            row for row in sorted(found, key=lambda row: row[0])
            if (start is None or row[0] >= start) and (end is None or row[0] <= end)
        ]  # fmt: skip
        stamps = np.array([stamp for stamp, _ in rows], dtype=np.int64)
        return stamps, np.array([values for _, values in rows], dtype=float).reshape(
            len(rows), width
        )


def _span(kind: str, start: int, end: int) -> tuple[int | None, int | None]:
    """Commands and scales hold: all of them count."""
    return (None, None) if kind in HELD else (start, end)


def recording_of_signals(vehicle: Vehicle, table: Table) -> Recording:
    """A recording of the boat's origin from signals of the measured point, forward-left-up.

    table: of a kind of signal and its width, the stamps (n,) [ns] in order and the values (n, width). Raises
    RecordingError.
    """
    poses = _poses(table)
    position, heading = vehicle.delays
    later = poses.asynchronous
    commands, scales = (
        _signal(table, kind, names)
        for kind, names in (("command", vehicle.inputs), ("scale", vehicle.scales))
    )
    recording = make_recording(
        vehicle.name, stamps_of_headings(poses.stamps, heading), poses.eta, commands,
        scales=scales if vehicle.scales else None,
        timeout=vehicle.file.command_timeout, position_delay=position - heading,
        parts=poses.parts, asynchronous=None if later is None else later.shifted(-round(1e9 * heading)),
    )  # fmt: skip
    return poses_of_origin(recording, np.array(vehicle.lever))


def _poses(table: Table) -> Poses:
    positions, headings = table("position", 2), table("heading", 1)
    if not len(positions[0]):
        return Poses(*table("pose", 3))
    return joined(*positions, headings[0], headings[1][:, 0])


def _signal(table: Table, kind: str, names: tuple[str, ...]) -> Signal:
    """Of rows with one stamp the last."""
    stamps, values = table(kind, len(names))
    last = np.append(np.diff(stamps) > 0, True)[: len(stamps)]
    return Signal(names, stamps[last], values[last])
