# SPDX-License-Identifier: MIT
"""Definitions in ArduPilot's DataFlash logs: FMT names a message and its columns, FMTU states their units."""

import struct
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from seatrial.io.formats.layout import Layout, Place, topic_name
from seatrial.io.log import LogTopic

HEADER = 3  # [bytes] before the columns of a binary message
ARRAY = 32  # numbers of an array column
FORMAT_CODES = {  # format character: of struct and numpy
    "b": "b", "B": "B", "M": "B", "h": "h", "H": "H", "i": "i", "I": "I", "g": "e", "f": "f",
    "d": "d", "q": "q", "Q": "Q", "c": "h", "C": "H", "e": "i", "E": "I", "L": "i",
}  # fmt: skip
DIVISORS = {"c": 100, "C": 100, "e": 100, "E": 100, "L": 10_000_000}
TEXTS = {"n": "4s", "N": "16s", "Z": "64s", "a": "64s"}
ONE_BYTE = "bBM"
PREFIXES = {1e-1: "d", 1e-2: "c", 1e-3: "m", 1e-6: "u", 1e-9: "n"}
STAMPS = {"TimeUS": 1000, "TimeMS": 1_000_000, "T": 1_000_000}  # [ns] of one; T: of an old GPS
DEFINING = ("FMT", "FMTU", "UNIT", "MULT", "PARM")  # no topics
MOST_CHANGES = 2000  # definitions of a log; later ones are not followed
MOST_PARAMETERS = 20_000
Key = tuple[int, str, int, str, tuple[str, ...]]
NO_STAMPS = (
    "no ArduPilot log, or one from before 2014, whose messages have no time: it holds no message with a stamp; "
    "take the telemetry (.tlog) of the same run, or record with newer firmware"
)
Stated = dict[Key, tuple[str, str]]  # units and multipliers of formats
Values = Mapping[str, str | float]


@dataclass(frozen=True)
class Format:
    """A message as FMT defines it."""

    number: int
    name: str
    size: int  # [bytes] with header
    characters: str
    columns: tuple[str, ...]
    units: str = ""  # of FMTU: a character for each column
    multipliers: str = ""

    @property
    def key(self) -> Key:
        """What FMT states."""
        return self.number, self.name, self.size, self.characters, self.columns

    @property
    def consistent(self) -> bool:
        """Whether each column has a known format and its own name."""
        known = all(c in FORMAT_CODES or c in TEXTS for c in self.characters)
        return known and len(self.columns) == len(self.characters) == len(set(self.columns))

    @cached_property
    def body(self) -> struct.Struct:
        """The columns of a binary message."""
        return struct.Struct(f"<{''.join(map(_code, self.characters))}")

    @property
    def stamp(self) -> str | None:
        """The column with the stamp."""
        first = self.columns[0] if self.columns else ""
        if self.name.startswith("GPS") and {"TimeMS", "T"} <= set(self.columns):
            return "T"  # of firmware before 2015: TimeMS is the time of the week
        return first if first in ("TimeUS", "TimeMS") else None

    @property
    def instance(self) -> int | None:
        """The column, of one byte, that tells several sensors apart."""
        i = self.units.find("#")
        # a damaged FMT may state more columns than formats
        stated = min(len(self.columns), len(self.characters))
        return i if 0 <= i < stated and self.characters[i] in ONE_BYTE else None

    def places(self) -> Iterator[tuple[str, str, int]]:
        """Name, format character and offset [bytes] of each column."""
        offset = HEADER
        for name, character in zip(self.columns, self.characters, strict=True):
            yield name, character, offset
            offset += struct.calcsize(f"<{_code(character)}")

    def numbers(self) -> Iterator[tuple[str, Place]]:
        """Numeric columns, arrays spelled out."""
        for name, character, offset in self.places():
            if character in FORMAT_CODES:
                yield name, Place(offset, f"<{FORMAT_CODES[character]}", DIVISORS.get(character, 1))
            elif character == "a":
                for i in range(ARRAY):
                    yield f"{name}[{i}]", Place(offset + 2 * i, "<h")

    def values(self, data: bytes, at: int) -> Values:
        """Columns of the binary message at a place, as they are."""
        found = zip(self.columns, self.body.unpack_from(data, at + HEADER), strict=True)
        return {name: c_text(x) if isinstance(x, bytes) else x for name, x in found}

    def layout(self) -> Layout:
        """Places of the numbers in a binary message."""
        numbers, stamp = dict(self.numbers()), self.stamp
        offsets = [offset for _, _, offset in self.places()]
        return Layout(
            self.size, {n: p for n, p in numbers.items() if n != stamp},
            numbers.get(stamp or ""), STAMPS[stamp] if stamp else 1,
            None if self.instance is None else offsets[self.instance],
        )  # fmt: skip


@dataclass
class Definitions:
    """What a log has defined so far. `stated`: units, also those of an earlier pass."""

    changes: int = 0  # new or other formats
    formats: dict[int, Format] = field(default_factory=dict)
    stated: Stated = field(default_factory=dict)
    unit_names: dict[str, str] = field(default_factory=dict)
    factors: dict[str, float] = field(default_factory=dict)
    parameters: dict[str, float] = field(default_factory=dict)
    known: dict[str, list[Format]] = field(default_factory=dict)  # all so far, by name

    def define(self, found: Format) -> Format | None:
        """The format of an FMT with its units; None: the same as before."""
        before = self.formats.get(found.number)
        if (before is not None and before.key == found.key) or self.changes >= MOST_CHANGES:
            return None
        self.changes += 1
        units, multipliers = self.stated.get(found.key, ("", ""))
        return self._keep(replace(found, units=units, multipliers=multipliers))

    def learn(self, name: str, values: Values) -> Format | None:
        """What a UNIT, MULT, FMTU or PARM says; the format that has other units now.

        Raises KeyError, ValueError, OverflowError where the message is not as usual.
        """
        if name == "UNIT":
            self.unit_names[chr(int(values["Id"]))] = str(values["Label"])
        elif name == "MULT":
            self.factors[chr(int(values["Id"]))] = float(f"{float(values['Mult']):.7g}")
        elif name == "PARM" and len(self.parameters) < MOST_PARAMETERS:
            self.parameters[str(values["Name"])] = float(values["Value"])
        elif name == "FMTU":
            found = self.formats.get(int(values["FmtType"]))
            stated = str(values["UnitIds"]), str(values["MultIds"])
            other = found is not None and (found.units, found.multipliers) != stated
            if found is not None and other and self.changes < MOST_CHANGES:
                self.changes += 1
                self.stated[found.key] = stated
                return self._keep(replace(found, units=stated[0], multipliers=stated[1]))
        return None

    def _keep(self, found: Format) -> Format:
        self.formats[found.number] = found
        others = [f for f in self.known.get(found.name, []) if f.key != found.key]
        self.known[found.name] = [*others, found]
        return found

    def topics(self, counts: Counter[tuple[str, int]]) -> dict[str, LogTopic]:
        """Topics with their messages; (name, instance): how many."""
        found: dict[str, LogTopic] = {}
        for (name, instance), count in sorted((+counts).items()):
            formats = [f for f in self.known.get(name, []) if f.consistent and f.stamp]
            if not formats or name in DEFINING:
                continue
            fields = dict.fromkeys(c for f in formats for c, _ in f.numbers() if c != f.stamp)
            units = {c: unit for f in formats for c, unit in self._units(f)}
            topic = topic_name(name, instance)
            found[topic] = LogTopic(topic, name, count, tuple(fields), units)
        return found

    def _units(self, found: Format) -> Iterable[tuple[str, str]]:
        """Units by column, with the prefix that the multiplier is."""
        for i, (name, character) in enumerate(zip(found.columns, found.characters, strict=True)):
            unit = self.unit_names.get(found.units[i : i + 1], "")
            if not unit or name == found.stamp:
                continue
            factor = self.factors.get(found.multipliers[i : i + 1], 1.0)
            if character not in DIVISORS and factor not in (0.0, 1.0):
                unit = PREFIXES.get(factor, f"{factor:g} ") + unit
            yield name, unit


def _code(character: str) -> str:
    return FORMAT_CODES.get(character) or TEXTS[character]


def c_text(text: bytes) -> str:
    """A text that ends at its first zero byte."""
    return text.split(b"\0", 1)[0].decode("latin-1").strip()
