# SPDX-License-Identifier: MIT
"""Lines in, odometry out: what a program without ROS gets."""

import json
import os
import select
import signal
import socket
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli_tools import refused
from given_lines import Given
from programs import PROGRAM, piped
from test_model import frd
from waiting import PATIENCE, free_port, until

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.commands.cli import main
from seatrial.onboard.live import Reader, Settings, Writer, serve
from seatrial.onboard.live import replay as along_recording
from seatrial.onboard.live.endpoints import Pipes
from seatrial.onboard.live.protocol import CSV_HEADER
from seatrial.onboard.odometer import Odometer
from seatrial.onboard.predictor import Taken
from seatrial.util.errors import LiveError, ModelError
from seatrial.util.frames import Axes
from tests.boats.drives import drive, model, trials
from tests.boats.scenes import TRAINING

SCENE = "hard"
SEED = 5
SECONDS = 20.0
COMMAND = [PROGRAM, "predict"]


@pytest.fixture(scope="module")
def known() -> seatrial.Model:
    return model(SCENE, SEED)


@pytest.fixture(scope="module")
def path(known, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("live") / "model.yaml"
    seatrial.save(known, path)
    return path


@pytest.fixture(scope="module")
def recording() -> seatrial.Recording:
    return drive(SCENE, SEED).recording.cut(0.0, SECONDS)


def lines(recording, *, flip: bool = False, form: str = "json") -> list[str]:
    """A recording as a program would send it, in the order of the stamps."""
    turn = (Axes.FRD if flip else Axes.FLU).signs
    found = [
        (int(t), "command", (row * turn).tolist())
        for t, row in zip(recording.commands.stamps, recording.commands.values, strict=True)
    ]
    found += [
        (int(recording.stamps[i]), "pose", (recording.eta[i] * turn).tolist())
        for i in np.flatnonzero(recording.valid)
    ]
    found.sort(key=lambda one: (one[0], one[1] == "pose"))
    if form == "csv":
        return [",".join([kind, repr(t / 1e9), *map(repr, row)]) for t, kind, row in found]
    return [json.dumps({"stamp": t, kind: row}) for t, kind, row in found]


def through(path: Path, given: list[str], form: str = "json") -> tuple[list[str], list[str]]:
    """Answers and complaints."""
    said: list[str] = []
    source = Given(given)
    serve(path, source, Settings(form), said.append)
    return source.answers, said


def test_a_stream_gives_what_the_recording_gives(known, path, recording):
    answers, said = through(path, lines(recording))
    assert said == []
    assert len(answers) > 0.95 * 50.0 * SECONDS
    # a stream's lines are at multiples of the period, the recording's count from its first pose
    along = list(along_recording(known, recording, 1000.0))
    t = np.array([out.stamp * 1e-9 for out in along])
    of_along = np.array([[*out.motion.velocity, *out.motion.pose] for out in along])
    for answer in map(json.loads, answers[100::50]):
        nearest = int(np.argmin(np.abs(t - answer["t"])))
        got = [*answer["velocity"], *answer["map"]]
        np.testing.assert_allclose(got, of_along[nearest], atol=5e-3)


def test_velocity_is_near_the_truth(path, recording):
    trial = drive(SCENE, SEED)
    answers, _ = through(path, lines(recording))
    end = recording.origin * 1e-9 + recording.t[-1]  # commands go on a second more
    late = [a for a in map(json.loads, answers) if 5.0 < a["t"] <= end]
    asked = [a["t"] - recording.origin * 1e-9 for a in late]
    truth = np.column_stack([np.interp(asked, recording.t, nu) for nu in _truth(trial, recording)])
    wrong = np.array([a["velocity"] for a in late]) - truth
    assert np.all(np.sqrt(np.mean(wrong**2, axis=0)) < [0.003, 0.003, 0.01])


def _truth(trial, recording):
    return trial.truth[: len(recording.t), 3:].T


def test_csv_is_the_same_as_json(path, recording):
    as_json, _ = through(path, lines(recording))
    (header, *as_csv), said = through(path, lines(recording, form="csv"), "csv")
    assert said == []
    assert header == CSV_HEADER
    assert len(as_csv) == len(as_json)
    for row, text in zip(as_csv, as_json, strict=True):
        cells = dict(zip(header.split(","), row.split(","), strict=True))
        answer = json.loads(text)
        np.testing.assert_allclose(
            [float(cells[name]) for name in ("u", "v", "r")], answer["velocity"], atol=1e-6
        )
        np.testing.assert_allclose(
            float(cells["sd_u"]) ** 2, answer["velocity_covariance"][0][0], rtol=1e-3
        )


def test_a_boat_in_forward_right_down_gets_mirrored_lines(known, path, recording, tmp_path):
    other = tmp_path / "frd.yaml"
    seatrial.save(replace(known, vehicle=frd(known.vehicle)), other)
    here, _ = through(path, lines(recording))
    there, said = through(other, lines(recording, flip=True))
    assert said == []
    for a, b in zip(map(json.loads, here), map(json.loads, there), strict=True):
        for key in ("pose", "velocity", "map"):
            np.testing.assert_allclose(np.array(b[key]) * Axes.FRD.signs, a[key], atol=1e-9)
        square = np.outer(Axes.FRD.signs, Axes.FRD.signs)
        np.testing.assert_allclose(b["map_covariance"] * square, a["map_covariance"], atol=1e-12)


BAD = [
    ("not json", "malformed"),
    ('{"t": 1, "pose": [1, 2]}', "pose"),
    ('{"t": 1, "pose": [1, 2, 3], "command": [0, 0, 0]}', "expected one of"),
    ('{"t": 1}', "expected one of"),
    ('{"t": 1, "stamp": 3, "pose": [1, 2, 3]}', "not both"),
    ('{"pose": [1, 2, 3]}', "no t"),
    ('{"t": 1e99, "pose": [1, 2, 3]}', "expected seconds"),
    ('{"t": 1, "command": [0, 0]}', "expected 3 numbers"),
    ('{"t": 1, "command": {"F_u": 0, "F_v": 0, "F_x": 0}}', "F_r"),
    ('{"t": 1, "scale": [1]}', "expected 0 numbers"),
    ('{"t": 1, "poses": [1, 2, 3]}', "expected JSON with some of t, stamp, pose"),
    ('{"t": 1, "pose": [1e300, 2, 3]}', "a number is NaN, infinite or out of range"),
]


@pytest.mark.parametrize(("line", "words"), BAD)
def test_a_bad_line_is_said_and_left_out(path, line, words):
    good = ['{"t": 0, "command": [0, 0, 0]}', '{"t": 0.1, "pose": [0, 0, 0]}']
    answers, said = through(path, [*good, line, '{"t": 1.1, "pose": [0, 0, 0]}'])
    assert len(said) == 2
    assert words in said[0]
    assert said[0].startswith("line 3: ")
    assert "\n" not in said[0]
    assert said[1] == "1 of 4 lines could not be used"
    assert len(answers) == 50


@pytest.mark.parametrize(
    "line", ["pose,1,2", "pose,1,2,x,4", "speed,1,2", "command,1,0,0", "at", "pose,nan,1,2,3"]
)
def test_a_bad_csv_line_is_said_and_left_out(path, line):
    _, said = through(path, [line], "csv")
    assert said[0].startswith("line 1: ")


def test_mistakes_are_counted_but_not_all_said(path):
    _, said = through(path, ["?"] * 500)
    assert len(said) == 12
    assert said[-1] == "500 of 500 lines could not be used"


def test_comments_and_empty_lines_are_nothing(path):
    assert through(path, ["", "  ", "# a remark"]) == ([], [])


def test_at_is_answered_at_once_and_moves_nothing(path, recording):
    given = lines(recording.cut(0.0, 8.0))
    asked = [line for one in given for line in (one, '{"at": 30.0}')]
    plain, _ = through(path, given)
    answers, said = through(path, asked)
    assert said == []
    ahead = [a for a in map(json.loads, answers) if a["pose"] is None]
    assert len(ahead) == len(given)
    assert [a for a in answers if json.loads(a)["pose"] is not None] == plain
    assert np.trace(ahead[-1]["map_covariance"]) > np.trace(json.loads(plain[-1])["map_covariance"])


def test_a_leap_of_the_clock_does_not_flood(path):
    given = ['{"t": 0, "command": [0, 0, 0]}', '{"t": 0.1, "pose": [0, 0, 0]}']
    given += [f'{{"t": {1e6 + 0.1 * k}, "pose": [0, 0, 0]}}' for k in range(5)]
    answers, _ = through(path, given)
    assert len(answers) < 100


def test_the_model_is_read_once_more(path, recording, tmp_path, known):
    own = tmp_path / "m.yaml"
    seatrial.save(known, own)
    given = lines(recording)
    half = len(given) // 2
    asked = [*given[:half], '{"reload": true}', *given[half:]]
    plain, _ = through(own, given)
    again, said = through(own, asked)
    assert said == []
    assert len(again) == len(plain)
    for a, b in zip(map(json.loads, plain), map(json.loads, again), strict=True):
        np.testing.assert_allclose(a["velocity"], b["velocity"], atol=0.02)
        np.testing.assert_allclose(a["pose"], b["pose"], atol=0.02)


def test_a_model_that_can_not_be_used_leaves_the_one_before(known, tmp_path, path):
    odometer = Odometer(path)
    with pytest.raises(ModelError, match="inputs"):
        odometer.reload(seatrial.load(_of_other_inputs(known, tmp_path)))
    broken = tmp_path / "m.yaml"
    broken.write_text("seatrial: model 2\n")
    with pytest.raises(seatrial.SeatrialError):
        odometer.reload(broken)
    assert odometer.model.name == known.name
    assert odometer.command(0, [0.0, 0.0, 0.0]) is Taken.USED


def _of_other_inputs(known, folder):
    mapping = known.vehicle.to_mapping()
    inputs = mapping["commands"]["inputs"]
    mapping["commands"]["inputs"] = {name: inputs[name] for name in ("F_v", "F_u", "F_r")}
    path = folder / "other.yaml"
    seatrial.save(replace(known, vehicle=vehicle_from(mapping, "other")), path)
    return path


def test_standard_input_is_read_line_by_line_however_it_is_cut(tmp_path):
    fed, feeder = os.pipe()
    with (tmp_path / "out").open("wb") as out, os.fdopen(fed, "rb") as inlet:
        source = Pipes(inlet, out)
        os.write(feeder, b"one\ntw")
        assert source.read(1.0) == ["one"]
        assert source.read(0.01) == []
        os.write(feeder, b"o\nthree\nfour")
        assert source.read(1.0) == ["two", "three"]
        os.close(feeder)
        assert source.read(1.0) == ["four"]
        assert source.ended


def test_as_a_process_by_pipes(path, recording):
    given = "\n".join(lines(recording)) + "\n"
    done = piped(
        [*COMMAND, str(path), "--live", "--rate", "10"], input=given, check=True, timeout=PATIENCE
    )
    assert done.stderr == ""
    stamps = [json.loads(line)["t"] for line in done.stdout.splitlines()]
    np.testing.assert_allclose(np.diff(stamps), 0.1, atol=1e-6)


def test_as_a_process_by_udp_and_the_systems_clock(path):
    port, begin = free_port(), time.time()
    command = [*COMMAND, str(path), "--live", "--udp", str(port), "--clock", "system"]
    with (
        subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as own,
    ):
        own.bind(("127.0.0.1", 0))
        own.settimeout(0.05)
        heard: list[dict] = []

        def answers():
            own.sendto(b'{"command": [0.5, 0, 0]}\n{"pose": [1, 2, 0.5]}', ("127.0.0.1", port))
            try:
                heard.extend(map(json.loads, own.recv(65536).decode().splitlines()))
            except (TimeoutError, ConnectionError):
                return False
            return len(heard) >= 50

        until(answers)
        assert begin <= heard[-1]["t"] <= time.time() + 1.0
        np.testing.assert_allclose(heard[-1]["map"], [1.0, 2.0, 0.5], atol=0.05)
        process.send_signal(signal.SIGHUP)
        assert select.select([process.stderr], [], [], PATIENCE)[0]
        assert "reloaded" in process.stderr.readline()
        own.sendto(b"", ("127.0.0.1", port))
        assert process.wait(PATIENCE) == 0


def test_along_a_recording(path, recording, tmp_path, capsys):
    from seatrial.io.trial_files import write_trial

    folder = write_trial(trials(SCENE, SEED, TRAINING)["S1"], tmp_path)
    for name in ("out.csv", "out.jsonl"):
        given = ["predict", str(path), str(folder), "--end", "40", "-o", str(tmp_path / name)]
        assert main(given) == 0
    header, *rows = (tmp_path / "out.csv").read_text().splitlines()
    answers = (tmp_path / "out.jsonl").read_text().splitlines()
    assert header == CSV_HEADER
    assert len(rows) == len(answers) > 1000
    assert json.loads(answers[500])["t"] == float(rows[500].split(",")[0])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "give a recording"),
        (("x", "--live"), "give a recording"),
        (("--live", "--to", "3"), "--to belongs to --udp"),
        (("--live", "-o", "x"), "--live writes to"),
        (("--live", "--rate", "0"), "0.1 to 1000 Hz"),
        (("--live", "--udp", "70000"), "UDP port 70000"),
        (("x",), "-o FILE"),
        (("x", "--udp", "1"), "--udp belongs to --live"),
    ],
)
def test_a_mistake_is_one_line(path, arguments, words, capsys):
    assert words in refused(capsys, "predict", path, *arguments)


def test_a_reader_takes_names_in_any_order(known):
    reader = Reader(known.vehicle, "json")
    event = reader('{"t": 2, "command": {"F_r": 3, "F_u": 1, "F_v": 2}}')
    assert event.values.tolist() == [1.0, 2.0, 3.0]
    assert event.stamp == 2_000_000_000
    with pytest.raises(LiveError):
        reader("[]")
    assert Writer(known.vehicle, "json").header is None
