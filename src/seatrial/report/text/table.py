# SPDX-License-Identifier: MIT
"""A table as data: one content for the page, for a spreadsheet and for a paper."""

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

from seatrial.report.text.cells import Cell, Interval, Text, Worded
from seatrial.report.text.latex import latex_text

VERDICTS = ("verdict", "better")  # heads of columns that say what the numbers mean
LONGEST_WORD = 30  # characters of a cell that stays on one line, to the right


@dataclass(frozen=True)
class Table:
    """Rows of cells. A row of one cell heads the rows below it."""

    name: str  # of its file, and its class on the page
    caption: str
    head: tuple[str, ...]
    rows: Sequence[Sequence[Cell]]
    marked: frozenset[int] = field(default_factory=frozenset)  # rows that are highlighted
    numbers: bool = True  # columns of numbers, to the right

    def html(self) -> str:
        """For the page; it scrolls sideways where it is too wide."""
        top = "".join(
            f'<th scope="col"{_kind(words, sight)}>{escape(cell)}</th>' if cell else "<td></td>"
            for cell, words, sight in zip(self.head, self.wordy, self.in_sight, strict=True)
        )
        body = "".join(self._row(place, row) for place, row in enumerate(self.rows))
        kind = f"numbers {self.name}" if self.numbers else self.name
        return (
            f'<div class="scroll" tabindex="0"><table class="{kind}"><thead><tr>{top}</tr></thead>'
            f"<tbody>{body}</tbody></table></div>"
        )

    def _row(self, place: int, row: Sequence[Cell]) -> str:
        first, *rest = (cell.html() for cell in row)
        if not rest:
            return f'<tr class="group"><th scope="rowgroup" colspan="{len(self.head)}">{first}</th></tr>'
        mark = ' class="marked"' if place in self.marked else ""
        kinds = map(_kind, self.wordy[1:], self.in_sight[1:])
        cells = "".join(f"<td{kind}>{c}</td>" for c, kind in zip(rest, kinds, strict=True))
        return f'<tr{mark}><th scope="row">{first}</th>{cells}</tr>'

    @property
    def wordy(self) -> tuple[bool, ...]:
        """Columns among numbers, but for the first, that hold sentences: to the left, and wrapped."""
        if not self.numbers:
            return (False,) * len(self.head)
        rows = [row for row in self.rows if len(row) > 1]
        columns = [[row[k] for row in rows] for k in range(1, len(self.head))]
        return (False, *(any(map(_is_sentence, column)) for column in columns))

    @property
    def in_sight(self) -> tuple[bool, ...]:
        """Columns of verdicts, which stay in sight where a table scrolls."""
        return tuple(name in VERDICTS for name in self.head)

    @property
    def grouped(self) -> bool:
        """Whether rows of one cell head others."""
        return any(len(row) == 1 for row in self.rows)

    def csv(self) -> str:
        """Comma-separated, numbers in full; the heading of a group is its rows' first column.

        A column of intervals becomes two.
        """
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        columns = [[row[k] for row in self.rows if len(row) > 1] for k in range(len(self.head))]
        wide = [any(isinstance(cell, Interval) for cell in column) for column in columns]
        head = ["group"] if self.grouped else []
        for name, two, column in zip(self.head, wide, columns, strict=True):
            head += [f"{name} from", f"{name} to"] if two else [name + _unit(column)]
        writer.writerow(head)
        group = ""
        for row in self.rows:
            if len(row) == 1:
                group = row[0].plain()
                continue
            cells = [group] if self.grouped else []
            for cell, two in zip(row, wide, strict=True):
                ends = cell.ends() if isinstance(cell, Interval) else ("", "")
                cells += ends if two else [cell.plain()]
            writer.writerow(cells)
        return out.getvalue()

    def latex(self) -> str:
        """A `tabular` with the rules of booktabs."""
        right = [self.numbers and not words for words in self.wordy[1:]]
        columns = "l" + "".join("r" if r else "l" for r in right)
        lines = [
            f"% {latex_text(self.caption)}; needs \\usepackage{{booktabs}}",
            rf"\begin{{tabular}}{{{columns}}}",
        ]
        lines += [
            r"\toprule",
            " & ".join(latex_text(cell) for cell in self.head) + r" \\",
            r"\midrule",
        ]
        for row in self.rows:
            cells = [cell.latex() for cell in row]
            if len(cells) == 1:
                lines.append(rf"\multicolumn{{{len(self.head)}}}{{l}}{{{cells[0]}}} \\")
            else:
                lines.append(" & ".join(cells) + r" \\")
        return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def _is_sentence(cell: Cell) -> bool:
    return isinstance(cell, Text) and len(cell.text) > LONGEST_WORD


def _kind(wordy: bool, in_sight: bool) -> str:
    found = " ".join([*["words"] * wordy, *["verdict"] * in_sight])
    return f' class="{found}"' if found else ""


def _unit(column: Sequence[Cell]) -> str:
    """The unit of a column of worded numbers."""
    units = {cell.unit for cell in column if isinstance(cell, Worded) and cell.unit}
    return f" [{', '.join(sorted(units))}]" if units else ""
