# SPDX-License-Identifier: MIT
"""`seatrial mimic`: lines of commands and poses in, the carrier's velocity out."""

import json
import subprocess
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from cli_tools import by_lines, refused
from programs import PROGRAM
from test_model import frd
from waiting import PATIENCE

import seatrial
from seatrial.simulation.mimic import Carrier, Mimic
from seatrial.util.frames import Axes

mimic = partial(by_lines, "mimic")


def events(flip=None):
    turn = np.ones(3) if flip is None else flip
    rows = [(0.0, "pose", [1.0, 2.0, 0.5]), (0.1, "command", [0.6, -0.2, 0.3]),
            (1.0, "pose", [1.01, 2.0, 0.55]), (2.0, "command", [-0.3, 0.5, -0.2]),
            (4.0, "pose", [1.2, 2.1, 0.9])]  # fmt: skip
    return [(t, kind, (turn * row).tolist()) for t, kind, row in rows]


def lines(flip=None):
    return [json.dumps({"t": t, kind: row}) for t, kind, row in events(flip)]


def test_it_says_what_the_library_says(boat, path):
    code, rows, said = mimic(path, "--rate", 20, "--lag", 0.2, "--gain", 1.0, lines=lines())
    assert (code, said) == (0, "")
    own, want, given = Mimic(boat, Carrier(lag=0.2, gain=1.0)), [], events()
    for t in np.arange(0, 80) / 20:
        while given and given[0][0] < t + 1e-9:
            at, kind, row = given.pop(0)
            (own.pose if kind == "pose" else own.command)(at, row)
        want.append(own.at(t))
    assert len(rows) == 80
    for row, motion in zip(rows[1:], want[1:], strict=True):
        np.testing.assert_allclose(row["velocity"], motion.velocity, atol=1e-9)
        np.testing.assert_allclose(row["boat"], [*motion.pose, *motion.nu], atol=1e-9)
        np.testing.assert_allclose(row["mismatch"], motion.mismatch, atol=1e-9)
        assert tuple(row["health"]) == motion.health.names


def test_lines_are_in_the_models_own_axes(boat, path, tmp_path):
    other = tmp_path / "frd.yaml"
    seatrial.save(replace(boat, vehicle=frd(boat.vehicle)), other)
    _, own, _ = mimic(path, lines=lines())
    _, flipped, _ = mimic(other, lines=lines(Axes.FRD.signs))
    assert len(own) > 100
    for one, two in zip(own, flipped, strict=True):
        np.testing.assert_allclose(two["velocity"], one["velocity"] * Axes.FRD.signs, atol=1e-9)
        np.testing.assert_allclose(two["mismatch"], one["mismatch"] * Axes.FRD.signs, atol=1e-9)


def test_csv_goes_in_too(path):
    rows = [",".join([kind, str(t), *map(str, row)]) for t, kind, row in events()]
    assert mimic(path, "--format", "csv", lines=rows) == mimic(path, lines=lines())


def test_by_the_systems_clock_lines_need_no_stamp(path):
    command = [PROGRAM, "mimic", str(path), "--clock", "system", "--rate", "20"]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        process.stdin.write('{"pose": [0, 0, 0]}\n{"command": [1, 0, 0]}\n')
        process.stdin.flush()
        rows = [json.loads(process.stdout.readline()) for _ in range(30)]
        process.stdin.close()
        assert process.wait(PATIENCE) == 0
    assert rows[-1]["velocity"][0] > 0.03
    np.testing.assert_allclose(np.diff([row["t"] for row in rows]), 0.05, atol=1e-6)


def test_what_can_not_be_used_is_said_and_left_out(path):
    bad = ['{"pose": [0, 0, 0]}', '{"t": 1, "command": [1]}', '{"at": 3}', "?", '{"t": 1, "pose": [0, 0, 0]}',
           '{"t": 0.5, "pose": [0, 0, 0]}', '{"t": 900, "pose": [0, 0, 0]}']  # fmt: skip
    code, _, said = mimic(path, lines=bad)
    assert code == 0
    for words in (
        "line 1: no t", "line 2: command: expected 3 numbers", "line 3: expected pose or command; got at",
        "line 4:", "line 6: pose at 0.500000 s was not used", "line 7: pose at 900.000000 s was not used: its stamp is 899.0 s after",
        "6 of 7 lines",
    ):  # fmt: skip
        assert words in said


@pytest.mark.parametrize(
    ("options", "words"),
    [(["--lag", "3"], "carrier: lag"), (["--to", "5"], "--to belongs"), (["--rate", "0"], "rate 0")],
)  # fmt: skip
def test_a_mistake_is_one_line(path, options, words, capsys):
    assert words in refused(capsys, "mimic", path, *options)
