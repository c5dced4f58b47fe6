# SPDX-License-Identifier: MIT
"""How much a bag may become in memory and on disk.

Sensor data is compressed 2 to 20 times, empty images some 100 times. A bag that is made to fill the memory has
zeros: 30 000 times by zstd, and more by bzip2.
"""

import io
import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any
from urllib.parse import quote

from seatrial.util.errors import RecordingError

if TYPE_CHECKING:
    from types import ModuleType

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
            query = "SELECT type, name, coalesce(sql, '') FROM sqlite_master"
            for kind, name, text in base.execute(query):
                if kind not in ("table", "index") or "virtual" in str(text).lower()[:40]:
                    raise RecordingError(
                        f"{path}: has a {kind} '{name}', which no recording has; it is not read"
                    )
        finally:
            base.close()
    except (sqlite3.Error, UnicodeDecodeError, ValueError, OverflowError):
        return  # damaged: its reader says how


class UriPath(type(Path())):  # type: ignore[misc]
    """A path that rosbags can put into the URI of a database: `a#1.db3` is not `a`."""

    def __format__(self, spec: str) -> str:
        return quote(str(self))


class BoundedZstd:
    """What rosbags uses of zstd, within the limits."""

    def __init__(self, module: "ModuleType") -> None:
        self._module = module
        self.ZstdError = module.ZstdError

    def decompress(self, data: bytes) -> bytes:
        """All of it."""
        return _whole(self._module.ZstdDecompressor(), data)

    def open(self, file: IO[bytes], mode: str = "rb") -> "Bounded":
        """A file to read; its size is that of the packed one."""
        at = file.tell()
        size = file.seek(0, io.SEEK_END)
        file.seek(at)
        return Bounded(self._module.open(file, mode), file_limit(size))


class Bounded(io.RawIOBase):
    """A file that ends in an error where it is longer than `most` [bytes], or than the disk has room for."""

    def __init__(self, file: IO[bytes], most: int) -> None:
        self._file, self._left = file, min(most, room())

    def readable(self) -> bool:
        """It is."""
        return True

    def close(self) -> None:
        """Close the file, too."""
        self._file.close()
        super().close()

    def read(self, size: int = -1) -> bytes:
        """The next bytes. Raises ValueError beyond the limit."""
        found = self._file.read(PIECE if size < 0 else size)
        self._left -= len(found)
        if self._left < 0:
            raise ValueError(
                "unpacked it is larger than recordings are, or than the disk has room for"
            )
        return found


def room() -> int:
    """[bytes] for temporary files."""
    return max(0, shutil.disk_usage(tempfile.gettempdir()).free - LEAST_FREE)


@cache
def bound_rosbags() -> None:
    """Put the limits into rosbags, which unpacks whatever a chunk contains before it looks at the size."""
    from rosbags.rosbag2 import reader, storage_mcap

    from seatrial.io.bags.unpack import lz4_decompressor

    def lz4(data: bytes, _: int) -> bytes:
        return _whole(lz4_decompressor(), data)

    bounded = BoundedZstd(vars(reader)["zstd"])
    unpackers: dict[str, Callable[[bytes, int], bytes]] = storage_mcap.DECOMPRESSORS
    unpackers |= {"lz4": lz4, "zstd": lambda data, _: bounded.decompress(data)}
    setattr(reader, "zstd", bounded)  # noqa: B010, a module has no such type


def _whole(packed: Any, data: bytes) -> bytes:  # noqa: ANN401, of several libraries
    """All of compressed bytes. Raises ValueError beyond the limit."""
    from seatrial.io.bags.unpack import inflate

    most = chunk_limit(len(data))
    found = inflate(packed, data, most + 1)
    if len(found) > most:
        raise ValueError(f"a chunk of {len(data)} bytes becomes more than {most}")
    return found
