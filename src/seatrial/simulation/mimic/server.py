# SPDX-License-Identifier: MIT
"""The loop of `seatrial mimic`: commands and the carrier's poses in, its velocity out, as lines.

Input lines and clocks as in `seatrial predict --live` (docs/live.md).
"""

from collections.abc import Callable, Iterator

import msgspec

from seatrial.onboard.live.line_loop import Settings, Stream
from seatrial.onboard.live.protocol import NANO, Event
from seatrial.simulation.mimic.follow import Mimic
from seatrial.util.errors import LiveError

_encode = msgspec.json.Encoder().encode


class MimicStream(Stream):
    """Lines to and from a mimic."""

    def __init__(self, mimic: Mimic, settings: Settings, complain: Callable[[str], None]) -> None:
        vehicle = mimic.model.vehicle
        super().__init__(vehicle, settings, complain)
        self.mimic = mimic
        self._flip = vehicle.axes.signs
        self._newest = 0  # [ns]

    def use(self, event: Event, now: int) -> Iterator[str]:
        """See `Stream`."""
        if event.kind not in ("pose", "command"):
            raise LiveError(f"expected pose or command; got {event.kind}")
        stamp = self.stamp_of(event, now)
        yield from self.around(stamp, lambda: self._put(event, stamp))

    @property
    def newest(self) -> int:
        """See `Stream`."""
        return self._newest

    def _put(self, event: Event, stamp: int) -> None:
        t, newest = stamp / NANO, self.mimic.newest
        put = self.mimic.pose if event.kind == "pose" else self.mimic.command
        used = put(t, event.values)
        if self.mimic.newest == t:  # not so for a stray, or one that is late
            self._newest = stamp
        if not used:
            raise LiveError(
                f"{event.kind} at {t:.6f} s was not used: its stamp is {abs(t - newest):.1f} s "
                f"{'after' if t > newest else 'before'} the newest one, or a number is out of range. "
                "Stamps of a clock that was set are used once several agree"
            )

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
