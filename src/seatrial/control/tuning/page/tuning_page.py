# SPDX-License-Identifier: MIT
"""A tuning as one HTML file: gains, margins, step responses and Bode plots."""

from seatrial.control import Tuning
from seatrial.control.tuning.page.sections import bode, gains, provenance, safety, steps
from seatrial.control.tuning.responses import responses
from seatrial.report.html import page


def tuning_report(tuning: Tuning) -> str:
    """The page as HTML text; the same tuning gives the same text."""
    curves = responses(tuning)
    found = [
        gains(tuning), safety(tuning), steps(tuning, curves), bode(tuning, curves), provenance(tuning),
    ]  # fmt: skip
    return page(f"{tuning.model.name}: controller tuned by seatrial", found)
