# SPDX-License-Identifier: MIT
"""Tables in the layouts of published logs of boats: `init` and `read` give the boat's motion and its commands."""

from datetime import datetime, timezone

import numpy as np
import pytest
import steered_boat
from sheets import sheet

import seatrial
from tests.init_tools import proposed
from tests.odd_logs import columns, logged, moves_as_the_boat, read, refusal, written

BEGUN = 1_746_606_929  # [s] since 1970


def dated(t, digits, form="%Y/%m/%d %H:%M:%S"):
    """Dates of t [s], their fractions of a second whole numbers of so many digits, without leading zeros."""
    counts = np.rint(t * 10**digits).astype(np.int64)
    parts = [divmod(count, 10**digits) for count in counts.tolist()]
    return [
        f"{datetime.fromtimestamp(BEGUN + s, timezone.utc).strftime(form)}.{rest}"
        for s, rest in parts
    ]


@pytest.mark.parametrize("digits", [6, 9])
def test_dates_whose_fractions_lack_leading_zeros(tmp_path, digits):
    """Seconds, a point and nanoseconds, as converters of bags write them: a tenth of the rows was out of order."""
    c = columns()
    t = c["t"] + np.random.default_rng(2).uniform(0.0, 0.02, len(c["t"]))
    path = logged(tmp_path, c | {"stamp": dated(t, digits)}, "stamp x y yaw left right")
    np.testing.assert_allclose(read(path)[1].t, t - t[0], atol=2 * 0.1**digits)


def test_latitudes_in_radians(tmp_path):
    """As their names say; read as degrees the boat hardly moved."""
    c = columns()
    lat = np.radians(59.9 + c["north"] / 111_413.0)
    lon = np.radians(10.7 + c["east"] / (111_319.5 * np.cos(np.radians(59.9))))
    head = ("timestamp (s)", "lat (rad)", "lon (rad)", "psi (rad)", "left", "right")
    form = [f"{v:.12f}" for v in lat], [f"{v:.12f}" for v in lon]
    path = written(
        tmp_path / "log.csv", head, c["t"], *form, np.radians(c["heading"]), c["left"], c["right"]
    )
    moves_as_the_boat(read(path)[1])


def test_the_heading_has_the_clock_of_the_positions(tmp_path):
    """Its table has the seconds of its sensor, too, which count from another start."""
    c = columns()
    written(tmp_path / "gps.csv", ("timestamp", "x", "y"), c["t"] + BEGUN, c["east"], c["north"])
    written(
        tmp_path / "euler.csv", ("timestamp", "time (s)", "psi (rad)"), c["t"] + BEGUN, c["t"] + 7.0, c["psi"]
    )  # fmt: skip
    written(
        tmp_path / "motors.csv", ("timestamp", "left", "right"), c["t"] + BEGUN, c["left"], c["right"]
    )  # fmt: skip
    moves_as_the_boat(read(tmp_path)[1])


def test_a_second_clock_is_no_command(tmp_path):
    """It rises with every row."""
    c = columns()
    for name, head in (
        ("pose", "timestamp x y yaw"),
        ("motors", "timestamp timestamp_sample left right"),
    ):
        values = c | {"timestamp": c["t"] + 50.0, "timestamp_sample": c["t"] + 49.99}
        logged(tmp_path, values, head).rename(tmp_path / f"{name}.csv")
    vehicle, recording = read(tmp_path)
    assert vehicle.inputs == ("left", "right")
    moves_as_the_boat(recording)


def offsets(vehicle):
    return {n: (c.offset, c.scale) for n, c in vehicle.file.commands.inputs.items()}


@pytest.mark.parametrize(("rest", "range_"), [(1000.0, 900.0), (90.0, 60.0)])
def test_thrust_ahead_only_begins_where_the_boat_stands_still(tmp_path, rest, range_):
    """Of a speed controller without reverse: its pulses begin at 1000 us, a servo's angle at 90 deg."""
    t = np.arange(0.0, 60.0, 0.1)
    ahead = np.where(t < 5.0, 0.0, 0.5 + 0.5 * np.sign(np.sin(0.7 * t)) * (t % 4.0) / 4.0)
    speed = np.zeros_like(t)
    for i in range(1, len(t)):
        speed[i] = speed[i - 1] + 0.1 * (0.5 * ahead[i - 1] - 0.4 * speed[i - 1])
    psi = 0.5 * np.sin(0.3 * np.cumsum(speed))
    x, y = (np.cumsum(0.1 * speed * f(psi)) for f in (np.cos, np.sin))
    poses = np.random.default_rng(1).normal(0.0, 0.003, (3, len(t))) + np.stack([x, y, psi])
    head = ("t", "x", "y", "yaw", "esc")
    path = written(tmp_path / "log.csv", head, t, *poses, rest + range_ * ahead)
    assert offsets(read(path)[0]) == {"F_u": (rest, range_)}


def test_a_motors_speed_beside_its_command_is_measured(tmp_path):
    """The thrust in percent is the command, whatever the rows of the speeds follow better."""
    c = columns()
    late = [np.roll(c[side], 4) for side in ("left", "right")]
    names = ("port_thrust_pct", "stbd_thrust_pct", "port_rpm", "stbd_rpm")
    path = written(
        tmp_path / "log.csv", ("t", "x", "y", "yaw", *names), c["t"], c["east"], c["north"], c["psi"],
        100 * c["left"], 100 * c["right"], *(1200 * n for n in late),
    )  # fmt: skip
    vehicle, recording = read(path)
    assert vehicle.inputs == names[:2]
    moves_as_the_boat(recording)


def test_a_moment_beside_the_thrusters_it_is_the_sum_of_is_no_third_one(tmp_path):
    c = columns()
    own = c | {"left_cmd": 200 * c["left"], "right_cmd": 200 * c["right"]}
    own["M_cmd"] = np.round(0.4 * (own["right_cmd"] - own["left_cmd"]), 1)
    path = logged(tmp_path, own, "t x y yaw left_cmd right_cmd M_cmd")
    vehicle, recording = read(path)
    assert vehicle.inputs == ("left_cmd", "right_cmd")
    moves_as_the_boat(recording)


HEADS = {
    "t [s]|x_position_mid [m]|y_position_mid [m]|psi_hat [rad]|n_left [rps]|n_right [rps]": "psi",
    "时间|x|y|航向|左推进器|右推进器": "psi",
    "tiempo|este|norte|rumbo|motor_izq|motor_der": "heading",
    "temps|x_est|y_est|cap|moteur_gauche|moteur_droit": "psi",
}


@pytest.mark.parametrize("head", HEADS)
def test_words_of_other_languages_and_words_behind_a_coordinates(tmp_path, head):
    c = columns()
    names = head.split("|")
    values = (c["t"], c["east"], c["north"], c[HEADS[head]], c["left"], c["right"])
    path = written(tmp_path / "log.csv", names, *values)
    vehicle, recording = read(path)
    moves_as_the_boat(recording)
    assert [c.column for c in vehicle.file.commands.inputs.values()] == names[4:]


@pytest.mark.parametrize(("name", "power"), [("n_prop [rps]", True), ("throttle", False)])
def test_thrust_of_a_propellers_speed_has_a_power_beside_a_rudder(tmp_path, name, power):
    """It grows with about the square of the speed: with power 1 drag was off without a word."""
    recording = steered_boat.driven(steered_boat.known(), seed=1)
    commands = recording.commands
    at = np.searchsorted(commands.stamps, recording.stamps, side="right") - 1
    head = f"t,x,y,psi,{name},rudder"
    path = sheet(tmp_path / "log.csv", head, recording.t, recording.raw, commands.values[at])
    vehicle, _ = read(path)
    assert [group.power == "estimate" for group in vehicle.file.chain] == [power, False]


def test_a_table_without_a_header_has_numbered_columns(tmp_path):
    """Its first row is a row; the refusal lists the names to choose from."""
    c = columns()
    path = logged(tmp_path, c, "t x y yaw left right")
    path.write_text(path.read_text().partition("\n")[2])
    assert "column_1, column_2, column_3" in refusal(path)
    pose = "x=column_2,y=column_3,heading=column_4,stamp=column_1"
    found, vehicle = proposed(path, pose=pose, commands="left=column_5,right=column_6")
    recording = seatrial.read(path, vehicle)
    assert "has no header" in found.text
    assert len(recording.t) == len(c["t"])
    moves_as_the_boat(recording)


@pytest.mark.parametrize("layout", ["labels", "eta and tau"])
def test_matrices_of_matlab_whose_columns_have_names_elsewhere(tmp_path, layout):
    """As ground stations export logs: GPS and GPS_label; and as the field names poses and forces."""
    scipy_io = pytest.importorskip("scipy.io")
    c = columns()
    eta = np.column_stack([c["east"], c["north"], c["psi"]])
    both = np.column_stack([c["left"], c["right"]])
    content = {"t": c["t"], "eta": eta.T, "tau": both.T}
    if layout == "labels":
        line = np.arange(len(eta)) + 1.0
        content = {
            "POS": np.column_stack([line, 1e6 * c["t"], eta]), "Seen": cells("POS", "RCOU"),
            "POS_label": cells("LineNo", "TimeUS", "X", "Y", "Yaw"),
            "RCOU": np.column_stack([3 * line, 1e6 * c["t"], 1500 + 400 * both]),
            "RCOU_label": cells("LineNo", "TimeUS", "C1", "C3"),
        }  # fmt: skip
    scipy_io.savemat(tmp_path / "log.mat", content)
    moves_as_the_boat(read(tmp_path / "log.mat")[1])


def cells(*texts):
    return np.array([[text] for text in texts], dtype=object)
