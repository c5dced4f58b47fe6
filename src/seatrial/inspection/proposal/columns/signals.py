# SPDX-License-Identifier: MIT
"""Position, heading, yaw rate and stamps among the columns of tables, by name and by value."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from seatrial.inspection.proposal.columns.heading_sense import wraps_in_degrees
from seatrial.inspection.proposal.columns.names import (
    UNITS,
    Grade,
    Kind,
    family,
    grade,
    is_quaternion_part,
    order,
    read_name,
)
from seatrial.inspection.proposal.sources import Sureness
from seatrial.io.columns import ColumnView, Tables, TableSeen
from seatrial.io.poses import LARGEST_LATITUDE, LARGEST_LONGITUDE, NO_FIX
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

PAIRS = (  # kinds of a position, the usual first
    (Kind.X, Kind.Y),
    (Kind.EAST, Kind.NORTH),
    (Kind.LATITUDE, Kind.LONGITUDE),
)
TRANSLATION = ("tx", "ty")  # beside a quaternion, as the format of TUM names a position
WHOLE_DEGREES = 1e7  # scale of latitudes as whole numbers of 1e-7 deg
# of a degree, scale of latitudes as NMEA 0183 writes them: 5954.462 is 59 deg 54.462 min
MINUTES = 60.0
RADIANS = round(math.pi / 180, 15)  # in a degree, of latitudes whose name or line of units has rad
HOW_WRITTEN = {
    WHOLE_DEGREES: ", whole numbers of 1e-7 deg",
    MINUTES: ", degrees and minutes as in NMEA 0183",
    RADIANS: ", radians",
}
WIDEST = 2.0  # [deg] that a small boat moves in latitude or longitude, at most
HARDLY_MOVES = 0.02  # of the other coordinate's range
LEAST_CORRELATION = 0.6  # of a yaw rate with the derivative of the heading
FINE_DEGREES = (10.0, 100.0)  # in a degree, of headings as whole numbers
GYRO_WORDS = ("gyro", "gyr", "gz", "gyroscope", "imu")  # a sensor's own rate
LISTED = 40  # columns in an error message


@dataclass(frozen=True)
class Position:
    """Two columns of one table that are the position."""

    table: TableSeen
    kinds: tuple[Kind, Kind]
    names: tuple[str, str]
    grade: Grade
    sure: Sureness
    why: str
    scale: float = 1.0  # of latitude and longitude
    offsets: tuple[float, float] = (0.0, 0.0)  # the same
    still: str = ""  # a coordinate that hardly moves
    signs: tuple[int, int] = (1, 1)
    y_up: bool = False  # whether the file has y up; its heading is then about y
    height: str = ""  # the third coordinate

    @property
    def values(self) -> tuple[Array, Array]:
        """Both columns (n,), in degrees where geographic; NaN without a fix."""
        first, second = (
            sign * (self.table.numbers(name) - offset) / self.scale
            for name, offset, sign in zip(self.names, self.offsets, self.signs, strict=True)
        )
        if self.kinds[0] is Kind.LATITUDE:
            lost = (np.abs(first) < NO_FIX) & (np.abs(second) < NO_FIX)
            first, second = np.where(lost, np.nan, first), np.where(lost, np.nan, second)
        return first, second

    @property
    def east_north(self) -> tuple[Array, Array] | None:
        """East and north (n,), up to scale equal in both; None of x and y."""
        first, second = self.values
        if self.kinds[0] is Kind.LATITUDE:
            return second * np.cos(np.radians(np.nanmedian(first))), first
        return (first, second) if self.kinds[0] is Kind.EAST else None

    @property
    def right_handed(self) -> bool:
        """Whether x, y and up are, by the system that wrote them; columns that the user chose may not be."""
        return self.table.table.right_handed and self.sure is not Sureness.CHOSEN

    @property
    def plane(self) -> tuple[Array, Array]:
        """Coordinates (n,) of a plane, the first east where that is known."""
        return self.east_north or self.values


@dataclass(frozen=True)
class Heading:
    """A column, or the four of a quaternion, that are the heading."""

    table: TableSeen
    names: tuple[str, ...]  # one, or x, y, z, w
    grade: Grade
    rank: int  # among its kind's words

    @property
    def in_question(self) -> str:
        """As a question names it."""
        if len(self.names) == 1:
            return f"{self.names[0]}, the heading of the log,"
        return f"the heading of the log (a quaternion, {', '.join(self.names)})"

    @property
    def values(self) -> Array:
        """(n,) as written, by its scale; or [rad] of a quaternion."""
        columns = [self.table.numbers(name) for name in self.names]
        if len(columns) == 1:
            return columns[0] / self.scale
        x, y, z, w = columns
        return np.asarray(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))

    @cached_property
    def scale(self) -> float:
        """10 or 100 where the heading wraps at 3600 or 36000: tenths or hundredths of a degree."""
        raw = self.table.numbers(self.names[0])
        return next(
            (s for s in FINE_DEGREES if len(self.names) == 1 and wraps_in_degrees(raw / s)), 1.0
        )


def stated_unit(table: TableSeen, name: str) -> str:
    """The unit of a column by its name, else by the line of units below the header; empty: not stated."""
    return read_name(name).unit or UNITS.get(table.table.units.get(name, "").lower(), "")


# Position #


def positions(tables: Tables) -> list[Position]:
    """Pairs of columns that are a position, the best first."""
    found = [
        position
        for table in tables
        for kinds in PAIRS
        for first, second in _pairs(table, kinds)
        if (position := weighed(table, kinds, (first, second))) is not None
    ]
    return sorted(found, key=lambda p: (-p.grade, PAIRS.index(p.kinds), _order(p)))


def _order(position: Position) -> int:
    return sum(order(n, k) for n, k in zip(position.names, position.kinds, strict=True))


def _pairs(table: TableSeen, kinds: tuple[Kind, Kind]) -> Iterator[tuple[str, str]]:
    """Columns of both kinds whose other words are the same."""
    firsts, seconds = (
        [
            c.name
            for c in table.view.columns
            if c.least is not None
            and grade(c.name, kind)
            and not read_name(c.name).rate
            and is_quaternion_part(c.name) is None
        ]
        for kind in kinds
    )
    for first in firsts:
        for second in seconds:
            if first != second and family(first) == family(second):
                yield first, second
    if kinds == PAIRS[0] and quaternions(table):  # beside a force they are torques
        names = {c.name.lower(): c.name for c in table.view.columns if c.least is not None}
        if all(name in names for name in TRANSLATION):
            yield names[TRANSLATION[0]], names[TRANSLATION[1]]
    if len(firsts) == len(seconds) == 1 and family(firsts[0]) != family(seconds[0]):
        yield firsts[0], seconds[0]


def weighed(
    table: TableSeen, kinds: tuple[Kind, Kind], names: tuple[str, str], *, chosen: bool = False
) -> Position | None:
    """The position with what its values show; None where they contradict it."""
    fits = [
        Grade.WHOLE if n.lower() in TRANSLATION else grade(n, k) or Grade.PART
        for n, k in zip(names, kinds, strict=True)
    ]
    values = [table.numbers(name) for name in names]
    spans = [float(np.nanmax(v) - np.nanmin(v)) if np.isfinite(v).any() else 0.0 for v in values]
    sure = Sureness.GUESS if min(fits) is Grade.PART else Sureness.CERTAIN
    scale, offsets, still = 1.0, (0.0, 0.0), ""
    if kinds[0] is Kind.LATITUDE:
        radians = any(stated_unit(table, name) == "rad" for name in names)
        written = _degrees(*values, radians=radians)
        if written is None and not chosen:
            return None
        scale, offsets = written or (1.0, (0.0, 0.0))
        why = "names; within 90 and 180 deg" + HOW_WRITTEN.get(scale, "")
    else:
        if max(spans) == 0 and not chosen:
            return None
        why = f"names; they range over {spans[0]:.3g} and {spans[1]:.3g}"
        if min(spans) < HARDLY_MOVES * max(spans):
            still = names[int(np.argmin(spans))]
            sure = Sureness.LIKELY if sure is Sureness.CERTAIN else sure
            why += f"; {still} hardly moves: is it a height?"
    if chosen:
        sure, why = Sureness.CHOSEN, why.replace("names", "--pose")
    return Position(table, kinds, names, min(fits), sure, why, scale, offsets, still)


def _degrees(
    latitude: Array, longitude: Array, *, radians: bool
) -> tuple[float, tuple[float, float]] | None:
    """Scale and offsets with which these are a small boat's latitude and longitude; None: with none.

    radians: whether the table states that they are.
    """
    known = np.isfinite(latitude) & np.isfinite(longitude)
    known &= (np.abs(latitude) > NO_FIX) | (np.abs(longitude) > NO_FIX)
    if not known.any():
        return None
    raw = latitude[known], longitude[known]
    for scale, offsets in ((RADIANS, (0.0, 0.0)),) if radians else _written(*raw):
        lat, lon = ((v - offset) / scale for v, offset in zip(raw, offsets, strict=True))
        inside = np.abs(lat).max() <= LARGEST_LATITUDE and np.abs(lon).max() <= LARGEST_LONGITUDE
        spread = max(np.ptp(np.percentile(v, (5, 95))) for v in (lat, lon))
        if inside and 0 < spread < WIDEST:
            return scale, offsets
    return None


def _written(latitude: Array, longitude: Array) -> Iterator[tuple[float, tuple[float, float]]]:
    """How they may be written, as scale and offsets: degrees; whole numbers of 1e-7 deg; NMEA 0183."""
    yield 1.0, (0.0, 0.0)
    if all(np.all(v == np.rint(v)) for v in (latitude, longitude)):
        yield WHOLE_DEGREES, (0.0, 0.0)
    # NMEA: 100 degrees + minutes; within one degree that is degrees with an offset and a scale of 60
    degrees = [np.trunc(v / 100.0) for v in (latitude, longitude)]
    minutes = [np.abs(v - 100.0 * d) for v, d in zip((latitude, longitude), degrees, strict=True)]
    if all(np.all(d == d[0]) and m.max() < MINUTES for d, m in zip(degrees, minutes, strict=True)):
        first, second = (float((100.0 - MINUTES) * d[0]) for d in degrees)
        yield MINUTES, (first, second)


# Heading and yaw rate #


def headings(tables: Tables) -> list[Heading]:
    """Columns and quaternions that are a heading, the best first."""
    found = [
        Heading(table, (c.name,), fit, order(c.name, Kind.HEADING))
        for table in tables
        for c in table.view.columns
        if c.changes and c.least is not None and is_quaternion_part(c.name) is None
        and not read_name(c.name).rate and (fit := grade(c.name, Kind.HEADING)) is not None
    ]  # fmt: skip
    found += [
        Heading(table, names, Grade.PREFIXED, len(names))
        for table in tables
        for names in quaternions(table)
    ]
    return sorted(found, key=lambda h: (-h.grade, h.rank))


def quaternions(table: TableSeen) -> list[tuple[str, str, str, str]]:
    """Columns x, y, z, w of unit quaternions."""
    parts: dict[tuple[str, ...], dict[str, str]] = {}
    for column in table.view.columns:
        part = is_quaternion_part(column.name)
        if part is not None and column.least is not None:
            parts.setdefault(part[0], {}).setdefault(part[1], column.name)
    found = []
    for names in parts.values():
        if set(names) == set("xyzw"):
            four = (names["x"], names["y"], names["z"], names["w"])
            norm = np.linalg.norm([table.numbers(name) for name in four], axis=0)
            moves = any(c.changes for c in table.view.columns if c.name in four)
            if moves and np.isfinite(norm).any() and abs(float(np.nanmedian(norm)) - 1) < 0.01:
                found.append(four)
    return found


def yaw_rates(table: TableSeen) -> list[str]:
    """Columns named like a yaw rate rather than like a command, F_r; those of a gyro first."""
    named = [
        c.name
        for c in table.view.columns
        if c.changes and c.least is not None
        and (fit := grade(c.name, Kind.YAW_RATE)) is not None
        and fit > (grade(c.name, Kind.COMMAND) or 0)
    ]  # fmt: skip
    return sorted(named, key=lambda n: (not is_gyro(n), order(n, Kind.YAW_RATE)))


def is_gyro(name: str) -> bool:
    """Whether the name is of a sensor, rather than of an estimate."""
    words = read_name(name).words
    return any(w in GYRO_WORDS for w in words) or {"angular", "velocity"} <= set(words)


# Valid poses #


def is_validity(column: ColumnView) -> bool:
    """Whether a column marks valid poses."""
    marks = grade(column.name, Kind.VALID) is not None or "valid" in column.name.lower()
    return marks and (column.least, column.most) in ((0, 1), (1, 1))


# Columns that the user names #


def column_of(path: Path, tables: Tables, text: str, option: str) -> tuple[TableSeen, str]:
    """The table and name of a column that the user gave: COLUMN, or TABLE/COLUMN. Raises RecordingError."""
    found = holding_tables(tables, text)
    if len(found) == 1:
        return found[0]
    if found:
        listed = ", ".join(f"{t.key}/{c}" for t, c in found)
        raise RecordingError(f"{path}: column {text} ({option}) is in several tables: {listed}")
    listed = ", ".join(c.name for t in tables for c in t.view.columns[:LISTED])
    raise RecordingError(f"{path}: no column {text} ({option}); there are {listed}")


def holding_tables(tables: Tables, text: str) -> list[tuple[TableSeen, str]]:
    """Tables with such a column."""
    found = [(t, text) for t in tables if text in t.table.names]
    for table in tables:
        name = text.removeprefix(f"{table.key}/")
        if table.key and name != text and name in table.table.names:
            found.append((table, name))
    return found


def shown(table: TableSeen, *names: str) -> str:
    """Columns as the table of signals shows them."""
    listed = ", ".join(names)
    return f"{table.key}: {listed}" if table.key else listed
