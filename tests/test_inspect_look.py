# SPDX-License-Identifier: MIT
"""Inspect without a vehicle file: topics and columns."""

import re

import numpy as np
import pytest
from init_tools import tables
from inspect_tools import GOOD, said
from logs import EPOCH, JOY, POSE, drive, nanoseconds
from sheets import sheet

from seatrial.io.bags.write import BagTopic, write_bag

# Without a vehicle file. #


def test_the_topics_of_a_bag(look, tmp_path):
    log = drive()
    t = nanoseconds(np.arange(0.0, 90.0, 0.5))
    more = [
        BagTopic(
            "/temperature", "sensor_msgs/msg/Temperature", t, t, {"temperature": np.ones(180)}
        ),
        BagTopic("/lonely", "std_msgs/msg/Float64", t[:1], t[:1], {"data": np.ones(1)}),
    ]
    for kind, name in (("bag", "ROS 1 bag"), ("mcap", "ROS 2 bag"), ("db3", "ROS 2 bag")):
        path = write_bag(tmp_path / f"log.{kind}", [*log.topics(), *more])
        text, found = look(path)
        (bag,) = found["recordings"]
        assert bag["kind"] == name
        assert bag["length"] == pytest.approx(90.0, abs=0.05)
        topics = {x["source"]: x for x in bag["topics"]}
        assert {n: (x["kind"], x["count"], x["role"]) for n, x in topics.items()} == {
            POSE: ("geometry_msgs/PoseStamped", 1350, "poses"),
            JOY: ("sensor_msgs/Joy", 4500, "commands"),
            "/temperature": ("sensor_msgs/Temperature", 180, None),
            "/lonely": ("std_msgs/Float64", 1, "commands"),
        }
        assert topics[JOY]["rate"] == pytest.approx(50.0)
        assert topics[JOY]["delay"]["least"] == pytest.approx(0.001, abs=1e-4)
        for x in topics.values():
            row = next(line for line in text.splitlines() if line.startswith(f"  {x['source']} "))
            assert f" {x['count']} " in row
            assert x["kind"] in row
        assert said(text) == []


def test_clocks_of_a_bag_are_seen_without_a_vehicle_file(look, tmp_path):
    log = drive()
    stamps = log.command_t + np.where(log.command_t > 30.0, -3.0, 0.0)
    text, found = look(log.but(command_t=stamps).write(tmp_path / "log.mcap"))
    assert (
        "/joy: its clock jumps back by 3000 ms against the recorder's 30.0 s after the first"
        in text
    )
    topics = {x["source"]: x for x in found["recordings"][0]["topics"]}
    assert topics[JOY]["delay"]["step"] == pytest.approx(3.0, abs=0.001)


def test_a_bag_without_poses_or_without_anything(look, tmp_path):
    log = drive()
    text, _ = look(write_bag(tmp_path / "joy.bag", log.topics()[1:]))
    assert said(text) == [
        "no topic looks like poses by its type. init takes fields of any type (--pose x=TOPIC/FIELD,...). "
        "docs/recording.md says what to record"
    ]
    for kind in ("bag", "mcap", "db3"):
        text, found = look(write_bag(tmp_path / f"empty.{kind}", []))
        assert found["recordings"][0]["topics"] == []
        assert len(said(text)) == 2
        assert "no topic looks like commands" in text


def test_types_that_are_not_known_are_listed(look, tmp_path):
    """A .db3 has no definitions: of a custom type only the name is known."""
    import sqlite3

    path = drive().write(tmp_path / "log.db3")
    with sqlite3.connect(path) as base:
        base.execute("UPDATE topics SET type = 'boat_msgs/msg/Motors' WHERE name = '/joy'")
    text, found = look(path)
    topics = {x["source"]: x for x in found["recordings"][0]["topics"]}
    assert (topics[JOY]["kind"], topics[JOY]["role"]) == ("boat_msgs/Motors", None)
    assert "boat_msgs/Motors" in text
    assert "no topic looks like commands" in text


def test_the_columns_of_tables(look, tmp_path):
    folder = tmp_path / "log"
    folder.mkdir()
    log = drive()
    t = 1e3 * (log.pose_t + EPOCH * 1e-9)
    sheet(folder / "poses.csv", "stamp,x,y,psi,ok", t, log.pose, np.zeros(1350), form="%.16g")
    rows = zip(log.command_t, log.command[:, 0], strict=True)
    lines = ["t;mode;F_u", *(f"{t};manual;{f}" for t, f in rows)]
    lines[50] = "0.98;;n/a"
    (folder / "sticks.csv").write_text("\n".join(lines) + "\n")
    text, found = look(folder)
    poses, sticks = found["recordings"][0]["tables"]
    columns = {c["name"]: c for c in poses["columns"]}
    assert poses["rows"] == 1350
    assert columns["stamp"]["unit"] == "ms"
    assert columns["x"]["least"] == pytest.approx(log.pose[:, 0].min(), rel=1e-6)
    assert columns["x"]["most"] == pytest.approx(log.pose[:, 0].max(), rel=1e-6)
    assert (columns["ok"]["changes"], columns["x"]["changes"]) == (False, True)
    assert {c["name"]: c["least"] for c in sticks["columns"]}["mode"] is None
    assert "ok     0 to 0; constant" in text
    assert "mode  no numbers" in text
    assert {c["name"]: c["empty"] for c in sticks["columns"]} == {"t": 0, "mode": 4500, "F_u": 1}
    assert re.search(r"F_u +-0.9\d+ to 0.9\d+, 1 without a number", text)
    assert said(text) == []


def test_what_is_known_of_a_recording_in_a_table(look, tmp_path, mp):
    """No arrivals, so no delays; everything else as from a bag."""
    log = drive()
    text, found = look(tables(log, tmp_path / "log"), vehicle="mallard-mp")
    (recording,) = found["recordings"]
    assert recording["verdicts"] == [GOOD]
    assert [s["clock"] for s in recording["streams"]] == ["column of the table"] * 2
    assert [s["delay"] for s in recording["streams"]] == [None, None]
    assert "poses.csv (table): 1350 at 15 Hz" in text
    assert "commands.csv (table): 4500 at 50 Hz" in text
