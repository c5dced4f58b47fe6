# SPDX-License-Identifier: MIT
"""The telemetry of a simulated boat as MAVLink, a `.tlog`; what is written is read back in test_formats.py."""

import struct
from functools import partial
from pathlib import Path

import numpy as np
from autopilot_logs import BOOT, EPOCH, Event, Trial, in_order, pulses, sensed, servo_parameters


def telemetry(
    path: Path, run: Trial, *, version: int = 2, seed: int = 1, late: float = 0.03
) -> Path:
    """A `.tlog` as a ground station writes it: messages of the boat, `late` [s] on average, and its own."""
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    found, parts = sensed(run, seed=seed), []
    rng = np.random.default_rng([seed, 2])
    boat = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    ground = dialect.MAVLink(None, srcSystem=255, srcComponent=190)

    def write(t: float, message: object, sender: object = boat) -> None:
        arrival = EPOCH + round((t + rng.exponential(late)) * 1e6)
        packed = message.pack(sender, force_mavlink1=version == 1)
        sender.seq = (sender.seq + 1) % 256
        parts.append(struct.pack(">Q", arrival) + bytes(packed))

    parameters = servo_parameters(run.boat)

    def ms(t: float) -> int:
        return BOOT // 1000 + round(t * 1e3)

    events: list[Event] = []
    for i, (name, value) in enumerate(parameters.items()):
        message = dialect.MAVLink_param_value_message(name.encode(), value, 9, len(parameters), i)
        events.append((0.01 * i, partial(write, 0.01 * i, message)))
    for t in np.arange(0, run.seconds):
        events.append((t, partial(write, t, dialect.MAVLink_heartbeat_message(11, 3, 0, 0, 0, 3))))
        mine = dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3)
        events.append((t, partial(write, t, mine, ground)))
    for t, lat, lon in found.gps:
        e7 = round(lat * 1e7), round(lon * 1e7)
        message = dialect.MAVLink_gps_raw_int_message(ms(t) * 1000, 4, *e7, 3000, 70, 70, 0, 0, 14)
        events.append((t, partial(write, t, message)))
        message = dialect.MAVLink_global_position_int_message(ms(t), *e7, 3000, 0, 0, 0, 0, 65535)
        events.append((t, partial(write, t, message)))
    for t, yaw, rate in found.yaw:
        wrapped = float(np.angle(np.exp(1j * yaw)))
        message = dialect.MAVLink_attitude_message(ms(t), 0, 0, wrapped, 0, 0, rate)
        events.append((t, partial(write, t, message)))
    for t, *command in found.motors:
        pwm = pulses(run, t, command, 8)
        message = dialect.MAVLink_servo_output_raw_message((ms(t) * 1000) % (1 << 32), 0, *pwm)
        events.append((t, partial(write, t, message)))
    for t, volts in found.battery:
        message = dialect.MAVLink_sys_status_message(
            0, 0, 0, 500, round(volts * 1e3), 400, 50, 0, 0, 0, 0, 0, 0
        )
        events.append((t, partial(write, t, message)))
    return in_order(path, events, parts)
