# SPDX-License-Identifier: MIT
"""Compact tables for notebooks. Names come from files that nobody has checked: everything is escaped."""

from collections.abc import Sequence
from html import escape

from seatrial.util.errors import printable

LONGEST_NAME = 60  # [characters] shown of a name
MOST_ROWS = 60  # of a table
MOST_LINES = 12  # of a list of sentences


def plain(text: str, most: int = LONGEST_NAME) -> str:
    """Escaped text of limited length."""
    shown = printable(text, keep="")
    return escape(shown if len(shown) <= most else f"{shown[: most - 1]}…")


def table(
    head: Sequence[str], rows: Sequence[Sequence[str]], *, caption: str, words: int = 1
) -> str:
    """A table of cells that are HTML already. The first `words` columns are text, the others numbers."""
    shown = [_row("td", row, words) for row in rows[:MOST_ROWS]]
    if len(rows) > MOST_ROWS:
        shown.append(f'<tr><td colspan="{len(head)}">… {len(rows) - MOST_ROWS} more rows</td></tr>')
    return (
        f'<table class="seatrial"><caption style="text-align:left">{caption}</caption>'
        f"<thead>{_row('th', head, words)}</thead><tbody>{''.join(shown)}</tbody></table>"
    )


def folded(title: str, sentences: Sequence[str]) -> str:
    """Sentences behind a title that opens them; empty where there are none."""
    if not sentences:
        return ""
    shown = [f"<li>{plain(one, 1000)}</li>" for one in sentences[:MOST_LINES]]
    if len(sentences) > MOST_LINES:
        shown.append(f"<li>… {len(sentences) - MOST_LINES} more</li>")
    return f"<details><summary>{title}</summary><ul>{''.join(shown)}</ul></details>"


def counted(number: int, word: str) -> str:
    """`1 recording`, `3 recordings`."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def _row(kind: str, cells: Sequence[str], words: int) -> str:
    sides = ["left" if i < words else "right" for i in range(len(cells))]
    return (
        "<tr>"
        + "".join(
            f'<{kind} style="text-align:{side};padding:0 0.5em">{cell}</{kind}>'
            for cell, side in zip(cells, sides, strict=True)
        )
        + "</tr>"
    )
