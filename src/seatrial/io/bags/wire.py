# SPDX-License-Identifier: MIT
"""Numbers from serialised ROS messages, many messages at once.

Messages of one shape (equal lengths of every string and sequence) hold each field at the same
place. One message of a shape is walked by its definition. The fields of all others are columns of an
array of bytes.
"""

import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict

Bytes = NDArray[np.uint8]
Kind = tuple[int, Any]  # a field's description, as rosbags parses it
PRIMITIVES = {
    "bool": "u1", "byte": "u1", "char": "u1", "octet": "u1", "int8": "i1", "uint8": "u1",
    "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
BASE, NAME, ARRAY, SEQUENCE = 1, 2, 3, 4  # rosbags.interfaces.Nodetype, without the import
_STAMP = [("sec", (BASE, ("int32", 0))), ("nanosec", (BASE, ("uint32", 0)))]
BUILT_IN: dict[str, Any] = {  # types that definitions use without defining them
    "builtin_interfaces/msg/Time": ([], _STAMP),
    "builtin_interfaces/msg/Duration": ([], _STAMP),
}
MOST_ELEMENTS = 4096  # of a sequence of messages; a longer one is not a pose or a command
MOST_NESTING = 20  # of messages within messages
MOST_FIELDS = (
    10_000  # of a type, its messages' fields included: the usual ones have up to some hundred
)
LONGEST_DEFINITION = (
    1 << 20
)  # [characters] of a type and all that it uses: the usual ones have some thousand
PATH = re.compile(r"[A-Za-z_]\w*(?:\[\d+\])*(?:\.[A-Za-z_]\w*(?:\[\d+\])*)*")


class WireError(Exception):
    """Bytes that are not a message of their type."""


@dataclass(frozen=True)
class Leaf:
    """Position of a number, an array of numbers or a text in a message."""

    offset: int
    dtype: str  # of numpy; "S" for text
    count: int  # elements, or bytes of the text


@dataclass(frozen=True)
class Shape:
    """Messages of one shape as rows of bytes, and the positions of their fields."""

    rows: NDArray[np.int64]  # (m,) which of the messages given
    data: Bytes  # (m, length)
    leaves: Mapping[str, Leaf]

    def numbers(self, path: str) -> Array | None:
        """A field of every message (m,) as floats; None where this shape has none."""
        found = self._find(path)
        if found is None or found[0].dtype == "S":
            return None
        with np.errstate(invalid="ignore"):  # a signalling NaN is a NaN, too
            return self._column(*found).astype(np.float64)

    def integers(self, path: str) -> NDArray[np.int64] | None:
        """A field of every message (m,), exactly."""
        found = self._find(path)
        if found is None or np.dtype(found[0].dtype).kind not in "iu":
            return None
        return self._column(*found).astype(np.int64)

    def texts(self, path: str) -> list[str] | None:
        """A text of every message."""
        leaf = self.leaves.get(path)
        if leaf is None or leaf.dtype != "S":
            return None
        block = self.data[:, leaf.offset : leaf.offset + leaf.count]
        if (block == block[0]).all():
            block = block[:1]
        unique: dict[bytes, str] = {}
        found = [
            unique.setdefault(raw, raw.rstrip(b"\0").decode("utf-8", "replace"))
            for raw in map(bytes, block)
        ]
        return found if len(found) == len(self.data) else found * len(self.data)

    def place(self, path: str) -> tuple[int, str]:
        """Position of a number, and its numpy type. Raises KeyError."""
        found = self._find(path)
        if found is None:
            raise KeyError(path)
        leaf, item = found
        return leaf.offset + item * np.dtype(leaf.dtype).itemsize, leaf.dtype

    def _find(self, path: str) -> tuple[Leaf, int] | None:
        leaf = self.leaves.get(path)
        if leaf is not None:
            return leaf, 0
        array, _, index = path.rpartition("[")
        leaf = self.leaves.get(array)
        if leaf is None or leaf.dtype == "S" or int(index[:-1]) >= leaf.count:
            return None
        return leaf, int(index[:-1])

    def _column(self, leaf: Leaf, item: int) -> NDArray[Any]:
        size = np.dtype(leaf.dtype).itemsize
        begin = leaf.offset + item * size
        block = np.ascontiguousarray(self.data[:, begin : begin + size])
        return block.view(leaf.dtype)[:, 0]


@dataclass(frozen=True)
class Wire:
    """Layout of the messages of one type: its definition, and ROS 1 or CDR."""

    type_name: str
    definitions: "Typesdict"
    cdr: bool

    def shapes(self, messages: Sequence[bytes]) -> Iterator[Shape]:
        """The messages sorted by shape. Raises WireError on bytes that are not such a message."""
        lengths = np.fromiter(map(len, messages), dtype=np.int64, count=len(messages))
        for length in np.unique(lengths):
            rows = np.flatnonzero(lengths == length)
            joined = b"".join([messages[i] for i in rows.tolist()])
            data = np.frombuffer(joined, dtype=np.uint8).reshape(len(rows), int(length))
            while len(rows):
                walk = _Walk(bytes(data[0]), self)
                leaves = walk.leaves()
                same = np.ones(len(rows), dtype=bool)
                for at in walk.guards:
                    same &= (data[:, at : at + 4] == data[0, at : at + 4]).all(axis=1)
                yield Shape(rows[same], data[same], leaves)
                rows, data = rows[~same], data[~same]

    def readable(self, messages: Sequence[bytes]) -> list[int]:
        """Indices of the messages of this type."""
        found = []
        for i, message in enumerate(messages):
            try:
                found += [i for _ in self.shapes([message])]
            except WireError:
                continue
        return found

    def require(self, path: str, where: str) -> None:
        """Raise RecordingError unless the path leads to a number in messages of this type."""
        if not PATH.fullmatch(path):
            raise RecordingError(
                f"{where}: '{path}' is not a field; write it like axes[1] or a.b.c"
            )
        parts = re.findall(r"[A-Za-z_]\w*|\[\d+\]", path)
        kind: Kind = _root(self.type_name)
        seen = ""
        for part in parts:
            kind = self._step(kind, part, seen, where)
            seen += part if part.startswith("[") else f".{part}" if seen else part
        tag, detail = described(kind)
        if tag != "base" or detail not in PRIMITIVES:
            raise RecordingError(f"{where}: '{path}' is not a number; {self._inside(kind, seen)}")

    @property
    def stamped(self) -> bool:
        """Whether its messages start with a header."""
        fields = dict(self.definitions[self.type_name][1])
        return "header" in fields and described(fields["header"]) == ("name", "std_msgs/msg/Header")

    def has_text(self, name: str) -> bool:
        """Whether the path leads to a text, through lists without an index."""
        kind: Kind = _root(self.type_name)
        for part in name.split("."):
            tag, detail = described(kind)
            fields = self._fields(detail[0] if tag == "many" else kind)
            if part not in fields:
                return False
            kind = fields[part]
        return described(kind) == ("base", "string")

    def paths(self) -> list[str]:
        """Every number in messages of this type, sequences as name[]; for display."""
        return [*_numbers(_root(self.type_name), "", self.definitions)]

    def _fields(self, kind: Kind) -> dict[str, Kind]:
        """Fields of a message; none of other kinds."""
        tag, detail = described(kind)
        defined = tag == "name" and detail in self.definitions
        return dict(self.definitions[detail][1]) if defined else {}

    def _step(self, kind: Kind, part: str, seen: str, where: str) -> Kind:
        """The kind of a field's part, or of an element."""
        tag, detail = described(kind)
        if part.startswith("[") and tag == "many":
            return cast("Kind", detail[0])
        fields = self._fields(kind)
        if part in fields:
            return fields[part]
        near = get_close_matches(part, fields, n=1)
        hint = f"did you mean '{near[0]}'?" if near else self._inside(kind, seen)
        dot = "" if part.startswith("[") or not seen else "."
        raise RecordingError(
            f"{where}: {short_type(self.type_name)} has no '{seen}{dot}{part}'; {hint}"
        )

    def _inside(self, kind: Kind, seen: str) -> str:
        found = [*_numbers(kind, seen, self.definitions)]
        return f"numbers there: {', '.join(found[:12])}" if found else "there are no numbers in it"


def _root(type_name: str) -> Kind:
    return (NAME, type_name)


def described(kind: Kind) -> tuple[str, Any]:
    """A field's kind: ("base", primitive), ("name", type), ("many", (element, n, is sequence))."""
    tag, detail = int(kind[0]), kind[1]
    if tag == BASE:
        return "base", detail[0]
    if tag == NAME:
        return "name", detail
    return "many", (detail[0], detail[1], tag == SEQUENCE)


def _numbers(kind: Kind, seen: str, definitions: "Typesdict") -> Iterator[str]:
    """Paths of the numbers, depth first; of the first `MOST_FIELDS` fields, as each level may double them."""
    pending, left = [(kind, seen, 0)], MOST_FIELDS
    while pending and left > 0:
        (tag, detail), path, depth = described(pending[-1][0]), *pending.pop()[1:]
        left -= 1
        if tag == "base" and detail in PRIMITIVES:
            yield path
        elif tag == "many":
            pending.append((detail[0], f"{path}[]", depth))
        elif tag == "name" and depth <= MOST_NESTING and detail in definitions:
            pending += [
                (inner, f"{path}.{name}".lstrip("."), depth + 1)
                for name, inner in reversed(definitions[detail][1][:left])
            ]


class _Walk:
    """One message, walked from its first byte to its last."""

    def __init__(self, data: bytes, wire: Wire) -> None:
        self.data = data
        self.wire = wire
        self.guards: list[int] = []  # positions of lengths
        self.fields_left = 2 * len(data) + MOST_ELEMENTS  # most fields take bytes
        self.found: dict[str, Leaf] = {}
        self.origin, self.order = 0, "<"
        if wire.cdr:
            if len(data) < 4 or data[0] != 0 or data[1] > 1:
                raise WireError("is not plain CDR")
            self.origin, self.order = 4, "<" if data[1] else ">"
            self.guards.append(0)  # the byte order is part of the shape
        self.at = self.origin

    def leaves(self) -> Mapping[str, Leaf]:
        """Every field's place."""
        self._message(self.wire.type_name, "", 0)
        left = len(self.data) - self.at
        if left < 0 or left > (3 if self.wire.cdr else 0):
            raise WireError(f"has {left} bytes more than its definition")
        return self.found

    def _message(self, name: str, path: str, depth: int) -> None:
        if name not in self.wire.definitions or depth > MOST_NESTING:
            raise WireError(f"uses {name}, which is not defined")
        for field, kind in self.wire.definitions[name][1]:
            self._field(kind, f"{path}.{field}" if path else field, depth)

    def _field(self, kind: Kind, path: str, depth: int) -> None:
        self.fields_left -= 1
        if self.fields_left < 0:
            raise WireError("has more fields than bytes")
        tag, detail = described(kind)
        if tag == "name":
            self._message(detail, path, depth + 1)
        elif tag == "base":
            self._base(detail, path)
        else:
            element, size, is_sequence = detail
            self._many(element, self._length() if is_sequence else size, path, depth)

    def _many(self, element: Kind, count: int, path: str, depth: int) -> None:
        tag, detail = described(element)
        if count < 0:
            raise WireError(f"states {count} elements in '{path}'")
        if tag == "base" and detail in PRIMITIVES:
            self._leaf(self._code(detail), count, path)
            return
        if count > MOST_ELEMENTS:
            raise WireError(f"states {count} elements in '{path}'")
        for i in range(count):
            self._field(element, f"{path}[{i}]", depth + 1)

    def _base(self, primitive: str, path: str) -> None:
        if primitive in PRIMITIVES:
            self._leaf(self._code(primitive), 1, path)
        elif primitive == "string":
            count = self._length()
            self._take(path, Leaf(self.at, "S", count), count)
        else:
            raise WireError(f"has a field '{path}' of type {primitive}, which is not read")

    def _code(self, primitive: str) -> str:
        """numpy's code; ROS 1's byte has a sign."""
        return "i1" if primitive == "byte" and not self.wire.cdr else PRIMITIVES[primitive]

    def _leaf(self, code: str, count: int, path: str) -> None:
        size = int(code[1])
        if count:
            self._align(size)
        self._take(path, Leaf(self.at, self.order + code, count), size * count)

    def _take(self, path: str, leaf: Leaf, size: int) -> None:
        if self.at + size > len(self.data):
            raise WireError(f"ends inside '{path}'")
        self.found[path] = leaf
        self.at += size

    def _length(self) -> int:
        self._align(4)
        if self.at + 4 > len(self.data):
            raise WireError("ends before a length")
        self.guards.append(self.at)
        (count,) = struct.unpack_from(f"{self.order}I", self.data, self.at)
        self.at += 4
        return int(count)

    def _align(self, size: int) -> None:
        if self.wire.cdr:
            self.at += -(self.at - self.origin) % size


@lru_cache(maxsize=256)
def parse_definition(text: str, type_name: str, *, idl: bool = False) -> "Typesdict":
    """Message definitions from the text in a bag. Raises WireError."""
    from rosbags.typesys import TypesysError, get_types_from_idl, get_types_from_msg

    if len(text) > LONGEST_DEFINITION:
        raise WireError(f"the definition of {plain(type_name)} has {len(text)} characters")
    try:
        found: dict[str, Any] = dict(BUILT_IN)
        if not idl:
            return found | dict(get_types_from_msg(text, type_name))
        rule = "=" * 80 + "\n"
        for part in text.split(rule) if text.startswith(rule) else [text]:
            body = part.split("\n", 1)[1] if part.startswith("IDL: ") else part
            body = re.sub(r"(?m)^\s*#.*$", "", body)  # included files are part of the text
            if body.strip():
                found.update(get_types_from_idl(body))
    except (TypesysError, IndexError, KeyError, ValueError, RecursionError) as error:
        raise WireError(
            f"the definition of {plain(type_name)} can't be read: {plain(str(error))}"
        ) from None
    return found


def plain(text: str, most: int = 80) -> str:
    """Text from a file as one short printable line."""
    shown = "".join(c if c.isprintable() else " " for c in text[: 4 * most])
    shown = " ".join(shown.split())
    return shown if len(shown) <= most else f"{shown[:most]} ..."


def short_type(name: str) -> str:
    """The short form of a type's name: geometry_msgs/PoseStamped."""
    return name.replace("/msg/", "/")
