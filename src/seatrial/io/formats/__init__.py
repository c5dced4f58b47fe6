# SPDX-License-Identifier: MIT
"""Logs of autopilots: ArduPilot (`.BIN`, `.log`), PX4 (`.ulg`), MAVLink telemetry (`.tlog`), MOOS (`.alog`).

The binary formats are walked over here, message by message: their libraries keep an index entry for every
message or the whole file, and hang, flood the terminal or stop early on damaged files. pymavlink states
what MAVLink's messages hold; pymavlink and pyulog are the oracles of the tests.
"""

import re
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

from seatrial.io.formats.ardupilot import ArduPilotLog
from seatrial.io.formats.ardupilot_text import ArduPilotTextLog
from seatrial.io.formats.mavlink import MavlinkLog, is_telemetry
from seatrial.io.formats.moos import MoosLog
from seatrial.io.formats.px4 import Px4Log
from seatrial.io.log import Log
from seatrial.util.errors import FileError, RecordingError

Reader = Callable[[Path], Log]
OPENED = 8  # logs whose topics are kept
BEGINNING = 8192  # [bytes] by which a format is recognised
BEGINNINGS: dict[Reader, re.Pattern[bytes]] = {  # what is in the first bytes
    Px4Log: re.compile(rb"\A\x55\x4c\x6f\x67\x01\x12\x35"),
    ArduPilotLog: re.compile(rb"\A\xa3\x95"),
    ArduPilotTextLog: re.compile(rb"^FMT, ?\d{1,3}, ?\d{1,3}, ?\w{1,8}, ?\w", re.MULTILINE),
    MoosLog: re.compile(rb"^%% (LOGSTART|LOG FILE:)", re.MULTILINE),
}
SUFFIXES: dict[str, Reader] = {
    ".bin": ArduPilotLog, ".ulg": Px4Log, ".tlog": MavlinkLog, ".alog": MoosLog,
}  # fmt: skip


def is_log(path: str | Path) -> bool:
    """Whether this is the log of an autopilot, by its content or its name."""
    return _reader(Path(path)) is not None


def open_log(path: str | Path) -> Log:
    """The log, read once for its topics and their counts. Raises RecordingError, FileError."""
    path = Path(path)
    reader = _reader(path)
    if reader is None:
        raise RecordingError(
            f"{path}: no log of ArduPilot (.BIN, .log), PX4 (.ulg), MAVLink (.tlog) or MOOS (.alog)"
        )
    if not path.exists():
        raise FileError(f"{path}: no such file")
    found = path.stat()
    if found.st_size == 0:
        raise RecordingError(f"{path}: is empty (0 bytes)")
    return _opened(path, reader, found.st_size, found.st_mtime_ns)


@lru_cache(maxsize=OPENED)
def _opened(path: Path, reader: Reader, _size: int, _changed: int) -> Log:
    """The log; of a file that has not changed the one opened before, as counting its messages takes a pass."""
    return reader(path)


def _reader(path: Path) -> Reader | None:
    """The reader of the format, by the first bytes, else by the suffix."""
    if path.is_dir():
        return None
    try:
        with path.open("rb") as file:
            beginning = file.read(BEGINNING)
    except OSError:
        beginning = b""
    for reader, own in BEGINNINGS.items():
        if own.search(beginning) is not None:
            return reader
    return MavlinkLog if is_telemetry(beginning) else SUFFIXES.get(path.suffix.lower())
