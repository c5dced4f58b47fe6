# SPDX-License-Identifier: MIT
"""Head-to-head comparison of two models as one HTML file."""

from seatrial.report.comparison.comparison_page import write_comparison

__all__ = ["write_comparison"]
