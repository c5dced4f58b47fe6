# SPDX-License-Identifier: MIT
"""A rigid body of a motion-capture export as a table: position [m], rotation as a quaternion, time [s]."""

import re
from collections.abc import Sequence
from contextlib import suppress
from functools import cached_property
from typing import ClassVar

import numpy as np

from seatrial.boat.schema import TO_SI, Column
from seatrial.io.tables.base import Table
from seatrial.io.tables.csv_table import CsvTable
from seatrial.io.tables.headers import ERROR, FRAME, MATRIX, POSITION, ROTATION, TIME, JoinedHeader
from seatrial.io.tables.stamps import from_date_times
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Mask, Stamps
from seatrial.util.quaternion import of_angles, of_matrix

MOST_BODIES = 64  # of a file
MOST_TOGETHER = 128  # columns of all bodies that are read at once
LARGEST = 1e12  # of a number in any unit; a larger one is no pose
LONGEST_NAME = 40  # characters of a body's name
UNITS = {
    "meters": "m", "metres": "m", "centimeters": "cm", "centimetres": "cm", "millimeters": "mm",
    "millimetres": "mm", "m": "m", "cm": "cm", "mm": "mm",
}  # fmt: skip
POINTS = re.compile(r"(\d{1,2})\.(\d{2})\.(\d{2})(?=\.|\s|$)")  # 02.31.05 for 02:31:05
SECONDS, CLOCK, MARKER_ERROR = "Time", "Capture Time", "Mean Marker Error"  # columns
PLACES = tuple(f"Position {a}" for a in POSITION)
QUATERNION = tuple(f"Rotation {a}" for a in "XYZW")


class CaptureTable(Table):
    """One rigid body, in the axes of the file, whichever is up; NaN where the cameras did not see it.

    Columns: Time [s] from the start of the take; Capture Time [s] since 1970, where the file states when it began
    (without a zone: as if that were UTC); Position X, Y, Z [m]; Rotation X, Y, Z, W, a unit quaternion.
    """

    only_poses = True
    captured: ClassVar[bool] = True
    right_handed: ClassVar[bool] = True

    def __init__(self, rows: CsvTable, header: JoinedHeader, body: str) -> None:
        self._rows, self._header, self._body = rows, header, body
        super().__init__(rows.path, body)
        self._parts = header.bodies[body]
        self.remarks = list(rows.remarks)
        self._zone = ""  # a remark on the time zone
        self._begun = self._first_frame()
        error = [MARKER_ERROR] if ERROR in self._parts else []
        clock = [] if self._begun is None else [CLOCK]
        self.names = [SECONDS, *clock, *PLACES, *QUATERNION, *error]
        self.units = {SECONDS: "s", **dict.fromkeys([*PLACES, *error], "m")}
        self._scale = TO_SI[self._unit_of_lengths()]
        self._order = self._order_of_angles()
        space = header.about.get(header.layout.space, "")
        if space.lower() == "local":
            raise RecordingError(
                f"{self.path}: Coordinate Space is Local: positions do not show where the boat is; export Global"
            )

    def stamps(self, column: Column, rows: Mask | None = None) -> Stamps:
        """See `Table`; says of the time of day that its zone is not known."""
        if column.column == CLOCK and not column.offset and self._zone not in self.remarks:
            self.remarks.append(self._zone)
        return super().stamps(column, rows)

    def _texts(self, name: str) -> None:
        return None

    def place(self, row: int) -> str:
        """The line of a row."""
        return self._rows.place(row)

    def _numbers(self, name: str) -> Array:
        return np.asarray(self._values[:, self.names.index(name)])

    @cached_property
    def _values(self) -> Array:
        """All columns (n, len(names)), in metres and seconds; NaN where the body is not seen."""
        # 1. Position and rotation as written; all zeros: not seen.
        matrix = all(part in self._parts for part in MATRIX)
        turned = MATRIX if matrix else tuple(p for p in (*ROTATION, "RW") if p in self._parts)
        raw = self._written_numbers((*POSITION, *turned))
        raw[(raw == 0.0).all(axis=1)] = np.nan
        raw[np.abs(raw) > LARGEST] = np.nan
        if len(self._header.bodies) == 1 and not np.isfinite(raw).all(axis=1).any():
            raise RecordingError(
                f"{self.path}: {self.name} is seen in none of {len(raw)} rows; export a take in which the cameras "
                "track it"
            )
        position, rotation = self._scale * raw[:, :3], raw[:, 3:]
        # 2. A quaternion, from whatever the file has.
        if matrix:
            rotation = of_matrix(rotation)
        elif len(turned) == len(ROTATION):
            rotation = of_angles(rotation * TO_SI[self._unit_of_angles()], self._order)
        # 3. Times.
        t = self._seconds(len(raw))
        clock = [] if self._begun is None else [self._begun + t]
        error = [self._scale * self._written_numbers((ERROR,))] if ERROR in self._parts else []
        return np.column_stack([t, *clock, position, rotation, *error])

    def _written_numbers(self, parts: Sequence[str]) -> Array:
        """Columns (n, parts) of the body as written; those of a few bodies are read at once."""
        rows, bodies = self._rows, self._header.bodies
        together = [rows.names[i] for own in bodies.values() for i in own.values()]
        if len(together) <= MOST_TOGETHER:
            rows.columns(together)
        return rows.columns([rows.names[self._parts[part]] for part in parts])

    def _seconds(self, count: int) -> Array:
        """Time (n,) [s] of the rows: as written, else by frames and their rate."""
        index, rows = self._header.index, self._rows
        if TIME in index:
            return np.asarray(rows.columns([rows.names[index[TIME]]])[:, 0])
        stated = self._header.about.get(self._header.layout.rate, "")
        rate = 0.0
        with suppress(ValueError):
            rate = float(stated.replace(",", "."))
        if not 0.0 < rate < np.inf:
            raise RecordingError(
                f"{self.path}: no column of time, and the frame rate is '{stated[:20]}', not a number; export "
                "with time"
            )
        frame = np.arange(count, dtype=float)
        if FRAME in index:
            frame = rows.columns([rows.names[index[FRAME]]])[:, 0] - 1.0
        return np.asarray(frame / rate)

    def _first_frame(self) -> float | None:
        """Time [s] since 1970 of the take's start; None: not stated, or not readable."""
        key = self._header.layout.begun
        stated = self._header.about.get(key, "").strip()
        if not stated:
            return None
        try:
            (begun,) = from_date_times([POINTS.sub(r"\1:\2:\3", stated)], key, lambda _: "")
        except RecordingError:
            self.remarks.append(f"{key} '{stated[:40]}' is in no known format of times: not used")
            return None
        if begun < 0 or not re.search(r"\d[-/.]\d", stated):
            return None
        self._zone = (
            f"{key} {stated[:40]} has no zone, and counts as UTC in column {CLOCK}, by the clock of the computer "
            "that captured"
        )
        return float(begun) * 1e-9

    def _unit_of_lengths(self) -> str:
        """The unit of positions, which becomes m."""
        layout = self._header.layout
        own = self._rows.names[self._parts[POSITION[0]]]
        stated = self._header.about.get(layout.unit, "") or self._rows.units.get(own, "")
        unit = UNITS.get(stated.strip().lower(), "") if stated else layout.length or "m"
        if not unit:
            raise RecordingError(
                f"{self.path}: unit of lengths is '{stated[:20]}'; export in metres, centimetres or millimetres"
            )
        return unit

    def _unit_of_angles(self) -> str:
        own = self._rows.names[self._parts[ROTATION[0]]]
        return "rad" if self._rows.units.get(own, "").lower().startswith("rad") else "deg"

    def _order_of_angles(self) -> str:
        """The axes about which the body turns in turn, each as it was turned before: x, y, z."""
        stated = self._header.about.get(self._header.layout.order, "XYZ").strip().lower()
        if "RW" in self._parts:
            return ""
        if sorted(stated) != sorted("xyz"):
            raise RecordingError(
                f"{self.path}: Rotation Type is '{stated[:20]}' without a column W; export quaternions"
            )
        return stated


def capture_tables(rows: CsvTable, header: JoinedHeader) -> list[Table]:
    """A table for each rigid body. Raises RecordingError."""
    if len(header.bodies) > MOST_BODIES:
        raise RecordingError(
            f"{rows.path}: {len(header.bodies)} rigid bodies, of at most {MOST_BODIES} that are read; export fewer"
        )
    found: list[Table] = [CaptureTable(rows, header, body) for body in header.bodies]
    for number, table in enumerate(found, 1):
        name = "".join(c if c.isprintable() and c not in "/\\" else "_" for c in table.name)
        name = name[:LONGEST_NAME]
        taken = {other.name for other in found[: number - 1]}
        table.name = name if name not in taken else f"{name}_{number}"
    return found
