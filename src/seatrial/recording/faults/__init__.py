# SPDX-License-Identifier: MIT
"""Faults of poses: gaps, jumps, outliers, frozen poses."""
