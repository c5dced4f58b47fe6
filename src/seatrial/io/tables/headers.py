# SPDX-License-Identifier: MIT
"""Headers of several rows, joined to one name a column: exports of motion-capture systems, as data."""

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path

from seatrial.io.tables.base import unique_names
from seatrial.io.tables.csv_layout import SEPARATORS
from seatrial.util.errors import RecordingError

MOST_COLUMNS = 1 << 14  # of a file
MARK, NO_MORE = r"[,;\t|]\s*", r"[,;\t|\s]*"  # between two cells; after the last one of a line
LINES_OF_OPENING = 3  # that tell an export from a plain table
LONGEST_WORDS = 1 << 10  # [characters] of a line's first cells
ROWS_SHOWN = 3  # lines after the header: units, and two rows
# what a row of the header says
BODY, KIND, QUANTITY, RATE, REST = "body", "kind", "quantity", "rate", "rest"
POSITION = ("X", "Y", "Z")
ROTATION = ("RX", "RY", "RZ")  # a quaternion has RW, too
MATRIX = tuple(f"M{i}" for i in range(9))  # column by column
ERROR = "error"  # of the markers, in units of length
FRAME, TIME = "frame", "time"


@dataclass(frozen=True)
class HeaderLayout:
    """The header of one program's exports: where it says what."""

    program: str
    opening: tuple[re.Pattern[str], ...]  # the first lines: a table of the user's begins otherwise
    columns: re.Pattern[str]  # first cell of the row that names the columns
    parts: Mapping[str, str]  # what a column is of a body, by quantity and name
    advice: str  # where there is no rigid body
    index: Mapping[str, str] = field(default_factory=dict)  # columns that are of no body
    labelled: Mapping[str, str] = field(default_factory=dict)  # rows of the header by first word
    above: Mapping[int, str] = field(default_factory=dict)  # other rows, by lines above `columns`
    pairs_in_line: bool = False  # keys and values follow each other in the first line
    pairs_in_lines: bool = False  # each line before `columns` has a key and its values
    prefixed: bool = False  # names of columns begin with the body's, where another body begins
    ends_blank: bool = False  # an empty line ends the rows: another table follows
    rate: str = ""  # keys: frames a second
    begun: str = ""  # date and time of the first frame
    unit: str = ""  # of lengths
    order: str = ""  # of Euler angles
    space: str = ""  # coordinates
    length: str = ""  # unit where the file states none


AXES_OF_BODY = {f"Position {a}": a for a in POSITION} | {f"Rotation {a}": f"R{a}" for a in "XYZW"}
LAYOUTS = (
    HeaderLayout(
        "OptiTrack Motive",
        (re.compile(r'"?Format Version"?([,;\t|])"?\d[\d.,]*"?\1"?[A-Z].*'),),
        re.compile("Frame"),
        AXES_OF_BODY | {"Mean Marker Error": ERROR, "Error Per Marker": ERROR},
        "make a rigid body of the boat's markers in Motive, and export rigid bodies",
        index={"Frame": FRAME, "Time (Seconds)": TIME, "Time": TIME},
        labelled={"Type": KIND, "Name": BODY, "ID": REST, "Parent": REST}, above={1: QUANTITY},
        pairs_in_line=True, rate="Export Frame Rate", begun="Capture Start Time", unit="Length Units",
        order="Rotation Type", space="Coordinate Space",
    ),
    HeaderLayout(
        "Qualisys QTM",
        (re.compile(rf"(?:NO_OF_FRAMES|FILE_VERSION){MARK}\d[\d.]*{NO_MORE}"),
         re.compile(rf"[A-Z][A-Z_]+{MARK}.*")),
        re.compile("Frame|Time|.* X"),
        {a: a for a in POSITION} | dict(zip(("Roll", "Pitch", "Yaw"), ROTATION, strict=True))
        | {f"Rot[{i}]": part for i, part in enumerate(MATRIX)} | {"Residual": ERROR},
        "define a 6DOF body of the boat's markers in QTM, and export 6DOF data",
        index={"Frame": FRAME, "Time": TIME}, pairs_in_lines=True, prefixed=True, rate="FREQUENCY",
        begun="TIME_STAMP", length="mm",
    ),
    HeaderLayout(
        "Vicon",
        (
            re.compile(rf'"?(?:Segments|Objects|Trajectories|Devices|Joints|Model Outputs)"?{NO_MORE}'),
            re.compile(rf'"?\d+(?:[.,]\d+)?"?{NO_MORE}'), re.compile(rf'(?:"")?{MARK}.*'),
        ),
        re.compile("Frame"), {f"T{a}": a for a in POSITION} | {f"R{a}": f"R{a}" for a in "XYZW"},
        "make an object of the boat's markers, and export Segments or Objects alone",
        index={"Frame": FRAME, "Sub Frame": "sub frame"},
        above={1: BODY, 2: RATE}, ends_blank=True, rate=RATE, length="mm",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class JoinedHeader:
    """A header of several rows: a name for each column, and what it says of them."""

    layout: HeaderLayout
    row: int  # line that names the columns, from 0
    cells: list[str]  # of that line
    names: list[str]  # of the columns, from all rows
    index: Mapping[str, int]  # columns of frame and time
    bodies: Mapping[str, Mapping[str, int]]  # columns of each body by what they are: X, RW
    others: int  # things without position or rotation: markers
    about: Mapping[str, str]  # further keys and their values


def layout_of(lines: Sequence[str]) -> HeaderLayout | None:
    """The layout with which these lines begin; None: a plain table."""
    begins = [line[:LONGEST_WORDS].strip("\r\n") for line in lines[:LINES_OF_OPENING]]
    for layout in LAYOUTS:
        opening = layout.opening
        if len(begins) >= len(opening) and all(map(re.Pattern.fullmatch, opening, begins)):
            return layout
    return None


def is_whole(lines: Sequence[str]) -> bool:
    """Whether these lines reach beyond the row that names the columns."""
    layout = layout_of(lines)
    return layout is not None and (at := _row_of_columns(layout, lines)) is not None and (
        len(lines) > at + ROWS_SHOWN
    )  # fmt: skip


def joined_header(path: Path, lines: Sequence[str]) -> JoinedHeader | None:
    """The header with which these lines begin; None: a plain table. Raises RecordingError where it has no body."""
    layout = layout_of(lines)
    if layout is None:
        return None
    # 1. The row that names the columns, and the keys above it.
    at = _row_of_columns(layout, lines)
    about = _pairs(layout, lines[: at or len(lines)])
    if at is None:
        raise _no_body(path, layout, 0, lines[0])
    mark = max(SEPARATORS, key=lines[at].count)
    cells = _cells(lines[at], mark)
    if len(cells) > MOST_COLUMNS:
        raise RecordingError(
            f"{path}: {len(cells)} columns, of at most {MOST_COLUMNS} that are read; export rigid bodies "
            "without markers"
        )
    # 2. The rows above it by what they say; a name holds until the next one.
    rows = _rows_above(layout, lines[:at], mark, len(cells), about)
    names, own = cells, rows.get(BODY, [""] * len(cells))
    if layout.prefixed:
        own, names = _without_prefix(layout, cells)
    filled: Iterator[str] = accumulate(own, lambda last, cell: cell or last)
    own = [*filled]
    quantities = rows.get(QUANTITY, [""] * len(cells))
    joined = [f"{q} {n}".strip() for q, n in zip(quantities, names, strict=True)]
    # 3. Columns of bodies.
    bodies = _by_body(layout, own, rows.get(KIND, [""] * len(cells)), joined)
    others = len({*own} - {"", *bodies})
    if not bodies:
        raise _no_body(path, layout, others, lines[0])
    index = {layout.index[n]: i for i, n in reversed([*enumerate(names)]) if n in layout.index}
    full = [f"{b} {n}".strip() for b, n in zip(own, joined, strict=True)]
    return JoinedHeader(layout, at, cells, full, index, bodies, others, about)


def _no_body(path: Path, layout: HeaderLayout, others: int, first: str) -> RecordingError:
    found = f" but {others} markers or other columns" if others else ""
    if layout.ends_blank:
        found += f" in its first table, {_words(first)[0]}"
    return RecordingError(
        f"{path}: export of {layout.program} that has no rigid body with position and rotation{found}: markers "
        f"have no heading; {layout.advice}"
    )


def _row_of_columns(layout: HeaderLayout, lines: Sequence[str]) -> int | None:
    """Index of the row that names the columns."""
    for i, line in enumerate(lines[1:], 1):
        first = _words(line)
        if first and layout.columns.fullmatch(first[0]):
            return i
    return None


def _words(line: str) -> list[str]:
    """The first two cells and the beginning of the rest, whatever stands between them."""
    begin = line[:LONGEST_WORDS].strip("\r\n")
    return [cell.strip().strip('"') for cell in re.split(r"[,;\t|]", begin, maxsplit=2)]


def _cells(line: str, mark: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line.strip("\r\n")], delimiter=mark), [])]
    except csv.Error:
        return [cell.strip().strip('"') for cell in line.strip("\r\n").split(mark)]


def _pairs(layout: HeaderLayout, lines: Sequence[str]) -> dict[str, str]:
    """Keys and values above the columns."""
    if layout.pairs_in_line:
        mark = lines[0][len(_words(lines[0])[0]) :].lstrip('"')[:1]
        cells = _cells(lines[0], mark if mark in SEPARATORS else ",")
        return dict(zip(cells[::2], cells[1::2], strict=False))
    if layout.pairs_in_lines:
        marks = [re.search(MARK, line) for line in lines]
        found = [_cells(line, m[0][0]) for line, m in zip(lines, marks, strict=True) if m]
        return {cells[0]: cells[1] for cells in found}
    return {}


def _rows_above(
    layout: HeaderLayout, lines: Sequence[str], mark: str, width: int, about: dict[str, str]
) -> dict[str, list[str]]:
    """Rows of the header, each (width,), by what they say; a rate goes to `about`."""
    found: dict[str, list[str]] = {}
    for distance, line in enumerate(reversed(lines), 1):
        cells = _cells(line, mark)[:width]
        cells += [""] * (width - len(cells))
        label = next((i for i in range(min(2, width)) if cells[i] in layout.labelled), None)
        if label is not None:
            role, cells[label] = layout.labelled[cells[label]], ""
        else:
            role = layout.above.get(distance, REST)
        if role == RATE:
            about[RATE] = cells[0]
        elif role != REST:
            found.setdefault(role, cells)
    return found


def _without_prefix(layout: HeaderLayout, cells: Sequence[str]) -> tuple[list[str], list[str]]:
    """Names of bodies where they begin, and of columns without them: `boat X` is X of boat."""
    bodies, names = [], []
    for cell in cells:
        body, _, name = cell.rpartition(" ")
        known = name in layout.parts
        bodies.append(body if known else "")
        names.append(name if known else cell)
    return bodies, names


def _by_body(
    layout: HeaderLayout, bodies: Sequence[str], kinds: Sequence[str], names: Sequence[str]
) -> dict[str, dict[str, int]]:
    """Columns by body and by what they are of it; a column that comes again is of another body.

    Of one name and another kind, as a marker, is another thing.
    """
    found: dict[tuple[str, str, int], dict[str, int]] = {}
    again: dict[tuple[str, str, str], int] = {}
    for i, (body, kind, name) in enumerate(zip(bodies, kinds, names, strict=True)):
        part = layout.parts.get(name)
        if body and part:
            number = again[body, kind, part] = again.get((body, kind, part), 0) + 1
            found.setdefault((body, kind, number), {}).setdefault(part, i)
    whole = [(body, columns) for (body, _, _), columns in found.items() if _is_body(columns)]
    return dict(zip(unique_names([b for b, _ in whole])[0], [c for _, c in whole], strict=True))


def _is_body(parts: Mapping[str, int]) -> bool:
    turned = all(p in parts for p in ROTATION) or all(p in parts for p in MATRIX)
    return turned and all(p in parts for p in POSITION)
