# SPDX-License-Identifier: MIT
"""Gains by internal model control, their margins and their robustness."""
