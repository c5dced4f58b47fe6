# SPDX-License-Identifier: MIT
"""What the nodes send to a live session, and what comes back: without ROS, by scripts of events."""

import json
import os
import socket
import subprocess
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cpp_tools import built
from programs import PROGRAM
from ros_drive import CHANGE
from test_changes import drives, sent
from test_changes import model as driven_model
from test_model import frd
from test_ros_node import EPOCH, joy, model, play
from waiting import PATIENCE, free_port, until

import seatrial
from seatrial.evaluation.comparison.cause_candidates import ONE_THRUSTER
from seatrial.onboard.live import Reader
from seatrial.poolside.sources.lines import datagrams

pytestmark = pytest.mark.system
__all__ = ["driven_model", "drives", "model"]


@pytest.fixture(scope="module")
def program() -> Path:
    return built("script")


@pytest.fixture
def inlet():
    """A port on loopback that hears the node."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        opened.bind(("127.0.0.1", 0))
        opened.settimeout(PATIENCE)
        yield opened


def pose(t: int, x: float, y: float, psi: float) -> str:
    return f"{t} pose {t} map {x!r} {y!r} {psi!r}"


def received(inlet, count):
    return [inlet.recv(65536).decode() for _ in range(count)]


@pytest.mark.parametrize("flip", [False, True])
def test_lines_are_what_the_odometer_takes_in_the_file_s_own_axes(
    program, model, inlet, tmp_path, flip
):
    boat, path = model
    if flip:
        boat = replace(boat, vehicle=frd(boat.vehicle))
        path = tmp_path / "frd.yaml"
        seatrial.save(boat, path)
    events = [joy(EPOCH, 0.1, 0.2, 0.3, 0.4), pose(EPOCH + 7, 0.1, -0.2, 0.3), f"{EPOCH} tick"]
    play(program, events, model=path, live_port=inlet.getsockname()[1])
    command, placed = received(inlet, 2)
    reader = Reader(boat.vehicle, "json")
    assert reader(placed).stamp == EPOCH + 7
    # as Python reads the message: ROS's poses are the file's
    np.testing.assert_array_equal(json.loads(placed)["pose"], [0.1, -0.2, 0.3])
    assert len(reader(command).values) == 3
    assert json.loads(command)["stamp"] == EPOCH
    play(program, events, model=model[1], live_port=inlet.getsockname()[1])
    first, _ = received(inlet, 2)
    np.testing.assert_array_equal(json.loads(first)["command"], json.loads(command)["command"])


def test_a_session_hears_the_node(program, model):
    source = datagrams("udp:0", model[0].vehicle)
    found: list[object] = []
    thread = threading.Thread(target=lambda: found.extend(source))
    thread.start()
    events = [
        line
        for k in range(50)
        for line in (joy(EPOCH + k, 0.1, 0.2, 0.3, 0.4), pose(EPOCH + k, 1.0, 2.0, 0.1))
    ]
    play(program, events, model=model[1], live_port=source._endpoint.port)
    source.close()  # what was sent before is used
    thread.join(PATIENCE)
    assert [e.kind for e in found] == ["command", "pose"] * 50
    assert source.problems == ()


def test_odometry_is_the_same_with_nobody_listening(program, model):
    events = []
    for k in range(200):
        t = EPOCH + k * 20_000_000
        events += [joy(t, 0.1, 0.2, 0.3, 0.4), pose(t, 0.01 * k, 0.0, 0.0), f"{t} tick"]
    quiet = play(program, events, model=model[1])
    lost = play(program, events, model=model[1], live_port=free_port())
    assert [row for row in lost if row[0].isdigit()] == [row for row in quiet if row[0].isdigit()]
    assert any("without a receiver" in " ".join(row) for row in lost)


def answered(program, model, inlet, answers, other=None):
    """The diagnosis of a node to which these come back, from another socket where one is given."""
    node = Node(program, model=model[1], live_port=inlet.getsockname()[1])
    node.give([pose(EPOCH, 1.0, 2.0, 0.1)])
    node.ask(f"{EPOCH} tick")
    _, place = inlet.recvfrom(65536)
    for text in answers:  # on loopback an answer is there when it is sent
        (other or inlet).sendto(text, place)
    for _ in range(4):
        node.ask(f"{EPOCH} tick")
    return [" ".join(line.split()) for line in node.end().splitlines()]


def test_a_change_of_the_boat_is_diagnosed(program, model, inlet):
    line = json.dumps({"t": 1.0, "pose": [0, 0, 0], "change": CHANGE}).encode()
    head, *values = answered(program, model, inlet, [b'{"t": 1}', line])
    assert "boat changed (confirmed): mass" in head
    assert head.startswith("diagnosis 1 ") or head.startswith("diagnosis 2 ")
    assert "change: probability: 0.97" in values
    assert "change: size: 0.2" in values


def test_a_change_that_is_over_is_not_diagnosed(program, model, inlet):
    line = json.dumps({"t": 1.0, "change": CHANGE}).encode()
    found = answered(program, model, inlet, [line, b'{"t": 2, "pose": [0,0,0]}'])
    assert not [text for text in found if "boat changed" in text or "change:" in text]


HOSTILE = [
    b"", b"\0" * 60, b'{"change"', b'"change"', b'{"change": 3}', b'{"change": {"cause": [1], "state": {}}}',
    b'{"change": {"state": "x", "cause": "' + b"a" * 9000 + b'"}}', b'{"change":' + b"[" * 4000,
    b'&a [*a, "change"]', b'{"change": {"state": "\\u0007\\n", "cause": "\xff\xfe"}}',
]  # fmt: skip


@pytest.mark.parametrize("text", HOSTILE)
def test_answers_that_are_none_harm_nothing(program, model, inlet, text):
    found = answered(program, model, inlet, [text])
    assert found[0].startswith("diagnosis")
    assert all(line.isprintable() and len(line) < 700 for line in found)


def test_answers_of_others_are_not_heard(program, model, inlet):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        line = json.dumps({"t": 1.0, "change": CHANGE}).encode()
        assert "boat changed" not in str(answered(program, model, inlet, [line], other))
        assert "boat changed" in str(answered(program, model, inlet, [line]))


@pytest.mark.parametrize(
    ("value", "words"), [(70000, "expected 0 to 65535"), (90.5, "a whole number"), (-1, "0 to")]
)
def test_a_port_that_is_none_is_refused(program, model, value, words):
    with pytest.raises(RuntimeError, match=words):
        play(program, [], model=model[1], live_port=value)


def test_an_adapted_model_is_taken_once_it_is_written_and_odometry_does_not_jump(
    program, model, tmp_path
):
    boat, path = model
    adapted = tmp_path / "adapted.yaml"
    heavier = replace(boat, coefficients=boat.coefficients / 1.2)
    with subprocess.Popen(
        [program, f"model={path}", f"adapted_model={adapted}"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as node:  # fmt: skip
        send = lambda *lines: (node.stdin.write("\n".join(lines) + "\n"), node.stdin.flush())  # noqa: E731
        drive = []
        for k in range(100):
            t = EPOCH + k * 20_000_000
            drive += [joy(t, 0.1, 0.2, 0.3, 0.4), pose(t, 0.002 * k, 0.0, 0.0), f"{t} tick"]
        end = EPOCH + 99 * 20_000_000
        send(*drive, f"{end} adopt", f"{end} tick")
        before = [node.stdout.readline().split() for _ in range(102)]
        assert before[-2] == ["adopt", str(path)]
        seatrial.save(heavier, adapted)
        send(f"{end} adopt", f"{end} tick", f"{end} adopt")
        changed, after, again = (node.stdout.readline().split() for _ in range(3))
        assert changed == ["adopt", str(adapted)]
        assert again == ["adopt", str(adapted)]
        here, there = (
            np.array([float.fromhex(x) for x in row[1:4]]) for row in (before[-1], after)
        )
        np.testing.assert_allclose(here, there, atol=1e-9)
        adapted.write_text("broken")
        os.utime(adapted, ns=(1, EPOCH))
        send(f"{end} adopt", f"{end} adopt")
        wrong, quiet = (node.stdout.readline() for _ in range(2))
        assert "adapted.yaml" in wrong
        assert "expected 'key: value' lines" in wrong
        assert quiet.split() == ["adopt", str(adapted)]
        node.stdin.close()


class Node:
    """The node without ROS, to which events are given one after another."""

    def __init__(self, program, **settings) -> None:
        self.process = subprocess.Popen(
            [program, *(f"{name}={value}" for name, value in settings.items())],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def give(self, events) -> None:
        for event in events:
            self.process.stdin.write(event + "\n")

    def ask(self, event) -> list[str]:
        """The answer to an event that has one."""
        self.give([event])
        self.process.stdin.flush()
        return self.process.stdout.readline().split()

    def end(self) -> str:
        return self.process.communicate(timeout=PATIENCE)[0]


def events_of(rows):
    """The messages of a drive: a joypad's axes and SLAM's poses."""
    for stamp, kind, values in rows:
        if kind == "pose":
            yield pose(stamp, *values.tolist())
        else:
            yield joy(stamp, values[1], values[0], 0.0, values[2])


def test_a_changed_boat_is_found_beside_the_node_and_its_model_taken(
    program, driven_model, drives, tmp_path
):
    """Node, `seatrial predict --live`, diagnostics, adapted model: a thruster at 60 %, on a line of its own."""
    path, adapted = tmp_path / "model.yaml", tmp_path / "adapted.yaml"
    seatrial.save(driven_model, path)
    port = free_port()
    command = [
        "predict",
        path,
        "--live",
        "--udp",
        port,
        "--adapt",
        "ask",
        "--adapted",
        adapted,
        "--rate",
        10,
    ]
    beside = subprocess.Popen(
        [PROGRAM, *map(str, command)], stderr=subprocess.PIPE, text=True
    )  # fmt: skip
    node = Node(program, model=path, live_port=port, adapted_model=adapted)
    rows = [row for row in sent(drives[ONE_THRUSTER]) if np.isfinite(row[2]).all()]
    end = rows[-1][0]
    try:
        until(lambda: listens(port))
        drive(node, [row for row in rows if row[0] < end - 5 * 10**9])
        said = [beside.stderr.readline() for _ in range(2)]
        assert ["noticed" in said[0], "confirmed" in said[1]] == [True, True]
        drive(node, [row for row in rows if row[0] >= end - 5 * 10**9])
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as pilot:
            pilot.sendto(json.dumps({"stamp": end, "adapt": True}).encode(), ("127.0.0.1", port))
        until(adapted.exists)  # all lines before are answered
        for _ in range(60):
            node.ask(f"{end} tick")
        before = node.ask(f"{end} tick")
        assert node.ask(f"{end} adopt") == ["adopt", str(adapted)]
        after = node.ask(f"{end} tick")
        np.testing.assert_allclose(
            *[[float.fromhex(x) for x in row[1:4]] for row in (before, after)], atol=1e-9
        )
        assert before[4:7] != after[4:7]  # the velocity is the changed model's
        text = node.end()
    finally:
        beside.kill()
        beside.communicate()
    assert "boat changed (confirmed): one thruster" in text
    assert "change: what: F_2" in text
    assert f"model: mallard ({adapted})" in text


def drive(node, rows) -> None:
    """Rows at 20 times their pace, with a tick after each pose; at the end the node has sent them all."""
    begin, first = time.monotonic(), rows[0][0]
    for (stamp, kind, _), event in zip(rows, events_of(rows), strict=True):
        if kind == "pose":
            time.sleep(max(0.0, begin + (stamp - first) * 5e-11 - time.monotonic()))
            node.give([event])
            node.ask(f"{stamp} tick")
        else:
            node.give([event])
    node.ask(f"{rows[-1][0]} tick")


def listens(port) -> bool:
    """Whether somebody has this port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        try:
            other.bind(("127.0.0.1", port))
        except OSError:
            return True
        return False
