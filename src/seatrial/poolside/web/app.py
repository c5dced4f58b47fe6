# SPDX-License-Identifier: MIT
"""The routes of the page: its files, the state, the buttons, and a WebSocket with what changes."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from importlib import resources
from pathlib import Path
from typing import TypeVar

import msgspec
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from seatrial.poolside.state import Controller
from seatrial.poolside.web.changes import Changes, encode
from seatrial.poolside.web.gate import Gate
from seatrial.report.html import POLICY as REPORT_POLICY
from seatrial.util.errors import SeatrialError

PERIOD = 0.1  # [s] between two messages to a page
BEAT = 2.0  # [s] after which an empty message shows a page that the connection is there
MOST_BYTES = 4096  # of a request's body
MOST_PAGES = 8  # that are open at the same time
LONGEST_MARK = 200  # [characters]
LONGEST_DISCARD = 3600.0  # [s]
OWN, REPORT = "seatrial.poolside.web", "seatrial.report"
FILES = {  # address: package, file, type
    "/": (OWN, "live.html", "text/html"),
    "/live.css": (OWN, "live.css", "text/css"),
    "/report.css": (REPORT, "report.css", "text/css"),
    "/plotly.js": (REPORT, "plotly-basic.min.js", "text/javascript"),
    "/live.js": (OWN, "live.js", "text/javascript"),
    "/pool.js": (OWN, "pool.js", "text/javascript"),
    "/plots.js": (OWN, "plots.js", "text/javascript"),
    "/tables.js": (OWN, "tables.js", "text/javascript"),
    "/icon.svg": (OWN, "icon.svg", "image/svg+xml"),
}
T = TypeVar("T", bound=msgspec.Struct)


class Mark(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Body of POST /api/mark."""

    text: str = ""


class Discard(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Body of POST /api/discard."""

    seconds: float


class RefusedError(Exception):
    """A request that is answered with an error."""

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status, self.reason = status, reason


def make_app(
    controller: Controller,
    *,
    token: str | None = None,
    others: bool = False,
    period: float = PERIOD,
) -> ASGIApp:
    """The ASGI application of a session. `others`: other computers may call; `period` [s] of messages."""
    api = _Api(controller, period)
    routes = [
        *(Route(address, _file(*found)) for address, found in FILES.items()),
        Route("/api/state", api.state),
        Route("/api/track", api.track),
        Route("/api/mark", api.mark, methods=["POST"]),
        Route("/api/discard", api.discard, methods=["POST"]),
        Route("/api/stop", api.stop, methods=["POST"]),
        Route("/report", api.report),
        WebSocketRoute("/ws", api.stream),
    ]
    return Gate(Starlette(routes=routes), token, others)


def _file(package: str, name: str, kind: str) -> Callable[[Request], Response]:
    content = (resources.files(package) / "assets" / name).read_bytes()

    def answer(_: Request) -> Response:
        return Response(content, media_type=kind)

    return answer


class _Api:
    """What the routes do."""

    def __init__(self, controller: Controller, period: float) -> None:
        self.controller, self.period = controller, period
        self.pages = 0  # that are open

    async def state(self, _: Request) -> Response:
        return _json(self.controller.state())

    async def track(self, request: Request) -> Response:
        text = request.query_params.get("since", "0")
        if not text.isdecimal() or len(text) > 9:
            return PlainTextResponse("since: expected a whole number\n", 400)
        following, rows = self.controller.track(int(text))
        return _json({"next": following, "rows": rows})

    async def mark(self, request: Request) -> Response:
        def act(body: Mark) -> dict[str, str]:
            self.controller.mark(body.text[:LONGEST_MARK])
            return {}

        return await _answered(request, Mark, act)

    async def discard(self, request: Request) -> Response:
        def act(body: Discard) -> dict[str, str]:
            if not 0.0 < body.seconds <= LONGEST_DISCARD:
                raise RefusedError(400, f"seconds: expected more than 0, up to {LONGEST_DISCARD:g}")
            self.controller.discard(body.seconds)
            return {}

        return await _answered(request, Discard, act)

    async def stop(self, request: Request) -> Response:
        return await _answered(request, Nothing, lambda _: self.controller.stop())

    async def report(self, _: Request) -> Response:
        path = dict(self.controller.state().saved).get("report")
        if path is None or not Path(path).is_file():
            return PlainTextResponse("no report yet: stop and save first\n", 404)
        return FileResponse(path, headers={"content-security-policy": REPORT_POLICY})

    async def stream(self, page: WebSocket) -> None:
        """Send what changed, as often as the page takes it; what it sends is not read."""
        if self.pages >= MOST_PAGES:
            await page.close(1013, f"more than {MOST_PAGES} pages are open")
            return
        await page.accept()
        async with self._counted():
            leaving = asyncio.ensure_future(_until_left(page))
            try:
                await self._send_changes(page, leaving)
            finally:
                leaving.cancel()

    @contextlib.asynccontextmanager
    async def _counted(self) -> AsyncIterator[None]:
        self.pages += 1
        try:
            yield
        finally:
            self.pages -= 1

    async def _send_changes(self, page: WebSocket, leaving: "asyncio.Future[None]") -> None:
        """A page that falls behind waits in `send`, and then gets the newest state."""
        changes, silent = Changes(self.controller), 0.0  # [s]
        while not leaving.done():
            message = changes.take()
            if message is None and silent >= BEAT:
                message = "{}"
            if message is not None and not await _sent(page, message):
                return
            silent = silent + self.period if message is None else 0.0
            await asyncio.wait([leaving], timeout=self.period)


class Nothing(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Body of POST /api/stop: {}."""


async def _sent(page: WebSocket, message: str) -> bool:
    """Whether the page is still there: it left, or the server closed it, as it answered no ping (RuntimeError)."""
    try:
        await page.send_text(message)
    except (WebSocketDisconnect, RuntimeError):
        return False
    return True


async def _until_left(page: WebSocket) -> None:
    while (await page.receive())["type"] != "websocket.disconnect":
        pass


async def _answered(request: Request, kind: type[T], act: Callable[[T], object]) -> Response:
    """The answer of an action to a request's body."""
    try:
        body = await _body(request, kind)
        return _json(await run_in_threadpool(act, body))
    except RefusedError as refused:
        return PlainTextResponse(f"{refused.reason}\n", refused.status)
    except SeatrialError as error:
        return PlainTextResponse(f"{error}\n", 409)
    except asyncio.CancelledError:  # Ctrl-C: the server would print a fault
        return PlainTextResponse("the session is over\n", 503)


async def _body(request: Request, kind: type[T]) -> T:
    """A JSON body; a form of another site can't send that type. Raises RefusedError."""
    if request.headers.get("content-type", "").partition(";")[0].strip() != "application/json":
        raise RefusedError(415, "expected the content type application/json")
    found = b""
    async for block in request.stream():
        found += block
        if len(found) > MOST_BYTES:
            raise RefusedError(413, f"expected a body of up to {MOST_BYTES} bytes")
    try:
        return msgspec.json.decode(found, type=kind)
    except (msgspec.DecodeError, UnicodeError) as error:
        raise RefusedError(400, str(error)) from None


def _json(content: object) -> Response:
    return Response(encode(content), media_type="application/json")
