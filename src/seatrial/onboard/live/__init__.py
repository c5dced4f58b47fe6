# SPDX-License-Identifier: MIT
"""The predictor for any program: lines of poses and commands in, lines of odometry out."""

from seatrial.onboard.live.line_loop import Settings
from seatrial.onboard.live.playback import replay
from seatrial.onboard.live.protocol import LINE_FORMATS, Event, Reader, Writer
from seatrial.onboard.live.server import Adaptation, serve

__all__ = ["LINE_FORMATS", "Adaptation", "Event", "Reader", "Settings", "Writer", "replay", "serve"]
