# SPDX-License-Identifier: MIT
"""The gate before every route and the WebSocket: Host, Origin, token; and the headers of every answer."""

import hmac
import ipaddress
import secrets
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, quote, unquote

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from seatrial.util.errors import LiveError

FEWEST_CHARACTERS = 16  # of a token
POLICY_VIOLATION = 1008  # code of a WebSocket's close, RFC 6455, 7.4.1
# plotly sets styles of its own
POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "content-security-policy": POLICY,
    "referrer-policy": "no-referrer",  # the token may be in the address
    "x-content-type-options": "nosniff",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}


def check_address(address: str, token: str | None) -> None:
    """Raise LiveError where others could reach the page without a token, or by a short one."""
    try:
        alone = ipaddress.ip_address(address).is_loopback
    except ValueError:
        raise LiveError(
            f"--address {address}: expected an IP address of this computer, or 0.0.0.0 for all"
        ) from None
    if not alone and token is None:
        raise LiveError(
            f"--address {address}: other computers can reach the page; give a token, for example "
            f"--token {secrets.token_urlsafe(18)}"
        )
    if token is not None and len(token) < FEWEST_CHARACTERS:
        raise LiveError(
            f"--token has {len(token)} characters; give at least {FEWEST_CHARACTERS}, for example "
            f"{secrets.token_urlsafe(18)}"
        )


@dataclass(frozen=True)
class Gate:
    """An ASGI application behind the gate.

    Refuses a Host that is a name of the internet (DNS rebinding), an Origin other than the page's (cross-site
    requests), and, with a token, whoever does not have it: in the address, in a cookie, or as a bearer's.
    """

    app: ASGIApp
    token: str | None = None
    others: bool = False  # whether other computers may call

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """As ASGI has it."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        refused = self._refusal(scope)
        if refused and scope["type"] == "websocket":
            await WebSocketClose(POLICY_VIOLATION, refused)(scope, receive, send)
        elif refused:
            await PlainTextResponse(refused, 403)(scope, receive, _with_headers(send))
        else:
            await self.app(scope, receive, _with_headers(send, self._cookie(scope)))

    def _refusal(self, scope: Scope) -> str:
        """Why a request is refused; "": it is not."""
        headers = Headers(scope=scope)
        host = headers.get("host", "")
        if not known_host(host, others=self.others):
            return "refused: open the page by the address that seatrial live printed\n"
        if headers.get("origin") not in (None, f"http://{host}"):
            return "refused: the request is of another site\n"
        elsewhere = headers.get("sec-fetch-site", "none") not in ("none", "same-origin")
        if elsewhere and not _opens_page(scope):
            return "refused: the request is of another site\n"
        if self.token is not None and not any(
            hmac.compare_digest(given.encode(), self.token.encode())
            for given in _tokens(scope, headers)
        ):
            return "refused: open the page by the whole address that seatrial live printed, with its token\n"
        return ""

    def _cookie(self, scope: Scope) -> str | None:
        """The cookie that keeps the token, where it was in the page's address."""
        if self.token is None or scope["type"] != "http" or "token" not in _query(scope):
            return None
        return (
            f"{_cookie_name(scope)}={quote(self.token, safe='')}; Path=/; HttpOnly; SameSite=Strict"
        )


def known_host(host: str, *, others: bool) -> bool:
    """Whether a Host header is this computer's: an IP address or a local name, never one of the internet."""
    name = host.rpartition(":")[0] if not host.endswith("]") and ":" in host else host
    own = socket.gethostname().lower()
    if name.lower() == "localhost" or (others and name.lower() in (own, f"{own}.local")):
        return True
    try:
        address = ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return others or address.is_loopback


def _opens_page(scope: Scope) -> bool:
    """Whether a request only opens the page, as a link may from anywhere."""
    return bool(scope["type"] == "http" and scope["method"] == "GET" and scope["path"] == "/")


def _tokens(scope: Scope, headers: Headers) -> list[str]:
    given = _query(scope).get("token", [])
    scheme, _, bearer = headers.get("authorization", "").partition(" ")
    if scheme.lower() == "bearer":
        given.append(bearer)
    cookies: SimpleCookie = SimpleCookie()
    try:
        cookies.load(headers.get("cookie", ""))
    except CookieError:
        return given
    kept = cookies.get(_cookie_name(scope))
    return given if kept is None else [*given, unquote(kept.value)]


def _query(scope: Scope) -> dict[str, list[str]]:
    return parse_qs(scope["query_string"].decode("latin-1"))


def _cookie_name(scope: Scope) -> str:
    """With the port: cookies are of a host, whatever its port."""
    return f"seatrial-{(scope.get('server') or ('', 0))[1]}"


def _with_headers(send: Send, cookie: str | None = None) -> Send:
    """`send` that adds the headers to the beginning of an answer."""
    added: Mapping[str, str] = HEADERS if cookie is None else {**HEADERS, "set-cookie": cookie}

    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in added.items():
                headers.setdefault(name, value)
        await send(message)

    return sending
