# SPDX-License-Identifier: MIT
"""The gate of the live page: Host, Origin, token, bodies; and what its routes answer."""

import asyncio
import json
import socket
import sys
import time
from http.client import HTTPConnection

import pytest
from live_states import FakeSession, shown_state
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect
from waiting import PATIENCE

from seatrial.poolside.web.app import LONGEST_DISCARD, MOST_BYTES, MOST_PAGES, make_app
from seatrial.poolside.web.gate import check_address, known_host
from seatrial.poolside.web.server import SWITCH, PageServer, Place, url_of
from seatrial.util.errors import LiveError

TOKEN = "correct-horse-battery"
OWN, JSON = "http://127.0.0.1:8330", {"content-type": "application/json"}
WS, SECRET_WS = "ws://127.0.0.1:8330/ws", "ws://10.0.0.5:8330/ws"
ROUTES = ("/", "/live.js", "/plotly.js", "/api/state", "/api/track", "/report")


@pytest.fixture
def session():
    return FakeSession(shown_state())


@pytest.fixture
def client(session):
    return TestClient(make_app(session, period=0.01), base_url=OWN)


@pytest.fixture
def secret(session):
    """Behind a token, for other computers, too."""
    return TestClient(make_app(session, token=TOKEN, others=True), base_url="http://10.0.0.5:8330")


@pytest.mark.parametrize(
    ("host", "alone", "others"),
    [
        ("127.0.0.1:8330", True, True),
        ("localhost:8330", True, True),
        ("[::1]:8330", True, True),
        ("10.0.0.5:8330", False, True),
        ("10.0.0.5", False, True),
        ("evil.example:8330", False, False),
        ("127.0.0.1.evil.example", False, False),
        ("localhost.evil.example:80", False, False),
        ("", False, False),
    ],
)
def test_a_host_is_an_address_or_a_local_name(host, alone, others):
    assert known_host(host, others=False) is alone
    assert known_host(host, others=True) is others


@pytest.mark.parametrize("route", ROUTES)
def test_a_name_of_the_internet_is_refused_everywhere(client, route):
    """DNS rebinding: the name of an attacker's site, which now points to this computer."""
    assert client.get(route, headers={"host": "evil.example:8330"}).status_code == 403
    assert client.get(route).status_code in (200, 404)


def test_another_site_can_neither_post_nor_listen(client, session):
    for origin in (
        "http://evil.example",
        "null",
        "http://127.0.0.1:9999",
        "https://127.0.0.1:8330",
    ):
        answer = client.post("/api/stop", json={}, headers={"origin": origin})
        assert answer.status_code == 403, origin
        with (
            pytest.raises(WebSocketDisconnect),
            client.websocket_connect(WS, headers={"origin": origin}),
        ):
            pass
    cross = {"sec-fetch-site": "cross-site"}
    assert client.post("/api/stop", json={}, headers=cross).status_code == 403
    assert client.get("/api/state", headers=cross).status_code == 403
    assert client.get("/", headers=cross).status_code == 200  # a link from a message
    assert session.calls == []
    assert client.post("/api/mark", json={}, headers={"origin": OWN}).status_code == 200


@pytest.mark.parametrize("route", ROUTES)
def test_every_route_wants_the_token(secret, route):
    refused = [
        secret.get(route),
        secret.get(route, params={"token": TOKEN[:-1]}),
        secret.get(route, params={"token": ""}),
        secret.get(route, headers={"authorization": "Bearer nonsense"}),
        secret.get(route, headers={"cookie": "seatrial-8330=nonsense"}),
        secret.get(route, headers={"cookie": "\x00;;=,"}),
    ]
    assert {answer.status_code for answer in refused} == {403}
    assert all("set-cookie" not in answer.headers for answer in refused)
    assert secret.get(route, params={"token": TOKEN}).status_code in (200, 404)


def test_buttons_and_the_websocket_want_the_token(secret, session):
    for action in ("mark", "discard", "stop"):
        assert secret.post(f"/api/{action}", json={}).status_code == 403
    with pytest.raises(WebSocketDisconnect), secret.websocket_connect(SECRET_WS):
        pass
    assert session.calls == []
    bearer = {"authorization": f"Bearer {TOKEN}"}
    assert secret.post("/api/mark", json={"text": "a"}, headers=bearer).status_code == 200
    with secret.websocket_connect(SECRET_WS, headers=bearer) as page:
        assert page.receive_json()["state"]["vehicle"] == "model ship"


def test_the_token_of_the_address_becomes_a_cookie_that_other_sites_never_send(secret):
    given = secret.get("/", params={"token": TOKEN}).headers["set-cookie"]
    assert given.startswith(f"seatrial-8330={TOKEN};")
    assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= {part.strip() for part in given.split(";")}
    assert secret.get("/api/state").status_code == 200  # by the cookie
    with secret.websocket_connect(SECRET_WS) as page:
        assert page.receive_json()


def test_every_answer_forbids_what_is_elsewhere(client, secret):
    for answer in (
        client.get("/"),
        client.get("/live.js"),
        client.get("/api/state"),
        secret.get("/"),
    ):
        policy = answer.headers["content-security-policy"]
        assert policy.startswith("default-src 'self'; ")
        assert "http:" not in policy and "*" not in policy and "script-src" not in policy
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["x-content-type-options"] == "nosniff"


@pytest.mark.parametrize(
    ("content", "headers", "status"),
    [
        (b"{}", {}, 415),
        (b"seconds=10", {"content-type": "application/x-www-form-urlencoded"}, 415),
        (b'{"seconds": 10}', {"content-type": "text/plain"}, 415),
        (b"{", JSON, 400),
        (b"\xff\xfe", JSON, 400),
        (b'{"seconds": "ten"}', JSON, 400),
        (b'{"seconds": 10, "more": 1}', JSON, 400),
        (b'{"seconds": -1}', JSON, 400),
        (b'{"seconds": 0}', JSON, 400),
        (b'{"seconds": 1e300}', JSON, 400),
        (b'{"seconds": 10' + b" " * MOST_BYTES + b"}", JSON, 413),
        (b'{"seconds": 3000}', JSON, 409),  # more than the session has
        (b'{"seconds": 10}', {"content-type": "application/json; charset=utf-8"}, 200),
    ],
)
def test_a_body_is_small_json_of_its_kind(client, session, content, headers, status):
    assert LONGEST_DISCARD > 3000
    answer = client.post("/api/discard", content=content, headers=headers)
    assert answer.status_code == status
    assert session.calls == ([("discard", 10.0)] if status == 200 else [])
    assert status == 200 or len(answer.text) > 10  # states what is wrong


def test_buttons_are_not_links(client):
    for action in ("mark", "discard", "stop"):
        assert client.get(f"/api/{action}").status_code == 405
    assert client.get("/live.html").status_code == 404
    assert client.get("/../app.py").status_code == 404


def test_state_and_track_are_json(client, session):
    state = client.get("/api/state").json()
    assert state["vehicle"] == "model ship"
    assert [one["use"] for one in state["uses"]] == ["odometry", "control", "simulation"]
    track = client.get("/api/track", params={"since": 118}).json()
    assert track["next"] == 120
    assert track["rows"] == [pytest.approx(row) for row in session.rows[118:]]
    for wrong in ("-1", "x", "1" * 10, "²"):
        assert client.get("/api/track", params={"since": wrong}).status_code == 400


def test_the_websocket_sends_what_changed(client, session):
    with client.websocket_connect(WS) as page:
        first = page.receive_json()
        assert set(first["state"]) == set(json.loads(client.get("/api/state").text))
        assert len(first["track"]) == 120
        session.set(time=43.0)
        assert page.receive_json() == {"state": {"time": 43.0}, "since": 120}
        session.rows.append((24.0, 1.0, 2.0, 3.0))
        assert page.receive_json() == {"since": 120, "track": [[24.0, 1.0, 2.0, 3.0]]}
        session.discard(10.0)  # the track is sent anew, whatever came after it
        again = page.receive_json()
        assert again["state"] == {"discards": 1}
        assert "since" not in again and len(again["track"]) == 71


def test_a_page_that_falls_behind_gets_the_newest_state_only(client, session):
    with client.websocket_connect(WS) as page:
        page.receive_json()
        for k in range(200):
            session.set(time=100.0 + k)
        assert (
            page.receive_json()["state"]["time"] == 299.0
            or page.receive_json()["state"]["time"] == 299.0
        )


def test_pages_are_limited(client):
    opened = [client.websocket_connect(WS) for _ in range(MOST_PAGES)]
    for one in opened:
        one.__enter__()
        assert one.receive_json()
    with pytest.raises(WebSocketDisconnect), client.websocket_connect(WS):
        pass
    for one in opened:
        one.__exit__(None, None, None)
    with client.websocket_connect(WS) as page:
        assert page.receive_json()


def test_a_page_that_the_server_closed_is_no_error(session):
    """It answered no ping, as one whose computer sleeps: uvicorn then refuses what is sent."""
    sent = []

    async def receive():
        if not sent:
            sent.append("connected")
            return {"type": "websocket.connect"}
        return await asyncio.Event().wait()

    async def send(message):
        sent.append(message["type"])
        if message["type"] == "websocket.send":
            raise RuntimeError("Unexpected ASGI message 'websocket.send'")

    scope = {
        "type": "websocket", "path": "/ws", "raw_path": b"/ws", "query_string": b"", "root_path": "",
        "scheme": "ws", "headers": [(b"host", b"127.0.0.1:8330")], "subprotocols": [],
    }  # fmt: skip
    app = make_app(session, period=0.01)
    asyncio.run(asyncio.wait_for(app(scope, receive, send), PATIENCE))
    assert sent == ["connected", "websocket.accept", "websocket.send"]


def test_the_report_is_served_once_it_is_saved(client, session, tmp_path):
    assert client.get("/report").status_code == 404
    (tmp_path / "report.html").write_text("<p>found</p>")
    session.set(saved=(("report", str(tmp_path / "report.html")),))
    answer = client.get("/report")
    assert answer.text == "<p>found</p>"
    assert answer.headers["content-security-policy"].startswith("default-src 'none'")


@pytest.mark.parametrize(
    ("address", "token", "fault"),
    [
        ("0.0.0.0", None, "give a token"),
        ("10.0.0.5", None, "give a token"),
        ("10.0.0.5", "short", "5 characters"),
        ("127.0.0.1", "short", "5 characters"),
        ("pool.local", TOKEN, "expected an IP address"),
        ("127.0.0.1", None, None),
        ("::1", None, None),
        ("0.0.0.0", TOKEN, None),
    ],
)
def test_another_address_than_loopback_needs_a_token(address, token, fault):
    if fault is None:
        check_address(address, token)
        return
    with pytest.raises(LiveError, match=fault):
        check_address(address, token)


def test_the_server_listens_where_it_says(session):
    with PageServer(Place(port=0)) as server:
        server.serve(session)
        assert server.url == f"http://127.0.0.1:{server.port}/"
        with pytest.raises(LiveError, match="--port"):
            PageServer(Place(port=server.port))
    url = url_of(Place("0.0.0.0", 0, "a secret with spaces"), 8330)
    assert url.endswith(":8330/?token=a%20secret%20with%20spaces")
    assert "0.0.0.0" not in url
    assert url_of(Place("::1"), 1) == "http://[::1]:1/"


def test_the_interpreter_switches_threads_as_before_once_the_server_ends(session):
    before = sys.getswitchinterval()
    with PageServer(Place(port=0)) as server:
        server.serve(session)
        assert sys.getswitchinterval() == pytest.approx(SWITCH)
    assert sys.getswitchinterval() == pytest.approx(before)


def test_connections_that_ask_for_nothing_lose_their_place(session, monkeypatch):
    monkeypatch.setattr("seatrial.poolside.web.server.LONGEST_REQUEST", 0.5)
    with PageServer(Place(port=0)) as server:
        server.serve(session)
        begin = time.monotonic()
        silent = []
        while len(silent) < 80 and time.monotonic() < begin + PATIENCE:
            one = socket.create_connection(("127.0.0.1", server.port))
            one.send(b"GET / HTTP/1.1\r\n")
            silent.append(one)
        end = time.monotonic() + PATIENCE
        status = 503
        while status == 503 and time.monotonic() < end:
            time.sleep(0.1)
            asked = HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
            asked.request("GET", "/api/state")
            status = asked.getresponse().status
            asked.close()
        for one in silent:
            one.close()
    assert status == 200
