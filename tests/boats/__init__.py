# SPDX-License-Identifier: MIT
"""Boats, drives and scenes that tests and benchmarks share."""
