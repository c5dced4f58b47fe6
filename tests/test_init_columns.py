# SPDX-License-Identifier: MIT
"""Which columns of a table are the boat's signals: headers of many logs, and what their values say."""

import numpy as np
import pytest
from sheets import sheet

from seatrial.inspection.proposal.columns.pose import choose_pose
from seatrial.inspection.proposal.sources import Choices, Sureness
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
    head = ",".join(name for name, _ in pairs)
    return sheet(path, head, *(VALUES[value] for _, value in pairs), form="%.12g")


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
