# SPDX-License-Identifier: MIT
"""Bags that a recorder writes now."""
