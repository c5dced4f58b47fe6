# SPDX-License-Identifier: MIT
"""Numbers from serialised ROS messages, many messages at once.

Messages of one shape (equal lengths of every string and sequence) hold each field at the same
place. One message of a shape is walked by its definition. The fields of all others are columns of an
array of bytes.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from seatrial.io.bags.wire_walk import (
    BASE,
    MOST_NESTING,
    NAME,
    PRIMITIVES,
    Kind,
    Leaf,
    Walk,
    WireError,
    described,
)
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Index

if TYPE_CHECKING:
    from rosbags.interfaces.typing import Typesdict

Bytes = NDArray[np.uint8]
_STAMP = [("sec", (BASE, ("int32", 0))), ("nanosec", (BASE, ("uint32", 0)))]
BUILT_IN: dict[str, Any] = {  # types that definitions use without defining them
    "builtin_interfaces/msg/Time": ([], _STAMP),
    "builtin_interfaces/msg/Duration": ([], _STAMP),
}
# of a type, its messages' fields included: the usual ones have up to some hundred
MOST_FIELDS = 10_000
# [characters] of a type and all that it uses: the usual ones have some thousand
LONGEST_DEFINITION = 1 << 20
PATH = re.compile(r"[A-Za-z_]\w*(?:\[\d+\])*(?:\.[A-Za-z_]\w*(?:\[\d+\])*)*")


@dataclass(frozen=True)
class Shape:
    """Messages of one shape as rows of bytes, and the positions of their fields."""

    rows: Index  # (m,) which of the messages given
    data: Bytes  # (m, length)
    leaves: Mapping[str, Leaf]

    def numbers(self, path: str) -> Array | None:
        """A field of every message (m,) as floats; None where this shape has none."""
        found = self._find(path)
        if found is None or found[0].dtype == "S":
            return None
        with np.errstate(invalid="ignore"):  # a signalling NaN is a NaN, too
            return self._column(*found).astype(np.float64)

    def integers(self, path: str) -> Index | None:
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
                walk = Walk(bytes(data[0]), self.type_name, self.definitions, cdr=self.cdr)
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
