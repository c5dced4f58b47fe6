# SPDX-License-Identifier: MIT
"""A session at the poolside: its threads, its parts, and what it saves."""

from seatrial.poolside.session.assembly import Wishes, make_session
from seatrial.poolside.session.live_session import RECORDING, Session

__all__ = ["RECORDING", "Session", "Wishes", "make_session"]
