# SPDX-License-Identifier: MIT
"""The report's sections, one file each."""

from seatrial.report.sections.base import Section
from seatrial.report.sections.order import all_sections

__all__ = ["Section", "all_sections"]
