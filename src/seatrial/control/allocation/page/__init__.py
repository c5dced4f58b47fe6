# SPDX-License-Identifier: MIT
"""Schemes of thrust allocation side by side as one HTML file."""

from pathlib import Path

from seatrial.control.allocation import AllocationComparison
from seatrial.control.allocation.page import sections
from seatrial.report.figures.png import check
from seatrial.report.html import page
from seatrial.report.papers import write_figures, write_tables
from seatrial.report.sections.base import Section, store_of
from seatrial.util.files import write_text

__all__ = ["allocation_report", "write_allocation"]


def allocation_report(found: AllocationComparison) -> str:
    """The page as HTML text. The same comparison gives the same text."""
    return page(_title(found), _sections(found))


def write_allocation(
    found: AllocationComparison,
    path: str | Path,
    *,
    figures: str | Path | None = None,
    raster: bool = False,
    tables: str | Path | None = None,
) -> None:
    """Write `allocation_report` to a file; `figures`, `raster` and `tables` as in `write_report`."""
    if raster:
        check()
    told = _sections(found)
    write_text(Path(path), page(_title(found), told))
    if figures is not None:
        drives = max((row.drives for row in found.rows), key=len, default=())
        names = {store_of(i): drive.recording for i, drive in enumerate(drives)}
        write_figures(told, names, Path(figures), raster=raster)
    if tables is not None:
        write_tables(told, Path(tables))


def _sections(found: AllocationComparison) -> list[Section]:
    order = (sections.verdict, sections.authority, sections.idling, sections.driven)
    return [told for one in order if (told := one(found)) is not None]


def _title(found: AllocationComparison) -> str:
    return f"{found.boat.vehicle.name}: thrust allocation by seatrial"
