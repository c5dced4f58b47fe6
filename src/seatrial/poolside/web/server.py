# SPDX-License-Identifier: MIT
"""The page's server in a thread of its own."""

import socket
import threading
from dataclasses import dataclass
from ipaddress import ip_address
from urllib.parse import quote

import uvicorn

from seatrial.poolside.state import Controller
from seatrial.poolside.web.app import make_app
from seatrial.poolside.web.gate import check_address
from seatrial.util.errors import LiveError

LOOPBACK, PORT = "127.0.0.1", 8330
WAITING = 8  # connections that wait to be accepted
MOST_CONNECTIONS = 64  # at the same time
LONGEST_END = 5.0  # [s]
LONGEST_MESSAGE = 1024  # [bytes] from a page: it sends none


@dataclass(frozen=True)
class Place:
    """Where the page is served."""

    address: str = LOOPBACK
    port: int = PORT  # 0: any free one
    token: str | None = None


class PageServer:
    """A context manager: serves while it is open. Raises LiveError where the port can't be opened."""

    def __init__(self, controller: Controller, place: Place) -> None:
        check_address(place.address, place.token)
        self.place, self.port = place, place.port
        others = not ip_address(place.address).is_loopback
        config = uvicorn.Config(
            make_app(controller, token=place.token, others=others),
            ws="websockets-sansio", ws_max_size=LONGEST_MESSAGE, ws_per_message_deflate=False,
            limit_concurrency=MOST_CONNECTIONS, log_level="error", access_log=False, lifespan="off",
            timeout_graceful_shutdown=1, server_header=False,
        )  # fmt: skip
        self._server = uvicorn.Server(config)
        self._thread: threading.Thread | None = None

    @property
    def url(self) -> str:
        """The page's whole address, with the token."""
        return url_of(self.place, self.port)

    def __enter__(self) -> "PageServer":
        found = _listening(self.place)
        self.port = int(found.getsockname()[1])
        self._thread = threading.Thread(
            target=self._server.run, args=([found],), name="page", daemon=True
        )
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.should_exit = True
        if self._thread is not None:
            self._thread.join(timeout=LONGEST_END)


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
