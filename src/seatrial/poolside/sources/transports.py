# SPDX-License-Identifier: MIT
"""Lines that bytes arrive on: a UDP port, a serial line."""

import socket
from typing import Protocol

from seatrial.util.errors import LiveError

WAIT = 0.2  # [s] after which a closed source is noticed
BLOCK = 65536  # [bytes]


class Transport(Protocol):
    """Bytes from a line."""

    def read(self) -> bytes:
        """The next bytes, waiting up to `WAIT`; none: nothing came. Raises OSError."""

    def close(self) -> None:
        """Free it."""


class UdpTransport:
    """Datagrams to a port."""

    def __init__(self, address: str, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((address, port))
        except (OSError, UnicodeError) as error:
            self._socket.close()
            reason = getattr(error, "strerror", None) or error
            raise LiveError(
                f"UDP port {port} of {address}: can't be opened ({reason}); end the program that uses it, or give "
                "another"
            ) from None
        self._socket.settimeout(WAIT)
        self.port = int(self._socket.getsockname()[1])

    def read(self) -> bytes:
        """See `Transport`."""
        try:
            return self._socket.recv(BLOCK)
        except TimeoutError:
            return b""

    def close(self) -> None:
        """See `Transport`."""
        self._socket.close()


class SerialTransport:
    """A serial line."""

    def __init__(self, device: str, baud: int) -> None:
        try:
            import serial
        except ImportError:
            raise LiveError("a serial line needs pyserial: pip install 'seatrial[live]'") from None
        try:
            self._port = serial.Serial(device, baud, timeout=WAIT, exclusive=True)
        except (OSError, ValueError) as error:  # SerialException is an OSError
            raise LiveError(f"{device}: can't be opened ({error})") from None

    def read(self) -> bytes:
        """See `Transport`."""
        first: bytes = self._port.read(1)
        rest: bytes = self._port.read(self._port.in_waiting) if first else b""
        return first + rest

    def close(self) -> None:
        """See `Transport`."""
        self._port.close()
