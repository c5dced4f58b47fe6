# SPDX-License-Identifier: MIT
"""The loop of `seatrial mimic`: commands and the carrier's poses in, its velocity out, as lines.

Input lines and clocks as in `seatrial predict --live` (docs/live.md).
"""

from collections.abc import Callable, Iterator

import msgspec
import numpy as np

from seatrial.onboard.live.line_loop import STAMP_LEAP, Settings, Stream
from seatrial.onboard.live.protocol import NANO, Event
from seatrial.simulation.mimic.follow import Mimic
from seatrial.util.errors import LiveError
from seatrial.util.frames import POSE_SIGNS, Axes

_encode = msgspec.json.Encoder().encode


class MimicStream(Stream):
    """Lines to and from a mimic."""

    def __init__(self, mimic: Mimic, settings: Settings, complain: Callable[[str], None]) -> None:
        vehicle = mimic.model.vehicle
        super().__init__(vehicle, settings, complain)
        self.mimic = mimic
        self._flip = POSE_SIGNS if vehicle.axes is Axes.FRD else np.ones(3)
        self._newest = 0  # [ns]

    def use(self, event: Event, now: int) -> Iterator[str]:
        """See `Stream`."""
        if event.kind not in ("pose", "command"):
            raise LiveError(f"expected pose or command; got {event.kind}")
        stamp = self.stamp_of(event, now)
        if not self.system:
            self._refuse_leap(event, stamp)
            self._newest = max(self._newest, stamp)
            yield from self.due(stamp - 1)  # from the inputs before this one
        put = self.mimic.pose if event.kind == "pose" else self.mimic.command
        if not put(stamp / NANO, event.values):
            raise LiveError(
                f"{event.kind} at {stamp / NANO:.6f} s was not used: too old, or not a number"
            )

    def _refuse_leap(self, event: Event, stamp: int) -> None:
        if not self._newest or stamp <= self._newest + STAMP_LEAP:
            return
        self._newest = stamp  # accepted if the next one confirms it
        raise LiveError(f"{event.kind} at {stamp / NANO:.3f} s leaps ahead; left out")

    def line(self, stamp: int) -> str:
        """The carrier's motion."""
        motion, flip = self.mimic.at(stamp / NANO), self._flip
        answer = {
            "t": motion.time,
            "velocity": (motion.velocity * flip).tolist(),
            "asked": (motion.asked * flip).tolist(),
            "boat": [*(motion.pose * flip).tolist(), *(motion.nu * flip).tolist()],
            "mismatch": (motion.mismatch * flip).tolist(),
            "health": motion.health.names,
        }
        return _encode(answer).decode()
