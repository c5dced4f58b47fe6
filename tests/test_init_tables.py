# SPDX-License-Identifier: MIT
"""`seatrial init` of whole tables: their commands, their files, their clocks."""

import numpy as np
import pytest
import yaml
from init_tools import proposed, refused
from logs import drive

import seatrial
from seatrial.boat.schema import as_column
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices, recognised_text
from seatrial.util.errors import SeatrialError


def drive_half(t, seed):
    rng = np.random.default_rng(seed)
    blocks = (rng.uniform(-1, 1, (3, int(t[-1] / 2) + 2)) > 0) * 1.0
    return (blocks[:, (t / 2).astype(int)].T - 0.5) * 0.9


@pytest.fixture(scope="module")
def log():
    return drive(sticks=drive_half)


def at_poses(log):
    rows = np.searchsorted(log.command_t, log.pose_t, side="right") - 1
    return log.command[rows.clip(0)]


def written(path, names, columns, form="%.12g"):
    np.savetxt(path, np.column_stack(columns), fmt=form, delimiter=",", header=names, comments="")
    return path


def test_pulse_widths_of_a_disarmed_autopilot(log, tmp_path):
    """0 is off, not 3.75 times full astern; the neutral is the pulse of rest."""
    pwm = np.round(1511 + 400 * at_poses(log))
    pwm[:90] = 1511
    pwm[:45] = 0
    path = written(tmp_path / "log.csv", "t,x,y,psi,ch1,ch2,ch3", [log.pose_t, log.pose, pwm])
    found, vehicle = proposed(path)
    inputs = yaml.safe_load(found.text)["commands"]["inputs"]
    for entry in inputs.values():
        assert {k: entry[k] for k in ("offset", "scale", "off")} == {
            "offset": 1511, "scale": 400, "off": 0,
        }  # fmt: skip
    record = seatrial.read(path, vehicle)
    assert (record.commands.values[:45] == 0).all()
    assert np.abs(record.commands.values).max() <= 1.0


def test_the_table_of_signals_is_shown(log, tmp_path, capsys):
    path = written(
        tmp_path / "log.csv", "t,x,y,psi,F_u,F_v,F_r,battery",
        [log.pose_t, log.pose, at_poses(log), np.linspace(25, 24, len(log.pose_t))],
    )  # fmt: skip
    assert (
        seatrial.commands.cli.main(["init", str(path), "-o", str(tmp_path / "v.yaml"), "-q"]) == 0
    )
    shown = capsys.readouterr().out
    head, *rows = shown.split("\n\n")[0].splitlines()
    assert head.split() == ["signal", "column", "how", "sure", "why", "other", "candidates"]
    assert [row.split()[0] for row in rows] == ["x", "y", "heading", "stamps", "stamps", "commands"]
    assert "F_u, F_v, F_r" in rows[-1]
    assert "not used: battery; a signal that scales thrust" in shown
    assert recognised_text(init(path).sources.recognised) == shown.split("\n\n")[0]


def test_commands_that_are_named(log, tmp_path, capsys):
    path = written(
        tmp_path / "log.csv",
        "t,x,y,psi,a,b,c,d",
        [log.pose_t, log.pose, at_poses(log), -log.pose[:, :1]],
    )
    found = init(path, choices=Choices(commands="port=a,starboard=b,bow=c"))
    assert list(found.sources.channels) == ["port", "starboard", "bow"]
    found = init(path, choices=Choices(commands="a,b,c"))
    assert list(found.sources.channels) == ["a", "b", "c"]
    line = refused(capsys, path, "-o", tmp_path / "v.yaml", "--commands", "a,nothing")
    assert "no column nothing (--commands); there are t, x, y, psi, a, b, c, d" in line


def test_one_table_for_each_thruster(log, tmp_path):
    folder = tmp_path / "log"
    folder.mkdir()
    written(folder / "poses.csv", "t,x,y,psi", [log.pose_t, log.pose])
    for i, name in enumerate(("surge", "sway", "yaw")):
        written(folder / f"{name}.csv", "t,data", [log.command_t, log.command[:, i]])
    found, vehicle = proposed(folder)
    inputs = yaml.safe_load(found.text)["commands"]["inputs"]
    assert [e.get("file", "surge.csv") for e in inputs.values()] == [
        "surge.csv", "sway.csv", "yaw.csv",
    ]  # fmt: skip
    record = seatrial.read(folder, vehicle)
    np.testing.assert_allclose(record.commands.values, log.command, atol=1e-9)


@pytest.mark.parametrize("kind", ["parquet", "mat", "mat 7.3"])
def test_other_files_give_the_same_vehicle_and_recording(log, tmp_path, kind):
    names = ("t", "x", "y", "psi", "F_u", "F_v", "F_r")
    columns = dict(
        zip(names, np.column_stack([log.pose_t, log.pose, at_poses(log)]).T, strict=True)
    )
    text = written(tmp_path / "log.csv", ",".join(names), list(columns.values()), "%.17g")
    path = tmp_path / f"log.{kind.split()[0]}"
    if kind == "parquet":
        pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
        pq.write_table(pa.table(columns), path)
    elif kind == "mat":
        pytest.importorskip("scipy.io").savemat(path, columns)
    else:
        with pytest.importorskip("h5py").File(path, "w") as file:
            for name, column in columns.items():
                file[name] = column[None, :]
    expected, (found, vehicle) = init(text), proposed(path)
    assert found.text.splitlines()[1:] == expected.text.splitlines()[1:]
    one, other = seatrial.read(text, vehicle), seatrial.read(path, vehicle)
    np.testing.assert_array_equal(one.eta, other.eta)
    np.testing.assert_array_equal(one.stamps, other.stamps)
    np.testing.assert_array_equal(one.commands.values, other.commands.values)


@pytest.mark.parametrize(
    ("name", "per_second", "unit"), [("t", 1.0, None), ("stamp", 1e3, "ms"), ("time", 1e6, "us")]
)
def test_commands_logged_at_changes_seconds_apart_have_the_unit_of_their_length(
    log, tmp_path, name, per_second, unit
):
    """Their rate alone makes of seconds milliseconds."""
    folder = tmp_path / "log"
    folder.mkdir()
    changes = np.arange(0, len(log.command_t), 150)  # 3 s
    written(folder / "poses.csv", "t,x,y,psi", [log.pose_t, log.pose])
    rows = [per_second * log.command_t[changes], log.command[changes]]
    written(folder / "commands.csv", f"{name},F_u,F_v,F_r", rows)
    _, vehicle = proposed(folder)
    assert as_column(vehicle.file.commands.stamp).unit == unit
    found = seatrial.read(folder, vehicle)
    t = found.seconds(found.commands.stamps)
    np.testing.assert_allclose(t, log.command_t[changes] - log.pose_t[0], atol=1e-6)


@pytest.mark.parametrize(
    ("shift", "scale", "words"),
    [
        (7200.0, 1.0, "commands are 2 h after the poses: one of them is in another time zone"),
        (-19_800.0, 1.0, "commands are 5.5 h before the poses"),
        (0.0, 1000.0, "poses last 89.9. s and commands .*, a factor of 1000: one of them is in another unit"),
        (500.0, 1.0, "check the units of both stamps"),
    ],
)  # fmt: skip
def test_another_time_zone_or_unit_is_named(log, tmp_path, shift, scale, words):
    folder = tmp_path / "log"
    folder.mkdir()
    written(folder / "poses.csv", "t,x,y,psi", [log.pose_t, log.pose])
    written(folder / "commands.csv", "t,F_u,F_v,F_r", [log.command_t * scale + shift, log.command])
    vehicle = seatrial.load_vehicle("mallard-mp")
    with pytest.raises(SeatrialError, match=words):
        seatrial.read(folder, vehicle)


def test_the_stamp_is_no_command_whatever_it_is_called(log, tmp_path):
    """ "TimeS [s]" is a stamp in part by its name; rows of commands have no pose, rows of poses no command."""
    poses = [
        (t, f"{t:.3f},{x:.4f},{y:.4f},{psi:.4f},,,")
        for t, (x, y, psi) in zip(log.pose_t, log.pose, strict=True)
    ]
    sent = [
        (t, f"{t:.3f},,,,{a:.3f},{b:.3f},{c:.3f}")
        for t, (a, b, c) in zip(log.command_t, log.command, strict=True)
    ]
    path = tmp_path / "log.csv"
    rows = [line for _, line in sorted([*poses, *sent])]
    path.write_text("\n".join(["TimeS [s],x,y,psi,F_u,F_v,F_r", *rows]) + "\n")
    text = init(path).text
    assert yaml.safe_load(text)["commands"]["stamp"] == {"column": "TimeS [s]"}
    assert "not used" not in text
