# SPDX-License-Identifier: MIT
"""Salvage of a damaged .db3: the rows on all readable pages."""

import sqlite3
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from seatrial.io.bags.bag import LATEST, Bag, Message, Topic, merged_topics
from seatrial.io.bags.unpack import check_database, unpacked
from seatrial.io.bags.wire import plain
from seatrial.util.errors import RecordingError

MOST_DAMAGED_PARTS = 10_000  # that are skipped
FROM_ROW = "FROM messages WHERE rowid >= ? ORDER BY rowid"
DB3_ERRORS = (sqlite3.Error, UnicodeDecodeError, OverflowError)


@dataclass(frozen=True)
class _Row:
    number: int
    topic: int
    stamp: int
    data: bytes


class SalvagedDb3(Bag):
    """A .db3 with damaged pages: the rows on all others."""

    kind = "ROS 2 bag"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        check_database(path)
        uri = f"{path.resolve().as_uri()}?immutable=1"
        self._base = sqlite3.connect(uri, uri=True)
        self._base.execute("PRAGMA writable_schema = ON")  # needed to open a truncated file
        try:
            found = self._base.execute("SELECT id, name, type FROM topics").fetchall()
            names = {int(i): (str(name), str(kind)) for i, name, kind in found}
        except (sqlite3.Error, UnicodeDecodeError, ValueError, TypeError) as error:
            self.close()
            raise RecordingError(
                f"{path}: its list of topics is lost ({plain(str(error))}); nothing to salvage"
            ) from None
        texts = self._definitions()
        counts = Counter(row.topic for row in self._rows())
        self._known = {
            i: Topic(name, kind, counts[i], texts.get(kind, ("", False))[0],
                     idl=texts.get(kind, ("", False))[1])
            for i, (name, kind) in names.items()
        }  # fmt: skip
        self.topics = merged_topics(list(self._known.values()))
        self.remarks = self._salvaged(sum(t.messages for t in self._known.values()), self._lost)

    def close(self) -> None:
        """Close the file."""
        self._base.close()

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """The messages of some topics, in the order of the file."""
        for row in self._rows():
            topic = self._known.get(row.topic)
            if topic is not None and topic.name in names:
                yield topic.name, row.stamp, unpacked(row.data)

    def _definitions(self) -> dict[str, tuple[str, bool]]:
        """Texts by type, and whether they are IDL; none in bags before Iron."""
        query = "SELECT topic_type, encoded_message_definition, encoding FROM message_definitions"
        try:
            rows = self._base.execute(query).fetchall()
        except (sqlite3.Error, UnicodeDecodeError):
            return {}
        return {str(kind): (str(text), encoding == "ros2idl") for kind, text, encoding in rows}

    def _rows(self) -> Iterator[_Row]:
        """All readable rows, from the first on."""
        self._lost, at = 0, -LATEST
        while self._lost < MOST_DAMAGED_PARTS:
            try:
                for row in self._from(at):
                    at = row.number + 1
                    yield row
            except DB3_ERRORS:
                # sqlite returns a row only after it has searched for the next
                last = self._one(at)
                if last is not None:
                    at = last.number + 1
                    yield last
                    continue
            else:
                return
            self._lost += 1
            at = max(at, 0)
            step = self._readable_after(at)
            if step is None:
                return
            at += step

    def _from(self, at: int, ends: str = "") -> Iterator[_Row]:
        query = f"SELECT rowid, topic_id, timestamp, data {FROM_ROW}{ends}"
        for number, topic, stamp, data in self._base.execute(query, (at,)):
            if type(number) is not int or number < at:
                raise sqlite3.DatabaseError("pages in a cycle")
            at = number + 1
            kinds = [type(value) for value in (topic, stamp, data)]
            if kinds == [int, int, bytes] and 0 <= stamp <= LATEST:
                yield _Row(number, topic, stamp, data)

    def _one(self, at: int) -> _Row | None:
        try:
            return next(self._from(at, " LIMIT 1"), None)
        except DB3_ERRORS:
            return None

    def _readable_after(self, at: int) -> int | None:
        """Distance to the next readable row: doubled until one is found, then bisected."""
        far = 1
        while not self._readable(at + far):
            far *= 2
            if at + far > LATEST:
                return None
        near = far // 2
        while far - near > 1:
            middle = (near + far) // 2
            near, far = (near, middle) if self._readable(at + middle) else (middle, far)
        return far

    def _readable(self, number: int) -> bool:
        query = f"SELECT data {FROM_ROW} LIMIT 1"
        try:
            self._base.execute(query, (number,)).fetchall()
        except (sqlite3.Error, UnicodeDecodeError):
            return False
        return True
