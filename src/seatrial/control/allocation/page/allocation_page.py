# SPDX-License-Identifier: MIT
"""Schemes of thrust allocation side by side as one HTML file."""

from pathlib import Path

from seatrial.control.allocation import AllocationComparison
from seatrial.control.allocation.page import sections
from seatrial.report.figures.png import check
from seatrial.report.papers import write_page
from seatrial.report.sections.base import Section


def write_allocation(
    found: AllocationComparison,
    path: str | Path,
    *,
    figures: str | Path | None = None,
    raster: bool = False,
    tables: str | Path | None = None,
) -> None:
    """Write the page to a file; `figures`, `raster` and `tables` as in `write_report`."""
    if raster:
        check()
    names = [
        drive.recording for drive in max((row.drives for row in found.rows), key=len, default=())
    ]
    write_page(
        _title(found), _sections(found), path, names, figures=figures, raster=raster, tables=tables
    )


def _sections(found: AllocationComparison) -> list[Section]:
    order = (sections.verdict, sections.authority, sections.idling, sections.driven)
    return [section for one in order if (section := one(found)) is not None]


def _title(found: AllocationComparison) -> str:
    return f"{found.boat.vehicle.name}: thrust allocation by seatrial"
