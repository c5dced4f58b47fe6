# SPDX-License-Identifier: MIT
"""What ends a program of lines, and what does not: blank lines, absurd commands, a clock that is set back."""

import json
import os
import socket
import threading
import time
from pathlib import Path

import export_names
import numpy as np
import pytest
from given_lines import Given
from waiting import PATIENCE, until

import seatrial
from seatrial.commands.cli import main
from seatrial.onboard.live import Adaptation, Settings, serve
from seatrial.onboard.live.endpoints import Arrived, Datagrams, Pipes
from seatrial.onboard.live.server import Live
from seatrial.simulation.server import SimSettings, SimStream
from seatrial.util.errors import SimulatorError
from seatrial.util.progress import over

NANO = 1_000_000_000


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("live") / "model.yaml"
    seatrial.save(export_names.plain_boat(), path)
    return path


def test_blank_lines_in_a_datagram_are_nothing():
    """Before, one ended the server, as an empty datagram does."""
    source, found = Datagrams(0), []

    def read(count: int) -> list[str]:
        def enough():
            found.extend(source.read(0.05))
            return len(found) >= count or source.ended

        until(enough)
        return [*map(str, found)]

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as own:
        own.connect(("127.0.0.1", source.port))
        own.send(b"first")
        assert read(1) == ["first"]
        source.follow(found[0])
        for block in (b"\na\n\n\r\nb\n\n", b"\n", b"last"):
            own.send(block)
        assert read(4) == ["first", "a", "b", "last"]
        assert not source.ended
        own.send(b"")
        assert read(5) == ["first", "a", "b", "last"]
        assert source.ended
    source.close()


def test_a_standard_input_that_does_not_block_is_waited_for():
    """As some programs hand it over. Before, a moment without lines was taken for its end."""
    fed, feeder = os.pipe()
    os.set_blocking(fed, False)
    with os.fdopen(fed, "rb") as inlet, Path(os.devnull).open("wb") as out:
        source = Pipes(inlet, out)
        assert source.read(0.05) == []
        assert not source.ended
        os.write(feeder, b"line\n")
        assert [*map(str, source.read(PATIENCE))] == ["line"]
        os.close(feeder)
        assert source.read(PATIENCE) == []
        assert source.ended


@pytest.mark.parametrize("odd", ["1e4", "-1e300", "1e999"])
def test_an_absurd_command_does_not_end_the_simulator(path, odd):
    """Before, the boat diverged, and the program with it."""
    said: list[str] = []
    world = seatrial.World()
    boat = world.add(path)
    stream = SimStream(world, SimSettings(speed=0.0, kinds=("truth",)), said.append)
    given = [
        '{"t": 0, "command": [0.5, 0, 0]}',
        f'{{"t": 1, "command": [{odd}, 0, 0]}}',
        '{"at": 2}',
    ]
    rows = [json.loads(line) for text in given for line in stream.take(text)]
    assert rows[-1]["t"] == 2.0
    assert len(said) == 1
    assert "line 2: " in said[0]
    still = seatrial.Simulator(path)
    still.command([0.5, 0.0, 0.0])
    still.advance_to(2.0)
    np.testing.assert_allclose(rows[-1]["truth"], [*still.eta, *still.nu], atol=1e-9)
    with pytest.raises(SimulatorError, match="expected numbers from -1000 to 1000"):
        boat.command([0.0, float(odd), 0.0])


def test_an_absurd_command_does_not_end_the_mimic(path, capsys, monkeypatch):
    given = [
        '{"t": 0, "command": [0.5, 0, 0]}',
        '{"t": 1, "command": [1e300, 0, 0]}',
        '{"t": 2, "command": [0, 0, 0]}',
    ]
    source = Given(given, json.loads)
    monkeypatch.setattr("seatrial.onboard.live.endpoints.Pipes", lambda: source)
    assert main(["mimic", str(path)]) == 0
    assert "line 2: command at 1.000000 s was not used" in capsys.readouterr().err
    assert source.answers[-1]["health"] == ["NO_POSE"]
    assert source.answers[-1]["velocity"][0] > 0.01


@pytest.mark.parametrize("back", [2.0, 30.0, 3600.0])
def test_stamps_that_are_set_back_do_not_silence_the_odometry(path, back):
    """By the data's clock: before, nothing came until the stamps were where they had been."""
    rows = [(0.1 * k - (back if k >= 50 else 0.0), 0.01 * k) for k in range(100)]
    source = Given([json.dumps({"t": t, "pose": [x, 0, 0]}) for t, x in rows], json.loads)
    serve(path, source, Settings("json", 10.0), lambda _: None)
    late = [row for row in source.answers if row["map"][0] > 0.595]  # after ten poses that agree
    times = np.array([row["t"] for row in late]) + back
    np.testing.assert_allclose(times, np.arange(60, 60 + len(late)) / 10.0, atol=0.11)
    assert len(late) >= 37
    assert late[-1]["velocity"][0] == pytest.approx(0.1, abs=0.02)


class SlowTest:
    """A test for a change of the boat that takes until it is let go."""

    def __init__(self) -> None:
        self.due, self.begun, self.go = True, threading.Event(), threading.Event()

    def use(self, kind, stamp, values):
        pass

    def look(self):
        self.due = False
        self.thread = threading.current_thread()
        self.begun.set()
        assert self.go.wait(PATIENCE)

    def restart(self, model):
        pass


def test_the_thread_of_the_test_for_a_change_ends_with_the_server(path):
    """The server does not wait for a test that runs. Before, the thread stayed."""
    test = SlowTest()
    line = Arrived.of('{"pose": [0, 0, 0]}')
    live = serve(
        path, Given([line], json.loads), Settings(clock="system"), lambda _: None, Adaptation(test)
    )
    assert test.begun.wait(PATIENCE)
    assert not test.go.is_set()
    test.go.set()
    until(lambda: not test.thread.is_alive())
    live.close()  # again: nothing


def test_a_test_that_runs_ends_at_its_next_step(path):
    """The program, which waits for all threads, ends at once."""
    test = SlowTest()

    def look():
        test.begun.set()
        test.thread = threading.current_thread()
        for _ in over([*range(10**6)]):
            time.sleep(0.001)

    test.look = look
    live = Live(path, Settings(clock="system"), lambda _: None, Adaptation(test))
    assert [*live.take(json.dumps({"pose": [0, 0, 0]}), NANO)] == []
    assert test.begun.wait(PATIENCE)
    live.close()
    until(lambda: not test.thread.is_alive())
