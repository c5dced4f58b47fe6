# SPDX-License-Identifier: MIT
"""Variables of MATLAB files as a tree of vectors: version 5 by SciPy, 7.3 by h5py."""

import math
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np
from numpy.typing import NDArray

from seatrial.io.tables.base import MOST_NUMBERS, first_line
from seatrial.io.tables.mat_check import DEEPEST, HEADER, check_mat
from seatrial.util.errors import RecordingError
from seatrial.util.files import readable
from seatrial.util.frames import Array

if TYPE_CHECKING:
    import h5py

INSTALL = "pip install 'seatrial[mat]'"
HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
SIGNATURES_AT = (0, 512)  # [bytes]
MOST_NODES = 10_000  # variables and fields
MOST_CHUNK = 1 << 27  # [bytes] of a compressed piece
MOST_STRUCTS = 64  # of an array of structs that are read each as a variable
MOST_TEXT = 1 << 20  # cells of text
LONGEST_CELL = 256  # characters

Tree = dict[str, Union["Tree", Array, list[str]]]
Value = Tree | Array | list[str]


def read_variables(path: Path, remarks: list[str]) -> Tree:
    """All variables that are numbers, text or structs of these. Raises RecordingError."""
    with readable(path, RecordingError), path.open("rb") as file:
        head = file.read(1024)
    if any(head[at : at + 8] == HDF5_SIGNATURE for at in SIGNATURES_AT):
        return _version_73(path, remarks)
    if len(head) < HEADER or 0 in head[:4] or head[126:128] not in (b"IM", b"MI"):
        raise RecordingError(
            f"{path}: is no MATLAB file of version 5 or 7.3; save it with -v7 or -v7.3"
        )
    check_mat(path)
    return _version_5(path, remarks)


@contextmanager
def _errors(path: Path) -> Iterator[None]:
    """A library's errors as one line."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except RecordingError:
        raise
    except MemoryError:
        raise RecordingError(f"{path}: needs more memory than there is") from None
    except Exception as error:
        raise RecordingError(
            f"{path}: is damaged, or no MATLAB file ({first_line(error)})"
        ) from None


# Version 5 #


def _version_5(path: Path, remarks: list[str]) -> Tree:
    try:
        from scipy.io import loadmat
    except ImportError:
        raise RecordingError(f"{path}: MATLAB files need SciPy and h5py: {INSTALL}") from None
    with _errors(path):
        found = loadmat(path, struct_as_record=True, squeeze_me=False, chars_as_strings=True)
        tree: Tree = {}
        for name, value in found.items():
            if not name.startswith("__"):
                _enter(tree, name, _of_scipy(value, name, remarks, 0))
        return tree


def _enter(tree: Tree, name: str, value: Value | None) -> None:
    if value is not None:
        tree[name] = value


def _of_scipy(value: object, name: str, remarks: list[str], depth: int) -> Value | None:
    """A variable as SciPy gives it."""
    if depth > DEEPEST or not isinstance(value, np.ndarray):
        return None
    kind = type(value).__name__
    if kind in ("MatlabOpaque", "MatlabFunction", "MatlabObject"):
        remarks.append(_object_text(name))
        return None
    if value.dtype.names:
        return _structs(value, name, remarks, depth)
    if value.dtype.kind in "US":
        return [str(text)[:LONGEST_CELL].strip() for text in value.ravel()[:MOST_TEXT]]
    if value.dtype.kind == "O":
        return _cells(value, remarks, name, depth)
    return _numeric(value)


def _structs(value: NDArray[Any], name: str, remarks: list[str], depth: int) -> Tree | None:
    """A struct, or an array of structs: each a variable, or their scalars as vectors."""
    names = value.dtype.names or ()
    flat = value.ravel()
    tree: Tree = {}
    if len(flat) == 1:
        for field in names:
            _enter(tree, field, _of_scipy(flat[0][field], f"{name}.{field}", remarks, depth + 1))
        return tree
    for field in names:  # log(1).x, log(2).x, ...
        cells = [np.asarray(element[field]) for element in flat]
        if cells and all(c.size == 1 and c.dtype.kind in "fiub" for c in cells):
            tree[field] = np.array([float(c.ravel()[0]) for c in cells])
    if not tree and len(flat) <= MOST_STRUCTS:
        for i, element in enumerate(flat):
            inner: Tree = {}
            for field in names:
                _enter(inner, field, _of_scipy(element[field], name, remarks, depth + 1))
            tree[_label(inner) or f"{i + 1}"] = inner
    return tree or None


def _label(tree: Tree) -> str:
    """The name that Simulink gives a signal."""
    for key in ("label", "blockName"):
        text = tree.get(key)
        if isinstance(text, list) and text and text[0]:
            return text[0].rpartition("/")[2]
    return ""


def _cells(
    value: NDArray[Any], remarks: list[str], name: str, depth: int
) -> Tree | list[str] | None:
    """A cell array of text, or of a few variables."""
    flat = value.ravel()
    texts = [c for c in flat[:MOST_TEXT] if isinstance(c, np.ndarray) and c.dtype.kind in "US"]
    if len(flat) > 1 and len(texts) == len(flat):
        return [str(c.ravel()[0])[:LONGEST_CELL].strip() if c.size else "" for c in texts]
    tree: Tree = {}
    for i, cell in enumerate(flat[:MOST_STRUCTS]):
        _enter(tree, f"{i + 1}", _of_scipy(cell, f"{name}.{i + 1}", remarks, depth + 1))
    return tree or None


def _numeric(value: NDArray[Any]) -> Array | None:
    """An array of real numbers with one long dimension, its rows first."""
    if value.dtype.kind not in "fiub" or value.size < 2:
        return None
    shape = tuple(n for n in value.shape if n > 1)
    if len(shape) > 2:
        return None
    return np.asarray(value, dtype=float).reshape(shape)


# Version 7.3 #


def _version_73(path: Path, remarks: list[str]) -> Tree:
    try:
        import h5py
    except ImportError:
        raise RecordingError(f"{path}: MATLAB 7.3 files need h5py: {INSTALL}") from None
    with _errors(path), h5py.File(path, "r") as file:
        return _Groups(path, remarks).read(file, "", 0)


@dataclass
class _Groups:
    """Reads groups of HDF5 within a budget."""

    path: Path
    remarks: list[str]
    nodes: int = MOST_NODES
    left: int = MOST_NUMBERS  # numbers

    def read(self, group: "h5py.Group", above: str, depth: int) -> Tree:
        """A group: the file, or a struct."""
        import h5py

        tree: Tree = {}
        for key in group:
            self.nodes -= 1
            if self.nodes < 0 or depth > DEEPEST:
                raise RecordingError(
                    f"{self.path}: more than {MOST_NODES} variables, or structs too deep"
                )
            name = f"{above}{key}"
            if key.startswith("#") or not isinstance(group.get(key, getlink=True), h5py.HardLink):
                continue  # other files are not followed
            item = group[key]
            if isinstance(item, h5py.Group):
                tree[key] = self.read(item, f"{name}.", depth + 1)
            elif isinstance(item, h5py.Dataset):
                _enter(tree, key, self._dataset(item, name))
        return tree

    def _dataset(self, item: "h5py.Dataset", name: str) -> Array | list[str] | None:
        """A variable: MATLAB's columns are HDF5's rows."""
        if item.is_virtual or item.external:
            self.remarks.append(f"'{name}' is in another file, and is not read")
            return None
        if "MATLAB_object_decode" in item.attrs:
            self.remarks.append(_object_text(name))
            return None
        shape = tuple(n for n in item.shape or () if n > 1)
        if item.dtype.kind not in "fiub" or not 1 <= len(shape) <= 2:
            return None
        chunk = item.dtype.itemsize * math.prod(item.chunks or ())
        self.left -= int(item.size)
        if self.left < 0 or chunk > MOST_CHUNK:
            raise RecordingError(
                f"{self.path}: '{name}' makes more numbers than seatrial reads at once; save the boat's "
                "signals alone"
            )
        if item.attrs.get("MATLAB_class") in (b"char", "char"):
            return _characters(item)
        values = np.asarray(item[()], dtype=float).reshape(shape)
        return values.T if len(shape) == 2 else values


def _object_text(name: str) -> str:
    return (
        f"'{name}' is a MATLAB object (a timetable, a timeseries), which only MATLAB reads: save its columns "
        "as arrays"
    )


def _characters(item: "h5py.Dataset") -> list[str] | None:
    if item.ndim != 2 or item.shape[1] > MOST_TEXT or item.shape[0] > LONGEST_CELL:
        return None
    codes = np.asarray(item[()]).T.astype(np.uint32)
    rows = ["".join(chr(c) if c < 0xD800 else "?" for c in row.tolist()).strip() for row in codes]
    return rows if len(rows) > 1 else None
