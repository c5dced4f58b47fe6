# SPDX-License-Identifier: MIT
"""Recordings from files."""

from seatrial.io.reader import read, read_each

__all__ = ["read", "read_each"]
