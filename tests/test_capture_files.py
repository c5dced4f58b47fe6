# SPDX-License-Identifier: MIT
"""Files of motion-capture systems that are none, damaged or odd: one line that says why, or the table as ever."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from capture_logs import body, commands, far, minute, motive, qualisys, vicon
from cli_tools import refused

import seatrial
from seatrial.io.table import open_tables
from seatrial.util.errors import RecordingError


@pytest.fixture(scope="module")
def log():
    return minute()


def test_begins_that_can_not_be_read(log, tmp_path):
    """AM and PM in another language: stated, and not used."""
    path = motive(
        tmp_path / "take.csv", log.pose_t, [body("boat", log.pose)], begun="2023-11-28 10.27.58.765 DU."
    )  # fmt: skip
    (table,) = open_tables(path).values()
    assert "Capture Time" not in table.names
    assert any("'2023-11-28 10.27.58.765 DU.' is in no known format" in r for r in table.remarks)


def test_a_take_alone(log, tmp_path):
    """Without commands: where they belong."""
    path = motive(tmp_path / "take.csv", log.pose_t, [body("boat", log.pose)])
    with pytest.raises(
        RecordingError, match="has poses alone, and no commands: put it in a folder"
    ):
        seatrial.init(path)


REFUSED = {
    "markers": (lambda p, t, b: motive(p, t, [], markers=18), "no rigid body with position and rotation but 18 markers"),
    "local": (partial(motive, space="Local"), "Coordinate Space is Local"),
    "feet": (lambda p, t, b: _changed(motive(p, t, b), "Meters", "Feet"), "unit of lengths is 'Feet'"),
    "order": (lambda p, t, b: _changed(motive(p, t, b, rotation="XYZ"), "Type,XYZ", "Type,XYX"), "Rotation Type is 'xyx'"),
    "never seen": (lambda p, t, b: motive(p, t, [replace(b[0], seen=b[0].seen & False)]), "boat is seen in none of 1800 rows"),
    "devices": (lambda p, t, b: p.write_text("Devices\n100\n,,plate\nFrame,Sub Frame,Fx\n,,N\n1,0,2\n\n" + vicon(p, 30, b).read_text()),
                "in its first table, Devices"),
    "trajectories": (lambda p, t, b: _changed(vicon(p, 30, b), "Segments", "Trajectories", "R", "Q"), "make an object"),
    "3D": (lambda p, t, b: _changed(qualisys(p, 30, b), "Roll", "Q", "Rot[0]", "Q"), "has no rigid body"),
    "no columns": (lambda p, t, b: p.write_text("NO_OF_FRAMES\t7\nDATA_INCLUDED\t3D\n1.0\t2.0\n"), "export 6DOF data"),
    "no rate": (lambda p, t, b: _changed(qualisys(p, 30, b, time=False), "FREQUENCY\t30", "FREQUENCY\tEXT"),
                "the frame rate is 'EXT', not a number"),
    "columns": (lambda p, t, b: p.write_text(f"Format Version,1.23,Take Name,a\n,Name\nFrame,{'X,' * 20_000}\n"), "of at most 16384"),
    "bodies": (lambda p, t, b: motive(p, t[:3], [body(f"b{i}", b[0].place[:3]) for i in range(65)], markers=0),
               "65 rigid bodies, of at most 64"),
    "cut off": (lambda p, t, b: p.write_text(motive(p, t, b).read_text()[:5000].rpartition(",")[0].rpartition("\n")[0] + "\n8,0.2,0.1"),
                "3 cells, expected 22; is the file cut off?"),
}  # fmt: skip


def _changed(path, *pairs):
    text = path.read_text()
    for old, new in zip(pairs[::2], pairs[1::2], strict=True):
        text = text.replace(old, new)
    path.write_text(text)


@pytest.mark.parametrize("kind", REFUSED)
def test_refused_in_one_line(kind, log, tmp_path, capsys):
    """What was found, and what to do."""
    write, said = REFUSED[kind]
    write(tmp_path / "take.csv", log.pose_t, [body("boat", log.pose)])
    assert said in refused(capsys, "inspect", tmp_path / "take.csv")


def test_hostile_names(log, tmp_path):
    """Names of bodies come out printable, short and different."""
    names = ["../a/b", "../a\\b", "x" * 300, "x" * 301, "tab\x0bed", "a\u202eb"]
    bodies = [body(name, log.pose[:5], seed=i) for i, name in enumerate(names)]
    tables = open_tables(motive(tmp_path / "take.csv", log.pose_t[:5], bodies, markers=0))
    assert len(tables) == len(names)
    assert all(name.isprintable() and "/" not in name and len(name) < 50 for name in tables)


def test_a_marker_with_the_name_of_the_body(log, tmp_path):
    """The body's position is its own, whichever comes first."""
    path, pose = tmp_path / "take.csv", far(log.pose)[:50]
    motive(path, log.pose_t[:50], [body("Otter", pose)], up="z", markers=0, error=False)
    lines = [line.split(",") for line in path.read_text().splitlines()]
    for i, extra in enumerate(("Marker", "Otter", "7", "Position"), 2):
        lines[i][2:2] = [extra] * 3
    lines[6][2:2] = "XYZ"
    for row in lines[7:]:
        row[2:2] = ["9.0", "9.0", "9.0"]
    path.write_text("\n".join(map(",".join, lines)))
    (table,) = open_tables(path).values()
    assert table.name == "Otter"
    np.testing.assert_allclose(table.columns(["Position X", "Position Y"]), pose[:, :2], atol=1e-5)


PLAIN = (  # text, names of its columns
    ("Format Version,t,x\n1,0.0,1\n1,0.1,2\n", ["Format Version", "t", "x"]),
    ("Format Version,1.0\nt,x,y\n0,1,2\n1,2,3\n", ["t", "x", "y"]),
    ("Objects\n1\n2\n3\n", ["Objects"]),
    ("Objects,t\n1,0.0\n2,0.1\n", ["Objects", "t"]),
    ("Segments\n3\nFrame,x\n0,1\n1,2\n2,3\n", ["Frame", "x"]),
    ("NO_OF_FRAMES,t\n1,0.0\n2,0.1\n", ["NO_OF_FRAMES", "t"]),
    ("FILE_VERSION\t1\nt\tx\n0\t1\n1\t2\n", ["FILE_VERSION", "1"]),
    ("Frame,Time,x\n1,0.0,2\n2,0.1,3\n", ["Frame", "Time", "x"]),
)


@pytest.mark.parametrize(("text", "names"), PLAIN)
def test_tables_that_begin_as_exports(text, names, tmp_path):
    """One word in common is no export: the table is read as ever."""
    path = tmp_path / "log.csv"
    path.write_text(text)
    (table,) = open_tables(path).values()
    assert table.names == names


def test_exports_that_a_spreadsheet_saved(log, tmp_path):
    """QTM's with commas and lines of one length; Motive's with semicolons and decimal commas."""
    path, pose = tmp_path / "take.csv", far(log.pose)[:50]
    for mark in ",;":
        if mark == ",":
            text = qualisys(path, 30, [body("Otter", pose)]).read_text().replace(", ", " ")
            lines = [line.replace("\t", ",") for line in text.splitlines()]
            text = "\n".join(line + "," * (20 - line.count(",")) for line in lines)
        else:
            text = motive(path, log.pose_t[:50], [body("Otter", pose)], up="z").read_text()
            text = text.replace(",", ";").replace(".", ",")
        path.write_text(text)
        (table,) = open_tables(path).values()
        np.testing.assert_allclose(
            table.columns(["Position X", "Position Y"]), pose[:, :2], atol=1e-5
        )


def test_takes_one_after_the_other(log, tmp_path):
    """Two takes in one folder: each belongs into its own."""
    for i in (1, 2):
        motive(tmp_path / f"take{i}.csv", log.pose_t, [body("boat", far(log.pose))], markers=0)
    commands(log, tmp_path)
    with pytest.raises(
        RecordingError, match=r"2 takes: take1\.csv, take2\.csv; put each into a folder"
    ):
        seatrial.init(tmp_path)
