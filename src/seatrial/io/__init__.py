# SPDX-License-Identifier: MIT
"""Recordings from files."""

from seatrial.io.reader import read

__all__ = ["read"]
