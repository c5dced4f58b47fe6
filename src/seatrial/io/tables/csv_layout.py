# SPDX-License-Identifier: MIT
"""How a text table is laid out: which line is the header, what stands between the cells, what is a number."""

import csv
import re
from collections.abc import Sequence

from seatrial.io.tables.stamps import is_date_time

SEPARATORS = ",;\t|"
SPACES = " "  # any number of them between two cells
COMMENTS = ("#", "%", "//")  # that lines before the header begin with
# of a row without names, as trajectories of SLAM are exchanged (TUM RGB-D benchmark)
TRAJECTORY = ("timestamp", "x", "y", "z", "qx", "qy", "qz", "qw")
POSES = (TRAJECTORY[1:], ("tx", "ty", "tz", *TRAJECTORY[4:]))
TRAJECTORY_ROWS = 3
UNIT_NORM = 2e-3  # rounding of a quaternion to three decimals changes its squared norm by less
MOST_TITLES = 12  # lines of text above the header
COMMA_NUMBER = re.compile(r"\s*[-+]?\d*,\d+(?:[eE][-+]?\d+)?\s*")


def header_line(lines: Sequence[str]) -> int | None:
    """The header: the first line that is no comment, or the comment above the first row of numbers."""
    plain = [i for i, line in enumerate(lines) if line.strip() and not is_comment(line)]
    comments = [i for i, line in enumerate(lines) if line.strip() and is_comment(line)]
    if not plain:
        return comments[0] if comments else None
    before = [i for i in comments if i < plain[0]]
    if before and _begins_with_number(lines[plain[0]]):
        named = _named_in_comments(lines, before, lines[plain[0]])
        return plain[0] if named is None else named
    return _below_titles(lines, plain)


def _named_in_comments(lines: Sequence[str], before: Sequence[int], row: str) -> int | None:
    """The last comment that is divided as the row, else one with its separator; None: they are all words."""
    marks = [mark for mark in SEPARATORS if mark in row]
    cells = len(row.split())
    divided = [i for i in before if any(lines[i].count(m) == row.count(m) for m in marks)]
    spaced = [
        i
        for i in before
        if len(without_mark(lines[i]).split()) == cells > 1 or (not marks and cells == 1)
    ]
    marked = [i for i in before if any(mark in lines[i] for mark in marks)]
    return next(reversed(divided or spaced or marked), None)


def _below_titles(lines: Sequence[str], plain: Sequence[int]) -> int:
    """The header below lines of text: the first line that is divided as all lines below it, and has no number."""
    for k in plain[: MOST_TITLES + 1]:
        rows = [lines[i] for i in plain if i > k]
        if rows and _divided_alike(lines[k], rows):
            return plain[0] if _has_number(lines[k]) else k
    return plain[0]


def _divided_alike(head: str, rows: Sequence[str]) -> bool:
    counts = {mark: head.count(mark) for mark in SEPARATORS if mark in head}
    return any(all(row.count(mark) == n for row in rows) for mark, n in counts.items())


def _has_number(line: str) -> bool:
    cells = re.split(r"[,;\t|]", line)
    return any(map(is_number, cells)) or any(map(COMMA_NUMBER.fullmatch, re.split(r"[;\t|]", line)))


def _begins_with_number(line: str) -> bool:
    first = re.split(r"[,;\t| ]", line.strip(), maxsplit=1)[0]
    return is_number(first) or is_date_time(first)


def plain_lines(lines: Sequence[str]) -> int:
    """How many lines are neither empty nor a comment."""
    return sum(bool(line.strip()) and not is_comment(line) for line in lines)


def is_comment(line: str) -> bool:
    """Whether a line begins with the mark of a comment."""
    return line.lstrip().startswith(COMMENTS)


def without_mark(line: str) -> str:
    """The line without the mark of a comment."""
    return re.sub(r"^\s*(?:#|%|//)+[ \t]*", "", line)


def separator(head: str, row: str) -> str:
    """The separator: of the marks in the header the one that splits the first row into as many cells."""
    counts = {mark: head.count(mark) for mark in SEPARATORS if mark in head}
    likely = sorted(counts, key=lambda mark: -counts[mark])
    for mark in likely:
        if row.count(mark) == counts[mark]:
            return mark
    if likely:
        return likely[0]
    words = len(head.split())
    return SPACES if words > 1 and len(row.split()) == words else ","


def header_cells(head: str, row: str, delimiter: str) -> list[str]:
    """Names in the header; quoted names may hold the separator."""
    if delimiter == SPACES:
        return [name.strip('"') for name in head.split()]
    plain = head.split(delimiter)
    if '"' in head:
        try:
            quoted = next(csv.reader([head], delimiter=delimiter), [])
            cells = len(next(csv.reader([row], delimiter=delimiter), []))
        except csv.Error:
            quoted, cells = [], 0
        if quoted and len(quoted) == cells != len(plain):
            plain = quoted
    return [name.strip().strip('"') for name in plain]


def is_number(text: str) -> bool:
    """Whether a cell is a number with a decimal point."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def given_names(columns: int, rows: Sequence[str]) -> tuple[list[str], str]:
    """Names of columns without a header, and the remark on them: those of a trajectory, else column_1, ..."""
    if _are_trajectory(rows):
        names = list(TRAJECTORY)
        return names, f"has no header: a trajectory in the format of TUM, {', '.join(names)}"
    names = [f"column_{i + 1}" for i in range(columns)]
    return names, "has no header: its columns are column_1, column_2, ..."


def is_trajectory(names: Sequence[str]) -> bool:
    """Whether the columns are those of TUM's format and no others."""
    return tuple(name.lower() for name in names[1:]) in POSES


def _are_trajectory(rows: Sequence[str]) -> bool:
    """Whether rows are time, position and unit quaternion, as in TUM's format.

    Their four last cells have norm 1 in each of these rows, but are not all 0 or 1 there, as switches are.
    """
    try:
        values = [[float(cell) for cell in row.split()] for row in rows]
    except ValueError:
        return False
    if len(values) < TRAJECTORY_ROWS or any(len(row) != len(TRAJECTORY) for row in values):
        return False
    turns = [row[-4:] for row in values]
    unit = all(abs(sum(q * q for q in turn) - 1) < UNIT_NORM for turn in turns)
    return unit and not all(abs(q) in (0.0, 1.0) for turn in turns for q in turn)
