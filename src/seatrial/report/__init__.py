# SPDX-License-Identifier: MIT
"""The report: one self-contained HTML file, without network access."""

from seatrial.report.model_report import report, write_report

__all__ = ["report", "write_report"]
