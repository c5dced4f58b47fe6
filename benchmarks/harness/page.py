# SPDX-License-Identifier: MIT
"""Tables of a page, written between marks in it: `<!-- name -->` and `<!-- end -->`.

`<!-- name: some; words -->` shows only the rows that contain one of these words. All rows are then
in `tables/PAGE-name.csv` beside the page. A table that the page only links to, as
`(tables/PAGE-name.csv)`, needs no mark.
"""

import csv
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from seatrial.util.errors import FileError

MARK = re.compile(
    r"(?P<begin><!-- (?P<name>[a-z-]+)(?:: (?P<words>[^>]+))? -->\n).*?(?P<end><!-- end -->)",
    re.DOTALL,
)
RULE = re.compile(r"\|[ |:-]+\|")  # the line below a table's head


def fill(path: Path, makers: Mapping[str, Callable[[], str]]) -> None:
    """Every table of the page by the maker of its name; the words around them stay.

    Raises FileError where a table has no maker.
    """
    text = path.read_text()
    names = {m["name"] for m in MARK.finditer(text)} | linked(path, text)
    unknown = names - set(makers)
    if unknown:
        raise FileError(
            f"{path}: no table {', '.join(sorted(unknown))}; there are {', '.join(makers)}"
        )
    refill(path, {name: makers[name]() for name in names})


def refill(path: Path, made: Mapping[str, str]) -> None:
    """Replace the page's tables of these names; the others stay."""

    def block(mark: re.Match[str]) -> str:
        if mark["name"] not in made:
            return mark[0]
        text = compact(made[mark["name"]].strip())
        if mark["words"]:
            _write_csv(csv_of(path, mark["name"]), text)
            text = some_rows(text, mark["words"].split("; "))
        shown = f"{text}\n\n" if text else ""
        return f"{mark['begin']}\n{shown}{mark['end']}"

    text = path.read_text()
    path.write_text(MARK.sub(block, text))
    for name in linked(path, text) & made.keys():
        _write_csv(csv_of(path, name), compact(made[name].strip()))


def linked(path: Path, text: str) -> set[str]:
    """Names of the page's tables that it links to and shows no row of."""
    links = re.findall(rf"\(tables/{re.escape(path.stem)}-([a-z-]+)\.csv\)", text)
    return set(links) - {mark["name"] for mark in MARK.finditer(text)}


def compact(text: str) -> str:
    """The line below a table's head without spaces."""
    return re.sub(r"^\|[ |:-]+\|$", lambda rule: rule[0].replace(" ", ""), text, flags=re.MULTILINE)


def csv_of(page: Path, name: str) -> Path:
    """The file with all rows of a block that shows some."""
    return page.parent / "tables" / f"{page.stem}-{name}.csv"


def cells(line: str) -> list[str]:
    """Of a table's row."""
    return [cell.strip() for cell in line.strip().removeprefix("|").removesuffix("|").split("|")]


def some_rows(text: str, words: Sequence[str]) -> str:
    """The tables with only the rows that contain one of the words.

    Headings, and tables without such a row, are left out.
    """
    out = []
    for table in text.split("\n\n"):
        lines = table.splitlines()
        rows = [line for line in lines[2:] if any(word in line for word in words)]
        if rows and RULE.fullmatch(lines[1]):
            out.append("\n".join([*lines[:2], *rows]))
    return "\n\n".join(out)


def _write_csv(path: Path, text: str) -> None:
    """Tables one below the other, each under its heading."""
    path.parent.mkdir(exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        for line in text.splitlines():
            if line.startswith("|") and not RULE.fullmatch(line):
                writer.writerow(cells(line))
            elif not line.startswith("|"):
                writer.writerow([line.removeprefix("### ")] if line else [])
