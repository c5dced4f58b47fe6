# SPDX-License-Identifier: MIT
"""Text on a terminal, by rich: colours by what a line is, lines that fit the width. Imported only for a terminal.

The text is data: it is never read as markup. Colours depend on the line's own words alone.
"""

import re
from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from typing import TextIO

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

HANG = 4  # [columns] by which the rest of a long line is indented further
GAP = re.compile(r" {2,}")  # between two cells of a table
GAPS_OF_A_TABLE, ROWS_OF_A_TABLE = 2, 3  # at the least
WORDS_OF_A_CELL = 4  # more are a sentence, which stays with its row
COMMAND = re.compile(r"(?:\bnext: |^ *(?:=> )?)seatrial [a-z]")  # stays on one line, to be copied
STYLES = tuple(
    (re.compile(pattern, re.ASCII), style)
    for pattern, style in (
        (r"^ *=> (?:good|consistent) .*", "green"),
        (r"^ *=> (?!good |consistent ).*", "yellow"),
        (r"^ *(?:doubt|warning|assumed|Check first):(?= )", "bold yellow"),
        (r"^ *note:(?= )", "bold cyan"),
        (r"\bnot (?:identifiable|distinguishable from zero)", "yellow"),
        (r"^wrote(?= )", "bold green"),
        (r"(?:^|(?<=; ))next:(?= )", "bold cyan"),
        (r"(?<=\bnext: )seatrial .*", "cyan"),
        (r"^seatrial(?: [a-z]+)?:(?= )", "bold red"),
        (r"^ *# .*", "dim"),
    )
)
HEADING = re.compile(r"[^\s:#][^:]*:?")


def drawn(text: str, stream: TextIO, *, colour: bool, columns: int | None) -> str:
    """The text as it is sent to a terminal. columns: None: lines stay as they are."""
    console = Console(
        file=stream, force_terminal=colour, no_color=not colour, highlight=False, markup=False,
        emoji=False, width=columns,
    )  # fmt: skip
    text = text.expandtabs()
    lines = text.split("\n") if columns is None else with_folded_tables(text.split("\n"), columns)
    with console.capture() as captured:
        for line, following in zip(lines, [*lines[1:], ""], strict=True):
            whole = styled(line, following) if colour else Text(line)
            for part in [whole] if columns is None else fitted(whole, columns):
                console.print(part, soft_wrap=True)
    return captured.get().removesuffix("\n")


def with_folded_tables(lines: Sequence[str], columns: int) -> list[str]:
    """The lines; of a table that is too wide, the columns that do not fit below, with the first one again."""
    found: list[str] = []
    for is_table, block in groupby(lines, _is_row):
        rows = list(block)
        too_wide = is_table and len(rows) >= ROWS_OF_A_TABLE and max(map(cell_len, rows)) > columns
        found += folded(rows, columns) if too_wide else rows
    return found


def folded(rows: Sequence[str], columns: int) -> Sequence[str]:
    """A table in pieces one below the other; as it is where a column is too wide, as of sentences."""
    width = max(map(len, rows))
    padded = [row.ljust(width) for row in rows]
    filled = "".join(" " if set(letters) == {" "} else "x" for letters in zip(*padded, strict=True))
    if any(len(row.split("  ")[-1].split()) > WORDS_OF_A_CELL for row in rows):
        return rows
    places = [found.span() for found in re.finditer(r"x+(?: x+)*", filled)]
    label = places[0][1]  # [columns] of the first column, with its indentation
    pieces: list[list[tuple[int, int]]] = [[]]
    used = label
    for (_, before), (_, end) in pairwise(places):
        if used + end - before > columns and pieces[-1]:
            pieces.append([])
            used = label
        pieces[-1].append((before, end))
        used += end - before
        if used > columns:
            return rows
    return [
        (row[:label] + "".join(row[begin:end] for begin, end in piece)).rstrip()
        for piece in pieces
        for row in padded
    ]


def _is_row(line: str) -> bool:
    return len(GAP.findall(line.strip())) >= GAPS_OF_A_TABLE


def styled(line: str, following: str) -> Text:
    """A line with its colours. following: the next line, which makes this one a heading if it is indented."""
    text = Text(line)
    if following.startswith(" ") and (found := HEADING.match(line)):
        text.stylize("bold", *found.span())
    for pattern, style in STYLES:
        for found in pattern.finditer(line):
            text.stylize(style, *found.span())
    return text


def fitted(text: Text, columns: int) -> Iterator[Text]:
    """The line in parts that fit, broken between cells or words; what has no such place stays whole."""
    line = text.plain
    if cell_len(line) <= columns or COMMAND.search(line):
        yield text
        return
    indent = len(line) - len(line.lstrip(" "))
    hang = " " * min(indent + HANG, columns // 2)
    hang = f"{' ' * indent}# " if line[indent:].startswith("# ") else hang
    begin, lead = 0, ""
    for unit_begin, unit_end in _units(line, columns - len(hang)):
        if unit_begin > begin and cell_len(lead + line[begin:unit_end].rstrip()) > columns:
            yield _part(text, begin, unit_begin, lead)
            begin, lead = unit_begin, hang
    yield _part(text, begin, len(line), lead)


def _units(line: str, room: int) -> Iterator[tuple[int, int]]:
    """What stays together: cells of a table that fit, else words."""
    for cell in re.finditer(r"\S+(?: \S+)*" if _is_row(line) else r"\S+", line):
        if cell_len(cell[0]) <= room:
            yield cell.span()
        else:
            for word in re.finditer(r"\S+", cell[0]):
                yield cell.start() + word.start(), cell.start() + word.end()


def _part(text: Text, begin: int, end: int, lead: str) -> Text:
    part = text[begin:end]
    part.rstrip()
    return Text(lead).append_text(part)
