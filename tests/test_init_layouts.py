# SPDX-License-Identifier: MIT
"""Tables in the layouts of published logs of boats: `init` and `read` give the boat's motion and its commands."""

from datetime import datetime, timezone

import numpy as np
import pytest

from tests.odd_logs import columns, logged, moves_as_the_boat, read, written

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
