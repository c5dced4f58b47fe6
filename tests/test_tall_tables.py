# SPDX-License-Identifier: MIT
"""Tables whose rows are of several signals, as a column tells: one column for each."""

import json

import numpy as np
import pytest

from seatrial.io.table import open_tables
from seatrial.io.tables.signals import stamps_of_one
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


@pytest.mark.parametrize("clocks", [False, True])
def test_events_of_several_kinds(tmp_path, clocks):
    """A value that one kind has keeps its name; one kind's own clock is no clock of the others.

    A heading in other rows than the positions' has its sense by the motion: yaw is clockwise from north here.
    """
    c = columns(rate=10.0)
    kinds = {
        "GPS": (0.0, ("east", "north")),
        "ATT": (0.002, ("yaw",)),
        "SERVO": (0.004, ("left", "right")),
    }
    values = c | {"yaw": np.pi / 2 - c["psi"]}
    events = []
    for kind, (late, names) in kinds.items():
        rows = zip(c["t"], *(values[n] for n in names), strict=True)
        for t, *own in rows:
            data = dict(
                zip([{"east": "x", "north": "y"}.get(n, n) for n in names], own, strict=True)
            )
            clock = {"time_ms": round(1e3 * t)} if clocks and kind == "GPS" else {}
            events.append({"meta": {"type": kind, "timestamp": t + late}, "data": data | clock})
    events.sort(key=lambda e: e["meta"]["timestamp"])
    path = tmp_path / "log.jsonl"
    path.write_text("\n".join(map(json.dumps, events)))
    vehicle, recording = read(path)
    assert vehicle.inputs == ("data_left", "data_right")
    assert (vehicle.file.pose.stamp.column, vehicle.file.pose.psi.sign) == ("meta.timestamp", -1)
    moves_as_the_boat(recording, slack=0.05)


def test_channels_in_turn_have_the_rate_of_one():
    """Their rows together count half a period, by which changes of samples were taken too late."""
    first = np.arange(0, 10**10, 10**8)
    stamps = np.sort(np.concatenate([first, first + 10**6]))
    given = np.array([stamps % 10**8 == 0, stamps % 10**8 != 0]).T
    np.testing.assert_array_equal(stamps_of_one(stamps, given), first)
    np.testing.assert_array_equal(stamps_of_one(stamps, np.ones_like(given)), stamps)


@pytest.mark.parametrize("states", ["waypoints", "one that comes and goes"])
def test_a_state_is_no_signals_name(tmp_path, states):
    """Each waypoint has its time; a state has gaps."""
    number = np.floor(T / 5.0) if states == "waypoints" else (T % 5.0 > 2.0) * 1.0
    path = written(tmp_path / "log.csv", ("time", "id", "x"), T, [f"{n:.0f}" for n in number], T)
    (table,) = open_tables(path).values()
    assert table.names == ["time", "id", "x"]
