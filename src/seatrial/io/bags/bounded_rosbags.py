# SPDX-License-Identifier: MIT
"""The limits of `unpack` for rosbags, which unpacks a chunk before it looks at its size."""

import io
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from struct import Struct
from typing import IO, TYPE_CHECKING, Any
from urllib.parse import quote

from seatrial.io.bags.unpack import (
    PIECE,
    check_chunks,
    chunk_limit,
    file_limit,
    inflate,
    lz4_decompressor,
    room,
)

if TYPE_CHECKING:
    from types import ModuleType

    from rosbags.rosbag2.storage_mcap import McapReader

CHUNK = 0x06  # kind of an .mcap's record
RECORD = Struct("<BQ")  # kind and length [bytes] of its content
CHUNK_BEGIN = Struct("<QQQ")  # first and last time, unpacked size [bytes]


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


@cache
def bound_rosbags() -> None:
    """Put the limits into rosbags."""
    from rosbags.rosbag2 import reader, storage_mcap

    def lz4(data: bytes, _: int) -> bytes:
        return _whole(lz4_decompressor(), data)

    bounded = BoundedZstd(vars(reader)["zstd"])
    unpackers: dict[str, Callable[[bytes, int], bytes]] = storage_mcap.DECOMPRESSORS
    unpackers |= {"lz4": lz4, "zstd": lambda data, _: bounded.decompress(data)}
    setattr(reader, "zstd", bounded)  # noqa: B010, a module has no such type
    # without an index of chunks the whole file is unpacked: when it is opened, and when it is read
    for name in ("meta_scan", "messages_scan"):
        scan = getattr(storage_mcap.McapReader, name)
        setattr(storage_mcap.McapReader, name, _checked(scan))


def _checked(scan: Callable[..., Any]) -> Callable[..., Any]:
    """The method of an .mcap's reader, with all chunks checked before."""

    def checked(reader: "McapReader", *arguments: object) -> object:
        path = Path(str(reader.path))
        check_chunks(path, _chunks(reader), path.stat().st_size)
        return scan(reader, *arguments)

    return checked


def _chunks(reader: "McapReader") -> Iterator[tuple[int, int, int]]:
    """Position, packed and unpacked bytes of each chunk, by the records of an open .mcap."""
    file, at = reader.bio, reader.data_start
    while file is not None and at < reader.data_end:
        file.seek(at)
        head = file.read(RECORD.size)
        if len(head) < RECORD.size:
            return
        kind, length = RECORD.unpack(head)
        if kind == CHUNK:
            begin = file.read(CHUNK_BEGIN.size)
            if len(begin) < CHUNK_BEGIN.size:
                return
            yield at, length, CHUNK_BEGIN.unpack(begin)[2]
        at += RECORD.size + length


def _whole(packed: Any, data: bytes) -> bytes:  # noqa: ANN401, of several libraries
    """All of compressed bytes. Raises ValueError beyond the limit."""
    most = chunk_limit(len(data))
    found = inflate(packed, data, most + 1)
    if len(found) > most:
        raise ValueError(f"a chunk of {len(data)} bytes becomes more than {most}")
    if not packed.eof:
        raise ValueError("a chunk is cut off")
    return found
