# SPDX-License-Identifier: MIT
"""Headings and positions as receivers, compasses, IMUs and trackers give them."""

import subprocess

import numpy as np
import pytest

import seatrial
from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.recording.resolution import interpolated_position
from tests import autopilot_logs
from tests.autopilot_logs import TWIN, geodetic, trial
from tests.init_tools import proposed
from tests.logs import nanoseconds
from tests.odd_logs import columns, logged, moves_as_the_boat, read, refusal, written


def test_degrees_and_minutes(tmp_path):
    """NMEA 0183 writes 59 deg 54.462 min as 5954.462."""
    c = columns()
    lat, lon = geodetic(c["north"], c["east"])
    for name, values in (("lat", lat), ("lon", lon)):
        c[name] = [f"{int(v) * 100 + (v % 1) * 60:.8f}" for v in values]
    vehicle, recording = read(logged(tmp_path, c, "t lat lon heading left right"))
    assert vehicle.file.pose.origin == pytest.approx((lat[0], lon[0]), abs=1e-6)
    moves_as_the_boat(recording)


COMPASSES = {  # name and values of a heading from its degrees (n,), 0 to 360
    "0 to 360": ("yaw", lambda h: h),
    "-180 to 180": ("yaw", lambda h: (h + 180) % 360 - 180),
    "radians": ("psi", lambda h: np.radians((h + 180) % 360 - 180)),
    "not wrapped": ("heading", lambda h: np.degrees(np.unwrap(np.radians(h)))),
}


@pytest.mark.parametrize("kind", COMPASSES)
def test_compass_beside_x_and_y(tmp_path, kind):
    """Clockwise from y, though it is named yaw: as the boat moves."""
    c = columns()
    name, values = COMPASSES[kind]
    path = logged(tmp_path, c | {name: values(c["heading"])}, f"t x y {name} left right")
    moves_as_the_boat(read(path)[1])


def test_y_up(tmp_path):
    """Motive and Unity have y up: the boat moves in x and z."""
    c = columns()
    height = 0.1 + np.random.default_rng(2).normal(0, 0.001, len(c["t"]))
    own = {"pos_x": c["east"], "pos_y": height, "pos_z": -c["north"]}
    path = logged(tmp_path, c | own, "t pos_x pos_y pos_z yaw left right")
    assert "y is up in this log" in refusal(path)


def test_two_boats_with_equal_stamps(tmp_path):
    """Rows of two boats, at the same times: no model of the poses of one and the commands of the other."""
    c = columns()
    two = {
        k: np.column_stack([v, v if k == "t" else v[::-1] + (5.0 if k == "east" else 0.0)]).ravel()
        for k, v in c.items()
    }
    assert "are two robots, or two sources of poses" in refusal(logged(tmp_path, two))


def imu_bag(path, heading, rate):
    """GNSS at 10 Hz, the heading [rad] of an IMU as its driver gives it, commands; names of the bag's topics."""
    run = trial(TWIN, 120.0, 0)
    t, ti, tc = (np.arange(0.0, 119.9, 1 / hz) for hz in (10.0, 50.0, 50.0))
    noise = np.random.default_rng(1).normal(size=(len(t), 2)) * 0.005
    lat, lon = geodetic(*(run.at(t)[:, :2] + noise).T)
    state = run.at(ti)
    psi, r = heading(state[:, 2]), rate(state[:, 5])
    imu = {
        "orientation.z": np.sin(psi / 2),
        "orientation.w": np.cos(psi / 2),
        "angular_velocity.z": r,
    }
    left, right = run.command_at(tc).T
    one, two, three = (nanoseconds(x) for x in (t, ti, tc))
    return write_bag(path, [
        BagTopic("/fix", "sensor_msgs/msg/NavSatFix", one, one, {"latitude": lat, "longitude": lon}),
        BagTopic("/imu/data", "sensor_msgs/msg/Imu", two, two, imu),
        BagTopic("/thrust", "std_msgs/msg/Float64MultiArray", three, three, {"data[0]": left, "data[1]": right}),
    ])  # fmt: skip


@pytest.mark.parametrize(
    ("heading", "rate"),
    [
        (lambda h: np.pi / 2 - h, lambda r: -r),  # REP-103
        (lambda h: -h, lambda r: -r),  # 0 is north
        (lambda h: h, lambda r: r),  # north-east-down
        (lambda h: np.pi / 2 - h, lambda r: 0.0 * r),  # no gyro
    ],
    ids=["REP-103", "zero is north", "NED", "no gyro"],
)
def test_an_imu_of_any_convention(tmp_path, heading, rate):
    """Position in degrees shows the heading's sense; two thrusters that turn the boat drive it ahead."""
    moves_as_the_boat(read(imu_bag(tmp_path / "run.bag", heading, rate))[1])


def test_a_compass_topic_in_radians(tmp_path):
    """A number named heading counts as degrees; where the motion shows radians its zero is pi / 2, not 90."""
    run = trial(TWIN, 120.0, 0)
    t, tc = np.arange(0.0, 119.9, 0.1), np.arange(0.0, 119.9, 0.05)
    noise = np.random.default_rng(1).normal(size=(len(t), 2)) * 0.005
    lat, lon = geodetic(*(run.at(t)[:, :2] + noise).T)
    one, two = nanoseconds(t), nanoseconds(tc)
    left, right = run.command_at(tc).T
    path = write_bag(tmp_path / "run.bag", [
        BagTopic("/fix", "sensor_msgs/msg/NavSatFix", one, one, {"latitude": lat, "longitude": lon}),
        BagTopic("/heading", "std_msgs/msg/Float64", two, two, {"data": run.at(tc)[:, 2] % (2 * np.pi)}),
        BagTopic("/thrust", "std_msgs/msg/Float64MultiArray", two, two, {"data[0]": left, "data[1]": right}),
    ])  # fmt: skip
    moves_as_the_boat(read(path)[1])


def with_positions(folder, names, digits):
    """A log whose latitude and longitude have these names and so many digits after the point."""
    c = columns(10.0)
    both = ([f"{v:.{digits}f}" for v in values] for values in geodetic(c["north"], c["east"]))
    head, rest = ("t", *names, "heading", "left", "right"), (c["heading"], c["left"], c["right"])
    return written(folder / "log.csv", head, c["t"], *both, *rest)


def test_swapped_latitude_and_longitude(tmp_path):
    """The compass turns against the track; with the columns exchanged it follows."""
    path = with_positions(tmp_path, ("longitude", "latitude"), 9)
    text = refusal(path)
    option = "lat=longitude,lon=latitude,heading=heading"
    assert (
        f"latitude and longitude are swapped, or it counts counter-clockwise. If they are swapped: --pose {option}"
        in text
    )
    _, vehicle = proposed(path, pose=option)
    moves_as_the_boat(seatrial.read(path, vehicle))


def test_the_receiver_with_the_best_fix(tmp_path, monkeypatch):
    """The first of two receivers has no corrections, and metres of error; the second is RTK."""
    plain, rng, off = autopilot_logs.binary_message, np.random.default_rng(3), np.zeros(2)

    def two_receivers(name, values):
        nonlocal off
        if name != "GPS":
            return plain(name, values)
        off = 0.98 * off + rng.normal(0.0, 0.3, 2)  # [m]
        status, lat, lng = 2, 7, 8
        poor, good = list(values), list(values)
        poor[status], poor[lat], poor[lng] = (
            3,
            values[lat] + off[0] / 111e3,
            values[lng] + off[1] / 55e3,
        )
        good[1], good[status] = 1, 6
        return plain(name, poor) + plain(name, good)

    monkeypatch.setattr(autopilot_logs, "binary_message", two_receivers)
    path = autopilot_logs.ardupilot(tmp_path / "1.BIN", trial(TWIN, 120.0, 0))
    assert read(path)[0].file.pose.topic == "GPS[1]"


def test_a_compass_that_hangs(tmp_path):
    """The heading stands still for 12 s and catches up: those poses are left out."""
    c = columns()
    hangs = (c["t"] >= 50.0) & (c["t"] < 62.0)
    c["psi"][hangs] = c["psi"][np.argmax(hangs)]
    vehicle, recording = read(logged(tmp_path, c))
    assert not recording.valid[hangs][1:].any()
    assert recording.valid[~hangs].all()
    assert [f.axis for f in vehicle.forces] == [0, 2]


def test_rounded_degrees(tmp_path):
    """Six digits after the point are 0.11 m of latitude, 0.056 m of longitude at 59.9 deg."""
    path = with_positions(tmp_path, ("lat", "lon"), 6)
    assert "x moves in steps of 0.056 m, y in steps of 0.11 m" in read(path)[1].doubts[0]


@pytest.mark.parametrize("parts", [10, 100])
def test_tenths_and_hundredths_of_a_degree(tmp_path, parts):
    """MAVLink's hdg is 0 to 35999."""
    c = columns()
    c["hdg"] = np.floor(parts * c["heading"])
    moves_as_the_boat(read(logged(tmp_path, c, "t east north hdg left right"))[1])


def test_nmea_sentences(tmp_path):
    """A receiver's raw output is no table."""
    path = tmp_path / "gps.txt"
    path.write_text(
        "$GPGGA,120000.00,5954.462,N,01045.000,E,4,12,0.8,3.0,M,40,M,,*00\n$GPHDT,50.0,T*00\n"
    )
    assert "has NMEA 0183 sentences, not columns" in refusal(path)


@pytest.mark.parametrize("between", [" ", ", ", "; ", "\t"])
def test_lines_of_key_and_value(tmp_path, between):
    """The message has a command that makes a table of them, and the table reads as the boat's."""
    c = columns()
    table = np.loadtxt(
        logged(tmp_path, c, "t east north heading left right"), delimiter=",", skiprows=1
    )
    keys = ("t", "east", "north", "heading", "left", "right")
    path = tmp_path / "run.csv"
    rows = (between.join(f"{k}={x:.9g}" for k, x in zip(keys, row, strict=True)) for row in table)
    path.write_text("\n".join(rows) + "\n")
    said = refusal(path)
    assert "has lines of key=value (t and east and 4 more), not columns" in said
    command = said[said.index("(echo ") :].partition("table.csv")[0] + str(tmp_path / "made.csv")
    subprocess.run(command, shell=True, check=True)
    assert np.allclose(np.loadtxt(tmp_path / "made.csv", delimiter=",", skiprows=1), table)


def test_positions_between_those_of_a_slow_receiver(tmp_path):
    """Rows at 20 Hz on straight lines between positions at 1 Hz: stated. The boat's own are not, at any rate and digits."""
    c = columns()
    for name in ("east", "north"):
        c[name] = np.interp(c["t"], c["t"][::20], c[name][::20])
    (doubt, *_) = read(logged(tmp_path, c))[1].doubts
    assert doubt.startswith(
        "only about every 20th position is measured; the others were interpolated"
    )
    run = trial(TWIN, 120.0, 0)
    for rate in (1.0, 5.0, 20.0, 100.0):
        t = np.arange(0.0, 119.9, 1 / rate)
        for digits in (2, 3, 4, 6, 9):
            assert not interpolated_position(nanoseconds(t), np.round(run.at(t)[:, :2], digits))
