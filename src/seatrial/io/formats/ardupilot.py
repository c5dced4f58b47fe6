# SPDX-License-Identifier: MIT
"""ArduPilot's binary logs (`.BIN`).

A message is 0xA3 0x95, a type, and the columns that an earlier FMT message defines. Stamps are `TimeUS`,
microseconds since boot (`TimeMS` in old logs). Messages carry no checksum: one counts where another
follows it, or padding, or the file ends.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from seatrial.io.formats.dataflash import (
    DEFINING,
    HEADER,
    NO_STAMPS,
    Definitions,
    Format,
    Stated,
    Values,
)
from seatrial.io.formats.layout import Columns, pass_blocks, refuse_noise, topic_name
from seatrial.io.log import Log, LogSamples, Wanted
from seatrial.util.errors import RecordingError
from seatrial.util.files import readable

HEAD = b"\xa3\x95"
FMT = Format(0x80, "FMT", 89, "BBnNZ", ("Type", "Length", "Name", "Format", "Columns"))
LONGEST = 255  # [bytes] of a message
FOLLOWERS = frozenset((HEAD, b"\0\0", b"\xff\xff", b"", b"\xa3", b"\0", b"\xff"))  # or padding
BAD_PLACES = 50_000  # after which a file that is less than half messages is no log
Visit = Callable[[bytes, int], None]  # data, and where the message begins


class ArduPilotLog(Log):
    """A `.BIN` file."""

    kind = "ArduPilot log"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        self._stated: Stated = {}
        walk = _Walk(path, self._stated)
        if walk.late:  # messages before the units that tell their instances apart
            walk = _Walk(path, self._stated)
        self.topics = walk.definitions.topics(walk.totals)
        self.parameters = walk.definitions.parameters
        if not self.topics:
            raise RecordingError(f"{path}: {NO_STAMPS}")
        self.remarks = walk.remarks()

    def _read(self, wanted: Sequence[Wanted]) -> list[LogSamples]:
        columns = [Columns(each.topic, each.fields) for each in wanted]
        _Walk(self.path, self._stated, columns)
        return [each.samples() for each in columns]


class _Walk:
    """One pass over the file: counts messages, or collects the wanted columns."""

    def __init__(
        self, path: Path, stated: Stated, columns: Sequence[Columns] | None = None
    ) -> None:
        self.path, self.columns = path, columns
        self.definitions = Definitions(stated=stated)
        self.sizes = [0] * 256  # [bytes] of a message, by type; 0: unknown
        self.seen = [0] * 256  # messages since the type's last definition
        self.visits: list[Visit | None] = [None] * 256
        self.instances: dict[int, list[int]] = {}  # counts by type, of each instance
        self.totals: Counter[tuple[str, int]] = Counter()  # messages by name and instance
        self.unsound: set[str] = set()
        self.in_step = True  # whether the last bytes are a message
        self.lost, self.places = 0, 0  # [bytes] that are no message, runs of them
        self.passed = 0  # [bytes] that are messages, of settled formats
        self.current: dict[int, Format] = {}
        self.late = False  # whether units came after messages
        self._begin(FMT)
        with readable(path), path.open("rb") as file:
            pass_blocks(file, path.stat().st_size, self._pass)
        for found in self.current.values():
            self._settle(found)

    def remarks(self) -> tuple[str, ...]:
        """Losses."""
        texts = []
        if self.lost:
            texts.append(f"{self.lost} bytes in {self.places} places are no message")
        if self.unsound:
            listed = ", ".join(sorted(self.unsound)[:10])
            texts.append(f"not read, as their definitions contradict themselves: {listed}")
        return tuple(texts)

    def _pass(self, data: bytes, ended: bool) -> int:
        """Pass all messages that are whole; returns where the next one begins."""
        sizes, seen, visits = self.sizes, self.seen, self.visits
        at, end, in_step = 0, len(data), self.in_step
        last = end if ended else end - LONGEST - len(HEAD)
        while at < last:
            if data[at : at + 2] == HEAD and at + 2 < end:
                number = data[at + 2]
                after = at + sizes[number]
                if at < after <= end and data[after : after + 2] in FOLLOWERS:
                    seen[number] += 1
                    visit = visits[number]
                    if visit is not None:
                        visit(data, at)
                    at, in_step = after, True
                    continue
            found = data.find(HEAD, at + 1)
            after = found if found >= 0 else end if ended else max(at + 1, end - 1)
            if data[at:after].strip(b"\0\xff"):
                self.lost += after - at
                self.places += in_step
                in_step = False
                if self.lost > BAD_PLACES:
                    found = sum(n * size for n, size in zip(self.seen, self.sizes, strict=True))
                    refuse_noise(self.path, "ArduPilot log", self.passed + found, self.lost)
            at = after
        self.in_step = in_step
        return at

    def _begin(self, found: Format) -> None:
        """What to do from here on with the messages of a new or changed format."""
        number = found.number
        before = self.current.get(number)
        if before is not None:
            alike = before.key == found.key and before.instance == found.instance
            self.late |= not alike and before.key == found.key and self.seen[number] > 0
            self._settle(before)
        self.current[number] = found
        self.sizes[number] = found.size
        self.visits[number] = None
        if not found.consistent or HEADER + found.body.size != found.size:
            self.unsound.add(found.name)
        elif found.name in DEFINING:
            self.visits[number] = self._definer(found)
        elif self.columns is not None:
            self.visits[number] = self._collector(found, self.columns)
        elif found.instance is not None:
            self.visits[number] = self._counter(found)

    def _settle(self, found: Format) -> None:
        """Add the messages so far of a format to the totals."""
        number = found.number
        if number in self.instances:
            for i, count in enumerate(self.instances.pop(number)):
                self.totals[found.name, i] += count
        elif found.name not in self.unsound:
            self.totals[found.name, 0] += self.seen[number]
        self.passed += self.seen[number] * found.size
        self.seen[number] = 0

    def _definer(self, found: Format) -> Visit:
        """Reads FMT, FMTU, UNIT, MULT and PARM."""

        def visit(data: bytes, at: int) -> None:
            values = found.values(data, at)
            try:
                if found.name == "FMT":
                    new = _format(values)
                    changed = new and self.definitions.define(new)
                else:
                    changed = self.definitions.learn(found.name, values)
            except (KeyError, ValueError, OverflowError):
                self.unsound.add(found.name)
                return
            if changed is not None:
                self._begin(changed)

        return visit

    def _counter(self, found: Format) -> Visit:
        counts = self.instances[found.number] = [0] * 256
        offset = found.layout().instance or 0

        def visit(data: bytes, at: int) -> None:
            counts[data[at + offset]] += 1

        return visit

    def _collector(self, found: Format, columns: Sequence[Columns]) -> Visit | None:
        """Collects what is wanted of a format; None: nothing is."""
        layout, size = found.layout(), found.size
        offset = layout.instance
        wanted: dict[str, list[Columns]] = {}
        for column in columns:
            wanted.setdefault(column.topic, []).append(column)
        instances = range(1 if offset is None else 256)
        mine = [wanted.get(topic_name(found.name, i), []) for i in instances]
        if layout.stamp is None or not any(mine):
            return None

        def visit(data: bytes, at: int) -> None:
            for each in mine[0 if offset is None else data[at + offset]]:
                each.add(data[at : at + size], layout)

        return visit


def _format(values: Values) -> Format | None:
    """The format of an FMT message; None: of FMT itself, or shorter than a header."""
    columns = str(values["Columns"])
    found = Format(
        int(values["Type"]), str(values["Name"]), int(values["Length"]), str(values["Format"]),
        tuple(columns.split(",")) if columns else (),
    )  # fmt: skip
    usual = found.name.isalnum() and found.name.isascii()
    return found if usual and found.number != FMT.number and found.size >= HEADER else None
