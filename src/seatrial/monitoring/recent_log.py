# SPDX-License-Identifier: MIT
"""The last minute of a boat's signals, as a recording."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.recording.asynchronous import Poses, joined
from seatrial.recording.delays import stamps_of_headings
from seatrial.recording.origin import poses_of_origin
from seatrial.recording.recording import Recording, Signal, make_recording
from seatrial.util.frames import Array, Stamps

Rows = deque[tuple[int, Array]]  # stamp [ns], values
LATE = 8  # rows that may arrive after a newer one
MOST_ROWS = 60_000  # of one signal: a minute at 1 kHz; bounds memory whatever arrives


class RecentLog:
    """Signals of the last `length` seconds, in any order of their stamps [ns], forward-left-up.

    Poses are of the measured point, as the vehicle states it. A row that is not finite is dropped. One thread may
    add rows while another reads.
    """

    def __init__(self, vehicle: Vehicle, length: float) -> None:
        self.vehicle = vehicle
        self._length = round(1e9 * length)
        self._rows: dict[str, Rows] = {
            kind: deque(maxlen=MOST_ROWS)
            for kind in ("pose", "position", "heading", "command", "scale")
        }

    def add(self, kind: str, stamp: int, values: Sequence[float] | Array) -> None:
        """A row: pose (3,), position (2,), heading (1,), command (inputs,) or scale (scales,)."""
        row = np.array(values, dtype=float).reshape(-1)
        if not np.isfinite(row).all():
            return
        rows = self._rows[kind]
        rows.append((stamp, row))
        # of a signal that holds, one row before the log stays
        held = int(kind in ("command", "scale"))
        while len(rows) > held + 1 and rows[held][0] < stamp - self._length:
            rows.popleft()

    @property
    def newest(self) -> int | None:
        """Stamp [ns] of the newest pose or position; None: there is none."""
        stamps = [
            stamp for kind in ("pose", "position") for stamp, _ in list(self._rows[kind])[-LATE:]
        ]
        return max(stamps, default=None)

    def recording(self, start: int, end: int) -> Recording:
        """What is known of the interval between two stamps [ns]. Raises RecordingError."""
        poses = self._poses(start, end)
        position, heading = self.vehicle.delays
        later = poses.asynchronous
        signals = (
            self._signal("command", self.vehicle.inputs),
            self._signal("scale", self.vehicle.scales),
        )
        recording = make_recording(
            self.vehicle.name, stamps_of_headings(poses.stamps, heading), poses.eta, signals[0],
            scales=signals[1] if self.vehicle.scales else None,
            timeout=self.vehicle.file.command_timeout, position_delay=position - heading,
            parts=poses.parts, asynchronous=None if later is None else later.shifted(-round(1e9 * heading)),
        )  # fmt: skip
        return poses_of_origin(recording, np.array(self.vehicle.lever))

    def _poses(self, start: int, end: int) -> Poses:
        whole, positions, headings = (
            self._table(kind, width, start, end)
            for kind, width in (("pose", 3), ("position", 2), ("heading", 1))
        )
        if not len(positions[0]):
            return Poses(*whole)
        return joined(*positions, headings[0], headings[1][:, 0])

    def _signal(self, kind: str, names: tuple[str, ...]) -> Signal:
        return Signal(names, *self._table(kind, len(names)))

    def _table(
        self, kind: str, width: int, start: int | None = None, end: int | None = None
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
