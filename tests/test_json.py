# SPDX-License-Identifier: MIT
"""--json: the result for programs, in a file or on standard output."""

import json
from argparse import Namespace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from cli_tools import run

from seatrial.commands.shared import write_json
from seatrial.util.printing import put


def test_a_dash_is_standard_output_with_nothing_but_json(pool, tmp_path, capsys):
    command = ("inspect", pool / "S1-AF", "--vehicle", pool / "vehicle-AF.yaml", "--json")
    code, text, _ = run(capsys, *command, tmp_path / "found.json")
    assert code == 0
    assert "S1-AF" in text
    code, out, err = run(capsys, *command, "-")
    assert (code, err) == (0, "")
    content = json.loads(out)
    assert content["seatrial"] == "inspection 1"
    assert content == json.loads((tmp_path / "found.json").read_text())
    assert not Path("-").exists()
    _, again, _ = run(capsys, *command, tmp_path / "found.json")
    assert again == text  # the text is back after a call with a dash


def test_names_from_a_file_can_not_steer_the_terminal_through_json(capsys):
    write_json(Namespace(json=Path("-")), "test 1", {"name": "a\x1b[2J\x9b2J\u202eb\u2028"})
    out = capsys.readouterr().out
    assert out.isascii()
    assert all(c.isprintable() or c == "\n" for c in out)
    assert json.loads(out) == {"seatrial": "test 1", "name": "a\x1b[2J\x9b2J\u202eb\u2028"}
    with pytest.raises(ValueError, match="ASCII"):
        put("\x9b")


class _Result(msgspec.Struct):
    path: Path
    values: list[float]


def test_paths_numbers_of_numpy_and_what_json_lacks(tmp_path):
    args = Namespace(json=tmp_path / "out.json")
    write_json(args, "test 1", _Result(Path("a/b"), [1.0, float("inf"), float("nan")]))
    assert json.loads(args.json.read_text()) == {
        "seatrial": "test 1",
        "path": "a/b",
        "values": [1.0, None, None],
    }
    write_json(args, "test 1", {"x": np.float64(2.5), "A": np.eye(2), "n": np.int64(3)})
    found = json.loads(args.json.read_text())
    assert found == {"seatrial": "test 1", "x": 2.5, "A": [[1.0, 0.0], [0.0, 1.0]], "n": 3}


def test_content_with_a_kind_of_its_own_keeps_it(tmp_path):
    args = Namespace(json=tmp_path / "out.json")
    write_json(args, "test 1", {"seatrial": "scores 5"})
    assert json.loads(args.json.read_text()) == {"seatrial": "scores 5"}
    write_json(Namespace(json=None), "test 1", {"x": object()})  # not asked for
