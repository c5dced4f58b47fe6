# SPDX-License-Identifier: MIT
"""A bag that a recorder writes now: its messages as they are flushed."""

from abc import abstractmethod
from collections import Counter
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

from seatrial.io.bags.bag import Bag, Message, Topic, merged_topics
from seatrial.io.bags.ros2 import by_number
from seatrial.util.errors import FileError, RecordingError
from seatrial.util.files import readable

BLOCK = 16 << 20  # [bytes] that are read at once
LARGEST_RECORD = 256 << 20  # [bytes]: a longer one is no record


class GrowingBag(Bag):
    """The messages that `grow` found last; of a folder, those of its files in turn.

    path: a file, or a folder with one recording. Neither need be there yet.
    """

    salvage = True
    suffix: str  # of the files in a folder

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, ()
        self._message_counts: Counter[str] = Counter()  # messages so far, by topic
        self._at = 0  # of the newest file: how much is used
        self._complete = False  # whether that file is
        self._new: list[Message] = []
        self.topics = {}
        self._known: dict[int, Topic] = {}  # of the newest file, by number
        self._begin()

    def grow(self) -> set[str]:
        """Read what was added, of `BLOCK` and one record at most; its topics. Raises FileError, RecordingError."""
        self._new = []
        if self._complete or not self.files:
            self._open_next()
        if self.files and not self._complete:
            # a recorder closes a file before it begins the next
            later, before = self._left(), self._at
            self._read()
            self._complete |= bool(later) and not self._new and self._at == before
        self._message_counts.update(topic for topic, _, _ in self._new)
        self.topics |= merged_topics(self._known.values())
        counts = self._message_counts
        self.topics = {n: replace(t, messages=counts[n]) for n, t in self.topics.items()}
        return {topic for topic, _, _ in self._new}

    @property
    def place(self) -> tuple[int, int, bool]:
        """How far it is read: files, place in the newest one, whether that one is complete."""
        return len(self.files), self._at, self._complete

    def messages(self, names: Collection[str]) -> Iterator[Message]:
        """Those of the last `grow`."""
        return (one for one in self._new if one[0] in names)

    def check(self, name: str, count: int) -> None:
        """Nothing: the number of messages is not known before the end."""

    def close(self) -> None:
        """Nothing: no file stays open."""

    def _after_magic(self, block: bytes, magic: bytes, kind: str) -> bytes:
        """The block behind the file's first bytes, none before they are written. Raises RecordingError."""
        if self._at == 0 and len(block) >= len(magic):
            if not block.startswith(magic):
                raise RecordingError(f"{self.files[-1]}: does not begin like {kind}")
            self._at, block = len(magic), block[len(magic) :]
        return block if self._at else b""

    @abstractmethod
    def _begin(self) -> None:
        """Forget what is known of the file before."""

    @abstractmethod
    def _read(self) -> None:
        """Add what is new in the newest file to `_new`. Raises FileError, RecordingError."""

    def _there(self) -> list[Path]:
        """Files of the recording, in their order."""
        folder = self.path.is_dir()
        found = sorted(self.path.glob(f"*{self.suffix}"), key=by_number) if folder else [self.path]
        return [file for file in found if file.exists()]

    def _left(self) -> list[Path]:
        """Files that are not used yet."""
        return [file for file in self._there() if file not in self.files]

    def _open_next(self) -> None:
        """Go on with the first file that is not used yet, if there is one."""
        if left := self._left():
            self.files = (*self.files, left[0])
            self._at, self._complete = 0, False
            self._begin()

    def _names(self) -> tuple[Path, ...]:
        """Those that the newest file has one after the other; a recorder may rename it at any time."""
        return self.files[-1:]

    def _opened_file(self) -> BinaryIO:
        """The newest file, under the name that it has now. Raises OSError."""
        *earlier, last = self._names()
        for name in earlier:
            # opened without a look before: it may be renamed between the two
            with suppress(FileNotFoundError):
                return name.open("rb")
        return last.open("rb")

    def _bytes(self, most: int = BLOCK) -> bytes:
        """The bytes of the newest file after those that are used."""
        with readable(self.files[-1]), self._opened_file() as file:
            if file.seek(0, 2) < self._at:
                raise FileError(
                    f"{self.files[-1].name}: became shorter; a bag that is followed only grows"
                )
            file.seek(self._at)
            return file.read(most)
