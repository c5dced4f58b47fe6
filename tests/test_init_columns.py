# SPDX-License-Identifier: MIT
"""Which columns of a table are the boat's signals: headers of many logs, and what their values say."""

import numpy as np
import pytest
import yaml
from init_tools import refused
from logs import drive

import seatrial
from seatrial.boat.schema import as_column
from seatrial.inspection.proposal.columns.pose import choose_pose
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices, Sureness, recognised_text
from seatrial.io.columns import read_tables
from seatrial.util.errors import SeatrialError

RATE = 20.0  # [Hz]
T = np.arange(0.0, 40.0, 1 / RATE)
PSI = 0.9 * np.sin(0.31 * T) + 0.25 * T  # [rad] counter-clockwise from east
SPEED = 0.5 + 0.3 * np.sin(0.2 * T)  # [m/s] forward
EAST = np.cumsum(SPEED * np.cos(PSI)) / RATE
NORTH = np.cumsum(SPEED * np.sin(PSI)) / RATE
WRAPPED = (PSI + np.pi) % (2 * np.pi) - np.pi
COMPASS = (90 - np.degrees(PSI)) % 360  # [deg]
LAT, LON = 63.4 + NORTH / 111_000, 10.3 + EAST / (111_000 * np.cos(np.radians(63.4)))
STICK = np.sign(np.sin(0.5 * T))
VALUES = {
    "x": EAST, "y": NORTH, "psi": WRAPPED, "compass": COMPASS, "lat": LAT, "lon": LON, "t": T, "u": STICK,
    "rate": np.gradient(PSI, T), "zero": 0 * T, "qz": np.sin(PSI / 2), "qw": np.cos(PSI / 2),
    "secs": 1_744_366_094 + np.floor(T), "nsecs": np.round((T % 1) * 1e9), "ms": 1e3 * (T + 1_744_366_094),
    "e7lat": np.round(1e7 * LAT), "e7lon": np.round(1e7 * LON), "z": 0.001 * np.sin(T), "clockwise": -WRAPPED,
}  # fmt: skip


def table(path, names):
    """A table whose columns `NAME=VALUES` have these names and values."""
    pairs = [name.rpartition("=")[::2] for name in names.split("|")]
    rows = np.column_stack([VALUES[value] for _, value in pairs])
    head = ",".join(name for name, _ in pairs)
    np.savetxt(path, rows, fmt="%.12g", delimiter=",", header=head, comments="")
    return path


def pose_of(path, axes="forward-left-up", pose=None, ask=None):
    return choose_pose(path, read_tables(path), Choices(axes=axes, pose=pose), ask)


PLAIN = {"sign": 1, "offset": 0}
HEADERS = {
    "t=t|x=x|y=y|psi=psi|u=u": ("x", "y", "psi", {}),
    "Time [s]=t|X [m]=x|Y [m]=y|Yaw [rad]=psi": ("X [m]", "Y [m]", "Yaw [rad]", {}),
    "time=t|pos.x(m)=x|pos.y(m)=y|pos.z(m)=z|heading=psi": ("pos.x(m)", "pos.y(m)", "heading", {}),
    "stamp=t|posX=x|posY=y|yaw_deg=compass": ("posX", "posY", "yaw_deg", {"unit": "deg", "sign": -1, "offset": 90}),
    "t=t|gps_x=x|gps_y=y|ref_x=u|ref_y=u|ref_heading=u|imu_yaw=psi": ("gps_x", "gps_y", "imu_yaw", {}),
    "t=t|x=x|y=y|theta=psi|roll=z": ("x", "y", "theta", {}),
    "t=t|duck_x=x|duck_y=y|duck_psi=psi": ("duck_x", "duck_y", "duck_psi", {}),
    "t=t|E=x|N=y|hdg=compass": ("E", "N", "hdg", {"unit": "deg", "sign": -1, "offset": 90}),
    "t=t|easting=x|northing=y|Heading (°)=compass": (
        "easting", "northing", "Heading (°)", {"unit": "deg", "sign": -1, "offset": 90},
    ),
    "t=t|x_ned=y|y_ned=x|yaw_ned_rad=compass_rad": ("y_ned", "x_ned", "yaw_ned_rad", {"sign": -1, "offset": 1.570796327}),
    "t=t|utm_x=x|utm_y=y|compass=compass": ("utm_x", "utm_y", "compass", {"unit": "deg", "sign": -1, "offset": 90}),
    "t=t|utm_x=x|utm_y=y|yaw=psi": ("utm_x", "utm_y", "yaw", {}),
    "t=t|x=x|y=y|cog=compass|heading=compass": ("x", "y", "heading", {"unit": "deg", "sign": -1, "offset": 90}),
}  # fmt: skip
VALUES["compass_rad"] = np.radians(COMPASS)


@pytest.mark.parametrize("names", HEADERS)
def test_position_and_heading_of_many_headers(tmp_path, names):
    first, second, heading, entry = HEADERS[names]
    found = pose_of(table(tmp_path / "log.csv", names)).entries
    assert (found["x"]["column"], found["y"]["column"]) == (first, second)
    assert found["psi"] == {"column": heading} | entry


@pytest.mark.parametrize("names", [n for n in HEADERS if "compass" in n])
def test_the_heading_is_counter_clockwise_from_x_whatever_the_log_has(tmp_path, names):
    """As the file's column gives it: sign (raw - offset) in its unit is psi."""
    path = table(tmp_path / "log.csv", names)
    found = pose_of(path).entries["psi"]
    raw = read_tables(path)[0].numbers(found["column"])
    unit = np.pi / 180 if found.get("unit") == "deg" else 1.0
    psi = found.get("sign", 1) * (raw - found.get("offset", 0.0)) * unit
    np.testing.assert_allclose(np.exp(1j * psi), np.exp(1j * PSI), atol=1e-6)


def test_latitude_and_longitude_with_a_compass(tmp_path):
    path = table(tmp_path / "log.csv", "timestamp_ms=ms|Lat=lat|Lng=lon|cog=u|yaw=compass|ch1=u")
    found = pose_of(path)
    assert "x" not in found.entries
    assert found.entries["stamp"] == {"column": "timestamp_ms", "unit": "ms"}
    assert found.entries["latitude"] == {"column": "Lat"}
    assert found.entries["longitude"] == {"column": "Lng"}
    assert found.entries["origin"] == [round(LAT[0], 6), round(LON[0], 6)]
    assert found.entries["psi"] == {"column": "yaw", "unit": "deg", "sign": -1, "offset": 90}
    sure = {r.signal: r.sure for r in found.recognised}
    assert set(sure.values()) == {Sureness.CERTAIN}  # the boat moves along its heading
    right = pose_of(path, axes="forward-right-down").entries
    assert right["psi"] == {"column": "yaw", "unit": "deg"}


def test_whole_numbers_of_latitude_have_a_scale(tmp_path):
    path = table(tmp_path / "log.csv", "t=t|lat=e7lat|lon=e7lon|yaw=psi")
    found = pose_of(path).entries
    assert found["latitude"] == {"column": "lat", "scale": 1e7}
    assert found["psi"] == {"column": "yaw"}  # by the motion it is counter-clockwise from east


def test_north_and_east_change_places_with_the_axes(tmp_path):
    path = table(tmp_path / "log.csv", "t=t|east=x|north=y|heading=compass")
    left = pose_of(path)
    assert [left.entries[k]["column"] for k in ("x", "y")] == ["east", "north"]
    assert left.entries["psi"] == {"column": "heading", "unit": "deg", "sign": -1, "offset": 90}
    right = pose_of(path, axes="forward-right-down")
    assert [right.entries[k]["column"] for k in ("x", "y")] == ["north", "east"]
    assert right.entries["psi"] == {"column": "heading", "unit": "deg"}


@pytest.mark.parametrize(
    "prefix", ["q{}", "pose_orientation_{}", "field.pose.pose.orientation.{}", "quat[{}]"]
)
def test_a_quaternion_is_a_heading(tmp_path, prefix):
    parts = dict(zip("xyzw", ("zero", "zero", "qz", "qw"), strict=True))
    names = "|".join(f"{prefix.format(k)}={v}" for k, v in parts.items())
    path = table(tmp_path / "log.csv", f"t=t|pose_position_x=x|pose_position_y=y|{names}")
    found = pose_of(path).entries
    assert found["psi"] == {"quaternion": [prefix.format(k) for k in "xyzw"]}
    assert found["x"] == {"column": "pose_position_x"}


def test_of_q0_to_q3_the_first_is_w(tmp_path):
    path = table(tmp_path / "log.csv", "t=t|x=x|y=y|q0=qw|q1=zero|q2=zero|q3=qz")
    assert pose_of(path).entries["psi"] == {"quaternion": ["q1", "q2", "q3", "q0"]}


STAMPS = {
    "header_stamp_secs=secs|header_stamp_nsecs=nsecs|time=t": {"column": "header_stamp_secs", "nanoseconds": "header_stamp_nsecs"},
    "secs=secs|nsecs=nsecs": {"column": "secs", "nanoseconds": "nsecs"},
    "header.stamp.sec=secs|header.stamp.nanosec=nsecs": {"column": "header.stamp.sec", "nanoseconds": "header.stamp.nanosec"},
    "TimeUS=ms": {"column": "TimeUS", "unit": "us"},
    "time_boot_ms=ms": {"column": "time_boot_ms", "unit": "ms"},
    "rosbagTimestamp=t": {"column": "rosbagTimestamp"},
    "t_capture=t|seq=t": {"column": "t_capture"},
    "elapsed [s]=t": {"column": "elapsed [s]"},
    "ms=ms": {"column": "ms", "unit": "ms"},
    "ticks=t": {"column": "ticks"},
}  # fmt: skip


@pytest.mark.parametrize("names", STAMPS)
def test_stamps_of_many_headers(tmp_path, names):
    path = table(tmp_path / "log.csv", f"{names}|x=x|y=y|psi=psi")
    assert pose_of(path).entries["stamp"] == STAMPS[names]


def test_a_gyro_is_used_and_an_estimate_is_mentioned(tmp_path):
    path = table(tmp_path / "log.csv", "t=t|x=x|y=y|psi=psi|gyro_z=rate|r=rate")
    found = pose_of(path)
    assert found.entries["yaw_rate"] == {"column": "gyro_z"}
    VALUES["down"] = -np.degrees(VALUES["rate"])
    path = table(tmp_path / "log.csv", "t=t|x=x|y=y|psi=psi|imu.gyro.z=down")
    assert pose_of(path).entries["yaw_rate"] == {"column": "imu.gyro.z", "unit": "deg", "sign": -1}
    path = table(tmp_path / "log.csv", "t=t|x=x|y=y|psi=psi|r=rate")
    found = pose_of(path)
    assert "yaw_rate" not in found.entries
    assert found.notes["yaw_rate"][0] == "yaw_rate: r"
    path = table(tmp_path / "log.csv", "t=t|x=x|y=y|psi=psi|gyro_z=u")  # another signal
    assert "yaw_rate" not in pose_of(path).entries


def test_signals_of_several_tables_have_their_file(tmp_path):
    folder = tmp_path / "log"
    folder.mkdir()
    table(folder / "gps.csv", "t=t|lat=lat|lon=lon")
    table(folder / "imu.csv", "stamp=t|heading=compass|gyro_z=rate")
    table(folder / "motors.csv", "t=t|left=u|right=u")
    found = pose_of(folder)
    assert found.entries["file"] == "gps.csv"
    assert found.entries["psi"] == {
        "column": "heading", "unit": "deg", "sign": -1, "offset": 90, "file": "imu.csv", "stamp": "stamp",
    }  # fmt: skip
    assert found.entries["yaw_rate"] == {"column": "gyro_z", "file": "imu.csv", "stamp": "stamp"}


def test_a_coordinate_that_hardly_moves_is_named_and_asked_about(tmp_path):
    path = table(tmp_path / "log.csv", "t=t|x=x|y=z|z=y|psi=psi")
    with pytest.raises(
        SeatrialError, match=r"y ranges over 0\.002 m, z over 12 m: y is up in this log"
    ):
        pose_of(path)
    still = table(tmp_path / "still.csv", "t=t|x=x|y=z|psi=psi")
    assert "y hardly moves: is it a height?" in pose_of(still).recognised[0].why
    asked = []

    def ask(question, options):
        asked.append(question)
        return "z"

    assert pose_of(path, ask=ask).entries["y"] == {"column": "z"}
    assert asked == ["y hardly moves. Which column is the other coordinate?"]


def test_columns_that_say_nothing_are_chosen(tmp_path):
    path = table(tmp_path / "log.csv", "a=t|b=x|c=y|d=compass|e2=u")
    with pytest.raises(SeatrialError, match=r"Columns that change are .*a, b, c, d, e2") as caught:
        pose_of(path)
    assert "--pose x=COLUMN,y=COLUMN,heading=COLUMN" in str(caught.value)
    found = pose_of(path, pose="east=b,north=c,heading=d,stamp=a")
    assert found.entries["stamp"] == {"column": "a"}
    assert found.entries["psi"] == {"column": "d", "unit": "deg", "sign": -1, "offset": 90}
    assert {r.sure for r in found.recognised} == {Sureness.CHOSEN}
    for pose, words in (
        ("x=b,y=nothing,heading=d", r"no column nothing \(--pose\); there are a, b, c, d, e2"),
        ("x=b,north=c,heading=d", "give x and y, east and north, or lat and lon"),
        ("x=b,y=c,speed=d", "expected NAME=COLUMN,NAME=COLUMN with x, y,"),
        ("x=b,x=c", "x is there twice"),
    ):
        with pytest.raises(SeatrialError, match=words):
            pose_of(path, pose=pose)


def test_a_course_is_no_heading(tmp_path):
    path = table(tmp_path / "log.csv", "t=t|x=x|y=y|cog=compass|u=u")
    with pytest.raises(SeatrialError, match="cog is a course, the direction of the motion"):
        pose_of(path)


# The whole command. #


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
    found = init(path)
    inputs = yaml.safe_load(found.text)["commands"]["inputs"]
    for entry in inputs.values():
        assert {k: entry[k] for k in ("offset", "scale", "off")} == {
            "offset": 1511, "scale": 400, "off": 0,
        }  # fmt: skip
    out = tmp_path / "v.yaml"
    out.write_text(found.text)
    record = seatrial.read(path, seatrial.load_vehicle(out))
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
    found = init(folder)
    inputs = yaml.safe_load(found.text)["commands"]["inputs"]
    assert [e.get("file", "surge.csv") for e in inputs.values()] == [
        "surge.csv", "sway.csv", "yaw.csv",
    ]  # fmt: skip
    (tmp_path / "v.yaml").write_text(found.text)
    record = seatrial.read(folder, seatrial.load_vehicle(tmp_path / "v.yaml"))
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
    expected, found = init(text), init(path)
    assert found.text.splitlines()[1:] == expected.text.splitlines()[1:]
    (tmp_path / "v.yaml").write_text(found.text)
    vehicle = seatrial.load_vehicle(tmp_path / "v.yaml")
    one, other = seatrial.read(text, vehicle), seatrial.read(path, vehicle)
    np.testing.assert_array_equal(one.eta, other.eta)
    np.testing.assert_array_equal(one.stamps, other.stamps)
    np.testing.assert_array_equal(one.commands.values, other.commands.values)


# Two clocks. #


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
    (tmp_path / "v.yaml").write_text(seatrial.init(folder).text)
    vehicle = seatrial.load_vehicle(tmp_path / "v.yaml")
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
