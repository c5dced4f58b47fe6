# SPDX-License-Identifier: MIT
"""Trials of simulated boats, and the logs that ArduPilot writes of them.

mavlink_logs.py has the telemetry of them, px4_logs.py the logs of PX4.

Each writer follows its format's documents; what it writes is read back by pymavlink and pyulog in
test_formats.py. The truth is integrated here from Newton's equations, apart from seatrial's core.
"""

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

STEP = 0.01  # [s]
HOME = 59.9077, 10.7500  # latitude, longitude [deg]
EARTH = 6378137.0  # [m] equatorial radius of WGS 84
FLATTENING = 1 / 298.257223563
BOOT = 12_345_678  # [us] since boot at the trial's begin
EPOCH = 1_760_000_000_000_000  # [us] since 1970 at the trial's begin
ARMED, DISARMED = 3.0, 2.0  # [s] before arming, and after disarming


@dataclass(frozen=True)
class Boat:
    """Forward-right-down: thrusters x, y [m], angle clockwise from forward [deg]; SI units."""

    thrusters: tuple[tuple[float, float, float], ...]
    full: float = 8.0  # [N] of each
    mass: tuple[float, float, float] = (11.0, 15.0, 0.9)  # [kg, kg, kg m^2] with added mass
    linear: tuple[float, float, float] = (4.0, 9.0, 0.8)
    quadratic: tuple[float, float, float] = (12.0, 30.0, 0.6)
    servos: tuple["Servo", ...] = ()  # of each command; empty: those of `SERVOS`
    parameters: tuple[tuple[str, float], ...] = ()  # further ones of the log


@dataclass(frozen=True)
class Servo:
    """An output of ArduPilot: its function, its sense, its pulses [us]."""

    channel: int
    function: int
    turned: bool = False
    least: int = 1100
    trim: int = 1500
    most: int = 1900


TWIN = Boat(((-0.3, -0.3, 0.0), (-0.3, 0.3, 0.0)))  # left, right
HOLONOMIC = Boat(
    ((0.35, 0.25, -45.0), (0.35, -0.25, 45.0), (-0.35, 0.25, 45.0), (-0.35, -0.25, -45.0))
)


@dataclass(frozen=True)
class Trial:
    """Truth at every step: t [s], state (n, 6) north, east, psi (clockwise), u, v, r; commands (n, k)."""

    boat: Boat
    t: np.ndarray
    state: np.ndarray
    commands: np.ndarray
    volts: np.ndarray

    def at(self, times: np.ndarray) -> np.ndarray:
        """State (m, 6) at times [s]."""
        return np.column_stack([np.interp(times, self.t, x) for x in self.state.T])

    def command_at(self, times: np.ndarray) -> np.ndarray:
        """Commands (m, k) that hold at times [s]."""
        return self.commands[np.clip((times / STEP + 1e-6).astype(int), 0, len(self.t) - 1)]

    @property
    def seconds(self) -> float:
        """[s] in all."""
        return float(self.t[-1])


@cache
def trial(boat: Boat = TWIN, seconds: float = 120.0, seed: int = 0) -> Trial:
    """Pulses of single and of all thrusters, with pauses."""
    rng = np.random.default_rng(seed)
    n = round(seconds / STEP) + 1
    count = len(boat.thrusters)
    commands = np.zeros((n, count))
    t = ARMED + 1.0
    while t < seconds - DISARMED - 1.0:
        hold = rng.uniform(0.6, 2.5)
        shape = rng.choice([-1.0, 1.0], count) * rng.uniform(0.4, 1.0, count)
        if rng.random() < 0.4:
            shape = np.abs(shape) * rng.choice([-1.0, 1.0])
        commands[round(t / STEP) : round(min(t + hold, seconds - DISARMED - 1.0) / STEP)] = shape
        t += hold + (rng.uniform(0.3, 1.5) if rng.random() < 0.5 else 0.0)
    x, y, angle = np.array(boat.thrusters).T
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    lever = boat.full * np.array([c, s, x * s - y * c])
    return integrated(boat, commands, commands @ lever.T)


def integrated(
    boat: Boat, commands: np.ndarray, forces: np.ndarray, flow: np.ndarray | None = None
) -> Trial:
    """Truth of commands (n, k) at every step.

    forces: (n, 3) [N], [N], [N m] that act until the next one; flow: (n, 3) the same over |u| u, of rudders.
    """
    n = len(commands)
    flow = np.zeros((n, 3)) if flow is None else flow
    m, k, i = boat.mass
    linear, quadratic = np.array(boat.linear), np.array(boat.quadratic)

    def rate(state: np.ndarray, j: int) -> np.ndarray:
        psi, (u, v, r) = state[2], state[3:]
        f = (
            forces[j]
            + abs(u) * u * flow[j]
            - linear * state[3:]
            - quadratic * np.abs(state[3:]) * state[3:]
        )
        return np.array([
            u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi), r,
            (f[0] + k * v * r) / m, (f[1] - m * u * r) / k, (f[2] + (m - k) * u * v) / i,
        ])  # fmt: skip

    states = np.zeros((n, 6))
    states[0, 2] = 0.7
    for j in range(n - 1):
        a = rate(states[j], j)
        b = rate(states[j] + STEP / 2 * a, j)
        states[j + 1] = states[j] + STEP * b
    time = np.arange(n) * STEP
    return Trial(boat, time, states, commands, 16.6 - 1.2 * time / time[-1])


def geodetic(north: np.ndarray, east: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Latitude, longitude [deg] of points near `HOME`, by the radii of curvature of WGS 84."""
    e2 = FLATTENING * (2 - FLATTENING)
    sine = np.sin(np.radians(HOME[0]))
    meridian = EARTH * (1 - e2) / (1 - e2 * sine**2) ** 1.5
    normal = EARTH / np.sqrt(1 - e2 * sine**2)
    lat = HOME[0] + np.degrees(north / meridian)
    return lat, HOME[1] + np.degrees(east / (normal * np.cos(np.radians(HOME[0]))))


@dataclass(frozen=True)
class Sensors:
    """What the sensors measure, each at its own rate."""

    gps: np.ndarray  # (n, 3) t [s], latitude, longitude [deg]
    yaw: np.ndarray  # (n, 3) t, heading clockwise from north [rad], yaw rate
    gyro: np.ndarray  # (n, 2) t, yaw rate [rad/s]
    motors: np.ndarray  # (n, 1 + k) t, commands
    battery: np.ndarray  # (n, 2) t, [V]


def sensed(run: Trial, *, seed: int = 1, position: float = 0.02, outputs: float = 10.0) -> Sensors:
    """GNSS at 5 Hz (`position` [m]), heading at 20 Hz (0.2 deg), gyro at 50 Hz, motors at `outputs` [Hz]."""
    rng = np.random.default_rng(seed)

    def times(rate: float, phase: float) -> np.ndarray:
        return np.arange(phase, run.seconds, 1 / rate)

    t = times(5.0, 0.031)
    x = run.at(t)
    lat, lon = geodetic(*(x[:, :2] + rng.normal(0, position, (len(t), 2))).T)
    gps = np.column_stack([t, lat, lon])
    t = times(20.0, 0.007)
    x = run.at(t)
    yaw = np.column_stack([t, np.mod(x[:, 2] + rng.normal(0, 0.0035, len(t)), 2 * np.pi), x[:, 5]])
    t = times(50.0, 0.003)
    gyro = np.column_stack([t, run.at(t)[:, 5] + rng.normal(0, 0.004, len(t))])
    t = times(outputs, 0.0)
    motors = np.column_stack([t, run.command_at(t)])
    t = times(1.0, 0.5)
    return Sensors(gps, yaw, gyro, motors, np.column_stack([t, np.interp(t, run.t, run.volts)]))


Event = tuple[float, Callable[[], None]]


def in_order(path: Path, events: list[Event], parts: list[bytes]) -> Path:
    """The file with the parts that there are after all events."""
    for _, write in sorted(events, key=lambda e: e[0]):
        write()
    path.write_bytes(b"".join(parts))
    return path


# ArduPilot #

SERVOS = {  # by the number of thrusters
    2: (Servo(1, 73), Servo(3, 74, turned=True)),
    4: (Servo(1, 33), Servo(2, 34), Servo(3, 35, turned=True), Servo(4, 36)),
}
FORMATS = {
    "FMT": (0x80, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "UNIT": (1, "QbZ", "TimeUS,Id,Label"),
    "MULT": (2, "Qbd", "TimeUS,Id,Mult"),
    "FMTU": (3, "QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
    "PARM": (4, "QNff", "TimeUS,Name,Value,Default"),
    "MSG": (5, "QZ", "TimeUS,Message"),
    "GPS": (6, "QBBIHBcLLeffffB", "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U"),
    "ATT": (7, "QccccCCCC", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw,ErrRP,ErrYaw"),
    "IMU": (8, "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    "RCOU": (9, "QHHHHHHHHHHHHHH", "TimeUS," + ",".join(f"C{i}" for i in range(1, 15))),
    "BAT": (10, "QBff", "TimeUS,Inst,Volt,Curr"),
    "ARM": (11, "QBI", "TimeUS,ArmState,ArmChecks"),
    "POS": (12, "QLLfff", "TimeUS,Lat,Lng,Alt,RelHomeAlt,RelOriginAlt"),
}  # fmt: skip
UNITS = {
    "GPS": ("s#---SmDUmnhnh-", "F----0BGGB000--"), "ATT": ("sddddhhdh", "FBBBBBBBB"),
    "IMU": ("s#EEEooo", "F-000000"), "RCOU": ("s" + "Y" * 14, "F" + "-" * 14),
    "BAT": ("s#vA", "F-00"), "POS": ("sDUmmm", "FGG000"),
}  # fmt: skip
LABELS = {
    "s": "s", "#": "instance", "D": "deglatitude", "U": "deglongitude", "E": "rad/s", "h": "degheading",
    "d": "deg", "n": "m/s", "m": "m", "o": "m/s/s", "Y": "us", "v": "V", "A": "A", "S": "satellites",
}  # fmt: skip
FACTORS = {"F": 1e-6, "0": 1.0, "B": 1e-2, "G": 1e-7, "-": 0.0}
STRUCT = {
    "b": "b", "B": "B", "h": "h", "H": "H", "i": "i", "I": "I", "f": "f", "d": "d", "q": "q", "Q": "Q",
    "c": "h", "C": "H", "e": "i", "E": "I", "L": "i", "n": "4s", "N": "16s", "Z": "64s",
}  # fmt: skip
SCALED = {"c": 1e2, "C": 1e2, "e": 1e2, "E": 1e2, "L": 1e7}


def binary_message(name: str, values: Sequence[object]) -> bytes:
    """One message of `FORMATS`, its values in the units of the format."""
    number, characters, _ = FORMATS[name]
    raw = []
    for character, value in zip(characters, values, strict=True):
        if isinstance(value, str):
            raw.append(value.encode())
        else:
            raw.append(round(value * SCALED[character]) if character in SCALED else value)
    return b"\xa3\x95" + bytes([number]) + struct.pack(_packed(characters), *raw)


def text_message(name: str, values: Sequence[object]) -> bytes:
    """The same as a line of a `.log`."""
    texts = []
    for character, value in zip(FORMATS[name][1], values, strict=True):
        form = {**dict.fromkeys("cCeE", ".2f"), "L": ".7f", "f": ".7g", "d": ".7g"}.get(
            character, ""
        )
        texts.append(format(value, form))
    return ", ".join([name, *texts]).encode() + b"\n"


def _packed(characters: str) -> str:
    return "<" + "".join(STRUCT[c] for c in characters)


def servos(boat: Boat) -> tuple[Servo, ...]:
    """Those of its commands."""
    return boat.servos or SERVOS[len(boat.thrusters)]


def servo_parameters(boat: Boat) -> dict[str, float]:
    """Those of the channels that have a command, and further ones of the boat."""
    found: dict[str, float] = {}
    for each in servos(boat):
        key = f"SERVO{each.channel}"
        found |= {
            f"{key}_FUNCTION": each.function, f"{key}_MIN": each.least, f"{key}_MAX": each.most,
            f"{key}_TRIM": each.trim, f"{key}_REVERSED": each.turned,
        }  # fmt: skip
    return found | dict(boat.parameters)


def pulses(run: Trial, t: float, command: Sequence[float], channels: int) -> list[int]:
    """[us] of each channel for commands at t [s]: 0 while disarmed."""
    found = [0] * channels
    if ARMED <= t < run.seconds - DISARMED:
        for each, value in zip(servos(run.boat), command, strict=True):
            signed = -value if each.turned else value
            side = each.most - each.trim if signed > 0 else each.trim - each.least
            found[each.channel - 1] = round(each.trim + side * signed)
    return found


def ardupilot(
    path: Path, run: Trial, *, text: bool = False, seed: int = 1, outputs: float = 10.0
) -> Path:
    """A DataFlash log of Rover in a boat's frame, its RCOU at `outputs` [Hz]."""
    found, parts = sensed(run, seed=seed, outputs=outputs), []
    message = text_message if text else binary_message

    def write(name: str, *values: object) -> None:
        parts.append(message(name, values))

    for name, (number, characters, columns) in FORMATS.items():
        size = 3 + struct.calcsize(_packed(characters))
        write("FMT", number, size, name, characters, columns)
    for key, label in LABELS.items():
        write("UNIT", BOOT, ord(key), label)
    for key, factor in FACTORS.items():
        write("MULT", BOOT, ord(key), factor)
    for name, (unit, factor) in UNITS.items():
        write("FMTU", BOOT, FORMATS[name][0], unit, factor)
    parameters = {"FRAME_CLASS": 2.0, "SERVO5_FUNCTION": 0.0, **servo_parameters(run.boat)}
    for name, value in parameters.items():
        write("PARM", BOOT, name, float(value), 0.0)
    write("MSG", BOOT, "ArduRover V4.5.1 (simulated)")

    def us(t: float) -> int:
        return BOOT + round(t * 1e6)

    events: list[Event] = []
    for t, lat, lon in found.gps:
        row = (
            "GPS",
            us(t),
            0,
            4,
            round(t * 1e3),
            2350,
            14,
            0.7,
            lat,
            lon,
            3.0,
            0.0,
            0.0,
            0.0,
            0.0,
            1,
        )
        events.append((t, partial(write, *row)))
        slow = ("POS", us(t), lat, lon, 3.0, 0.0, 0.0)
        events.append((t, partial(write, *slow)))
    for t, yaw, _ in found.yaw:
        row = ("ATT", us(t), 0.0, 0.0, 0.0, 0.0, 0.0, np.degrees(yaw) % 360, 0.0, 0.0)
        events.append((t, partial(write, *row)))
    for t, rate in found.gyro:
        for i in (0, 1):
            row = ("IMU", us(t), i, 0.0, 0.0, rate, 0.0, 0.0, -9.81)
            events.append((t, partial(write, *row)))
    for t, *command in found.motors:
        row = ("RCOU", us(t), *pulses(run, t, command, 14))
        events.append((t, partial(write, *row)))
    for t, volts in found.battery:
        events.append((t, partial(write, "BAT", us(t), 0, volts, 4.0)))
    for t, state in ((ARMED, 1), (run.seconds - DISARMED, 0)):
        events.append((t, partial(write, "ARM", us(t), state, 0)))
    return in_order(path, events, parts)
