# SPDX-License-Identifier: MIT
"""The page's server in a thread of its own."""

import asyncio
import socket
import sys
import threading
from dataclasses import dataclass
from ipaddress import ip_address
from urllib.parse import quote

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from seatrial.poolside.state import Controller
from seatrial.poolside.web.app import make_app
from seatrial.poolside.web.gate import check_address
from seatrial.util.errors import LiveError

LOOPBACK, PORT = "127.0.0.1", 8330
WAITING = 8  # connections that wait to be accepted
MOST_CONNECTIONS = 64  # at the same time
SWITCH = 0.0005  # [s]
LONGEST_END = 5.0  # [s]
LONGEST_REQUEST = 5.0  # [s] in which a connection sends its first request
LONGEST_MESSAGE = 1024  # [bytes] from a page: it sends none


@dataclass(frozen=True)
class Place:
    """Where the page is served."""

    address: str = LOOPBACK
    port: int = PORT  # 0: any free one
    token: str | None = None


class Prompt(H11Protocol):
    """HTTP that closes a connection which sends no whole request in time: such ones would fill all places."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """As of `asyncio.Protocol`."""
        super().connection_made(transport)
        self.loop.call_later(LONGEST_REQUEST, self._close_silent)

    def _close_silent(self) -> None:
        if getattr(self, "scope", None) is None:
            self.transport.close()


class PageServer:
    """A context manager that opens the port, and closes it. Raises LiveError where it can't be opened."""

    def __init__(self, place: Place) -> None:
        check_address(place.address, place.token)
        self.place = place
        self._socket = _listening(place)
        self.port = int(self._socket.getsockname()[1])
        self._server: uvicorn.Server | None = None
        self._thread: threading.Thread | None = None
        self._switch = sys.getswitchinterval()  # [s] of the process, before

    def serve(self, controller: Controller) -> None:
        """Answer from now on, in a thread."""
        # by default a thread that computes keeps the interpreter for 5 ms each time that this one wants it
        sys.setswitchinterval(SWITCH)
        others = not ip_address(self.place.address).is_loopback
        config = uvicorn.Config(
            make_app(controller, token=self.place.token, others=others),
            http=Prompt, ws="websockets-sansio", ws_max_size=LONGEST_MESSAGE, ws_per_message_deflate=False,
            limit_concurrency=MOST_CONNECTIONS, log_level="error", access_log=False, lifespan="off",
            timeout_graceful_shutdown=1, server_header=False,
        )  # fmt: skip
        self._server = uvicorn.Server(config)
        self._thread = threading.Thread(
            target=self._server.run, args=([self._socket],), name="page", daemon=True
        )
        self._thread.start()

    @property
    def url(self) -> str:
        """The page's whole address, with the token."""
        return url_of(self.place, self.port)

    @property
    def connected(self) -> bool:
        """Whether a browser shows the page, or loads something."""
        return self._server is not None and bool(self._server.server_state.connections)

    def __enter__(self) -> "PageServer":
        return self

    def __exit__(self, *_: object) -> None:
        if self._server is not None and self._thread is not None:
            self._server.should_exit = True
            self._thread.join(timeout=LONGEST_END)
        sys.setswitchinterval(self._switch)
        self._socket.close()


def url_of(place: Place, port: int) -> str:
    """The whole address of a page, with the token."""
    host = _own_address() if ip_address(place.address).is_unspecified else place.address
    host = f"[{host}]" if ":" in host else host
    token = "" if place.token is None else f"?token={quote(place.token, safe='')}"
    return f"http://{host}:{port}/{token}"


def _listening(place: Place) -> socket.socket:
    family = socket.AF_INET6 if ":" in place.address else socket.AF_INET
    found = socket.socket(family, socket.SOCK_STREAM)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind((place.address, place.port))
        found.listen(WAITING)
    except (OSError, OverflowError) as error:
        found.close()
        reason = getattr(error, "strerror", None) or error
        raise LiveError(
            f"port {place.port} of {place.address}: can't be opened ({reason}); give another one with --port"
        ) from None
    return found


def _own_address() -> str:
    """The address by which others reach this computer: of the way to the next router. Nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # reserved for documentation, RFC 5737
            return str(probe.getsockname()[0])
        except OSError:
            return socket.gethostname()
