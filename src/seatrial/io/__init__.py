# SPDX-License-Identifier: MIT
"""Recordings from files."""

from seatrial.io.read import read

__all__ = ["read"]
