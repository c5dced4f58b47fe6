# SPDX-License-Identifier: MIT
"""The logs that PX4 writes of simulated trials (ULog), by its documents."""

import struct
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import autopilot_logs
import numpy as np
from autopilot_logs import BOOT, Event, Trial, in_order, sensed

ODOMETRY = "vehicle_odometry"
ULOG = {  # name: fields
    "sensor_gps": "uint64_t timestamp;uint64_t timestamp_sample;double latitude_deg;double longitude_deg;"
                  "float heading;uint8_t fix_type;uint8_t[7] _padding0;",
    "vehicle_attitude": "uint64_t timestamp;uint64_t timestamp_sample;float[4] q;",
    "vehicle_local_position": "uint64_t timestamp;float x;float y;float heading;uint8_t[4] _padding0;",
    ODOMETRY: "uint64_t timestamp;float[3] position;float[4] q;uint8_t reset_counter;"
                        "uint8_t[3] _padding0;",
    "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;",
    "actuator_motors": "uint64_t timestamp;float[12] control;uint16_t reversible_flags;uint8_t[6] _padding0;",
    "actuator_servos": "uint64_t timestamp;float[8] control;",
    "battery_status": "uint64_t timestamp;float voltage_v;float current_a;",
}  # fmt: skip
OLD_GPS = (
    "uint64_t timestamp;int32_t lat;int32_t lon;float hdop;uint8_t fix_type;uint8_t[3] _padding0;"
)


def ulog_message(kind: str, body: bytes) -> bytes:
    """A ULog message."""
    return struct.pack("<HB", len(body), ord(kind)) + body


def px4(
    path: Path,
    run: Trial,
    *,
    seed: int = 1,
    old: bool = False,
    without: Sequence[str] = (ODOMETRY,),
) -> Path:
    """A ULog of PX4; `old`: vehicle_gps_position with whole numbers, as before 1.14.

    without: topics that it lacks.
    """
    found = sensed(run, seed=seed)
    formats = {
        ("vehicle_gps_position" if old and n == "sensor_gps" else n): f for n, f in ULOG.items()
    }
    if old:
        formats["vehicle_gps_position"] = OLD_GPS
    steered = run.commands.shape[1] > len(run.boat.thrusters)
    without = (*without, *(() if steered else ("actuator_servos",)))
    numbers = {name: i for i, name in enumerate(formats) if name not in without}
    parts = [
        b"\x55\x4c\x6f\x67\x01\x12\x35\x01" + struct.pack("<Q", BOOT),
        ulog_message("B", bytes(40)),
    ]
    key = b"char[3] sys_name"
    parts.append(ulog_message("I", bytes([len(key)]) + key + b"PX4"))
    parts += [ulog_message("F", f"{name}:{fields}".encode()) for name, fields in formats.items()]
    count = len(run.boat.thrusters)
    angles = run.commands.shape[1] - count
    frame = {"CA_AIRFRAME": 5} if angles else {"CA_ROTOR_COUNT": count}  # of a car
    whole = {**frame, "CA_R_REV": (1 << count) - 1}
    real = {}
    for i, (x, y, angle) in enumerate(run.boat.thrusters):
        real |= {f"CA_ROTOR{i}_PX": x, f"CA_ROTOR{i}_PY": y}
        real |= {
            f"CA_ROTOR{i}_AX": np.cos(np.radians(angle)),
            f"CA_ROTOR{i}_AY": np.sin(np.radians(angle)),
        }
    for kind, code, values in (("int32_t", "<i", whole), ("float", "<f", real)):
        for name, value in values.items():
            key = f"{kind} {name}".encode()
            parts.append(ulog_message("P", bytes([len(key)]) + key + struct.pack(code, value)))
    for name, number in numbers.items():
        parts.append(ulog_message("A", bytes([0]) + struct.pack("<H", number) + name.encode()))

    def write(name: str, t: float, code: str, *values: float) -> None:
        if name not in numbers:
            return
        stamp = struct.pack("<Q", BOOT + round(t * 1e6))
        body = struct.pack("<H", numbers[name]) + stamp + struct.pack(f"<{code}", *values)
        parts.append(ulog_message("D", body))

    events: list[Event] = []
    for t, lat, lon in found.gps:
        row = (
            ("vehicle_gps_position", t, "iifB", round(lat * 1e7), round(lon * 1e7), 0.7, 3)
            if old
            else ("sensor_gps", t, "QddfB", BOOT + round(t * 1e6) - 100_000, lat, lon, np.nan, 3)
        )
        events.append((t, partial(write, *row)))
    for t, yaw, _ in found.yaw:
        q = (np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2))
        row = ("vehicle_attitude", t, "Q4f", BOOT + round(t * 1e6), *q)
        events.append((t, partial(write, *row)))
    for t in found.yaw[::2, 0]:
        x = run.at(np.array([t]))[0]
        row = ("vehicle_local_position", t, "fff", x[0], x[1], x[2])
        events.append((t, partial(write, *row)))
        q = (np.cos(x[2] / 2), 0.0, 0.0, np.sin(x[2] / 2))
        row = (ODOMETRY, t, "7fB", x[0], x[1], 0.0, *q, 0)
        events.append((t, partial(write, *row)))
    for t, rate in found.gyro:
        events.append((t, partial(write, *("sensor_combined", t, "6f", 0, 0, rate, 0, 0, -9.81))))
    for t, *command in found.motors:
        if autopilot_logs.ARMED <= t < run.seconds - autopilot_logs.DISARMED:
            stopped = t < autopilot_logs.ARMED + 0.9 and not any(
                command
            )  # armed, nothing commanded yet
            given = [np.nan] * len(command) if stopped else command
            control = [*given[:count], *[np.nan] * (12 - count)]
            row = ("actuator_motors", t, "12fH", *control, (1 << count) - 1)
            events.append((t, partial(write, *row)))
            control = [*given[count:], *[np.nan] * (8 - angles)]
            events.append((t, partial(write, *("actuator_servos", t, "8f", *control))))
    for t, volts in found.battery:
        events.append((t, partial(write, *("battery_status", t, "ff", volts, 4.0))))
        magic = ulog_message("S", bytes.fromhex("2f731320250cbb12"))
        events.append((t, partial(parts.append, magic)))
    return in_order(path, events, parts)
