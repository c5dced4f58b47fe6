# SPDX-License-Identifier: MIT
"""One serialised message, walked by its definition: the place of each field."""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict
Kind = tuple[int, Any]  # a field's description, as rosbags parses it
PRIMITIVES = {
    "bool": "u1", "byte": "u1", "char": "u1", "octet": "u1", "int8": "i1", "uint8": "u1",
    "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "int64": "i8", "uint64": "u8",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
BASE, NAME, ARRAY, SEQUENCE = 1, 2, 3, 4  # rosbags.interfaces.Nodetype, without the import
MOST_ELEMENTS = 4096  # of a sequence of messages; a longer one is not a pose or a command
MOST_NESTING = 20  # of messages within messages


class WireError(Exception):
    """Bytes that are not a message of their type."""


@dataclass(frozen=True)
class Leaf:
    """Position of a number, an array of numbers or a text in a message."""

    offset: int
    dtype: str  # of numpy; "S" for text
    count: int  # elements, or bytes of the text


def described(kind: Kind) -> tuple[str, Any]:
    """A field's kind: ("base", primitive), ("name", type), ("many", (element, n, is sequence))."""
    tag, detail = int(kind[0]), kind[1]
    if tag == BASE:
        return "base", detail[0]
    if tag == NAME:
        return "name", detail
    return "many", (detail[0], detail[1], tag == SEQUENCE)


class Walk:
    """One message, walked from its first byte to its last."""

    def __init__(self, data: bytes, type_name: str, definitions: "Typesdict", *, cdr: bool) -> None:
        self.data = data
        self.type_name, self.definitions, self.cdr = type_name, definitions, cdr
        self.guards: list[int] = []  # positions of lengths
        self.fields_left = 2 * len(data) + MOST_ELEMENTS  # most fields take bytes
        self.found: dict[str, Leaf] = {}
        self.origin, self.order = 0, "<"
        if cdr:
            if len(data) < 4 or data[0] != 0 or data[1] > 1:
                raise WireError("is not plain CDR")
            self.origin, self.order = 4, "<" if data[1] else ">"
            self.guards.append(0)  # the byte order is part of the shape
        self.at = self.origin

    def leaves(self) -> Mapping[str, Leaf]:
        """Every field's place."""
        self._message(self.type_name, "", 0)
        left = len(self.data) - self.at
        if left < 0 or left > (3 if self.cdr else 0):
            raise WireError(f"has {left} bytes more than its definition")
        return self.found

    def _message(self, name: str, path: str, depth: int) -> None:
        if name not in self.definitions or depth > MOST_NESTING:
            raise WireError(f"uses {name}, which is not defined")
        for field, kind in self.definitions[name][1]:
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
        return "i1" if primitive == "byte" and not self.cdr else PRIMITIVES[primitive]

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
        if self.cdr:
            self.at += -(self.at - self.origin) % size
