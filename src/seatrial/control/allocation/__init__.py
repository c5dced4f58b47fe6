# SPDX-License-Identifier: MIT
"""Thrust allocation for any geometry, and what each scheme costs a boat."""

from seatrial.control.allocation.allocator import PRIORITY, Allocator, AllocatorScheme
from seatrial.control.allocation.boat import load_boat
from seatrial.control.allocation.console import allocation_json, allocation_text, wrench_text
from seatrial.control.allocation.schemes import AllocationComparison, compare_schemes
from seatrial.control.allocation.thruster_effectiveness import Effectiveness, effectiveness

__all__ = [
    "PRIORITY", "AllocationComparison", "Allocator", "AllocatorScheme", "Effectiveness", "allocation_json",
    "allocation_text", "compare_schemes", "effectiveness", "load_boat", "wrench_text",
]  # fmt: skip
