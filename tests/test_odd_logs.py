# SPDX-License-Identifier: MIT
"""Tables as users' own loggers write them: `init` and `read` give the boat's motion, or one line that says why not.

The boat is integrated in autopilot_logs.py. What is read is compared with its velocities.
"""

from datetime import datetime, timedelta

import numpy as np
import pytest

import seatrial
from seatrial.boat.vehicle import as_column
from seatrial.inspection.proposal.channel_scales import scale_of
from seatrial.inspection.proposal.sources import Choices
from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.recording.excitation import excitation
from seatrial.util.errors import RecordingError
from tests import autopilot_logs
from tests.autopilot_logs import TWIN, geodetic, trial
from tests.logs import drive, nanoseconds

RATE = 20.0  # [Hz]
STEP = 0.4  # [s] over which velocities are compared
FEET = 1 / 0.3048
MOTIONS = ("u", "v", "r")


def columns(rate=RATE):
    """The boat at the rows of a log: t [s], east, north [m], heading [deg], psi [rad], commands (n,)."""
    run = trial(TWIN, 120.0, 0)
    t = np.arange(0.0, 119.9, 1 / rate)
    state = run.at(t)
    noise = np.random.default_rng(1).normal(size=(len(t), 3)) * [0.005, 0.005, 0.003]
    north, east, heading = (state[:, :3] + noise).T
    left, right = run.command_at(t).T
    return {
        "t": t, "east": east, "north": north, "heading": np.degrees(heading) % 360,
        "psi": np.pi / 2 - heading, "left": left, "right": right,
    }  # fmt: skip


def written(path, head, *values, sep=",", below=()):
    """A table; values are numbers (n,) or texts."""
    cells = [[v if isinstance(v, str) else f"{v:.6f}" for v in column] for column in values]
    lines = [sep.join(head), *below, *(sep.join(row) for row in zip(*cells, strict=True))]
    path.write_text("\n".join(lines) + "\n")
    return path


def read(path):
    """The vehicle file that `init` proposes, and the recording by it."""
    file = path.with_suffix(".yaml")
    file.write_text(seatrial.init(path).text)
    vehicle = seatrial.load_vehicle(file)
    return vehicle, seatrial.read(path, vehicle)


def motion(t, eta, at):
    """u, v (to port), r (n, 3) about the times `at` [s]."""
    good = np.isfinite(eta).all(axis=1)
    before, now, after = (
        np.column_stack([np.interp(at + d, t[good], x) for x in eta[good].T])
        for d in (-STEP / 2, 0, STEP / 2)
    )
    x, y, r = ((after - before) / STEP).T
    c, s = np.cos(now[:, 2]), np.sin(now[:, 2])
    return np.column_stack([c * x + s * y, c * y - s * x, r])


def moves_as_the_boat(recording, slack=0.03, until=118.0):
    """Whether velocities are those of the truth, forward-left-up, at its times, and commands too."""
    run = trial(TWIN, 120.0, 0)
    north, east, heading = run.state[:, :3].T
    at = np.arange(1.0, until, 0.05)
    found = motion(recording.t, recording.eta, at)
    true = motion(run.t, np.column_stack([east, north, np.pi / 2 - heading]), at)
    for name, f, w in zip(MOTIONS, found.T, true.T, strict=True):
        assert f @ w / (w @ w) == pytest.approx(1.0, abs=slack), name
        assert np.corrcoef(f, w)[0, 1] > 0.9, name
    commands = recording.commands
    rows = np.searchsorted(recording.seconds(commands.stamps), at, side="right") - 1
    full = np.abs(commands.values).max(axis=0)
    for i, true_command in enumerate(run.command_at(at).T):
        assert np.corrcoef(commands.values[rows, i] / full[i], true_command)[0, 1] > 0.93


def test_forces_beside_the_poses_are_commands(tmp_path):
    """F_r follows the turning of the boat, and is no yaw rate."""
    log = drive(60.0)
    poses = np.column_stack([np.interp(log.command_t, log.pose_t, x) for x in log.pose.T])
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "psi", "F_u", "F_v", "F_r"),
        log.command_t, *poses.T, *log.command.T,
    )  # fmt: skip
    vehicle, _ = read(path)
    assert vehicle.inputs == ("F_u", "F_v", "F_r")
    assert vehicle.file.pose.yaw_rate is None


@pytest.mark.parametrize("stated", ["name", "line of units"])
def test_feet(tmp_path, stated):
    """A metre has 3.28 ft, in the name of a column or in the line below the header."""
    c = columns()
    head = ("t", "x_ft", "y_ft", "yaw", "left", "right")
    below = ("s,ft,ft,rad,-,-",) if stated == "line of units" else ()
    if below:
        head = ("t", "x", "y", "yaw", "left", "right")
    path = written(
        tmp_path / "log.csv", head, c["t"], c["east"] * FEET, c["north"] * FEET, c["psi"],
        c["left"], c["right"], below=below,
    )  # fmt: skip
    moves_as_the_boat(read(path)[1])


def test_degrees_and_minutes(tmp_path):
    """NMEA 0183 writes 59 deg 54.462 min as 5954.462."""
    c = columns()
    lat, lon = geodetic(c["north"], c["east"])
    minutes = [[f"{int(v) * 100 + (v % 1) * 60:.8f}" for v in values] for values in (lat, lon)]
    path = written(
        tmp_path / "log.csv", ("t", "lat", "lon", "heading", "left", "right"), c["t"], *minutes,
        c["heading"], c["left"], c["right"],
    )  # fmt: skip
    vehicle, recording = read(path)
    assert vehicle.file.pose.origin == pytest.approx((lat[0], lon[0]), abs=1e-6)
    moves_as_the_boat(recording)


@pytest.mark.parametrize(("name", "turns"), [("yaw", False), ("heading", True)])
def test_compass_beside_x_and_y(tmp_path, name, turns):
    """0 to 360 clockwise from north though it is named yaw; and one that is not wrapped."""
    c = columns()
    heading = 90 - np.degrees(c["psi"]) if turns else c["heading"]
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", name, "left", "right"), c["t"], c["east"],
        c["north"], heading, c["left"], c["right"],
    )  # fmt: skip
    moves_as_the_boat(read(path)[1])


@pytest.mark.parametrize("clock", ["%d.%m.%Y %H:%M:%S", "%s"])
def test_whole_seconds(tmp_path, clock):
    """Ten rows share a stamp: they are put on an even clock, poses and commands alike."""
    c = columns(10.0)
    begin = datetime(2026, 5, 11, 12, 0, 0)
    stamps = [(begin + timedelta(seconds=float(t))).strftime(clock) for t in c["t"]]
    path = written(
        tmp_path / "log.csv", ("time", "east", "north", "heading", "left", "right"), stamps,
        c["east"], c["north"], c["heading"], c["left"], c["right"],
    )  # fmt: skip
    recording = read(path)[1]
    assert len(recording.t) == len(stamps)
    assert any("10 rows each" in r for r in recording.remarks)
    moves_as_the_boat(recording)


def test_comments_headers_and_marks_among_the_rows(tmp_path):
    """A logger that was started again writes its header again; cells without a value say so."""
    c = columns()
    head = ("t", "x", "y", "yaw", "left", "right")
    path = written(
        tmp_path / "log.csv", head, c["t"], c["east"], c["north"], c["psi"], c["left"], c["right"]
    )
    lines = path.read_text().splitlines()
    for i, mark in zip(
        range(300, 900, 100), ("N/A", "null", "None", "-", "NaN", "#N/A"), strict=True
    ):
        cells = lines[i].split(",")
        lines[i] = ",".join([cells[0], mark, mark, *cells[3:]])
    lines = [
        *lines[:900],
        lines[0],
        *lines[900:1500],
        "# second pilot, 20 knots",
        *lines[1500:],
        "# end",
    ]
    path.write_text("\n".join(lines) + "\n")
    recording = read(path)[1]
    assert any("3 lines among the rows" in r and "line 901" in r for r in recording.remarks)
    assert int((~recording.valid).sum()) == 6
    moves_as_the_boat(recording)


def test_measured_speeds_of_the_propellers_are_no_commands(tmp_path):
    """rpm_left follows rpm_cmd_left late."""
    c = columns()
    commanded = [3000 * np.sign(x) * np.sqrt(np.abs(x)) for x in (c["left"], c["right"])]
    measured = [np.convolve(x, np.full(4, 0.25))[: len(x)] for x in commanded]
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "yaw", "rpm_cmd_left", "rpm_cmd_right", "rpm_left", "rpm_right"),
        c["t"], c["east"], c["north"], c["psi"], *commanded, *measured,
    )  # fmt: skip
    vehicle, recording = read(path)
    assert vehicle.inputs == ("rpm_cmd_left", "rpm_cmd_right")
    moves_as_the_boat(recording)


def refusal(path):
    """The line with which `init` refuses a log."""
    with pytest.raises(RecordingError) as error:
        read(path)
    return str(error.value)


def test_throttle_and_reverse_switch(tmp_path):
    """A throttle without a sign is no command, and neither is the switch beside it."""
    c = columns()
    sides = [
        ("throttle_left", "reverse_left", c["left"]),
        ("throttle_right", "reverse_right", c["right"]),
    ]
    head = ("t", "x", "y", "yaw", *(n for a, b, _ in sides for n in (a, b)))
    values = [v for _, _, x in sides for v in (np.abs(x), (x < 0).astype(float))]
    path = written(tmp_path / "log.csv", head, c["t"], c["east"], c["north"], c["psi"], *values)
    assert "none of them is ever negative: if gear or direction is another column" in refusal(path)


@pytest.mark.parametrize(
    ("name", "stamp", "text"),
    [
        ("sample", lambda t: np.rint(RATE * t), "sample counts rows and is no time: with a known rate"),
        ("timestamp", lambda t: np.full(len(t), 1.7785e9), "timestamp has 1 different values in 2398 rows: it was rounded"),
        ("t", lambda t: t[::-1], "t falls from row to row: sort the rows by it"),
        ("time", lambda t: ["a quarter past two"] * len(t), "time has 'a quarter past two', which is no time"),
    ],
)  # fmt: skip
def test_stamps_that_are_none(tmp_path, name, stamp, text):
    """What is wrong with the column that could be the stamps."""
    c = columns()
    path = written(
        tmp_path / "log.csv", (name, "x", "y", "yaw", "left", "right"), stamp(c["t"]), c["east"],
        c["north"], c["psi"], c["left"], c["right"],
    )  # fmt: skip
    assert text in refusal(path)


def test_numbers_with_a_unit_in_each_cell(tmp_path):
    """Columns of text are named."""
    c = columns()
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "yaw", "left", "right"), c["t"],
        [f"{v:.3f} m" for v in c["east"]], [f"{v:.3f} m" for v in c["north"]], c["psi"], c["left"], c["right"],
    )  # fmt: skip
    assert "Columns with text, not numbers: x ('" in refusal(path)


def test_y_up(tmp_path):
    """Motive and Unity have y up: the boat moves in x and z."""
    c = columns()
    height = 0.1 + np.random.default_rng(2).normal(0, 0.001, len(c["t"]))
    path = written(
        tmp_path / "log.csv", ("t", "pos_x", "pos_y", "pos_z", "yaw", "left", "right"), c["t"], c["east"],
        height, -c["north"], c["psi"], c["left"], c["right"],
    )  # fmt: skip
    assert "y is up in this log" in refusal(path)


def test_two_boats_with_equal_stamps(tmp_path):
    """Rows of two boats, at the same times: no model of the poses of one and the commands of the other."""
    c = columns()
    two = {
        k: np.column_stack([v, v if k == "t" else v[::-1] + (5.0 if k == "east" else 0.0)]).ravel()
        for k, v in c.items()
    }
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "yaw", "left", "right"),
        *(two[k] for k in ("t", "east", "north", "psi", "left", "right")),
    )  # fmt: skip
    assert "are two robots, or two sources of poses" in refusal(path)


def test_channels_logged_on_change_in_one_table(tmp_path):
    """A row holds a pose, or the one command that changed; an empty cell holds the last value."""
    c = columns()
    run = trial(TWIN, 120.0, 0)
    rows = [(t, f"{t:.4f},{x:.5f},{y:.5f},{psi:.5f},,") for t, x, y, psi in zip(c["t"], c["east"], c["north"], c["psi"], strict=True)]  # fmt: skip
    for i, cells in enumerate(("{:.4f},,,,{:.4f},", "{:.4f},,,,,{:.4f}")):
        for k in np.flatnonzero(np.diff(run.commands[:, i], prepend=1.0)).tolist():
            rows.append(
                (run.t[k] + 0.001 * i, cells.format(run.t[k] + 0.001 * i, run.commands[k, i]))
            )
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["t,x,y,psi,left,right", *(row for _, row in sorted(rows))]) + "\n")
    vehicle, recording = read(path)
    assert vehicle.inputs == ("left", "right")
    moves_as_the_boat(recording)


def test_two_drives_and_a_night_between(tmp_path):
    """The hours without commands do not count: the axes are excited."""
    c = columns()
    later = {k: np.concatenate([v, v + (50_000.0 if k == "t" else 0.0)]) for k, v in c.items()}
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "yaw", "left", "right"),
        *(later[k] for k in ("t", "east", "north", "psi", "left", "right")),
    )  # fmt: skip
    vehicle, recording = read(path)
    once = seatrial.read(path, vehicle).cut(None, 119.0)
    found, expected = excitation(vehicle, recording), excitation(vehicle, once)
    np.testing.assert_allclose(found.rms[[0, 2]], expected.rms[[0, 2]], rtol=0.03)


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


def test_swapped_latitude_and_longitude(tmp_path):
    """The compass turns against the track; with the columns exchanged it follows."""
    c = columns(10.0)
    lat, lon = ([f"{v:.9f}" for v in values] for values in geodetic(c["north"], c["east"]))
    path = written(
        tmp_path / "log.csv", ("t", "latitude", "longitude", "heading", "left", "right"), c["t"], lon, lat,
        c["heading"], c["left"], c["right"],
    )  # fmt: skip
    text = refusal(path)
    option = "lat=longitude,lon=latitude,heading=heading"
    assert (
        f"latitude and longitude are swapped, or it counts counter-clockwise. If they are swapped: --pose {option}"
        in text
    )
    path.with_suffix(".yaml").write_text(seatrial.init(path, choices=Choices(pose=option)).text)
    moves_as_the_boat(seatrial.read(path, seatrial.load_vehicle(path.with_suffix(".yaml"))))


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


@pytest.mark.parametrize(
    ("neutral", "full"), [(512, 511), (128, 127), (992, 820), (50, 50), (4915, 1638)]
)
def test_commands_whose_neutral_is_in_the_middle(tmp_path, neutral, full):
    """Analogue sticks, bytes, SBUS, per cent, duty cycles: rest is where the log begins."""
    c = columns()
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "yaw", "left", "right"), c["t"], c["east"], c["north"],
        c["psi"], np.rint(neutral + full * c["left"]), np.rint(neutral + full * c["right"]),
    )  # fmt: skip
    vehicle, recording = read(path)
    assert [as_column(v).offset for v in vehicle.file.commands.inputs.values()] == [
        neutral,
        neutral,
    ]
    assert np.abs(recording.commands.values[0]).max() == 0.0
    moves_as_the_boat(recording)


def test_a_throttle_that_cruises_has_its_zero():
    """60 % most of the time, and 0 at the start: no neutral in the middle."""
    values = np.concatenate([np.zeros(50), np.full(500, 60.0), np.linspace(0.0, 100.0, 50)])
    assert scale_of(values) == {"scale": 100.0}


def test_a_compass_that_hangs(tmp_path):
    """The heading stands still for 12 s and catches up: those poses are left out."""
    c = columns()
    hangs = (c["t"] >= 50.0) & (c["t"] < 62.0)
    c["psi"][hangs] = c["psi"][np.argmax(hangs)]
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "yaw", "left", "right"), c["t"], c["east"], c["north"],
        c["psi"], c["left"], c["right"],
    )  # fmt: skip
    vehicle, recording = read(path)
    assert not recording.valid[hangs][1:].any()
    assert recording.valid[~hangs].all()
    assert [f.axis for f in vehicle.forces] == [0, 2]


def test_rounded_degrees(tmp_path):
    """Six digits after the point are 0.11 m of latitude, 0.056 m of longitude at 59.9 deg."""
    c = columns(10.0)
    lat, lon = ([f"{v:.6f}" for v in values] for values in geodetic(c["north"], c["east"]))
    path = written(
        tmp_path / "log.csv", ("t", "lat", "lon", "heading", "left", "right"), c["t"], lat, lon,
        c["heading"], c["left"], c["right"],
    )  # fmt: skip
    assert "x moves in steps of 0.056 m, y in steps of 0.11 m" in read(path)[1].doubts[0]
