# SPDX-License-Identifier: MIT
"""Tables whose rows are of several signals, as a column tells: one column for each."""

import numpy as np
import pytest

from seatrial.io.table import open_tables
from tests.odd_logs import columns, logged, moves_as_the_boat, read, written

T = np.arange(0.0, 20.0, 0.1)


def tall(path, key="id", of=("0", "1"), late=0.0002, stamps=None):
    """Rows of signals in turn, of values 10 t and -t."""
    t = np.concatenate([T + i * late for i in range(len(of))])
    order = np.argsort(t, kind="stable")
    keys = np.repeat(of, len(T))[order]
    values = np.concatenate([10.0 * T, -T])[order]
    return written(
        path, ("time", key, "value"), t[order] if stamps is None else stamps, list(keys), values
    )


@pytest.mark.parametrize("key", ["id", "_field", "Topic"])
def test_a_column_for_each_signal(tmp_path, key):
    """Rows with one stamp are one row; a cell without a value is empty."""
    of = ("left", "right")
    (together,) = open_tables(tall(tmp_path / "a.csv", key, of, late=0.0)).values()
    np.testing.assert_allclose(together.numbers(), np.column_stack([T, 10.0 * T, -T]))
    assert together.names == ["time", *of]
    (apart,) = open_tables(tall(tmp_path / "b.csv", key)).values()
    assert apart.names == ["time", "value 0", "value 1"]
    assert np.isfinite(apart.numbers()).sum(axis=0).tolist() == [400, 200, 200]


def test_thrusters_in_turn_are_two_commands(tmp_path):
    """They were one command, that another one undid with every row, and the model was wrong."""
    c = columns()
    logged(tmp_path, c, "t x y yaw").rename(tmp_path / "pose.csv")
    rows = [(t + late, i, value) for i, (late, side) in enumerate([(0.0, "left"), (2e-4, "right")])
            for t, value in zip(c["t"], c[side], strict=True)]  # fmt: skip
    t, i, value = zip(*sorted(rows), strict=True)
    written(tmp_path / "thrusters.csv", ("t", "id", "value"), t, [str(n) for n in i], value)
    vehicle, recording = read(tmp_path)
    assert vehicle.inputs == ("value_0", "value_1")
    moves_as_the_boat(recording)


@pytest.mark.parametrize("states", ["waypoints", "one that comes and goes"])
def test_a_state_is_no_signals_name(tmp_path, states):
    """Each waypoint has its time; a state has gaps."""
    number = np.floor(T / 5.0) if states == "waypoints" else (T % 5.0 > 2.0) * 1.0
    path = written(tmp_path / "log.csv", ("time", "id", "x"), T, [f"{n:.0f}" for n in number], T)
    (table,) = open_tables(path).values()
    assert table.names == ["time", "id", "x"]
