# SPDX-License-Identifier: MIT
"""Logs of autopilots: ArduPilot (`.BIN`, `.log`), PX4 (`.ulg`), MAVLink telemetry (`.tlog`), MOOS (`.alog`).

The binary formats are walked over here, message by message: their libraries keep an index entry for every
message or the whole file, and hang, flood the terminal or stop early on damaged files. pymavlink states
what MAVLink's messages hold; pymavlink and pyulog are the oracles of the tests.
"""

import re
from functools import lru_cache
from pathlib import Path

from seatrial.io.log import Log
from seatrial.util.errors import FileError, RecordingError

OPENED = 8  # logs whose topics are kept
BEGINNING = 8192  # [bytes] by which a format is recognised
BEGINNINGS = {  # what is in the first bytes
    "px4": re.compile(rb"\A\x55\x4c\x6f\x67\x01\x12\x35"),
    "ardupilot": re.compile(rb"\A\xa3\x95"),
    "ardupilot text": re.compile(rb"^FMT, ?\d{1,3}, ?\d{1,3}, ?\w{1,8}, ?\w", re.MULTILINE),
    "moos": re.compile(rb"^%% (LOGSTART|LOG FILE:)", re.MULTILINE),
}
SUFFIXES = {".bin": "ardupilot", ".ulg": "px4", ".tlog": "mavlink", ".alog": "moos"}


def is_log(path: str | Path) -> bool:
    """Whether this is the log of an autopilot, by its content or its name."""
    return _kind(Path(path)) is not None


def open_log(path: str | Path) -> Log:
    """The log, read once for its topics and their counts. Raises RecordingError, FileError."""
    path = Path(path)
    kind = _kind(path)
    if kind is None:
        raise RecordingError(
            f"{path}: no log of ArduPilot (.BIN, .log), PX4 (.ulg), MAVLink (.tlog) or MOOS (.alog)"
        )
    if not path.exists():
        raise FileError(f"{path}: no such file")
    found = path.stat()
    if found.st_size == 0:
        raise RecordingError(f"{path}: is empty (0 bytes)")
    return _opened(path, kind, found.st_size, found.st_mtime_ns)


@lru_cache(maxsize=OPENED)
def _opened(path: Path, kind: str, _size: int, _changed: int) -> Log:
    """The log; of a file that has not changed the one opened before, as counting its messages takes a pass."""
    if kind == "ardupilot":
        from seatrial.io.formats.ardupilot import ArduPilotLog

        return ArduPilotLog(path)
    if kind == "ardupilot text":
        from seatrial.io.formats.ardupilot_text import ArduPilotTextLog

        return ArduPilotTextLog(path)
    if kind == "px4":
        from seatrial.io.formats.px4 import Px4Log

        return Px4Log(path)
    if kind == "moos":
        from seatrial.io.formats.moos import MoosLog

        return MoosLog(path)
    from seatrial.io.formats.mavlink import MavlinkLog

    return MavlinkLog(path)


def _kind(path: Path) -> str | None:
    """The format, by the first bytes, else by the suffix."""
    if path.is_dir():
        return None
    try:
        with path.open("rb") as file:
            beginning = file.read(BEGINNING)
    except OSError:
        beginning = b""
    for kind, own in BEGINNINGS.items():
        if own.search(beginning) is not None:
            return kind
    return "mavlink" if _is_telemetry(beginning) else SUFFIXES.get(path.suffix.lower())


def _is_telemetry(data: bytes) -> bool:
    """Whether records of a stamp of this century and a MAVLink frame follow each other."""
    at, found = 0, 0
    while at + 12 <= len(data) and found < 4:
        usec = int.from_bytes(data[at : at + 8], "big")
        if data[at + 8] not in (0xFE, 0xFD) or not 9e14 < usec < 5e15:
            return False
        at += 8 + frame_size(data, at + 8)
        found += 1
    return found > 0 and at <= max(len(data), BEGINNING)


def frame_size(data: bytes, at: int) -> int:
    """[bytes] of the MAVLink frame that begins at a place, of version 1 or 2."""
    if data[at] == 0xFE:
        return 8 + data[at + 1]
    return 12 + data[at + 1] + (13 if data[at + 2] & 1 else 0)  # signed
