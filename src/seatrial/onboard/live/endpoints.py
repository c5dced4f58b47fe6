# SPDX-License-Identifier: MIT
"""Endpoints of lines: standard input and output, or UDP on loopback."""

import os
import select
import socket
import sys
from typing import BinaryIO, Protocol

from seatrial.util.errors import LiveError

LOOPBACK = "127.0.0.1"
LONGEST_LINE = 65536  # [bytes] of a line, and of a datagram


class Source(Protocol):
    """Lines in and out."""

    ended: bool

    def read(self, wait: float | None) -> list[str]:
        """Complete lines, waiting up to `wait` [s]; None: without a limit."""

    def write(self, line: str) -> None:
        """One line."""


class Pipes:
    """Standard input and output."""

    def __init__(self, inlet: BinaryIO | None = None, outlet: BinaryIO | None = None) -> None:
        self._inlet = (inlet or sys.stdin.buffer).fileno()
        self._outlet = outlet or sys.stdout.buffer
        self._rest = b""
        self.ended = False

    def read(self, wait: float | None) -> list[str]:
        """See `Source`; text longer than `LONGEST_LINE` is split, and its parts are no valid lines."""
        if not select.select([self._inlet], [], [], wait)[0]:
            return []
        block = os.read(self._inlet, LONGEST_LINE)
        self.ended = not block
        *whole, self._rest = (self._rest + block).split(b"\n")
        if self._rest and (self.ended or len(self._rest) > LONGEST_LINE):
            whole.append(self._rest)
            self._rest = b""
        return [line.decode("utf-8", "replace") for line in whole]

    def write(self, line: str) -> None:
        """See `Source`."""
        self._outlet.write(line.encode() + b"\n")
        self._outlet.flush()


class Datagrams:
    """UDP on loopback: answers go to port `to`, or to the last sender."""

    def __init__(self, port: int, to: int | None = None) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((LOOPBACK, port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise LiveError(f"UDP port {port}: can't be opened ({error})") from None
        self.port = int(self._socket.getsockname()[1])
        self._to = None if to is None else (LOOPBACK, to)
        self._fixed = to is not None
        self.ended = False

    def read(self, wait: float | None) -> list[str]:
        """See `Source`; an empty datagram ends it."""
        if not select.select([self._socket], [], [], wait)[0]:
            return []
        try:
            block, sender = self._socket.recvfrom(LONGEST_LINE)
        except ConnectionError:  # an answer was not received
            return []
        if not self._fixed:
            self._to = sender
        self.ended = not block
        return block.decode("utf-8", "replace").splitlines()

    def write(self, line: str) -> None:
        """See `Source`; without a receiver the line is lost."""
        if self._to is not None:
            try:
                self._socket.sendto(line.encode() + b"\n", self._to)
            except OSError:  # no receiver
                return
