# SPDX-License-Identifier: MIT
"""Where the poses and commands of a session at the poolside come from."""

from seatrial.poolside.sources.opening import open_source
from seatrial.poolside.sources.source import EventKind, EventSource, SourceEvent

__all__ = ["EventKind", "EventSource", "SourceEvent", "open_source"]
