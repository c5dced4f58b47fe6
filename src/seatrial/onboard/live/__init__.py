# SPDX-License-Identifier: MIT
"""The predictor for any program: lines of poses and commands in, lines of odometry out."""

from seatrial.live.lines import FORMATS, Event, Reader, Writer
from seatrial.live.loop import serve
from seatrial.live.replay import replay
from seatrial.live.stream import Settings

__all__ = ["FORMATS", "Event", "Reader", "Settings", "Writer", "replay", "serve"]
