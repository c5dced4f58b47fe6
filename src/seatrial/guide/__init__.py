# SPDX-License-Identifier: MIT
"""The guided path: from logs to a validated model and its report, in one call."""

from seatrial.guide.path import Guide, auto

__all__ = ["Guide", "auto"]
