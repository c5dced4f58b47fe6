# SPDX-License-Identifier: MIT
"""Endpoints of lines: standard input and output, or UDP on loopback.

A thread reads, so that lines have the time at which they arrived, whatever keeps the program from handling them.
"""

import os
import select
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterable
from typing import BinaryIO, Protocol

from seatrial.util.errors import LiveError

LOOPBACK = "127.0.0.1"
LONGEST_LINE = 65536  # [bytes] of a line, and of a datagram
MOST_WAITING = 1 << 24  # [bytes] that wait to be handled: minutes of a fast sender
CLOSING = 0.1  # [s] after which a closed port is free
MOST_BUFFERED = 4096  # datagrams that are read after it is closed: the system holds fewer
Address = tuple[str, int]


class Arrived(str):
    """A line, and when it arrived."""

    __slots__ = ("at", "sender")
    at: int  # [ns] by the system's clock
    sender: Address | None  # of a datagram

    @classmethod
    def of(cls, text: str, sender: Address | None = None) -> "Arrived":
        """A line that arrives now."""
        line = cls(text)
        line.at, line.sender = time.time_ns(), sender
        return line


class Source(Protocol):
    """Lines in and out."""

    ended: bool

    def read(self, wait: float | None) -> list[str]:
        """Complete lines, waiting up to `wait` [s]; None: without a limit."""

    def follow(self, line: str) -> None:
        """`line` is one of ours: answers belong to its sender."""

    def write(self, line: str) -> None:
        """One line."""


class Inbox:
    """Lines that a thread puts and another one takes."""

    def __init__(self, fill: Callable[["Inbox"], None]) -> None:
        self._thread = threading.Thread(target=self._run, args=(fill,), name="input", daemon=True)
        self._changed = threading.Condition()
        self._lines: list[Arrived] = []
        self._size = 0  # [bytes]
        self._over = self._closing = False

    def put(self, lines: Iterable[Arrived]) -> None:
        """Add lines; waits while there are too many."""
        with self._changed:
            self._changed.wait_for(lambda: self._size < MOST_WAITING or self._closing)
            for line in lines:
                self._lines.append(line)
                self._size += len(line) + 1
            self._changed.notify_all()

    def take(self, wait: float | None) -> tuple[list[Arrived], bool]:
        """All lines, and whether they were the last."""
        if not self._thread.ident:
            self._thread.start()
        with self._changed:
            self._changed.wait_for(lambda: self._lines or self._over, wait)
            lines, self._lines, self._size = self._lines, [], 0
            self._changed.notify_all()
            return lines, self._over

    def join(self) -> None:
        """Wait for the end of the thread that fills it; lines that wait can still be taken."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()
        if self._thread.ident:
            self._thread.join()

    def _run(self, fill: Callable[["Inbox"], None]) -> None:
        try:
            fill(self)
        finally:
            with self._changed:
                self._over = True
                self._changed.notify_all()


class Pipes:
    """Standard input and output."""

    def __init__(self, inlet: BinaryIO | None = None, outlet: BinaryIO | None = None) -> None:
        self._inlet = (inlet or _open(sys.stdin, "input")).fileno()
        self._outlet = outlet or _open(sys.stdout, "output")
        self._inbox = Inbox(self._fill)
        self.ended = False

    def read(self, wait: float | None) -> list[str]:
        """See `Source`; text longer than `LONGEST_LINE` is split, and its parts are no valid lines."""
        lines, self.ended = self._inbox.take(wait)
        return [*lines]

    def _fill(self, inbox: Inbox) -> None:
        rest = b""
        while block := _read(self._inlet):
            *whole, rest = (rest + block).split(b"\n")
            if len(rest) > LONGEST_LINE:
                whole.append(rest)
                rest = b""
            inbox.put(Arrived.of(line.decode("utf-8", "replace")) for line in whole)
        inbox.put([Arrived.of(rest.decode("utf-8", "replace"))] if rest else [])

    def follow(self, line: str) -> None:
        """See `Source`; there is one reader only."""

    def write(self, line: str) -> None:
        """See `Source`. Raises LiveError where there is no room, BrokenPipeError without a reader."""
        try:
            self._outlet.write(line.encode() + b"\n")
            self._outlet.flush()
        except BrokenPipeError:
            raise
        except OSError as error:
            raise LiveError(f"standard output can't be written ({error.strerror})") from None


class Datagrams:
    """UDP, on loopback unless told: answers go to port `to`, or to the last sender of a valid line."""

    def __init__(self, port: int, to: int | None = None, *, address: str = LOOPBACK) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((address, port))
        except (OSError, OverflowError, UnicodeError) as error:
            self._socket.close()
            place = "" if address == LOOPBACK else f" of {address}"
            reason = getattr(error, "strerror", None) or error
            raise LiveError(
                f"UDP port {port}{place}: can't be opened ({reason}); end the program that uses it, or give "
                "another"
            ) from None
        self.port = int(self._socket.getsockname()[1])
        self._to = None if to is None else (LOOPBACK, to)
        self._peer: Address | None = None  # sender of the last valid line
        self._leaving: set[Address | None] = set()  # senders of empty datagrams
        self._closed = False
        self._inbox = Inbox(self._fill)
        self.ended = False

    def read(self, wait: float | None) -> list[str]:
        """See `Source`; an empty datagram of the last sender of a valid line ends it."""
        if self._peer is not None and self._peer in self._leaving:
            self.ended = True
            return []
        lines, self.ended = self._inbox.take(wait)
        self._leaving = {line.sender for line in lines if not line}
        return [line for line in lines if line]

    def close(self) -> None:
        """End the reading within `CLOSING`, and free the port."""
        self._closed = True
        self._inbox.join()
        self._socket.close()

    def _fill(self, inbox: Inbox) -> None:
        left = MOST_BUFFERED
        self._socket.settimeout(CLOSING)
        while left:
            closed = self._closed  # before the look: what had arrived then is read
            if closed:
                left -= 1
                self._socket.settimeout(0.0)
            try:
                block, sender = self._socket.recvfrom(LONGEST_LINE)
            except (TimeoutError, BlockingIOError):
                if closed:
                    return
                continue
            except ConnectionError:  # an answer was not received
                continue
            # blank lines are dropped: an empty text is a sender that leaves
            texts = filter(None, block.decode("utf-8", "replace").splitlines()) if block else [""]
            inbox.put([Arrived.of(text, sender) for text in texts])

    def follow(self, line: str) -> None:
        """See `Source`."""
        self._peer = line.sender if isinstance(line, Arrived) else None

    def write(self, line: str) -> None:
        """See `Source`; without a receiver the line is lost."""
        to = self._to or self._peer
        if to is not None:
            try:
                self._socket.sendto(line.encode() + b"\n", to)
            except OSError:  # no receiver
                return


def _open(stream: object, name: str) -> BinaryIO:
    """The bytes of a standard stream. Raises LiveError where it is closed."""
    found: BinaryIO | None = getattr(stream, "buffer", None)
    if found is None or found.closed:
        raise LiveError(f"standard {name} is closed; open it, or use --udp PORT")
    return found


def _read(inlet: int) -> bytes:
    """The next bytes; none at the end, or where it can't be read."""
    while True:
        try:
            return os.read(inlet, LONGEST_LINE)
        except BlockingIOError:  # one that does not block
            select.select([inlet], [], [])
        except OSError:
            return b""
