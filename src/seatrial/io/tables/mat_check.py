# SPDX-License-Identifier: MIT
"""Sizes and nesting of a MATLAB 5 file, checked before a library reads it."""

import math
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from seatrial.util.errors import RecordingError

HEADER = 128  # [bytes]
MOST_BYTES = 1 << 30  # of all variables, uncompressed
DEEPEST = 32  # structs and cells in each other
MOST_ELEMENTS = 1_000_000  # of a file
STEP = 1 << 20  # [bytes] inflated at a time
MATRIX, COMPRESSED = 14, 15  # types of elements
CELL, STRUCT, OBJECT, SPARSE, FUNCTION, OPAQUE = 1, 2, 3, 5, 16, 17  # classes of matrices
KNOWN_CLASSES = range(1, 18)
CHAR, FIRST_NUMERIC, LAST_NUMERIC = 4, 6, 15
FLAG_TYPE, SIZE_TYPES, NAME_TYPES = 6, (5, 6), (1, 2, 16)
NUMBER_TYPES = (1, 2, 3, 4, 5, 6, 7, 9, 12, 13)
TEXT_TYPES = (*NUMBER_TYPES, 16, 17, 18)  # with UTF-8, 16 and 32
COMPLEX = 0x08  # of the flags' second byte


@dataclass
class _Budget:
    order: str = "<"  # of bytes
    left: int = MOST_BYTES  # [bytes]
    elements: int = MOST_ELEMENTS


class _Damaged(Exception):  # noqa: N818 (turned into a RecordingError)
    """Bytes that are no MATLAB element."""


def check_mat(path: Path) -> None:
    """Raise RecordingError where a MATLAB 5 file is damaged, too large, or too deep."""
    try:
        with path.open("rb") as file:
            head = file.read(HEADER)
            budget = _Budget("<" if head[126:128] == b"IM" else ">")
            while (content := _content(file, budget)) is not None:
                _check_matrix(content, budget)
    except _Damaged as error:
        raise RecordingError(f"{path}: is damaged, or no MATLAB file: {error}") from None
    except (struct.error, zlib.error) as error:
        raise RecordingError(f"{path}: is damaged ({error})") from None
    except MemoryError:
        raise RecordingError(f"{path}: needs more memory than there is") from None


def _content(file: BinaryIO, budget: _Budget) -> memoryview | None:
    """The next variable's bytes, inflated; None at the end."""
    tag = file.read(8)
    if not tag:
        return None
    if len(tag) < 8:
        raise _Damaged("it ends within an element")
    kind, size = struct.unpack(f"{budget.order}II", tag)
    if size > budget.left:
        raise _Damaged(f"a variable of {size} bytes; at most {MOST_BYTES >> 20} MB are read")
    raw = file.read(size)
    if len(raw) < size:
        raise _Damaged(f"a variable of {size} bytes, of which {len(raw)} are there")
    if kind == MATRIX:
        budget.left -= size
        return memoryview(raw)
    if kind != COMPRESSED:
        return memoryview(b"")
    inflater = zlib.decompressobj()
    out = bytearray()
    while raw and not inflater.eof:
        out += inflater.decompress(raw, STEP)
        raw = inflater.unconsumed_tail
        if len(out) > budget.left:
            raise _Damaged(f"it inflates to more than {MOST_BYTES >> 20} MB")
    budget.left -= len(out)
    return memoryview(bytes(out))[8:]  # after its own tag


def _check_matrix(content: memoryview, budget: _Budget) -> None:
    """Walk a matrix and those within it, without recursion."""
    stack = [(0, len(content), 1)]  # begin, end, depth
    while stack:
        begin, end, depth = stack.pop()
        if depth > DEEPEST:
            raise _Damaged(f"structs are nested more than {DEEPEST} deep")
        if end <= begin:
            continue
        stack += [(b, e, depth + 1) for b, e in _inner(content, begin, end, budget)]


def _inner(content: memoryview, at: int, end: int, budget: _Budget) -> list[tuple[int, int]]:
    """Begin and end of the matrices within a matrix."""
    parts = []
    while at < end:
        budget.elements -= 1
        if budget.elements < 0:
            raise _Damaged(f"more than {MOST_ELEMENTS} elements")
        kind, begin, size, at = _element(content, at, end, budget.order)
        parts.append((kind, begin, size))
    if len(parts) < 2 or parts[0][0] != FLAG_TYPE or parts[0][2] != 8:
        raise _Damaged("a variable without a head")
    little = budget.order == "<"
    kind = content[parts[0][1] + (0 if little else 3)]
    if kind not in KNOWN_CLASSES:
        raise _Damaged(f"a variable of class {kind}")
    if kind not in (OPAQUE, FUNCTION):
        is_complex = content[parts[0][1] + (1 if little else 2)] & COMPLEX
        _check_parts([k for k, _, _ in parts], kind, 2 if is_complex else 1)
        _check_size(content, parts, budget.order, kind)
    return [(begin, begin + size) for k, begin, size in parts[1:] if k == MATRIX]


def _check_parts(kinds: list[int], kind: int, data: int) -> None:
    """Refuse elements of another type than a variable of this class has: a library may end on them."""
    if len(kinds) < 3 or kinds[1] not in SIZE_TYPES or kinds[2] not in NAME_TYPES:
        raise _Damaged("a variable without dimensions or a name")
    rest = kinds[3:]
    if FIRST_NUMERIC <= kind <= LAST_NUMERIC or kind in (CHAR, SPARSE):
        known = TEXT_TYPES if kind == CHAR else NUMBER_TYPES
        least = data + 2 if kind == SPARSE else data
        if len(rest) < least or any(k not in known for k in rest):
            raise _Damaged("numbers of an unknown type, or none")
    elif any(k not in (*TEXT_TYPES, MATRIX) for k in rest):
        raise _Damaged("a field of an unknown type")


def _check_size(
    content: memoryview, parts: list[tuple[int, int, int]], order: str, kind: int
) -> None:
    """Refuse dimensions that the bytes can't fill: a library takes memory for them."""
    _, begin, size = parts[1]
    if size < 8 or size % 4:
        raise _Damaged(f"dimensions of {size} bytes")
    dims = struct.unpack_from(f"{order}{size // 4}i", content, begin)
    if any(d < 0 for d in dims):
        raise _Damaged("a negative dimension")
    count = math.prod(dims)
    held = sum(size for _, _, size in parts[2:])
    matrices = sum(k == MATRIX for k, _, _ in parts)
    many = matrices if kind in (CELL, STRUCT, OBJECT) else held
    empty = kind in (STRUCT, OBJECT) and matrices == 0  # a struct without fields
    if (count > many and not empty and kind != SPARSE) or count > MOST_BYTES:
        raise _Damaged(f"a variable of {count} elements in {held} bytes")


def _element(content: memoryview, at: int, end: int, order: str) -> tuple[int, int, int, int]:
    """Type, begin, size and the next element's begin."""
    if end - at < 8:
        raise _Damaged("an element is cut off")
    kind, size = struct.unpack_from(f"{order}II", content, at)
    if kind >> 16:  # a small element: size and type in one word
        kind, size = kind & 0xFFFF, kind >> 16
        if size > 4:
            raise _Damaged("a small element that is large")
        return kind, at + 4, size, at + 8
    begin = at + 8
    if size > end - begin:
        raise _Damaged(f"an element of {size} bytes in {end - begin}")
    after = begin + size if kind == COMPRESSED else begin + (size + 7) // 8 * 8
    return kind, begin, size, min(after, end)
