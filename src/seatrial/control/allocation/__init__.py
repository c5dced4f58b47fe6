# SPDX-License-Identifier: MIT
"""Thrust allocation for any geometry, and what each scheme costs a boat."""

from seatrial.allocate.allocator import PRIORITY, Allocator, AllocatorScheme
from seatrial.allocate.boat import load_boat
from seatrial.allocate.comparison import AllocationComparison, compare_schemes
from seatrial.allocate.effectiveness import Effectiveness, effectiveness
from seatrial.allocate.text import allocation_json, allocation_text, wrench_text

__all__ = [
    "PRIORITY",
    "AllocationComparison",
    "Allocator",
    "AllocatorScheme",
    "Effectiveness",
    "allocation_json",
    "allocation_text",
    "compare_schemes",
    "effectiveness",
    "load_boat",
    "wrench_text",
]
