# SPDX-License-Identifier: MIT
"""A tuning as one HTML file: gains, margins, step responses and Bode plots."""

from seatrial.control.tuning.page.tuning_page import tuning_report

__all__ = ["tuning_report"]
