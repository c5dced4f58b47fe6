# SPDX-License-Identifier: MIT
"""A page as a file, its figures as SVG and PNG, its tables as CSV and LaTeX."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from seatrial.report.figures.png import png
from seatrial.report.figures.svg import svg
from seatrial.report.html import page, stores
from seatrial.report.sections.base import ALL, Section, store_of
from seatrial.util.files import write_bytes, write_text


def write_page(
    title: str,
    found: Sequence[Section],
    path: str | Path,
    recordings: Sequence[str],
    *,
    figures: str | Path | None,
    raster: bool,
    tables: str | Path | None,
) -> None:
    """Write sections to a page; into the folders `figures` and `tables` what `write_report` states.

    `recordings`: their names, in the order of the sections' stores.
    """
    write_text(Path(path), page(title, found))
    if figures is not None:
        names = {store_of(i): name for i, name in enumerate(recordings)}
        write_figures(found, names, Path(figures), raster=raster)
    if tables is not None:
        write_tables(found, Path(tables))


def write_figures(
    found: Sequence[Section], names: Mapping[str, str], folder: Path, *, raster: bool = False
) -> list[Path]:
    """Every figure as `NAME.svg`, those of a recording as `RECORDING-NAME.svg`; the paths written.

    `names`: the recording of every store; `raster`: each also as `.png`, see `png`.
    """
    written = []
    taken: set[str] = set()
    for store, figures in stores(found).items():
        head = "" if store == ALL else f"{_safe(names[store], store, taken)}-"
        for name, figure in figures.items():
            path = folder / f"{head}{name}.svg"
            drawn = svg(figure)
            write_text(path, drawn)
            written.append(path)
            if raster:
                written.append(folder / f"{head}{name}.png")
                write_bytes(written[-1], png(drawn))
    return written


def write_tables(found: Sequence[Section], folder: Path) -> list[Path]:
    """Every table as `NAME.csv` and `NAME.tex`; the paths written."""
    written = []
    for section in found:
        for table in section.tables:
            for suffix, text in (("csv", table.csv()), ("tex", table.latex())):
                path = folder / f"{table.name}.{suffix}"
                write_text(path, text)
                written.append(path)
    return written


def _safe(name: str, store: str, taken: set[str]) -> str:
    """A recording's name as a file name, unique."""
    found = re.sub(r"[^\w.-]+", "_", name).strip("._") or store
    found = f"{found}-{store}" if found in taken else found
    taken.add(found)
    return found
