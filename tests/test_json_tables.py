# SPDX-License-Identifier: MIT
"""Logs as JSON: `init` and `read` give the boat's motion; what is no table is refused in one line."""

import json

import numpy as np
import pytest

from seatrial.io.table import is_table, open_tables
from seatrial.util.errors import RecordingError
from tests.odd_logs import columns, moves_as_the_boat, read


def rows():
    """An object a row, with objects, a list, a truth and nothing within it."""
    c = {name: values.tolist() for name, values in columns().items()}
    return [
        {"time": t, "pose": {"x": x, "y": y, "yaw": psi}, "motors": [left, right], "armed": True,
         "mode": "manual", "fix": None}
        for t, x, y, psi, left, right in zip(*(c[k] for k in ("t", "east", "north", "psi", "left", "right")), strict=True)
    ]  # fmt: skip


def as_lines(found):
    return "\n".join(map(json.dumps, found)) + "\n"


def as_columns(found):
    flat = {
        "time": [r["time"] for r in found], "left": [r["motors"][0] for r in found],
        "right": [r["motors"][1] for r in found], "dt": 0.05,
    }  # fmt: skip
    return json.dumps(flat | {k: [r["pose"][k] for r in found] for k in ("x", "y", "yaw")})


@pytest.mark.parametrize(
    ("name", "write"),
    [("a.jsonl", as_lines), ("a.ndjson", as_lines), ("a.json", json.dumps), ("a.json", as_columns)],
)
def test_every_form_of_rows(tmp_path, name, write):
    path = tmp_path / name
    path.write_text(write(rows()))
    vehicle, recording = read(path)
    moves_as_the_boat(recording)
    own = ["left", "right"] if write is as_columns else ["motors[0]", "motors[1]"]
    assert [c.column for c in vehicle.file.commands.inputs.values()] == own


def test_a_value_that_a_row_lacks_is_an_empty_cell(tmp_path):
    """As NaN is, which Python writes as no JSON has it."""
    path = tmp_path / "log.jsonl"
    path.write_text(
        '{"t": 0, "x": 1.5}\n\n{"t": 1, "name": "ok"}\n{"t": 2, "x": NaN, "on": true}\n'
    )
    (table,) = open_tables(path).values()
    assert table.names == ["t", "x", "name", "on"]
    np.testing.assert_array_equal(table.columns(["t", "x"]), [[0, 1.5], [1, np.nan], [2, np.nan]])
    assert table.texts("name") == ["", "ok", ""]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"t": 0}\n{"t": 1', "line 2: is not JSON"),
        ('{"gain": 3}', "expected an object for each row"),
        ("[]", "no rows"),
    ],
)
def test_what_is_no_table_is_refused(tmp_path, text, said):
    path = tmp_path / "log.json"
    path.write_text(text)
    with pytest.raises(RecordingError, match=said):
        open_tables(path)


def test_settings_beside_tables_are_none(tmp_path):
    (tmp_path / "settings.json").write_text('{"gain": 3}')
    assert not is_table(tmp_path)
    (tmp_path / "log.csv").write_text("t,x\n0,1\n1,2\n")
    assert [*open_tables(tmp_path)] == ["log.csv"]


def test_two_values_of_one_dotted_name_are_one_column(tmp_path):
    path = tmp_path / "log.jsonl"
    rows = [{"t": 0.1 * i, "a": {"b": 1.0}, "a.b": 2.0, "deep": [[{"c": i}]]} for i in range(5)]
    path.write_text("\n".join(json.dumps(row) for row in rows))
    (table,) = open_tables(path).values()
    assert table.names == ["t", "a.b", "deep[0][0].c"]
    assert table.columns(["a.b", "deep[0][0].c"]).tolist() == [[2.0, float(i)] for i in range(5)]
