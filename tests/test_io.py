# SPDX-License-Identifier: MIT
"""CSV as people have it: other names, units, delimiters; and what goes wrong with it."""

from pathlib import Path

import numpy as np
import pytest

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.io.reader import recording_name, recording_names
from seatrial.util.errors import SeatrialError

T = np.arange(0, 20, 1 / 15)
POSE = np.column_stack([T, 0.5 * np.sin(0.4 * T), 0.3 * np.cos(0.5 * T), 0.6 * T])
STICKS = np.column_stack([np.arange(0, 20, 0.01), np.sign(np.sin(np.arange(0, 20, 0.01)))])


def vehicle(**changes) -> seatrial.Vehicle:
    content = seatrial.load_vehicle("mallard-mp").to_mapping()
    for key, value in changes.items():
        content[key] = value
    return vehicle_from(content, "vehicle.yaml")


def folder(path: Path, poses: str | None = None, commands: str | None = None) -> Path:
    path.mkdir(exist_ok=True)
    rows = "\n".join(",".join(f"{x:.6f}" for x in row) for row in POSE)
    sticks = "\n".join(f"{t:.3f},{s:.1f},0,0" for t, s in STICKS)
    (path / "poses.csv").write_text(f"t,x,y,psi\n{rows}\n" if poses is None else poses)
    (path / "commands.csv").write_text(
        f"t,F_u,F_v,F_r\n{sticks}\n" if commands is None else commands
    )
    return path


def test_two_tables_at_their_own_rates_stay_asynchronous(tmp_path):
    record = seatrial.read(folder(tmp_path / "run"), vehicle())
    assert len(record.stamps) == len(T)
    assert len(record.commands.stamps) == len(STICKS)
    assert record.name == "run"
    assert [s.name for s in record.sources] == ["poses.csv", "commands.csv"]
    assert all(len(s.sha256) == 64 for s in record.sources)


@pytest.mark.parametrize(
    ("name", "recording"),
    [
        ("run.1.csv", "run.1"),
        ("LOG00012", "LOG00012"),  # an autopilot's log is known by its content
        (".bag", ".bag"),
        ("run.bag.active", "run"),
        ("run.mcap.zstd", "run"),
    ],
)
def test_a_recording_has_the_name_of_its_file(tmp_path, name, recording):
    (tmp_path / name).touch()
    assert recording_name(tmp_path / name) == recording


@pytest.mark.parametrize(
    ("paths", "names"),
    [
        (["a/run.csv", "b/other.csv"], ["run", "other"]),
        (["a/run.csv", "b/run.csv", "b/other.csv"], ["a/run.csv", "b/run.csv", "other"]),
        (["run.csv", "run.bag"], ["run.csv", "run.bag"]),
        (["a/x/run", "b/x/run", "b/y/run"], ["a/x/run", "b/x/run", "y/run"]),
        (["a/run", "a/run"], ["run", "run"]),  # one log, which is refused elsewhere
        (["/run", "/a/run"], ["run", "a/run"]),
    ],
)
def test_recordings_of_one_name_are_told_apart_by_folders(paths, names):
    assert recording_names([Path(path) for path in paths]) == names


def test_units_signs_scales_and_offsets_are_applied(tmp_path):
    rows = "\n".join(
        f"{t * 1000:.3f};{x * 1000:.3f};{-y * 100:.4f};{np.rad2deg(p):.5f}" for t, x, y, p in POSE
    )
    sticks = "\n".join(f"{t * 1e9:.0f}\t{1500 + 400 * s:.0f}" for t, s in STICKS)
    path = folder(tmp_path / "run", f"ms;X [mm];Y;yaw\n{rows}\n", f"ns\tpwm\n{sticks}\n")
    v = vehicle(
        pose={
            "stamp": {"column": "ms", "unit": "ms"}, "x": {"column": "X [mm]", "unit": "mm"},
            "y": {"column": "Y", "unit": "cm", "sign": -1}, "psi": {"column": "yaw", "unit": "deg"},
        },
        commands={
            "stamp": {"column": "ns", "unit": "ns"},
            "inputs": {
                "F_u": {"column": "pwm", "offset": 1500, "scale": 400},
                "F_v": {"column": "pwm", "offset": 1500, "scale": 800, "sign": -1},
                "F_r": {"column": "pwm", "offset": 1500, "scale": 400},
            },
        },
    )  # fmt: skip
    record = seatrial.read(path, v)
    np.testing.assert_allclose(record.eta, POSE[:, 1:], atol=2e-6)
    np.testing.assert_allclose(record.t, T, atol=1e-6)
    np.testing.assert_allclose(record.commands.values[:, 0], STICKS[:, 1], atol=1e-12)
    np.testing.assert_allclose(record.commands.values[:, 1], -STICKS[:, 1] / 2, atol=1e-12)


def test_an_empty_cell_among_the_poses_is_a_pose_left_out(tmp_path):
    path = folder(tmp_path / "run")
    lines = (path / "poses.csv").read_text().splitlines()
    lines[50] = lines[50].split(",")[0] + ",,,"
    (path / "poses.csv").write_text("\n".join(lines))
    record = seatrial.read(path, vehicle())
    assert np.flatnonzero(~record.valid).tolist() == [49]


def text(rows: str) -> str:
    return "t,x,y,psi\n" + rows


@pytest.mark.parametrize(
    ("poses", "commands", "words"),
    [
        ("", None, "poses.csv: is empty"),
        ("t,x,y,psi\n", None, "has a header but no rows"),
        (text("0,1,2,3\n1,2,x,4\n"), None, "line 3: column 'y' has 'x', expected a number"),
        (text("0,1,2,3,4\n"), None, "line 2: 5 cells, expected 4; name every column"),
        (text("0,1,2,3\n1,2\n"), None, "line 3: 2 cells, expected 4; is the file cut off"),
        ("t,x,y,yaw\n0,1,2,3\n", None, r"no column 'psi'\. It has: t, x, y, yaw"),
        ("t,x,y,psy\n0,1,2,3\n", None, "did you mean 'psy'"),
        ("t,x,x,psi\n0,1,2,3\n", None, "column 'x' is twice|no column 'y'"),
        (text("0,1,2,3\n"), None, "1 poses"),
        (text("nan,1,2,3\n1,1,2,3\n"), None, "line 2: column 't' has no stamp"),
        (text("1700000000000000000,1,2,3\n1700000000100000000,1,2,3\n"), None, "is its unit ms, us or ns"),
        (text("0,nan,2,3\n" * 5), None, "0 usable poses of 5, most not a number"),
        (None, "t,F_u,F_v,F_r\n0,0,0,nan\n", "line 2: 'F_r' is empty or not finite"),
        (None, "t,F_u,F_v\n0,0,0\n", "no column 'F_r'"),
        (None, "t,F_u,F_v,F_r\n", "has a header but no rows"),
    ],
)  # fmt: skip
def test_a_bad_table_is_one_line_that_names_the_place(tmp_path, poses, commands, words):
    path = folder(tmp_path / "run", poses, commands)
    with pytest.raises(SeatrialError, match=words) as caught:
        seatrial.read(path, vehicle())
    assert "\n" not in str(caught.value)


def test_missing_and_foreign_files_say_what_was_expected(tmp_path):
    with pytest.raises(SeatrialError, match="no such file or folder"):
        seatrial.read(tmp_path / "none", vehicle())
    (tmp_path / "empty").mkdir()
    with pytest.raises(SeatrialError, match=r"is an empty folder"):
        seatrial.read(tmp_path / "empty", vehicle())
    (tmp_path / "a.png").write_bytes(b"PNG")
    with pytest.raises(SeatrialError, match=r"expected a bag .*, a table \(\.csv"):
        seatrial.read(tmp_path / "a.png", vehicle())
    path = folder(tmp_path / "run")
    (path / "poses.csv").write_bytes(bytes(range(256)) * 10)
    with pytest.raises(SeatrialError, match=r"not a CSV text file|no column"):
        seatrial.read(path, vehicle())


def test_a_wrong_unit_is_refused_not_guessed(tmp_path):
    path = folder(tmp_path / "run")
    wrong = vehicle(
        pose={"stamp": "t", "x": {"column": "x", "unit": "rad"}, "y": "y", "psi": "psi"}
    )
    with pytest.raises(SeatrialError, match="unit 'rad'; use m, cm, mm"):
        seatrial.read(path, wrong)
    wrong = vehicle(pose={"stamp": {"column": "t", "unit": "m"}, "x": "x", "y": "y", "psi": "psi"})
    with pytest.raises(SeatrialError, match="use s, ms, us or ns"):
        seatrial.read(path, wrong)


def test_merged_logs_with_empty_cells_are_two_signals(tmp_path):
    rows = [f"{t:.6f},{x:.6f},{y:.6f},{p:.6f},,," for t, x, y, p in POSE]
    rows += [f"{t:.6f},,,,{s:.1f},0,0" for t, s in STICKS]
    rows.sort(key=lambda row: float(row.split(",")[0]))
    (tmp_path / "merged.csv").write_text("t,x,y,psi,F_u,F_v,F_r\n" + "\n".join(rows))
    record = seatrial.read(tmp_path / "merged.csv", vehicle())
    apart = seatrial.read(folder(tmp_path / "run"), vehicle())
    np.testing.assert_allclose(record.eta, apart.eta, atol=1e-6)
    np.testing.assert_allclose(record.commands.values, apart.commands.values)
    assert record.faults == apart.faults == ()


def test_direct_thrusters_are_matched_by_name(tmp_path):
    three = {
        "port": {"x": -0.3, "y": 0.2, "angle_deg": 0}, "starboard": {"x": -0.3, "y": -0.2, "angle_deg": 0},
        "bow": {"x": 0.4, "y": 0.0, "angle_deg": 90},
    }  # fmt: skip

    def with_inputs(*names):
        commands = {"stamp": "t", "inputs": {n: n for n in names}}
        return vehicle(thrusters=three, commands=commands, allocation={"scheme": "direct"})

    first, second = with_inputs("port", "starboard", "bow"), with_inputs("starboard", "port", "bow")
    np.testing.assert_allclose(first.mix[:, [1, 0, 2]], second.mix)
    with pytest.raises(
        SeatrialError, match="inputs must be the thrusters port, starboard, bow; got left"
    ):
        with_inputs("left", "right", "front")
    with pytest.raises(SeatrialError, match=r"write allocation: \{scheme: moore-penrose\}"):
        with_inputs("F_u", "F_v", "F_r")


def spaced(start: float, end: float, step: float = 0.05) -> str:
    times = np.arange(start, end, step)
    return "t,F_u,F_v,F_r\n" + "\n".join(f"{t:.3f},{np.sign(np.sin(t)):.1f},0,0" for t in times)


@pytest.mark.parametrize(("start", "end"), [(500.0, 520.0), (-520.0, -500.0), (1.7e9, 1.7e9 + 20)])
def test_commands_of_another_time_are_refused(tmp_path, start, end):
    path = folder(tmp_path / "run", None, spaced(start, end))
    with pytest.raises(SeatrialError, match="poses and commands do not overlap: commands run from"):
        seatrial.read(path, vehicle())


def test_poses_without_commands_are_left_out(tmp_path):
    hole = spaced(4.0, 8.0) + "\n" + spaced(11.0, 16.0).split("\n", 1)[1]
    record = seatrial.read(folder(tmp_path / "run", None, hole), vehicle())
    kept = record.t[record.valid]
    assert not np.any((kept < 3.99) | ((kept > 8.06) & (kept < 10.99)) | (kept > 16.06))
    assert len(kept) == pytest.approx(9.1 * 15, abs=3)
    assert [f.kind.name for f in record.faults] == ["SILENT"] * 3


def test_a_log_written_on_changes_only_is_not_silent(tmp_path):
    changes = "t,F_u,F_v,F_r\n-1,0,0,0\n1,0.5,0,0\n1.2,0.7,0,0\n9,0,0,0\n12,-1,0,0\n"
    record = seatrial.read(folder(tmp_path / "run", None, changes), vehicle())
    assert record.valid.all()
    assert record.faults == ()


def test_more_inputs_than_the_core_has_room_for_are_refused():
    inputs = {f"c{i}": f"c{i}" for i in range(9)}
    with pytest.raises(SeatrialError, match="9 inputs and 9 actuators; at most 8"):
        vehicle(
            commands={"stamp": "t", "inputs": inputs}, thrusters={}, allocation={},
            forces={"F_u": {"axis": "surge", "of": {"c0": 1.0}}},
            structure={"surge": ["X_F * F_u"], "sway": ["Y_v * v"], "yaw": ["N_r * r"]},
        )  # fmt: skip
