# SPDX-License-Identifier: MIT
"""MOOS logs (`.alog` of pLogger): a posting a line, as `12.345 NAV_X uSimMarine 3.21`.

Each variable that holds numbers is a topic. The two coordinates of a position are variables of their own, which an
application posts one after the other: together they are a topic, too.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from seatrial.io.formats.layout import LONGEST_LINE, MOST_STAMP, pass_lines
from seatrial.io.log import Log, LogSamples, LogTopic, Wanted
from seatrial.recording.timing import Clock
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Index, Stamps

LOGSTART = re.compile(r"%% LOGSTART\s+(\d{1,12}(\.\d*)?)$")
PAIRS = (("_X", "_Y"), ("_LAT", "_LONG"))  # endings of two coordinates
TOGETHER = 50_000_000  # [ns] between the postings of one position's coordinates, at most
ABSOLUTE = 1e8  # [s] a time of a posting beyond it counts from 1970, not from the log's start
MOST_VARIABLES = 10_000


class MoosLog(Log):
    """An `.alog` file."""

    kind = "MOOS log"
    clock = Clock.HEADER  # a posting is the command itself, at its time

    def __init__(self, path: Path) -> None:
        self.path, self.files = path, (path,)
        counts: Counter[str] = Counter()
        for name, _, _ in self._postings():
            counts[name] += 1
            if len(counts) > MOST_VARIABLES:
                raise RecordingError(f"{path}: more than {MOST_VARIABLES} variables: no MOOS log")
        if not counts:
            raise RecordingError(f"{path}: no MOOS log: no variable holds numbers")
        self._pairs = {
            f"{name.removesuffix(first)}{first}{second.removeprefix('_')}": (name, other)
            for first, second in PAIRS
            for name in counts
            if name.endswith(first) and (other := name.removesuffix(first) + second) in counts
        }
        alone = [LogTopic(name, name, n, (name,)) for name, n in counts.items()]
        both = [
            LogTopic(name, name, min(counts[one] for one in pair), pair)
            for name, pair in self._pairs.items()
            if name not in counts
        ]
        self.topics = {topic.name: topic for topic in sorted([*both, *alone], key=lambda t: t.name)}

    def _read(self, wanted: Sequence[Wanted]) -> list[LogSamples]:
        variables = {name for each in wanted for name in self.topics[each.topic].fields}
        stamps: dict[str, list[int]] = {name: [] for name in variables}
        values: dict[str, list[float]] = {name: [] for name in variables}
        for name, stamp, value in self._postings():
            if name in variables:
                stamps[name].append(stamp)
                values[name].append(value)
        found = {
            name: (np.array(stamps[name], dtype=np.int64), np.array(values[name], dtype=float))
            for name in variables
        }
        return [self._samples(each, found) for each in wanted]

    def _samples(self, wanted: Wanted, found: dict[str, tuple[Stamps, Array]]) -> LogSamples:
        """Rows of a topic, at the times of its first variable."""
        fields = self.topics[wanted.topic].fields
        stamps, _ = found[fields[0]]
        rows = [np.arange(len(stamps))] * len(fields)
        if len(fields) > 1:
            rows = [*_together(stamps, found[fields[1]][0])]
        columns = {name: found[name][1][own] for name, own in zip(fields, rows, strict=True)}
        values = np.zeros((len(rows[0]), len(wanted.fields)))
        for i, name in enumerate(wanted.fields):
            values[:, i] = columns[name]
        return LogSamples(wanted.topic, stamps[rows[0]], values)

    def _postings(self) -> Iterator[tuple[str, int, float]]:
        """Variable, stamp [ns] from 1970, and number of each posting of one; texts are left out."""
        start = 0.0  # [s] from 1970
        for line in self._lines():
            if line.startswith("%"):
                if found := LOGSTART.match(line):
                    start = float(found[1])
                continue
            parts = line.split(None, 3)
            if len(parts) < 4:
                continue
            try:
                # with DATATYPE MARKING ON a number stands as D:1.5
                time, value = float(parts[0]), float(parts[3].removeprefix("D:"))
            except ValueError:
                continue
            if 0.0 <= time < MOST_STAMP * 1e-9 - start:
                since = 0 if time > ABSOLUTE else round(start * 1e9)
                yield parts[1], since + round(time * 1e9), value

    def _lines(self) -> Iterator[str]:
        """Lines up to the longest that can hold a number."""
        whole = True  # the piece before ended its line
        for piece in pass_lines(self.path):
            ends = piece.endswith(b"\n")
            if whole and (ends or len(piece) < LONGEST_LINE):
                yield piece.decode("latin-1").strip()
            whole = ends


def _together(first: Stamps, second: Stamps) -> tuple[Index, Index]:
    """Places of the postings that belong together: each the nearest of the other, within `TOGETHER`."""
    if not (len(first) and len(second)):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    there, back = _nearest(first, second), _nearest(second, first)
    own = np.arange(len(first))
    kept = (back[there] == own) & (np.abs(second[there] - first) <= TOGETHER)
    return own[kept], there[kept]


def _nearest(times: Stamps, among: Stamps) -> Index:
    """Place of the nearest among other stamps, which may be out of order, for each of some."""
    order = np.argsort(among, kind="stable")
    ordered = among[order]
    after = np.searchsorted(ordered, times).clip(0, len(among) - 1)
    before = (after - 1).clip(0)
    nearer = np.abs(ordered[before] - times) < np.abs(ordered[after] - times)
    return np.asarray(order[np.where(nearer, before, after)])
