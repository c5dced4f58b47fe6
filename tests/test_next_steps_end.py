# SPDX-License-Identifier: MIT
"""A user that follows `next:` lines gets to `validate`, whatever the log is doubtful for."""

import shlex

import numpy as np
import pytest
from cli_tools import done
from conftest import make_model
from survey_boat import TRUTH, boat, driven

from seatrial.boat.model_file import save
from seatrial.util.files import dump_yaml

MOST_STEPS = 5
CARRIED = 40.0  # [s] before the drive


def written(folder, *, carried=False, digits=5):
    """A drive as a table with commands in the rows of the poses, and its vehicle file."""
    _, recording = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=100.0)
    held = np.searchsorted(recording.commands.stamps, recording.stamps, side="right") - 1
    rows = np.column_stack([recording.t, recording.raw, recording.commands.values[held]])
    if carried:
        ashore = np.zeros((round(10 * CARRIED), rows.shape[1]))
        ashore[:, 0] = 0.1 * np.arange(len(ashore)) - CARRIED
        ashore[:, 1] = ashore[:, 0]  # 1 m/s
        rows = np.concatenate([ashore, rows])
    lines = [
        f"{t:.3f},{x:.{digits}f},{y:.{digits}f},{psi:.5f},{left:.4f},{right:.4f}"
        for t, x, y, psi, left, right in rows
    ]
    (folder / "lake.csv").write_text("\n".join(["t,x,y,psi,left,right", *lines]) + "\n")
    (folder / "v.yaml").write_text(dump_yaml(boat().to_mapping()))


@pytest.mark.parametrize(
    ("log", "options"),
    [
        pytest.param({}, [], id="samples"),
        pytest.param({}, ["--method", "equation-error"], id="samples by another method"),
        pytest.param({"carried": True}, [], id="carried"),
        pytest.param({"digits": 2}, [], id="rounded"),
    ],
)
def test_next_lines_lead_to_validate(log, options, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written(tmp_path, **log)
    words = ["inspect", "lake.csv", "--vehicle", "v.yaml"]
    for _ in range(MOST_STEPS):
        if words[0] == "identify":
            words += options
        out = done(capsys, *words)
        step = out.partition("\nnext: ")[2]
        if step.startswith("State 'sampled: true' under 'commands:'"):
            told = (
                (tmp_path / "v.yaml").read_text().replace("commands:", "commands:\n  sampled: true")
            )
            (tmp_path / "v.yaml").write_text(told)
            continue
        words = shlex.split(step, comments=True)[1:]
        if words[0] == "validate":
            return
    raise AssertionError(f"no end: {words}")


def test_a_test_recording_of_a_carried_boat_is_told_and_left_out(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    written(tmp_path, carried=True)
    save(make_model(boat(), TRUTH), tmp_path / "m.yaml")
    out = done(capsys, "validate", "m.yaml", "lake.csv")
    assert "doubt: lake: the boat moves 39 m in the 39 s before the first command" in out
    again = shlex.split(out.partition("\nnext: ")[2], comments=True)[1:]
    assert again[0] == "validate"
    out = done(capsys, *again)
    assert "carried" not in out
    assert out.partition("\nnext: ")[2].startswith("seatrial report")
