# SPDX-License-Identifier: MIT
"""Lines in and out beside other programs: absurd stamps, other senders, clocks that are set, readers that stall."""

import json
import os
import socket
import sys
import time
from pathlib import Path

import export_names
import pytest
from cli_tools import refused
from programs import PROGRAM, piped
from waiting import PATIENCE, until

import seatrial
from seatrial.commands.cli import main
from seatrial.onboard.live import Settings, serve
from seatrial.onboard.live.endpoints import Arrived, Datagrams, Pipes
from seatrial.onboard.live.server import Live
from seatrial.onboard.odometer import Odometer
from seatrial.onboard.predictor import Taken
from seatrial.simulation.mimic import Mimic
from seatrial.simulation.mimic.server import MimicStream
from seatrial.util.errors import LiveError

NANO = 1_000_000_000
BEGIN = 1_700_000_000 * NANO  # [ns]
ABSURD = [2**63 - 1, 2**63, -(2**63) - 1, 2**64 - 1, 10**40, -(10**400), 4 * 10**18 + 1]


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("live") / "model.yaml"
    seatrial.save(export_names.plain_boat(), path)
    return path


class Script:
    """Batches of lines with their times of arrival, read at times of a clock that may be set."""

    def __init__(self, monkeypatch, batches) -> None:
        self.batches, self.answers, self.ended = [*batches], [], False
        self.now = BEGIN
        monkeypatch.setattr(time, "time_ns", lambda: self.now)

    def read(self, wait):
        self.now, lines = self.batches.pop(0)
        self.ended = not self.batches
        return lines

    def follow(self, line):
        pass

    def write(self, line):
        self.answers.append((self.now, json.loads(line)))


def at(stamp: int, **content) -> Arrived:
    line = Arrived(json.dumps(content))
    line.at, line.sender = stamp, None
    return line


@pytest.mark.parametrize("stamp", ABSURD)
@pytest.mark.parametrize("kind", ["pose", "command"])
def test_an_absurd_stamp_is_one_complaint(path, kind, stamp):
    said: list[str] = []
    live = Live(path, Settings(), said.append)
    for line in (
        {"t": 1000, "pose": [0, 0, 0]},
        {"stamp": stamp, kind: [0, 0, 0]},
        {"t": 1000.1, "pose": [0, 0, 0]},
    ):
        out = list(live.take(json.dumps(line), 0))
    assert len(out) > 3
    assert len(said) == 1
    assert "expected [ns], up to 4e+18" in said[0]
    other: list[str] = []
    mimic = MimicStream(Mimic(path), Settings(), other.append)
    assert list(mimic.take(json.dumps({"stamp": stamp, kind: [0, 0, 0]}), 0)) == []
    assert len(other) == 1


@pytest.mark.parametrize("stamp", ABSURD)
def test_the_odometer_itself_refuses_an_absurd_stamp(path, stamp):
    odometer = Odometer(path)
    assert odometer.pose(BEGIN, [0, 0, 0]) is Taken.USED
    assert odometer.pose(stamp, [0, 0, 0]) is Taken.NOT_A_NUMBER
    assert odometer.command(stamp, [0, 0, 0]) is Taken.NOT_A_NUMBER
    assert odometer.look(stamp).health
    assert odometer.at(stamp).stamp == stamp
    assert odometer.pose(BEGIN + NANO // 10, [0, 0, 0]) is Taken.USED


@pytest.mark.parametrize("back", [0.03, 2.0, 30.0, 3600.0, 1e8])
def test_a_clock_set_back_does_not_silence_it(path, monkeypatch, back):
    """The boat drives 0.1 m/s; three seconds after the clock is set, lines come and have its speed."""
    batches = []
    for i in range(130):
        real = i * NANO // 10
        clock = BEGIN + real - (round(back * NANO) if i >= 60 else 0)
        batches.append((clock, [at(clock, pose=[0.1 * real / NANO, 0, 0])]))
    script = Script(monkeypatch, batches)
    serve(path, script, Settings("json", 10.0, "system"), lambda _: None)
    after = [
        answer for now, answer in script.answers if now >= BEGIN + 9 * NANO - round(back * NANO)
    ]
    late = [a for _, a in script.answers[-30:]]
    assert len(after) >= 30
    assert script.answers[-1][1]["t"] == pytest.approx(
        (BEGIN - round(back * NANO)) / NANO + 12.9, abs=0.11
    )
    assert all(a["velocity"][0] == pytest.approx(0.1, abs=0.01) for a in late[-10:])
    assert all(now / NANO - 0.11 <= a["t"] <= now / NANO + 1e-3 for now, a in script.answers[-30:])


def test_inputs_have_the_time_of_their_arrival_however_late_they_are_handled(path, monkeypatch):
    """Eight seconds of poses wait while the reader of the output stalls."""
    batches = [
        (BEGIN + i * NANO // 10, [at(BEGIN + i * NANO // 10, pose=[0.01 * i, 0, 0])])
        for i in range(60)
    ]
    waiting = [at(BEGIN + i * NANO // 10, pose=[0.01 * i, 0, 0]) for i in range(60, 140)]
    script = Script(monkeypatch, [*batches, (BEGIN + 14 * NANO, waiting)])
    serve(path, script, Settings("json", 50.0, "system"), lambda _: None)
    stamps = [answer["t"] - BEGIN / NANO for _, answer in script.answers]
    assert stamps == pytest.approx([0.02 * k for k in range(len(stamps))], abs=1e-3)
    assert stamps[-1] == pytest.approx(14.0, abs=0.03)
    late = [
        answer["velocity"][0] for _, answer in script.answers if answer["t"] - BEGIN / NANO > 3.0
    ]
    assert late == pytest.approx([0.1] * len(late), abs=0.01)


def test_a_pipe_is_read_while_nobody_handles_its_lines():
    fed, feeder = os.pipe()
    with os.fdopen(fed, "rb") as inlet, Path(os.devnull).open("wb") as out:
        source = Pipes(inlet, out)
        assert source.read(0.0) == []
        for count in range(1, 6):
            os.write(feeder, b"line\n")
            until(lambda n=count: len(source._inbox._lines) == n)
            time.sleep(0.05)
        lines = source.read(1.0)
        os.close(feeder)
        assert [*map(str, lines)] == ["line"] * 5
        assert lines[-1].at - lines[0].at > 0.15 * NANO
        assert source.read(1.0) == []
        assert source.ended


def sender() -> socket.socket:
    own = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    own.bind(("127.0.0.1", 0))
    own.settimeout(PATIENCE)
    return own


def test_answers_stay_with_the_sender_of_valid_lines():
    source = Datagrams(0)
    with sender() as first, sender() as other:
        to = ("127.0.0.1", source.port)

        def read() -> list[str]:
            for _ in range(round(PATIENCE / 0.05)):
                if (lines := source.read(0.05)) or source.ended:
                    return lines
            return []

        first.sendto(b"one", to)
        (line,) = read()
        source.follow(line)
        for text in (b"# a comment", b"garbage"):
            other.sendto(text, to)
            assert [*map(str, read())] == [text.decode()]  # and not followed
            source.write("answer")
            assert first.recv(100) == b"answer\n"
        other.sendto(b"", to)
        first.sendto(b"two", to)
        assert [*map(str, read())] == ["two"]
        assert not source.ended
        other.sendto(b"three", to)
        (line,) = read()
        source.follow(line)
        source.write("answer")
        assert other.recv(100) == b"answer\n"
        other.sendto(b"", to)
        assert read() == []
        assert source.ended


def run(path, *arguments, shell="", **streams):
    command = f'"$0" predict "$1" --live "${{@:2}}" {shell}'
    return piped(
        ["bash", "-c", command, PROGRAM, str(path), *arguments], timeout=PATIENCE, **streams
    )


GOOD = '{"t": 1, "pose": [0, 0, 0]}\n{"t": 1.5, "pose": [0, 0, 0]}\nodd\n'


@pytest.mark.parametrize(
    ("streams", "words"),
    [
        ("<&-", "seatrial: standard input is closed"),
        (">&-", "seatrial: standard output is closed"),
        ("> /dev/full", "seatrial: standard output can't be written (No space left on device)"),
    ],
)
def test_standard_streams_that_are_closed_or_full_are_one_line(path, streams, words):
    done = run(path, shell=streams, input=GOOD)
    assert done.returncode == 1
    assert done.stderr.startswith(words)
    assert "Traceback" not in done.stderr
    assert done.stderr.count("\n") <= 2  # and the line that can't be used


@pytest.mark.parametrize("streams", ["2>&-", "2> /dev/full"])
def test_without_standard_error_it_goes_on(path, streams):
    done = run(path, shell=streams, input=GOOD)
    assert done.returncode == 0
    assert len(done.stdout.splitlines()) > 10


@pytest.mark.parametrize("streams", [">&-", "> /dev/full", "<&-", "2>&- >&-"])
@pytest.mark.parametrize(
    "words", [("--version",), ("export", "MODEL", "--to", "json", "-o", "OUT"), ("inspect", "none")]
)
def test_any_command_with_a_broken_stream_has_no_traceback(path, tmp_path, streams, words):
    given = {"MODEL": str(path), "OUT": str(tmp_path / "boat.json")}
    arguments = [given.get(word, word) for word in words]
    done = piped(["bash", "-c", f'"$0" "$@" {streams}', PROGRAM, *arguments], timeout=PATIENCE)
    assert "Traceback" not in done.stderr
    assert "Exception" not in done.stderr


def test_an_absurd_time_does_not_keep_the_simulator_for_ever(path, tmp_path, monkeypatch):
    given = '{"t":0.1,"command":[0.5,0,0]}\n{"t":1e9,"command":[0.5,0,0]}\n{"t":0.2,"command":[0.5,0,0]}\n'
    done = piped([PROGRAM, "sim", str(path), "--speed", "0"], input=given, timeout=PATIENCE)
    assert done.returncode == 0
    assert "line 2: t 1e+09: more than 3600 s after the simulated time 0.1 s" in done.stderr
    assert [json.loads(line)["t"] for line in done.stdout.splitlines() if "truth" in line][
        -1
    ] == 0.2


def test_a_closed_standard_input_is_refused_in_words(monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(LiveError, match="standard input is closed"):
        Pipes()


def test_escape_sequences_of_files_do_not_reach_the_terminal(tmp_path, capsys):
    folder = tmp_path / "run\x1b]0;title\x07\x1b[2J"
    folder.mkdir()
    (folder / "poses.csv").write_text("t,x\x1b[31m,y,psi\n0,0,0,0\n1,0,0,\x1b[31m\n")
    (folder / "commands.csv").write_text("t,F_u\n0,0\n1,1\n")
    for arguments in (["inspect", str(folder)], ["inspect", str(folder), "--vehicle", "mallard"]):
        main(arguments)
        shown = capsys.readouterr()
        text = shown.out + shown.err
        assert text
        assert all(c.isprintable() or c in "\n\t" for c in text)


def test_a_name_that_is_no_unicode_can_be_printed(tmp_path, capsys):
    folder = tmp_path / os.fsdecode(b"run\xff")
    folder.mkdir()
    assert "run : is an empty folder" in refused(capsys, "inspect", folder)
