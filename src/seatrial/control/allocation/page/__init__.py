# SPDX-License-Identifier: MIT
"""Schemes of thrust allocation side by side as one HTML file."""

from seatrial.control.allocation.page.allocation_page import write_allocation

__all__ = ["write_allocation"]
