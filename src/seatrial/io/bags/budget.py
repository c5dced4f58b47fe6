# SPDX-License-Identifier: MIT
"""How much a bag may become in memory and on disk.

Sensor data is compressed 2 to 20 times, empty images some 100 times. A bag that is made to fill the memory has
zeros: 30 000 times by zstd, and more by bzip2.
"""

import shutil
import sqlite3
import tempfile
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import quote

from seatrial.util.errors import RecordingError

ALWAYS = 1 << 26  # [bytes] that any chunk or message may be: writers make chunks of 1 to 50 MB
RATIO = 256  # of unpacked to packed bytes, above that; all of a bag's chunks together, too
ALWAYS_FILE = 1 << 30  # [bytes] that any compressed file may be, and all chunks of any bag
LARGEST_CHUNK = 1 << 30  # [bytes] of a chunk, however large it is in the file
LEAST_FREE = 1 << 30  # [bytes] that stay free on the disk of temporary files
PIECE = 1 << 16  # [bytes] unpacked at once


def chunk_limit(packed: int) -> int:
    """[bytes] that so many packed ones may become."""
    return min(max(ALWAYS, RATIO * packed), LARGEST_CHUNK)


def file_limit(packed: int) -> int:
    """[bytes] that a file of this size may become, or its chunks together."""
    return max(ALWAYS_FILE, RATIO * packed)


def check_chunks(path: Path, chunks: Iterable[tuple[int, int, int]], size: int) -> None:
    """Raise RecordingError for chunks (position, packed and unpacked bytes) beyond the limits."""
    total, seen = 0, set()
    for position, packed, unpacked in chunks:
        if position in seen:
            raise RecordingError(f"{path}: the bag is damaged: it lists a chunk twice")
        seen.add(position)
        total += unpacked
        if unpacked > chunk_limit(packed) and unpacked > packed:
            raise too_large(path, f"a chunk of {packed} bytes", unpacked)
    if total > file_limit(size):
        raise too_large(path, f"its {size} bytes", total)


def too_large(path: Path, what: str, unpacked: int) -> RecordingError:
    """The error of a bag that is made to fill the memory."""
    return RecordingError(
        f"{path}: {what} would become {unpacked / 1e6:.0f} MB, {RATIO} times more than recordings do; "
        "it is damaged, or not a recording"
    )


def check_database(path: Path) -> None:
    """Raise RecordingError where a .db3 has views or triggers: reading a view may run for ever."""
    try:
        base = sqlite3.connect(f"file:{quote(str(path.resolve()))}?immutable=1", uri=True)
        try:
            base.execute("PRAGMA writable_schema = ON")  # opens also a truncated file
            check_schema(base, path)
        finally:
            base.close()
    except (sqlite3.Error, UnicodeDecodeError, ValueError, OverflowError):
        return  # damaged: its reader says how


def check_schema(base: sqlite3.Connection, path: Path) -> None:
    """Raise RecordingError where a database has views or triggers."""
    query = "SELECT type, name, coalesce(sql, '') FROM sqlite_master"
    for kind, name, text in base.execute(query):
        if kind not in ("table", "index") or "virtual" in str(text).lower()[:40]:
            raise RecordingError(
                f"{path}: has a {kind} '{name}', which no recording has; it is not read"
            )


def room() -> int:
    """[bytes] for temporary files."""
    return max(0, shutil.disk_usage(tempfile.gettempdir()).free - LEAST_FREE)
