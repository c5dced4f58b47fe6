# SPDX-License-Identifier: MIT
"""`seatrial sim`: lines of commands in, lines of readings and truth out."""

import json
import socket
import subprocess
import time
from functools import partial

import numpy as np
import pytest
from cli_tools import by_lines, refused
from programs import PROGRAM, piped
from test_model import frd
from waiting import PATIENCE, free_port, until

import seatrial
from seatrial.simulation.server import SimSettings, SimStream
from seatrial.util.frames import Axes

sim = partial(by_lines, "sim")
SCRIPT = [(0.0, [0.8, 0.0, 0.1]), (2.0, [0.3, -0.6, 0.5]), (5.0, [-0.5, 0.2, -0.4])]


def commands(flip=None):
    turn = np.ones(3) if flip is None else flip
    return [json.dumps({"t": t, "command": (turn * f).tolist()}) for t, f in SCRIPT]


def by_kind(rows, kind):
    return np.array([[row["t"], *row[kind]] for row in rows if kind in row])


def test_the_truth_is_the_simulators_by_the_same_commands(boat, path):
    code, rows, said = sim(path, "--speed", 0, "--duration", 8, "--rate", 10, lines=commands())
    assert (code, said) == (0, "")
    truth = by_kind(rows, "truth")
    np.testing.assert_allclose(truth[:, 0], np.arange(81) / 10)
    simulator = seatrial.Simulator(boat)
    for (t, force), end in zip(SCRIPT, (2.0, 5.0, 8.0), strict=True):
        simulator.advance_to(t)
        simulator.command(force)
        simulator.advance_to(end)
    np.testing.assert_allclose(
        truth[-1, 1:], np.concatenate([simulator.eta, simulator.nu]), atol=1e-9
    )
    assert len(by_kind(rows, "imu")) == 800
    assert len(by_kind(rows, "pose")) == pytest.approx(120, abs=2)


def test_the_same_lines_and_seed_give_the_same_bytes(path):
    options = (path, "--speed", 0, "--duration", 3, "--seed", 7)
    shown = sim(*options, lines=commands())
    assert sim(*options, lines=commands()) == shown != sim(*options[:-1], 8, lines=commands())


def test_it_pipes_into_the_live_predictor(path):
    """Poses and commands are lines that `predict --live` reads; what it says is near the truth."""
    kinds = ("--speed", 0, "--duration", 8, "--lines")
    _, rows, _ = sim(path, *kinds, "pose,command", lines=commands())
    predicted = piped(
        [PROGRAM, "predict", str(path), "--live", "--rate", "10"],
        check=True,
        input="\n".join(map(json.dumps, rows)),
        timeout=PATIENCE,
    )
    assert predicted.stderr == ""
    answers = {round(a["t"], 6): a for a in map(json.loads, predicted.stdout.splitlines())}
    _, rows, _ = sim(path, *kinds, "truth", "--rate", 10, lines=commands())
    truth = {t: x for t, *x in by_kind(rows, "truth").tolist()}
    late = [t for t in answers if 2.0 < t < 7.5]
    assert len(late) > 40
    wrong = np.array([np.subtract(answers[t]["velocity"], truth[t][3:]) for t in late])
    assert np.all(np.sqrt(np.mean(wrong**2, axis=0)) < [0.005, 0.005, 0.01])


def test_lines_are_in_the_models_own_axes(boat, path, tmp_path):
    from dataclasses import replace

    other = tmp_path / "frd.yaml"
    seatrial.save(replace(boat, vehicle=frd(boat.vehicle)), other)
    scene = tmp_path / "scene.yaml"
    scene.write_text("seatrial: scene 1\nwalls: [[-5, 1, 9, 1]]\nsensors: {imu: {rate: 20}}\n")
    options = ("--speed", 0, "--duration", 4, "--scene", scene)
    _, own, _ = sim(path, *options, lines=commands())
    _, flipped, _ = sim(other, *options, lines=commands(Axes.FRD.signs))
    turn = {
        "pose": Axes.FRD.signs,
        "truth": np.tile(Axes.FRD.signs, 2),
        "imu": np.array([-1, 1, -1]),
    }
    for kind, signs in turn.items():
        want = by_kind(own, kind)
        np.testing.assert_allclose(by_kind(flipped, kind)[:, 1:], want[:, 1:] * signs, atol=1e-9)
    first, second = (next(row for row in rows if "scan" in row) for rows in (own, flipped))
    assert first["angles"] == [-angle for angle in second["angles"]]
    # the wall is to port: seen by the last beams in both
    assert first["scan"][0] is None
    assert second["scan"][-46] == pytest.approx(first["scan"][-46])


def test_two_boats_say_who_they_are_and_meet(path, tmp_path):
    scene = tmp_path / "scene.yaml"
    scene.write_text(
        "seatrial: scene 1\npool: {length: 20, width: 8}\nsensors: {imu: null, pose: null}\n"
        "boats: [{name: a}, {name: b, start: [2, 0, 0]}]\n"
    )
    lines = ['{"t": 0, "boat": "a", "command": {"F_u": 1, "F_v": 0, "F_r": 0}}']
    _, rows, said = sim(path, path, "--scene", scene, "--speed", 0, "--duration", 20, lines=lines)
    assert said == ""
    track = {
        name: np.array([r["truth"] for r in rows if r["boat"] == name and "truth" in r])
        for name in "ab"
    }
    assert track["b"][-1, 0] > 2.3  # pushed along
    apart = np.hypot(*(track["a"] - track["b"])[:, :2].T)
    assert 0.6 - 0.003 < apart.min() < 0.6
    first = next(r["scan"] for r in rows if r["boat"] == "a" and "scan" in r)
    assert first[135] == pytest.approx(2.0 - 0.3, abs=0.1)


def test_names_and_places_of_their_own_without_a_scene(path):
    _, rows, _ = sim(path, path, "--speed", 0, "--duration", 0.1)
    starts = {row["boat"]: row["truth"][:3] for row in rows if "truth" in row and row["t"] == 0}
    assert starts == {"mallard": [0, 0, 0], "mallard-2": [0, 1.5, 0]}


def test_it_keeps_to_the_clock(path):
    """Without input, at twice the speed: 3 s in 1.5."""
    begin = time.monotonic()
    code, rows, _ = sim(path, "--duration", 3, "--speed", 2, "--lines", "truth")
    took = time.monotonic() - begin
    assert code == 0
    assert rows[-1]["t"] == pytest.approx(3.0)
    assert took >= 1.5  # a busy machine is late, never early


def test_by_udp_a_command_moves_it(path):
    port = free_port()
    program = subprocess.Popen(
        [PROGRAM, "sim", str(path), "--udp", str(port), "--lines", "truth", "--duration", "3600"]
    )
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as boat:
            boat.connect(("127.0.0.1", port))
            boat.settimeout(0.2)

            def moves():
                try:
                    boat.send(b'{"command": [1, 0, 0]}')
                    return json.loads(boat.recv(65536))["truth"][3] >= 0.05
                except OSError:  # not there yet
                    return False

            until(moves)
    finally:
        program.terminate()
        program.wait(PATIENCE)


def test_what_can_not_be_used_is_said_and_left_out(path):
    lines = [
        '{"t": 1, "command": [1, 2]}', '{"t": 1}', "what?", '{"t": 0.5, "at": 1, "command": [0, 0, 0]}',
        '{"t": 1, "boat": "q", "command": [0, 0, 0]}', '{"at": 2}', '{"t": 1, "command": [0, 0, 0]}',
        '{"t": 2, "command": {"F_u": 1}}',
    ]  # fmt: skip
    code, _, said = sim(path, "--speed", 0, "--duration", 3, lines=lines)
    assert code == 0
    for words in (
        "line 1: command: expected 3 numbers: F_u, F_v, F_r; got 2", "line 2: expected command or at",
        "line 3:", "line 4: expected command or at", "line 5: boat: got q; expected one of mallard",
        "line 7: t 1: before the simulated time 2 s", "line 8: command: expected F_u, F_v, F_r; got F_u",
        "7 of 8 lines could not be used",
    ):  # fmt: skip
        assert words in said


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--rate", "0"], "rate 0"),
        (["--speed", "-1"], "speed -1"),
        (["--lines", "pose,odd"], "lines odd: expected some of pose, truth"),
        (["--to", "5"], "--to belongs to --udp"),
        (["--scene", "nowhere"], "nowhere: no such file"),
        (["--duration", "-3"], "duration -3"),
    ],
)
def test_a_mistake_is_one_line(path, options, words, capsys):
    assert words in refused(capsys, "sim", path, *options)


def test_mistakes_are_counted_after_ten(boat):
    said = []
    world = seatrial.World()
    world.add(boat)
    stream = SimStream(world, SimSettings(), said.append)
    for _ in range(15):
        assert not list(stream.take("nonsense"))
    assert stream.mistakes == 15
    assert len(said) == 11
