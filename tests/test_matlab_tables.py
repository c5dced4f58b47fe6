# SPDX-License-Identifier: MIT
"""Tables of MATLAB files of version 5 and 7.3: the same numbers and stamps, or one line."""

import re
import struct
import zlib
from functools import partial

import numpy as np
import pytest
from conftest import at_length
from test_tables import EPOCH, N, T, X, Y, one

from seatrial.boat.schema import Column
from seatrial.io.table import open_tables
from seatrial.util.errors import SeatrialError


def tables_of(path):
    return {name: table.names for name, table in open_tables(path).items()}


MATS = {
    "vectors": ({"t": T, "x": X[:, None], "y": Y[None, :], "mass": 3.0}, {"t": ["t", "x", "y"]}),
    "structs with a time": (
        {"pose": {"t": T, "x": X, "y": Y}, "cmd": {"t": T[:9], "u": np.column_stack([X, Y])[:9]}},
        {"pose": ["t", "x", "y"], "cmd": ["t", "u_1", "u_2"]},
    ),
    "a struct of structs": (
        {"log": {"time": T, "nav": {"x": X, "y": Y}, "cmd": {"left": X}}},
        {"log": ["time", "nav.x", "nav.y", "cmd.left"]},
    ),
    "series": (
        {n: {"time": T, "signals": {"values": v, "dimensions": 1, "label": n}} for n, v in (("x", X), ("y", Y))},
        {"x": ["time", "x", "y"]},
    ),
    "series of several": ({"out": {"Time": T, "Data": np.column_stack([X, Y])}}, {"out": ["Time", "out_1", "out_2"]}),
    "rows of a matrix": ({"t": T, "A": np.vstack([X, Y])}, {"t": ["t", "A_1", "A_2"]}),
    "array of structs": (
        {"log": np.array(list(zip(T, X, strict=True)), dtype=[("t", float), ("x", float)])}, {"log": ["t", "x"]},
    ),
    "cells of text": (
        {"t": np.array([f"10:08:{i:02d}" for i in range(N)], dtype=object), "x": X}, {"t": ["t", "x"]},
    ),
}  # fmt: skip


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", MATS)
def test_matlab_5(tmp_path, kind, packed):
    savemat = pytest.importorskip("scipy.io").savemat
    content, expected = MATS[kind]
    path = tmp_path / "log.mat"
    savemat(path, content, do_compression=packed)
    assert tables_of(path) == expected
    table = next(iter(open_tables(path).values()))
    assert len(table.numbers()) == N
    assert len(table.stamps(Column(column=table.names[0]))) == N
    numbered = [n for n in table.names if n.split(".")[-1] in ("x", "A_1", "out_1")]
    np.testing.assert_array_equal(table.columns(numbered)[:, 0], X)


@pytest.mark.parametrize("packed", [False, True])
def test_matlab_73(tmp_path, packed):
    h5py = pytest.importorskip("h5py")
    path = tmp_path / "log.mat"
    more = {"chunks": True, "compression": "gzip"} if packed else {}
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, column in (("t", T), ("x", X), ("nav/y", Y)):
            file.create_dataset(f"log/{name}", data=column[None, :], **more)
        file.create_dataset("log/A", data=np.vstack([X, Y]), **more)  # MATLAB's N times 2
        clock = np.array([[ord(c) for c in f"10:08:{i:02d}"] for i in range(N)], dtype=np.uint16)
        file.create_dataset("log/when", data=clock.T).attrs["MATLAB_class"] = np.bytes_("char")
        file["elsewhere"] = h5py.ExternalLink("/etc/hostname", "x")
        file["around"] = file["log"]
    found = open_tables(path)
    assert set(found) == {"around", "log"}
    table = found["log"]
    assert table.names == ["A_1", "A_2", "nav.y", "t", "when", "x"]
    values = table.columns(["t", "x", "nav.y", "A_1", "A_2"])
    np.testing.assert_array_equal(values, np.column_stack([T, X, Y, X, Y]))
    assert np.diff(table.stamps(Column(column="when"))).tolist() == [10**9] * (N - 1)


def test_matlab_serial_dates_are_seconds(tmp_path):
    savemat = pytest.importorskip("scipy.io").savemat
    path = tmp_path / "log.mat"
    savemat(path, {"t": 719_529 + (EPOCH + T) / 86_400, "x": X})
    table = one(path)
    np.testing.assert_allclose(
        table.stamps(Column(column="t")) * 1e-9 - EPOCH, T, atol=2e-5
    )  # [s] the dates' own resolution
    assert "serial dates" in table.remarks[0]


def matrix(kind, dims, *parts, order="<"):
    """A MATLAB 5 element."""
    head = struct.pack(f"{order}IIII", 6, 8, kind, 0) + struct.pack(f"{order}II", 5, 4 * len(dims))
    head += struct.pack(f"{order}{len(dims)}i", *dims) + struct.pack(f"{order}II", 1, 0)
    body = head + b"".join(parts)
    return struct.pack(f"{order}II", 14, len(body)) + body


def mat_file(path, *elements):
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + b"".join(elements))
    return path


def nested(depth):
    element = matrix(6, (1, 1), struct.pack("<IId", 9, 8, 1.0))
    for _ in range(depth):
        element = matrix(1, (1, 1), element)
    return element


def bomb():
    raw = matrix(6, (1, 1), struct.pack("<II", 9, 1 << 30))
    packer = zlib.compressobj(9)
    packed = packer.compress(raw) + packer.flush(zlib.Z_FULL_FLUSH)
    # after a full flush equal bytes are packed alike: no gigabyte needs to be packed
    packed += 66 * (packer.compress(bytes(1 << 24)) + packer.flush(zlib.Z_FULL_FLUSH))
    return struct.pack("<II", 15, len(packed)) + packed


@pytest.mark.parametrize(
    ("element", "words"),
    [
        (partial(nested, 20_000), "structs are nested more than 32 deep"),
        (matrix(1, (1 << 15, 1 << 15)), "a variable of 1073741824 elements in 0 bytes"),
        (matrix(6, (9, 1), struct.pack("<IId", 200, 8, 1.0)), "numbers of an unknown type"),
        (matrix(6, (1, 1)), "numbers of an unknown type, or none"),
        (matrix(6, (1, -1), struct.pack("<IId", 9, 8, 1.0)), "a negative dimension"),
        (struct.pack("<II", 14, 1 << 20), "a variable of 1048576 bytes, of which 0 are there"),
        at_length(bomb, "it inflates to more than 1024 MB"),
    ],
    ids=["nested", "cells", "type", "no numbers", "negative", "cut off", "inflates"],
)  # fmt: skip
def test_a_hostile_matlab_file_is_one_line(tmp_path, element, words):
    path = mat_file(tmp_path / "log.mat", element() if callable(element) else element)
    with pytest.raises(SeatrialError, match=words) as caught:
        open_tables(path)
    assert "\n" not in str(caught.value)


def test_a_matlab_file_without_vectors_says_what_it_holds(tmp_path):
    from scipy.io import savemat

    path = tmp_path / "log.mat"
    savemat(path, {"mass": 3.0, "boat": {"inertia": np.ones((2, 2)), "name": "tern"}})
    words = "numbers, 3 long at least; of its variables those that could be columns: inertia (2 x 2), name (1); save"
    with pytest.raises(SeatrialError, match=re.escape(words)):
        open_tables(path)
    savemat(path, {"mass": 3.0})
    with pytest.raises(
        SeatrialError, match="that could be columns: none; save time, positions, heading"
    ):
        open_tables(path)
