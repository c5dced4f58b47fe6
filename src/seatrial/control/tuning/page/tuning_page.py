# SPDX-License-Identifier: MIT
"""A tuning as one HTML file: gains, margins, step responses and Bode plots."""

from pathlib import Path

from seatrial.control import Tuning
from seatrial.control.tuning.page.sections import bode, gains, provenance, safety, steps
from seatrial.control.tuning.responses import responses
from seatrial.report.html import page
from seatrial.util.files import write_text


def tuning_report(tuning: Tuning) -> str:
    """The page as HTML text; the same tuning gives the same text."""
    curves = responses(tuning)
    found = [
        gains(tuning),
        safety(tuning),
        steps(tuning, curves),
        bode(tuning, curves),
        provenance(tuning),
    ]
    return page(f"{tuning.model.name}: controller tuned by seatrial", found)


def write_tuning_report(tuning: Tuning, path: str | Path) -> None:
    """Write `tuning_report` to a file atomically."""
    write_text(Path(path), tuning_report(tuning))
