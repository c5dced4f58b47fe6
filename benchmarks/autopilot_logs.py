# SPDX-License-Identifier: MIT
"""Gate: time and memory of reading logs of autopilots beside the formats' own libraries, in the same run.

    python -m benchmarks.autopilot_logs                # 100 MB of .BIN and .ulg, 10 minutes of .tlog
    python -m benchmarks.autopilot_logs --size 500     # 500 MB: more than an hour of .ulg
    python -m benchmarks.autopilot_logs --log FILE     # a log of yours

Each reads the same: position, heading, gyro and motor outputs. Times are CPU seconds; machines are noisy: read
the ratios.
"""

# ruff: noqa: PLC0415 what is not measured is not imported either

import contextlib
import struct
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.harness import command
from benchmarks.harness.measure import Measured, measure, measured, options

WANTED = {
    ".bin": {"GPS": ("Lat", "Lng"), "ATT": ("Yaw",), "IMU": ("GyrZ",), "RCOU": ("C1", "C3")},
    ".ulg": {
        "vehicle_gps_position": ("lat", "lon"), "vehicle_attitude": ("q[0]", "q[1]", "q[2]", "q[3]"),
        "sensor_combined": ("gyro_rad[2]",), "actuator_motors": ("control[0]", "control[1]"),
    },
    ".tlog": {
        "GPS_RAW_INT": ("lat", "lon"), "ATTITUDE": ("yaw", "yawspeed"),
        "SERVO_OUTPUT_RAW": ("servo1_raw", "servo3_raw"),
    },
}  # fmt: skip
PERIOD = 10.0  # [s] of a block that is written again and again, with later stamps
TELEMETRY = 600  # [s]
REPEATS = 3


# Logs #


def _repeated(path: Path, head: bytes, records: list[bytes], at: int, size: int) -> None:
    """Records of one period, again and again; each has its stamp [us] `at` bytes behind its begin."""
    block = np.frombuffer(b"".join(records), np.uint8).copy()
    begins = np.cumsum([0, *map(len, records[:-1])])
    places = (begins + at)[:, None] + np.arange(8)
    stamps = block[places].copy().view("<u8")[:, 0]
    with path.open("wb") as file:
        file.write(head)
        for k in range(max(size // len(block), 1)):
            moved = stamps + np.uint64(round(k * PERIOD * 1e6))
            block[places] = moved[:, None].view(np.uint8).reshape(-1, 8)
            file.write(block)


def _ticks(rate: float) -> np.ndarray:
    return np.arange(0.0, PERIOD, 1 / rate)


def write_bin(path: Path, size: int) -> None:
    """Three IMUs at 400 Hz, attitude at 100 Hz, outputs at 50 Hz, GPS at 5 Hz."""
    kinds = {
        0x80: ("FMT", "BBnNZ", "Type,Length,Name,Format,Columns", 89, ""),
        1: ("UNIT", "QbZ", "TimeUS,Id,Label", 76, ""),
        2: ("FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds", 44, ""),
        5: ("GPS", "QBLLf", "TimeUS,I,Lat,Lng,Spd", 24, "QBiif"),
        6: ("ATT", "QccC", "TimeUS,Roll,Pitch,Yaw", 17, "QhhH"),
        7: ("IMU", "QBffffff", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ", 36, "QB6f"),
        8: ("RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4", 19, "Q4H"),
    }  # fmt: skip
    head = b""
    for number, (name, characters, columns, length, _) in kinds.items():
        fmt = struct.pack(
            "<BB4s16s64s", number, length, name.encode(), characters.encode(), columns.encode()
        )
        head += b"\xa3\x95\x80" + fmt
    head += b"\xa3\x95\x01" + struct.pack("<Qb64s", 0, ord("#"), b"instance")
    for number, units in ((5, b"-#---"), (7, b"-#------")):
        head += b"\xa3\x95\x02" + struct.pack("<QB16s16s", 0, number, units, b"-" * len(units))
    rng = np.random.default_rng(0)
    several: list[tuple[float, bytes]] = []

    def add(t: float, number: int, *values: float) -> None:
        body = struct.pack("<" + kinds[number][4], round(t * 1e6), *values)
        several.append((t, b"\xa3\x95" + bytes([number]) + body))

    for t in _ticks(400):
        for i in range(3):
            add(t, 7, i, *rng.normal(0, 1, 6))
    for t in _ticks(100):
        add(t, 6, 0, 0, int(36000 * t / PERIOD))
    for t in _ticks(50):
        add(t, 8, *rng.integers(1100, 1900, 4).tolist())
    for t in _ticks(5):
        add(t, 5, 0, int(5.99e8 + 10 * t), int(1.07e8 - 10 * t), 1.0)
    _repeated(path, head, [record for _, record in sorted(several)], 3, size)


def write_ulg(path: Path, size: int) -> None:
    """PX4's usual rates, and others' topics beside."""
    formats = {
        "vehicle_gps_position": ("uint64_t timestamp;int32_t lat;int32_t lon;float eph;", "iif", 5),
        "vehicle_attitude": ("uint64_t timestamp;float[4] q;", "4f", 100),
        "sensor_combined": ("uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;", "6f", 250),
        "actuator_motors": ("uint64_t timestamp;float[12] control;", "12f", 100),
        "estimator_states": ("uint64_t timestamp;float[24] states;float[24] covariances;", "48f", 100),
        "vehicle_imu": ("uint64_t timestamp;float[3] delta_angle;float[3] delta_velocity;", "6f", 200),
    }  # fmt: skip
    head = b"\x55\x4c\x6f\x67\x01\x12\x35\x01" + bytes(8)
    several: list[tuple[float, bytes]] = []
    rng = np.random.default_rng(0)

    def message(kind: str, body: bytes) -> bytes:
        return struct.pack("<HB", len(body), ord(kind)) + body

    head += message("B", bytes(40))
    for name, (fields, _, _) in formats.items():
        head += message("F", f"{name}:{fields}".encode())
    for i, (name, (_, code, rate)) in enumerate(formats.items()):
        head += message("A", b"\0" + struct.pack("<H", i) + name.encode())
        count = struct.calcsize(f"<{code}") // 4
        for t in _ticks(rate):
            values = rng.normal(0, 1, count)
            numbers = values.astype(int) if "i" in code else values
            row = [*numbers[:-1], values[-1]]
            body = struct.pack(f"<HQ{code}", i, round(t * 1e6), *row)
            several.append((t, message("D", body)))
    _repeated(path, head, [record for _, record in sorted(several)], 5, size)


def write_tlog(path: Path, seconds: float) -> None:
    """Attitude at 25 Hz, outputs and positions at 10 Hz, as a ground station writes them."""
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    boat = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    with path.open("wb") as file:
        for k in range(round(seconds * 50)):
            ms = 20 * k
            several = []
            if k % 2 == 0:
                several.append(
                    dialect.MAVLink_attitude_message(ms, 0, 0, 0.001 * (k % 3000), 0, 0, 0.1)
                )
            if k % 5 == 0:
                outputs = (1500, 0, 1600, 0, 0, 0, 0, 0)
                several += [
                    dialect.MAVLink_servo_output_raw_message(ms * 1000 % (1 << 32), 0, *outputs),
                    dialect.MAVLink_gps_raw_int_message(ms * 1000, 3, 599077000 + k, 107500000, 0, 1, 1, 0, 0, 9),
                    dialect.MAVLink_vfr_hud_message(1.0, 1.0, 10, 5, 0.0, 0.0),
                ]  # fmt: skip
            for sent in several:
                file.write(
                    struct.pack(">Q", 1_700_000_000_000_000 + ms * 1000) + bytes(sent.pack(boat))
                )


# Readers #


def with_seatrial(path: Path) -> Measured:
    """Opened, which counts all messages, and read."""
    from seatrial.io.formats import open_log
    from seatrial.io.log import Wanted

    begin = time.process_time()
    log = open_log(path)
    opened = time.process_time() - begin
    asked = [Wanted(t, f) for t, f in WANTED[path.suffix.lower()].items() if t in log.topics]
    found = log.read(asked)
    return {
        "seconds": time.process_time() - begin, "opened": opened,
        "messages": sum(len(s.stamps) for s in found),
    }  # fmt: skip


def with_library(path: Path) -> Measured:
    """The library of the format: the same fields of the same messages."""
    with contextlib.redirect_stdout(sys.stderr):  # they print
        return _with_library(path, WANTED[path.suffix.lower()])


def _with_library(path: Path, wanted: dict[str, tuple[str, ...]]) -> Measured:
    begin = time.process_time()
    if path.suffix.lower() == ".ulg":
        from pyulog import ULog

        log = ULog(str(path), list(wanted))
        opened = time.process_time() - begin
        count = 0
        for data in log.data_list:
            for name in wanted[data.name]:
                data.data[name].astype(float)
            count += len(data.data["timestamp"])
    else:
        from pymavlink import mavutil

        reader = mavutil.mavlink_connection(str(path))
        opened = time.process_time() - begin
        count = 0
        while (message := reader.recv_match(type=list(wanted))) is not None:
            if getattr(message, "I", 0) == 0:  # the first of several sensors
                for name in wanted[message.get_type()]:
                    getattr(message, name)
                count += 1
    return {"seconds": time.process_time() - begin, "opened": opened, "messages": count}


def with_pyulog_counts(path: Path) -> Measured:
    """pyulog on all topics of a `.ulg`, which it needs for their counts: it keeps their data."""
    from pyulog import ULog

    begin = time.process_time()
    with contextlib.redirect_stdout(sys.stderr):
        log = ULog(str(path))
    count = sum(len(data.data["timestamp"]) for data in log.data_list)
    return {"seconds": time.process_time() - begin, "messages": count}


WORK: dict[str, Callable[[Path], Measured]] = {
    "seatrial": with_seatrial, "library": with_library, "counts": with_pyulog_counts,
}  # fmt: skip
LIBRARIES = {".bin": "pymavlink", ".ulg": "pyulog", ".tlog": "pymavlink"}


def compare(path: Path, repeats: int) -> bool:
    """Print one row; whether it is at least half as fast."""
    found = {
        what: measured("autopilot_logs", what, path, repeats=repeats if what == "seatrial" else 1)
        for what in ("seatrial", "library")
    }
    ours, theirs = found["seatrial"], found["library"]
    assert ours["messages"] == theirs["messages"], (path, ours["messages"], theirs["messages"])
    size = path.stat().st_size / 1e6
    print(
        f"{path.suffix[1:]:5} {size:6.0f} MB  {ours['messages']:9d} messages   "
        f"seatrial {ours['seconds']:7.2f} s (topics {ours['opened']:.2f} s), {ours['peak'] / 1e6:5.0f} MB   "
        f"{LIBRARIES[path.suffix.lower()]} {theirs['seconds']:7.2f} s, {theirs['peak'] / 1e6:5.0f} MB   "
        f"speed {theirs['seconds'] / ours['seconds']:.1f} times the library's"
    )
    if path.suffix.lower() == ".ulg":
        whole = measured("autopilot_logs", "counts", path, repeats=1)
        ratio = (whole["seconds"] + theirs["seconds"]) / ours["seconds"]
        print(
            f"      pyulog, counts of all topics {whole['seconds']:.2f} s, {whole['peak'] / 1e6:.0f} MB: opened "
            f"and read it takes {ratio:.1f} times as long"
        )
    return bool(ours["seconds"] <= 2 * theirs["seconds"])


def main() -> int:
    """Write logs and read them; 1 where one is read at less than half the library's speed."""
    given = command.parser("autopilot_logs", __doc__)
    given.add_argument("--size", type=int, default=100, help="[MB] of .BIN and .ulg")
    given.add_argument("--log", type=Path, help="a log instead: .BIN, .ulg or .tlog")
    options(given)
    args = given.parse_args()
    if measure(args, WORK):
        return 0
    if args.log is not None:
        return int(not compare(args.log, REPEATS))
    good = True
    with tempfile.TemporaryDirectory() as name:
        for path, write in (
            (Path(name) / "run.BIN", lambda p: write_bin(p, args.size * 1_000_000)),
            (Path(name) / "run.ulg", lambda p: write_ulg(p, args.size * 1_000_000)),
            (Path(name) / "run.tlog", lambda p: write_tlog(p, TELEMETRY)),
        ):
            write(path)
            good &= compare(path, REPEATS)
            path.unlink()
    return int(not good)


if __name__ == "__main__":
    sys.exit(main())
