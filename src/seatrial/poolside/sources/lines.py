# SPDX-License-Identifier: MIT
"""Lines of poses and commands, as `seatrial predict --live` reads them: standard input or UDP."""

from collections.abc import Iterable, Iterator
from time import monotonic, sleep, time_ns

from seatrial.boat.vehicle import Vehicle
from seatrial.onboard.live.endpoints import LOOPBACK, Arrived, Datagrams, Source
from seatrial.onboard.live.protocol import Reader
from seatrial.poolside.sources.source import EVENT_KINDS, EventSource, Mistakes, SourceEvent, usable
from seatrial.util.errors import LiveError, SeatrialError

WAIT = 0.2  # [s] after which a closed source is noticed
GATHER = 0.02  # [s] between two looks: waking for each line costs more than using it


class LineSource(EventSource):
    """Lines of an endpoint; JSON where a line begins with a brace, else CSV.

    No sender is followed: nothing is answered, and no empty datagram ends a session.
    """

    by_columns = False

    def __init__(self, name: str, vehicle: Vehicle, endpoint: Source) -> None:
        super().__init__(name)
        self._endpoint = endpoint
        self._readers = {form: Reader(vehicle, form) for form in ("json", "csv")}
        self._mistakes = Mistakes("lines")

    def __iter__(self) -> Iterator[SourceEvent]:
        """See `EventSource`. Lines that arrived before it was closed are used."""
        while not (self._closed.is_set() or self._endpoint.ended):
            looked = monotonic()
            yield from self._events(self._endpoint.read(WAIT))
            sleep(max(0.0, looked + GATHER - monotonic()))
        yield from self._events(self._endpoint.read(0.0))

    def _events(self, lines: Iterable[str]) -> Iterator[SourceEvent]:
        for line in lines:
            if not line.strip() or line.lstrip().startswith("#"):
                continue
            self._handled = line.at if isinstance(line, Arrived) else None
            if event := self._event(line):
                yield event
        self._handled = None

    def close(self) -> None:
        """See `EventSource`."""
        super().close()
        if isinstance(self._endpoint, Datagrams):
            self._endpoint.close()

    @property
    def problems(self) -> tuple[str, ...]:
        """See `EventSource`."""
        return (str(self._mistakes),) if self._mistakes.bad else ()

    def _event(self, line: str) -> SourceEvent | None:
        """The event of a line; None, and counted, where it can't be used."""
        self._mistakes.total += 1
        arrival = line.at if isinstance(line, Arrived) else time_ns()
        try:
            found = self._readers["json" if line.lstrip().startswith("{") else "csv"](str(line))
            if found.kind not in EVENT_KINDS:
                raise LiveError(
                    f"'{found.kind}' is for a predictor; a session takes poses and commands"
                )
            if not usable(found.values):
                raise LiveError(f"{found.kind}: expected finite numbers; got {line.strip()[:80]}")
        except SeatrialError as error:
            self._mistakes.add(f"line {self._mistakes.total}: {error}")
            return None
        stamp = arrival if found.stamp is None else found.stamp
        return SourceEvent(found.kind, stamp, found.values, arrival, found.covariance)


def datagrams(text: str, vehicle: Vehicle) -> LineSource:
    """Lines of `udp:PORT`, on loopback, or of `udp:ADDRESS:PORT`. Raises LiveError."""
    address, port = address_of(text.removeprefix("udp:"), text)
    return LineSource(text, vehicle, Datagrams(port, address=address))


def address_of(text: str, whole: str) -> tuple[str, int]:
    """Address and port of `PORT` or `ADDRESS:PORT`. Raises LiveError."""
    address, _, port = text.rpartition(":")
    if not (port.isascii() and port.isdecimal() and int(port) < 1 << 16):
        raise LiveError(f"{whole}: expected a port from 1 to 65535, or ADDRESS:PORT, after udp:")
    return address or LOOPBACK, int(port)
