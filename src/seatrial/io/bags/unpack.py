# SPDX-License-Identifier: MIT
"""Decompression of bags: with a size limit, and up to the first damage."""

import shutil
import sqlite3
import sys
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Protocol
from urllib.parse import quote

from seatrial.io.bags.bag import SALVAGE, Bag, Message
from seatrial.io.bags.wire import plain
from seatrial.util.errors import RecordingError

LZ4_RATIO = 256  # largest ratio of lz4
LARGEST_MESSAGE = 1 << 28  # [bytes]
ZSTD = b"\x28\xb5\x2f\xfd"  # first bytes of a compressed message; CDR starts with 0
ALWAYS = 1 << 26  # [bytes] that any chunk or message may be: writers make chunks of 1 to 50 MB
RATIO = 256  # of unpacked to packed bytes, above that; all of a bag's chunks together, too
ALWAYS_FILE = 1 << 30  # [bytes] that any compressed file may be, and all chunks of any bag
LARGEST_CHUNK = 1 << 30  # [bytes] of a chunk, however large it is in the file
LEAST_FREE = 1 << 30  # [bytes] that stay free on the disk of temporary files
PIECE = 1 << 16  # [bytes] unpacked at once


if TYPE_CHECKING:
    from backports.zstd import ZstdDecompressor


class Decompressor(Protocol):
    """Common interface of bz2, lz4 and zstd."""

    @property
    def eof(self) -> bool:
        """Whether the end was reached."""

    @property
    def needs_input(self) -> bool:
        """Whether the input is used up."""

    def decompress(self, data: bytes, max_length: int) -> bytes:
        """The next part."""


def inflate(packed: Decompressor, raw: bytes, most: int, *, part: bool = False) -> bytes:
    """At most `most` bytes out of compressed ones; with `part` those before the damage.

    Raises ValueError.
    """
    errors: tuple[type[Exception], ...]
    errors = (OSError, EOFError, RuntimeError, ValueError, MemoryError, *_zstd_errors())
    found: list[bytes] = []
    left = most
    try:
        for at in range(0, len(raw), PIECE):
            given = raw[at : at + PIECE]
            while left > 0 and not packed.eof and (given or not packed.needs_input):
                found.append(packed.decompress(given, max_length=left))
                left -= len(found[-1])
                given = b""
    except errors as error:
        if not part:
            raise ValueError(f"can't be decompressed: {plain(str(error))}") from None
    return b"".join(found)


def lz4_decompressor() -> Decompressor:
    """For frames of lz4."""
    from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

    found: Decompressor = LZ4FrameDecompressor()
    return found


def zstd_decompressor() -> "ZstdDecompressor":
    """For frames of zstd."""
    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    return zstd.ZstdDecompressor()


def _zstd_errors() -> tuple[type[Exception], ...]:
    """What zstd raises, if it is in use."""
    module = sys.modules.get("compression.zstd") or sys.modules.get("backports.zstd")
    return () if module is None else (module.ZstdError,)


class UnpackedBag(Bag):
    """A file compressed as a whole, unpacked into a temporary folder."""

    def __init__(self, path: Path, opened: Callable[[Path], Bag], *, salvage: bool) -> None:
        self.path = path
        self._folder = tempfile.TemporaryDirectory()
        unpacked = Path(self._folder.name) / path.stem
        try:
            self._unpack(unpacked, salvage=salvage)
            self._bag = opened(unpacked)
        except RecordingError as error:
            self._folder.cleanup()
            raise RecordingError(str(error).replace(str(unpacked), str(path))) from None
        except OSError:
            self._folder.cleanup()
            raise
        self.kind, self.topics, self.remarks = self._bag.kind, self._bag.topics, self._bag.remarks
        self._bag.path = path  # for error messages
        self.files = (path,)

    def close(self) -> None:
        """Remove the temporary folder."""
        self._bag.close()
        self._folder.cleanup()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics."""
        yield from self._bag.messages(names)

    def _unpack(self, target: Path, *, salvage: bool) -> None:
        """Unpack up to the first damage. Raises RecordingError where that is not the end."""
        packed = zstd_decompressor()
        size = self.path.stat().st_size
        left = most = min(file_limit(size), room())
        with self.path.open("rb") as source, target.open("wb") as out:
            for raw in iter(lambda: source.read(PIECE), b""):
                try:
                    while raw or not (packed.eof or packed.needs_input):
                        packed = zstd_decompressor() if packed.eof else packed
                        piece = packed.decompress(raw, max_length=PIECE)
                        left -= out.write(piece)
                        if left < 0:
                            raise RecordingError(
                                f"{self.path}: its {size} bytes become more than {most / 1e6:.0f} MB: more than "
                                "recordings do, or than the disk of temporary files has room for"
                            )
                        raw = packed.unused_data if packed.eof else b""  # noqa: PLW2901
                except _zstd_errors():
                    break
        if not packed.eof and not salvage:
            raise RecordingError(f"{self.path}: the compressed bag is not whole; {SALVAGE}")


def unpacked(data: bytes) -> bytes:
    """A message, decompressed if it is compressed by itself."""
    if not data.startswith(ZSTD):
        return data
    return inflate(zstd_decompressor(), data, LARGEST_MESSAGE, part=True)


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


def room() -> int:
    """[bytes] for temporary files."""
    return max(0, shutil.disk_usage(tempfile.gettempdir()).free - LEAST_FREE)
