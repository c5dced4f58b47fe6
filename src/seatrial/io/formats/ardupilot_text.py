# SPDX-License-Identifier: MIT
"""ArduPilot's logs as text (`.log`): a message a line, its columns behind its name, already scaled."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from seatrial.io.formats.dataflash import DEFINING, NO_STAMPS, STAMPS, Definitions, Format
from seatrial.io.formats.layout import MOST_STAMP, pass_lines, refuse_noise
from seatrial.io.log import Log, LogSamples, Wanted
from seatrial.util.errors import RecordingError

BAD_LINES = 100_000  # after which a file that is less than half messages is no log
INSTANCE = re.compile(r"\[(\d+)\]$")


class ArduPilotTextLog(Log):
    """A `.log` file."""

    kind = "ArduPilot log (text)"

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        self._definitions = Definitions()
        self._counts: Counter[tuple[str, int]] = Counter()
        self._late = False  # whether lines stand before their definition
        # formats by name, where those of the lines' places are not right
        self._settled: dict[str, Format] = {}
        strange = self._count()
        if strange or self._late:
            self._settled = self._by_name()  # counted as it is read
            self._counts.clear()
            strange = self._count()
        self.topics = self._definitions.topics(self._counts)
        self.parameters = self._definitions.parameters
        if not self.topics:
            raise RecordingError(f"{path}: {NO_STAMPS}")
        self.remarks = (f"{strange} lines are no message",) if strange else ()

    def _read(self, wanted: Sequence[Wanted]) -> list[LogSamples]:
        columns = [_TextColumns(each) for each in wanted]
        by_name: dict[str, list[_TextColumns]] = {}
        for column in columns:
            by_name.setdefault(column.name, []).append(column)
        formats = self._by_name()
        for line in self._lines():
            for column in by_name.get(line.split(",", 1)[0], ()):
                column.add(line, formats[column.name])
        return [column.samples() for column in columns]

    def _count(self) -> int:
        """Count messages; returns how many lines are none."""
        strange = empty = 0
        for number, line in enumerate(self._lines(), 1):
            if line:
                strange += self._take(line)
            else:
                empty += 1
            if (lost := strange + empty) > BAD_LINES:
                refuse_noise(self.path, "ArduPilot log", number - lost, lost, "lines")
        return strange

    def _lines(self) -> Iterator[str]:
        return (line.decode("latin-1").strip() for line in pass_lines(self.path))

    def _take(self, line: str) -> int:
        """Count a line, or learn what it defines; 1 where it is no message."""
        name, *texts = (text.strip() for text in line.split(","))
        try:
            if name == "FMT":
                columns = tuple(texts[4:]) if texts[4:] != [""] else ()
                found = Format(int(texts[0]), texts[2], int(texts[1]), texts[3], columns)
                if not self._settled:
                    self._definitions.define(found)
                return 0
            found = self._named(name)
            if len(texts) < len(found.columns):
                return 1
            if name in DEFINING:
                if self._settled:
                    return 0
                values = dict(zip(found.columns, texts, strict=False))
                if name in ("UNIT", "MULT"):
                    values["Id"] = str(_character(values["Id"]))
                changed = self._definitions.learn(name, values)
                self._late |= changed is not None and self._counts[changed.name, 0] > 0
                return 0
            i = found.instance
            self._counts[name, 0 if i is None else int(texts[i])] += 1
        except (KeyError, ValueError, OverflowError, IndexError):
            return 1
        return 0

    def _named(self, name: str) -> Format:
        return self._settled[name] if self._settled else self._definitions.known[name][-1]

    def _by_name(self) -> dict[str, Format]:
        return {f.name: f for f in self._definitions.formats.values()}


def _character(text: str) -> int:
    """UNIT's and MULT's Id: written as a number."""
    return ord(text) if len(text) == 1 and not text.isdecimal() else int(text)


class _TextColumns:
    """Wanted columns of one topic, line by line."""

    def __init__(self, wanted: Wanted) -> None:
        self.wanted = wanted
        found = INSTANCE.search(wanted.topic)
        self.name = wanted.topic[: found.start()] if found else wanted.topic
        self.instance = int(found[1]) if found else 0
        self.stamps: list[int] = []
        self.values: list[float] = []
        self.dropped = 0

    def add(self, line: str, found: Format) -> None:
        """One line of this name."""
        texts = line.split(",")[1:]
        if len(texts) < len(found.columns):
            return  # counted when the log was opened
        index = {name: i for i, name in enumerate(found.columns)}
        try:
            i = found.instance
            if i is not None and int(texts[i]) != self.instance:
                return
        except ValueError:
            return
        try:
            stamp = int(texts[index[found.stamp or ""]]) * STAMPS[found.stamp or ""]
            values = [float(texts[index[name]]) for name in self.wanted.fields]
        except (KeyError, ValueError, IndexError):
            self.dropped += 1
            return
        if not 0 <= stamp <= MOST_STAMP:
            self.dropped += 1
            return
        self.stamps.append(stamp)
        self.values += values

    def samples(self) -> LogSamples:
        """All that was collected."""
        shape = len(self.stamps), len(self.wanted.fields)
        values = np.array(self.values, dtype=np.float64).reshape(shape)
        stamps = np.array(self.stamps, dtype=np.int64)
        return LogSamples(self.wanted.topic, stamps, values, self.dropped)
