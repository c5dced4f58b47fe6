# SPDX-License-Identifier: MIT
"""MAVLink as it arrives: messages out of blocks of bytes, and the autopilot's clock."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.io.formats.layout import topic_name
from seatrial.io.formats.mavlink import (
    AUTOPILOT,
    LONGEST,
    STAMP,
    STARTS,
    Message,
    frame_at,
    frame_size,
    messages,
    own_stamps,
)

RESTART = 2_000_000_000  # [ns] by which its time falls back where it starts again
Sender = tuple[int, int]  # system, component


@dataclass(frozen=True)
class Heard:
    """A message of one sensor."""

    topic: str
    message: Message
    record: bytes  # eight bytes of nothing, then the payload
    sender: Sender


class FrameStream:
    """Frames out of bytes that arrive in blocks of any size."""

    def __init__(self) -> None:
        self.lost = 0  # [bytes] that are no frame of a known message
        self._known = messages()
        from fastcrc.crc16 import mcrf4xx  # pymavlink brings it

        self._checksum, self._rest = mcrf4xx, b""
        self._autopilot: Sender | None = None

    def feed(self, block: bytes) -> Iterator[Heard]:
        """The messages that these bytes complete."""
        data, at = self._rest + block, 0
        while at < len(data):
            found = frame_at(data, at, len(data), self._known, self._checksum)
            message = None if found is None else self._known.get(found[1])
            if found is not None and message is not None:
                at, _, sender, body, length = found
                payload = data[body : body + min(length, message.payload)]
                yield self._heard(message, sender, payload)
            elif self._may_begin(data, at):
                break
            else:
                self.lost += 1
                at += 1
        self._rest = data[at:]

    @staticmethod
    def _may_begin(data: bytes, at: int) -> bool:
        """Whether a frame may begin here that has not arrived whole."""
        left = len(data) - at
        if data[at] not in STARTS or left >= LONGEST:
            return False
        return left < 12 or left < frame_size(data, at)

    def _heard(self, message: Message, sender: Sender, payload: bytes) -> Heard:
        if self._autopilot is None or (self._autopilot[1] != AUTOPILOT == sender[1]):
            self._autopilot = sender
        record = (bytes(STAMP) + payload).ljust(message.layout.size, b"\0")
        instance = message.layout.instance
        name = topic_name(message.name, 0 if instance is None else record[instance])
        if sender != self._autopilot:
            name += f"@{sender[0]}.{sender[1]}"
        return Heard(name, message, record, sender)


class AutopilotClock:
    """The autopilot's times on the clock of arrival."""

    def __init__(self) -> None:
        self.offset: int | None = None  # [ns] least of arrival minus time since boot
        self._last = 0  # [ns] since boot

    def hear(self, boot: int, arrival: int) -> bool:
        """A time since boot and its arrival [ns]; whether the autopilot has started again."""
        restarted = self.offset is not None and boot < self._last - RESTART
        if restarted:
            self.offset = None
        self._last = boot
        since = arrival - boot
        self.offset = since if self.offset is None else min(self.offset, since)
        return restarted

    def stamp(self, own: float | None, unit: str, arrival: int) -> int:
        """The stamp [ns]: its own time where it is sound, else that of its arrival."""
        if own is None or self.offset is None:
            return arrival
        found = own_stamps(np.array([own]), unit, np.array([arrival]), self.offset)
        return arrival if found is None else int(found[0])
