# SPDX-License-Identifier: MIT
"""What is no recording, in words: text, a folder of recordings, a file of another kind."""

from collections.abc import Iterator
from pathlib import Path

from seatrial.io.bags.opening import is_bag
from seatrial.io.formats import is_log
from seatrial.io.table import ALONE, TABLES, is_table
from seatrial.util.errors import FileError, RecordingError, SeatrialError
from seatrial.util.format import joined

EXPECTED = (
    "expected a bag (.bag, .mcap, .db3, or a folder of ROS 2), a log of ArduPilot (.BIN, .log), PX4 (.ulg), "
    f"MAVLink (.tlog) or MOOS (.alog), a table ({', '.join((*TABLES, *ALONE))}), or a folder of tables"
)
YAML = (".yaml", ".yml")
LISTED = 8  # recordings in a message
TRUTH = "truth"  # folder of the true states of simulated trials, which a real boat does not record


def refused(path: Path) -> SeatrialError | None:
    """Why this is neither bag, log nor table; None where it may be one."""
    if not path.exists():
        return FileError(f"{path}: no such file or folder")
    if is_bag(path) or is_log(path) or is_table(path):
        return None
    if not path.is_dir():
        hint = f"; a vehicle file is given as --vehicle {path}" if path.suffix in YAML else ""
        return RecordingError(f"{path}: {EXPECTED}, got '{path.suffix}'{hint}")
    inside = list(recordings_in(path))
    if inside:
        number = f"{len(inside)} recordings" if len(inside) > 1 else "a recording"
        more = [f"{len(inside) - LISTED} more"] if len(inside) > LISTED else []
        listed = joined([*map(str, inside[:LISTED]), *more])
        return RecordingError(f"{path}: is no recording but a folder with {number}: give {listed}")
    if not any(path.iterdir()):
        return FileError(f"{path}: is an empty folder; {EXPECTED}")
    return FileError(f"{path}: no table and no bag in this folder; {EXPECTED}")


def recordings_in(folder: Path) -> Iterator[Path]:
    """Recordings one level down, by their names and first bytes; not the truth of simulated ones."""
    for path in sorted(folder.iterdir()):
        if (
            not path.name.startswith(".")
            and path.name != TRUTH
            and (is_bag(path) or is_log(path) or (path.is_dir() and is_table(path)))
        ):
            yield path
