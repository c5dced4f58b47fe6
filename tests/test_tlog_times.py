# SPDX-License-Identifier: MIT
"""Stamps of telemetry whose messages do not all state a time that can be used. Traits of real logs."""

import struct

import numpy as np
import pytest

from seatrial.io.formats import open_log
from seatrial.io.formats.mavlink import own_stamps
from seatrial.io.log import Wanted

ARRIVAL = 1_600_000_000_000_000  # [us]
WRAP = 1 << 32  # [us]
N, PERIOD = 100, 0.25  # messages; [s]


def written(path, boot, fix, late):
    """ATTITUDE with `boot` [s] and GPS_RAW_INT with `fix` [s], each `late` [s] after its time."""
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    boat, parts = dialect.MAVLink(None, srcSystem=1, srcComponent=1), []
    for i in range(N):
        for message in (
            dialect.MAVLink_attitude_message(round(boot[i] * 1e3), 0, 0, 0.01 * i, 0, 0, 0),
            dialect.MAVLink_gps_raw_int_message(round(fix[i] * 1e6), 3, i, i, 0, 1, 1, 0, 0, 9),
        ):
            arrival = ARRIVAL + round((i * PERIOD + late[i]) * 1e6)
            parts.append(struct.pack(">Q", arrival) + bytes(message.pack(boat)))
    path.write_bytes(b"".join(parts))
    return path


def stamps(path):
    """[s] since the first message was made, of ATTITUDE and GPS_RAW_INT, in the order of the file."""
    found = open_log(path).read([Wanted("ATTITUDE", ("yaw",)), Wanted("GPS_RAW_INT", ("lat",))])
    orders = [np.argsort(s.values[:, 0]) for s in found]
    return [s.stamps[o] * 1e-9 - ARRIVAL * 1e-6 for s, o in zip(found, orders, strict=True)]


@pytest.fixture
def late():
    """[s] of delays; one message has none."""
    found = np.random.default_rng(1).exponential(0.1, N)
    found[70] = 0.0
    return found


GRID = np.arange(N) * PERIOD
BOOT = 7000.0 + GRID  # [s] at which they were made; microseconds in 32 bits have wrapped


def test_positions_before_the_first_fix_do_not_cost_those_after_it_their_times(tmp_path, late):
    """ArduPilot's GPS_RAW_INT states 0 until the first fix."""
    fix = np.where(np.arange(N) < 40, 0.0, BOOT)
    attitude, gps = stamps(written(tmp_path / "run.tlog", BOOT, fix, late))
    np.testing.assert_allclose(attitude, GRID, atol=1e-6)
    np.testing.assert_allclose(gps[:40], GRID[:40] + late[:40], atol=1e-6)
    np.testing.assert_allclose(gps[40:], GRID[40:], atol=1e-6)


def test_a_fix_that_was_lost_does_not_cost_the_others_their_times(tmp_path, late):
    """The time of the last fix stands still until the next: beyond 10 s, arrival says more."""
    fix = BOOT.copy()
    fix[20:80] = fix[19]
    _, gps = stamps(written(tmp_path / "run.tlog", BOOT, fix, late))
    np.testing.assert_allclose(gps[:20], GRID[:20], atol=1e-6)
    held = GRID + late - GRID[19] <= 10.0  # by these the same fix is repeated
    expected = np.where(held, GRID[19], GRID + late)
    np.testing.assert_allclose(gps[20:80], expected[20:80], atol=1e-6)
    np.testing.assert_allclose(gps[80:], GRID[80:], atol=1e-6)


def test_messages_that_lay_in_a_router_do_not_cost_the_others_their_times(tmp_path, late):
    """The first of a public log were made 631 s before those that arrived with them."""
    boot = BOOT.copy()
    boot[:2] -= 631.0
    attitude, _ = stamps(written(tmp_path / "run.tlog", boot, BOOT, late))
    np.testing.assert_allclose(attitude[:2], GRID[:2] + late[:2], atol=1e-6)
    np.testing.assert_allclose(attitude[2:], GRID[2:], atol=1e-6)


def test_an_autopilot_that_began_again_has_all_stamps_by_arrival(tmp_path, late):
    boot = BOOT - 6900.0
    boot[50:] -= boot[50]
    attitude, gps = stamps(written(tmp_path / "run.tlog", boot, boot, late))
    for found in (attitude, gps):
        np.testing.assert_allclose(found, GRID + late, atol=1e-6)


@pytest.mark.parametrize("turns", [0, 1, 17])
def test_a_time_of_zero_is_no_time_whenever_the_32_bits_wrap(turns):
    """Without a fix all are 0; as microseconds they were taken for a time in 20 s of every 72 min."""
    offset = ARRIVAL * 1000
    arrival = offset + turns * WRAP * 1000 + (np.arange(N) * PERIOD * 1e9).astype(np.int64)
    np.testing.assert_array_equal(own_stamps(np.zeros(N), "time_usec", arrival, offset), arrival)
