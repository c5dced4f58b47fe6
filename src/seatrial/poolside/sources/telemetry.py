# SPDX-License-Identifier: MIT
"""MAVLink as it arrives, over UDP or a serial line: the messages that a `.tlog` has, by the same definitions.

It only listens: it sends the autopilot no request. Stamps are the autopilot's own times on this machine's
clock; their offset is that of the least delayed message of the first `SETTLING`.
"""

import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.io.formats.mavlink import TIMES, messages
from seatrial.io.log import Log, LogSamples, Wanted
from seatrial.io.log_signals import LogSignals
from seatrial.io.signals import Request, of_columns
from seatrial.poolside.sources.conversion import Conversion
from seatrial.poolside.sources.lines import address_of
from seatrial.poolside.sources.mavlink_stream import AutopilotClock, FrameStream, Heard
from seatrial.poolside.sources.source import EventSource, Mistakes, SourceEvent
from seatrial.poolside.sources.transports import WAIT, SerialTransport, Transport, UdpTransport
from seatrial.util.errors import LiveError, RecordingError

SETTLING = 1.0  # [s] of messages that give the offset of the autopilot's clock
MOST_WAITING = 1024  # blocks that wait to be handled
BAUD = 115200


@dataclass(frozen=True)
class _Row:
    """A row of one request, before its stamp is known."""

    request: Request
    values: list[float]  # one number a path
    own: float | None  # its own time, in units of `unit`
    unit: str
    arrival: int  # [ns]


class TelemetrySource(EventSource):
    """MAVLink messages of the vehicle file's topics."""

    def __init__(self, name: str, vehicle: Vehicle, transport: Transport) -> None:
        super().__init__(name)
        self._transport = transport
        self._frames, self._clock = FrameStream(), AutopilotClock()
        try:
            self._conversion = Conversion(vehicle, LogSignals(_Definitions()))
            _require(self._conversion.wanted)
        except BaseException:
            transport.close()
            raise
        self._broken = ""
        self._blocks: queue.Queue[tuple[int, bytes]] = queue.Queue(MOST_WAITING)
        self._thread = threading.Thread(target=self._fill, name="telemetry", daemon=True)
        self._heard: set[str] = set()

    def __iter__(self) -> Iterator[SourceEvent]:
        """See `EventSource`."""
        self._thread.start()
        waiting: list[_Row] = []
        settled = 0  # [ns] arrival from which stamps are known; 0: no message yet
        while not (self._blocks.empty() and (self._broken or self._closed.is_set())):
            try:
                arrival, block = self._blocks.get(timeout=WAIT)
            except queue.Empty:
                arrival, block = time.time_ns(), b""
            self._handled = arrival
            for heard in self._frames.feed(block):
                settled = settled or arrival + round(1e9 * SETTLING)
                if self._hear(heard, arrival, settling=arrival < settled):
                    settled = arrival + round(1e9 * SETTLING)
                waiting += self._rows(heard, arrival)
            if settled and arrival >= settled:
                for row in waiting:
                    yield from self._events(row)
                waiting = []
            self._handled = None
        for row in waiting:  # of less than `SETTLING`
            yield from self._events(row)

    def close(self) -> None:
        """See `EventSource`."""
        super().close()
        if self._thread.ident:
            self._thread.join()
        self._transport.close()

    @property
    def problems(self) -> tuple[str, ...]:
        """See `EventSource`."""
        mistakes: Mistakes = self._conversion.mistakes
        wanted = {one.place for one in self._conversion.wanted}
        missing = sorted(wanted - self._heard) if self._heard else []
        found = [
            f"{self._frames.lost} bytes are no known MAVLink message" if self._frames.lost else "",
            f"no message {', '.join(missing)} yet: let the autopilot send it" if missing else "",
            str(mistakes),
            self._broken,
        ]
        return tuple(text for text in found if text)

    def _fill(self) -> None:
        """Read until closed; a thread's."""
        while not self._closed.is_set():
            try:
                block = self._transport.read()
            except OSError as error:
                self._broken = f"{self.name}: can't be read any more ({error})"
                return
            while block and not self._closed.is_set():
                try:
                    self._blocks.put((time.time_ns(), block), timeout=WAIT)
                    block = b""
                except queue.Full:
                    continue

    def _hear(self, heard: Heard, arrival: int, *, settling: bool) -> bool:
        """Set the autopilot's clock; whether it has started again."""
        self._heard.add(heard.topic)
        offset = heard.message.boot
        if offset is None or "@" in heard.topic:
            return False
        boot = int.from_bytes(heard.record[offset : offset + 4], "little") * TIMES["time_boot_ms"]
        if settling or self._clock.offset is None:
            return self._clock.hear(boot, arrival)
        held = self._clock.offset
        restarted = self._clock.hear(boot, arrival)
        if not restarted:
            self._clock.offset = held
        return restarted

    def _rows(self, heard: Heard, arrival: int) -> Iterator[_Row]:
        layout = heard.message.layout
        unit = next((t for t in TIMES if t in layout.fields), "")
        number: Callable[[str], float] = lambda name: float(  # noqa: E731
            layout.fields[name].values(bytearray(heard.record), layout.size)[0]
        )
        for one in self._conversion.wanted:
            if one.place == heard.topic:
                own = number(unit) if unit else None
                yield _Row(one, [number(path) for path in one.paths], own, unit, arrival)

    def _events(self, row: _Row) -> Iterator[SourceEvent]:
        stamp = self._clock.stamp(row.own, row.unit, row.arrival)
        raw = of_columns(np.array([row.values]), row.request.columns)
        return self._conversion.events([(row.request, np.array([stamp]), raw)], row.arrival)


class _Definitions(Log):
    """What MAVLink's messages are, without a log."""

    path = Path("LOG.tlog")  # in the advice to let `seatrial init` write a vehicle file
    files = ()

    def _read(self, wanted: Sequence[Wanted]) -> list[LogSamples]:
        raise NotImplementedError


def _require(wanted: list[Request]) -> None:
    """Raise RecordingError where MAVLink has no such message or field."""
    known = {message.name: message for message in messages().values()}
    for one in wanted:
        name = one.place.partition("@")[0].partition("[")[0]
        if name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise RecordingError(f"{one.wheres[0]}: MAVLink has no message {name}{hint}")
        fields = known[name].layout.fields
        for path in one.paths:
            if path not in fields:
                raise RecordingError(
                    f"{one.wheres[0]}: MAVLink's {name} has no field '{path}'; it has {', '.join(fields)}"
                )


def telemetry(text: str, vehicle: Vehicle) -> TelemetrySource:
    """MAVLink of `mavlink:udp:PORT`, `mavlink:udp:ADDRESS:PORT` or `mavlink:DEVICE:BAUD`. Raises LiveError."""
    place = text.removeprefix("mavlink:")
    if place.startswith("udp:"):
        return TelemetrySource(text, vehicle, UdpTransport(*address_of(place[4:], text)))
    device, _, baud = place.rpartition(":")
    if not device or not (baud.isascii() and baud.isdecimal() and 0 < int(baud) <= 12_000_000):
        raise LiveError(
            f"{text}: expected mavlink:udp:PORT, mavlink:udp:ADDRESS:PORT, or mavlink:DEVICE:BAUD, "
            f"as mavlink:/dev/ttyACM0:{BAUD}"
        )
    return TelemetrySource(text, vehicle, SerialTransport(device, int(baud)))
