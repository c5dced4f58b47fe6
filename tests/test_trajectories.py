# SPDX-License-Identifier: MIT
"""Trajectories in the format of TUM, as SLAM writes them, and tables with notes in comments above the rows."""

import numpy as np
import pytest
from init_tools import proposed
from logs import drive, half
from sheets import sheet

import seatrial
from seatrial.io.table import open_tables
from seatrial.util.errors import RecordingError

HEADER = "# timestamp tx ty tz qx qy qz qw"
NOTES = ["# ground truth trajectory", "# https://example.org/1", "# made by me, on a pond"]
ABOVE = {
    "nothing": [], "notes": NOTES, "header": [HEADER], "notes, header": [*NOTES, HEADER],
    "header, notes": [HEADER, *NOTES], "plain header": ["t x y z qx qy qz qw"],
}  # fmt: skip


def quaternions(log, roll=0.01):
    """Unit quaternions x, y, z, w of yaw, after a small roll."""
    half_psi = log.pose[:, 2] / 2
    s, c = np.sin(roll / 2), np.cos(roll / 2)
    return np.column_stack([
        s * np.cos(half_psi), s * np.sin(half_psi), c * np.sin(half_psi), c * np.cos(half_psi)
    ])  # fmt: skip


def trajectory(path, log, above, form="%.9f"):
    """The poses, a line each, below these lines."""
    height = np.random.default_rng(3).normal(0.1, 0.002, len(log.pose))
    rows = np.column_stack([log.pose_t, log.pose[:, :2], height, quaternions(log)])
    np.savetxt(path, rows, fmt=form, header="\n".join(above), comments="")
    return path


def commands(path, log):
    return sheet(path, "t,F_u,F_v,F_r", log.command_t, log.command)


@pytest.mark.parametrize("above", ABOVE)
@pytest.mark.parametrize("name", ["slam.tum", "slam.txt"])
def test_a_trajectory_beside_commands(tmp_path, above, name):
    """With any notes above it: the poses that were written, and the commands of the other table."""
    log, folder = drive(joypad=20.0, sticks=half), tmp_path / "run"
    folder.mkdir()
    trajectory(folder / name, log, ABOVE[above])
    commands(folder / "sticks.csv", log)
    found, vehicle = proposed(folder)
    assert [*vehicle.file.commands.inputs] == ["F_u", "F_v", "F_r"]
    assert "assumed: position" not in found.text
    recording = seatrial.read(folder, vehicle)
    assert len(recording.eta) == len(log.pose)
    np.testing.assert_allclose(recording.eta[:, :2], log.pose[:, :2], atol=1e-8)
    turned = np.angle(np.exp(1j * (recording.eta[:, 2] - log.pose[:, 2])))
    np.testing.assert_allclose(turned, 0.0, atol=1e-6)
    np.testing.assert_allclose(recording.t, log.pose_t, atol=1e-6)


def test_a_trajectory_alone_says_what_is_missing(tmp_path):
    for above in ABOVE.values():
        path = trajectory(tmp_path / "slam.txt", drive(), above)
        with pytest.raises(RecordingError, match="has poses alone, and no commands: put it in a f"):
            proposed(path)


def test_two_trajectories_are_a_question(tmp_path):
    """An estimate and its reference: neither is a take of a motion capture."""
    log, folder = drive(), tmp_path / "run"
    folder.mkdir()
    trajectory(folder / "slam.txt", log, [])
    trajectory(folder / "reference.txt", log, [HEADER])
    commands(folder / "sticks.csv", log)
    with pytest.raises(
        RecordingError, match=r"candidates for the poses: .*slam.txt, reference.txt"
    ):
        proposed(folder)


@pytest.mark.parametrize("form", ["%.9f", "%.3f", "%.18e"])
def test_columns_of_a_trajectory_are_named(tmp_path, form):
    (table,) = open_tables(trajectory(tmp_path / "slam.txt", drive(), [], form)).values()
    assert table.names == ["timestamp", "x", "y", "z", "qx", "qy", "qz", "qw"]
    (remark,) = table.remarks
    assert "a trajectory in the format of TUM" in remark


def odd_rows(kind):
    """Rows (20, k) of eight columns or other numbers of them that are no trajectory."""
    log = drive()
    rows = np.column_stack([log.pose_t, log.pose, quaternions(log)])[:20]
    if kind == "switches":
        rows[:, 4:] = [0, 0, 1, 0]
    if kind == "no unit quaternion":
        rows[:, 4:] *= 1.01
    if kind == "one row is none":
        rows[2, 4:] = 0.3
    return rows[:, :7] if kind == "seven columns" else rows


@pytest.mark.parametrize(
    "kind", ["switches", "no unit quaternion", "one row is none", "seven columns"]
)
def test_other_rows_without_a_header_are_columns_by_number(tmp_path, kind):
    path = tmp_path / "log.txt"
    rows = odd_rows(kind)
    np.savetxt(path, rows)
    (table,) = open_tables(path).values()
    assert table.names == [f"column_{i + 1}" for i in range(rows.shape[1])]


def test_torques_are_no_position(tmp_path):
    """tx and ty without a quaternion: commands of a wrench."""
    log, folder = drive(joypad=20.0, sticks=half), tmp_path / "run"
    folder.mkdir()
    sheet(folder / "poses.csv", "t,x,y,psi", log.pose_t, log.pose)
    still = np.zeros(len(log.command))
    u, v, r = log.command.T
    sheet(
        folder / "wrench.csv",
        "t,fx,fy,fz,tx,ty,tz",
        log.command_t,
        u,
        v,
        still,
        0.01 * v,
        0.01 * u,
        r,
    )
    found, vehicle = proposed(folder)
    assert vehicle.file.pose.x.column == "x"
    assert found.text.index("poses.csv") < found.text.index("wrench.csv")


@pytest.mark.parametrize(
    ("comment", "names"),
    [
        ("t,x,y", ["t", "x", "y"]),
        ("# t,x,y", ["t", "x", "y"]),
        ("# t,x,y\n# pond, west side\n# today", ["t", "x", "y"]),
        ("# pond, west side\n%t,x,y", ["t", "x", "y"]),
        ("# three plain words", ["column_1", "column_2", "column_3"]),
        ("# log 12", ["column_1", "column_2", "column_3"]),
    ],
)
def test_the_comment_that_is_divided_as_the_rows_is_the_header(tmp_path, comment, names):
    path = tmp_path / "log.csv"
    path.write_text(comment + "\n" + "".join(f"{0.1 * i:.1f},{i},{-i}\n" for i in range(20)))
    (table,) = open_tables(path).values()
    assert table.names == names
    np.testing.assert_allclose(table.columns(names)[:, 1], np.arange(20))


def test_notes_below_the_first_row_of_a_table_without_a_header_cost_no_row(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("0.0,7,1\n# pond, today\n# west\n0.1,8,2\n0.2,9,3\n")
    (table,) = open_tables(path).values()
    np.testing.assert_allclose(table.columns(table.names), [[0, 7, 1], [0.1, 8, 2], [0.2, 9, 3]])


def test_a_height_is_no_command_where_y_is_up(tmp_path):
    """Of a game engine, commands in the same table; the height bobs."""
    log = drive(joypad=15.0, sticks=half)
    x, y, z, w = quaternions(log).T
    bob = 0.02 * np.sin(1.3 * log.pose_t)
    at = np.searchsorted(log.command_t, log.pose_t, side="right") - 1
    path = sheet(
        tmp_path / "log.csv", "t,x,y,z,qx,qy,qz,qw,F_u,F_v,F_r",
        log.pose_t, log.pose[:, 0], bob, -log.pose[:, 1], y, z, x, w, log.command[at],
    )  # fmt: skip
    _, vehicle = proposed(path)
    assert [*vehicle.file.commands.inputs] == ["F_u", "F_v", "F_r"]
