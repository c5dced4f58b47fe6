# SPDX-License-Identifier: MIT
"""A .db3 that rosbag2 writes now, with a write-ahead log: its rows as they are committed.

Without that log a reader's lock stops the recorder (https://sqlite.org/wal.html).
"""

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager

from seatrial.io.bags.bag import Topic
from seatrial.io.bags.growing.growing_bag import BLOCK, GrowingBag
from seatrial.io.bags.salvage_db3 import DB3_ERRORS, SalvagedDb3
from seatrial.io.bags.unpack import check_schema, unpacked
from seatrial.io.bags.wire import plain
from seatrial.util.errors import FileError, RecordingError

HEADER, VERSIONS, LOGGED = 100, slice(18, 20), b"\x02\x02"  # [bytes] of a database with such a log
RESILIENT = "ros2 bag record -s sqlite3 --storage-preset-profile resilient"


class GrowingDb3(GrowingBag, SalvagedDb3):
    """Rows of a .db3 as they are committed. The database is open during `grow` only."""

    suffix = ".db3"

    def _begin(self) -> None:
        self._known = {}
        self._seen: tuple[int, ...] = ()  # sizes and times when it was read

    def _read(self) -> None:
        try:
            seen = self._state()
            if seen == self._seen or not self._logged():
                # the next file is begun when the one before is closed
                self._complete = self.files[-1] != self._there()[-1]
                return
            self._seen = seen
            with self._opened():
                self._rows_after()
        except OSError as error:
            raise FileError(f"{self.files[-1]}: can't be read ({error.strerror})") from None
        except DB3_ERRORS as error:
            raise RecordingError(f"{self.files[-1]}: can't be read ({plain(str(error))})") from None

    def _state(self) -> tuple[int, ...]:
        """Sizes [bytes] and times [ns] of the file and its log."""
        file = self.files[-1]
        log = file.with_name(f"{file.name}-wal")
        stats = [file.stat(), *([log.stat()] if log.exists() else [])]
        return tuple(value for one in stats for value in (one.st_size, one.st_mtime_ns))

    def _logged(self) -> bool:
        """Whether it is a database with a write-ahead log, once it has begun. Raises RecordingError."""
        with self.files[-1].open("rb") as file:
            head = file.read(HEADER)
        if len(head) == HEADER and head[VERSIONS] != LOGGED and not self._at:
            raise RecordingError(
                f"{self.files[-1]}: has no write-ahead log, so reading it now would stop its recorder; "
                f"record with '{RESILIENT}', or as .mcap"
            )
        return len(head) == HEADER

    @contextmanager
    def _opened(self) -> Iterator[None]:
        file = self.files[-1]
        being_written = file.with_name(f"{file.name}-wal").exists()
        # without a log sqlite would make one, and leave it
        mode = "mode=ro" if being_written else "immutable=1"
        uri = f"{file.resolve().as_uri()}?{mode}"
        self._base = sqlite3.connect(uri, uri=True)
        try:
            check_schema(self._base, file)
            yield
        finally:
            self._base.close()

    def _rows_after(self) -> None:
        """Topics, and the rows after row number `_at`."""
        if not self._base.execute("SELECT 1 FROM sqlite_master WHERE name = 'messages'").fetchone():
            return
        texts = self._definitions()
        for number, name, kind in self._base.execute("SELECT id, name, type FROM topics"):
            text, idl = texts.get(str(kind), ("", False))
            self._known[int(number)] = Topic(str(name), str(kind), 0, text, idl=idl)
        size = 0
        for row in self._from(self._at + 1):
            self._at = row.number
            topic = self._known.get(row.topic)
            if topic is not None:
                self._new.append((topic.name, row.stamp, unpacked(row.data)))
            size += len(row.data)
            if size > BLOCK:
                self._seen = ()  # there are more
                return
