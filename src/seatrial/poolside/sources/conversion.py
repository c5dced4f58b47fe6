# SPDX-License-Identifier: MIT
"""Rows of a log as events, by the columns of the vehicle file."""

from collections.abc import Iterator, Sequence

import msgspec
import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.io.assemble import GEOGRAPHIC, requests
from seatrial.io.poses import degrees_of, heading_of, in_plane
from seatrial.io.signals import Request, Signals, scaled
from seatrial.poolside.sources.source import EventKind, Mistakes, SourceEvent, usable
from seatrial.recording.faults.pose_faults import in_order
from seatrial.util.frames import Array, Stamps

NOT_LIVE = "yaw rates"  # of a gyro: read from a recording, not used by a session


class Conversion:
    """Turns rows of the vehicle file's signals into events, from first to last.

    The first fix is the origin of latitude and longitude, where the file states none. Commands from several
    places hold until their next row; a row of all of them is an event once each is known.
    """

    def __init__(self, vehicle: Vehicle, signals: Signals) -> None:
        self.vehicle, self.mistakes = vehicle, Mistakes("rows")
        self.wanted = [one for one in requests(signals, vehicle) if one.role != NOT_LIVE]
        self._whole = not any(one.role == "headings" for one in self.wanted)
        self._flip = vehicle.axes.signs
        self._signs = dict(zip(vehicle.inputs, vehicle.input_signs, strict=True))
        self._held: dict[str, dict[str, float]] = {"commands": {}, "scales": {}}

    def events(
        self, parts: Sequence[tuple[Request, Stamps, Array]], arrival: int | None = None
    ) -> Iterator[SourceEvent]:
        """Events of rows: of each request stamps (n,) [ns] and raw values (n, names), as `Signals.read` has them.

        They are in the order of their stamps; a row whose stamp is out of order follows the one before it.
        arrival [ns]: of all of them; None: by the log's clock.
        """
        values = [self._values(request, raw) for request, _, raw in parts]
        kinds = [self._kind(request) for request, _, _ in parts]
        turns = [_turns(stamps) for _, stamps, _ in parts]
        which = np.repeat(np.arange(len(parts)), [len(turn) for turn in turns])
        rows = np.concatenate([np.arange(len(turn)) for turn in turns])
        for j in np.argsort(np.concatenate(turns), kind="stable").tolist():
            k, i = int(which[j]), int(rows[j])
            request, stamps, _ = parts[k]
            row = self._row(request, kinds[k], values[k][i])
            if row is not None:
                at = int(turns[k][i]) if arrival is None else arrival
                yield SourceEvent(kinds[k], int(stamps[i]), row, at)

    def _row(self, request: Request, kind: EventKind, row: Array) -> Array | None:
        """The values of an event; None where there is none."""
        self.mistakes.total += 1
        if not usable(row):
            self.mistakes.add(f"a row of {request.place} has no number, or too large a one")
            return None
        return self._hold(request, row) if kind in ("command", "scale") else row

    def _kind(self, request: Request) -> EventKind:
        if request.role == "commands":
            return "command"
        if request.role == "scales":
            return "scale"
        if request.role == "headings":
            return "heading"
        return "pose" if self._whole else "position"

    def _values(self, request: Request, raw: Array) -> Array:
        """Forward-left-up values (n, names), of poses those of the measured point."""
        columns = request.columns
        if request.role in ("commands", "scales"):
            signs = [self._signs[n] if request.role == "commands" else 1.0 for n in request.names]
            return np.column_stack([scaled(raw[:, i], c) for i, c in enumerate(columns)]) * signs
        if request.role == "headings":
            return np.asarray(heading_of(raw[:, 0], columns[0])[:, None] * self._flip[2])
        if request.names[0] in GEOGRAPHIC:
            plane = self._in_plane(raw[:, :2], request)
        else:
            plane = np.column_stack([scaled(raw[:, i], columns[i]) for i in range(2)])
        plane = plane * self._flip[:2]
        if not self._whole:
            return plane
        return np.column_stack([plane, heading_of(raw[:, 2], columns[2]) * self._flip[2]])

    def _in_plane(self, raw: Array, request: Request) -> Array:
        """Positions (n, 2) [m]; NaN without a fix. Keeps the first fix as the origin."""
        columns = request.columns[:2]
        degrees = degrees_of(raw, columns)
        fixed = np.isfinite(degrees).all(axis=1)
        if not fixed.any():
            return np.full((len(raw), 2), np.nan)
        if self.vehicle.file.pose.origin is None:
            first = degrees[fixed][0]
            pose = msgspec.structs.replace(
                self.vehicle.file.pose, origin=(float(first[0]), float(first[1]))
            )
            file = msgspec.structs.replace(self.vehicle.file, pose=pose)
            self.vehicle = Vehicle(file, self.vehicle.source)
        return in_plane(raw, columns, self.vehicle)

    def _hold(self, request: Request, row: Array) -> Array | None:
        """All commands, or scales, with this row's; None: not all are known."""
        held = self._held[request.role]
        held.update(zip(request.names, row.tolist(), strict=True))
        names: Sequence[str] = (
            self.vehicle.inputs if request.role == "commands" else self.vehicle.scales
        )
        return np.array([held[name] for name in names]) if len(held) == len(names) else None


def _turns(stamps: Stamps) -> Stamps:
    """Stamps (n,) in order; of a row that is out of order the stamp of the one before it."""
    good = in_order(stamps, strict=False)
    last = np.maximum.accumulate(np.where(good, np.arange(len(stamps)), -1))
    first = int(np.argmax(good)) if len(good) else 0
    return np.asarray(stamps[np.where(last < 0, first, last)])
