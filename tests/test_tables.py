# SPDX-License-Identifier: MIT
"""Tables of every kind, written by the libraries of their formats: the same numbers and stamps, or one line."""

import datetime

import numpy as np
import pytest

from seatrial.boat.schema import Column
from seatrial.io.table import open_tables
from seatrial.util.errors import SeatrialError

N = 40
T = np.round(np.arange(N) * 0.05, 6)
X, Y = np.round(np.sin(T), 6), np.round(np.cos(T), 6)
EPOCH = 1_744_366_094  # [s] 2025-04-11 10:08:14 UTC


def one(path):
    (table,) = open_tables(path).values()
    return table


def text_of(separator, *, comma=False, head="t,x,y", rows=None):
    lines = [separator.join(f"{v:.6f}" for v in row) for row in (rows or zip(T, X, Y, strict=True))]
    if comma:
        lines = [line.replace(".", ",") for line in lines]
    return "\n".join([head.replace(",", separator), *lines]) + "\n"


TEXTS = {
    "comma": text_of(","), "semicolon": text_of(";"), "tab": text_of("\t"), "bar": text_of("|"),
    "spaces": text_of("   "), "decimal comma": text_of(";", comma=True),
    "decimal comma, tabs": text_of("\t", comma=True), "comments": "# boat 7\n# 2025\n" + text_of(","),
    "header in a comment": "# a log\n# t x y\n" + text_of(" ").split("\n", 1)[1],
    "percent": "%" + text_of(","), "units": text_of(",").replace("y\n", "y\n[s],[m],[m]\n", 1),
    "carriage returns": text_of(",").replace("\n", "\r\n"), "byte order mark": "\ufeff" + text_of(","),
    "title": "Drive of boat 3; 12.05.2026, lake\n" + text_of(";", comma=True), "separator": "sep=;\n" + text_of(";"),
    "titles and units": "boat 3\nlake, calm\n\n" + text_of(",").replace("y\n", "y\ns,m,m\n", 1),
    "quoted": text_of(",").replace("t,x,y", '"t","x","y"'), "empty lines": text_of(",").replace("\n", "\n\n"),
}  # fmt: skip


@pytest.mark.parametrize("kind", TEXTS)
def test_text_with_any_separator_gives_the_same_numbers(tmp_path, kind):
    path = tmp_path / "log.csv"
    path.write_text(TEXTS[kind], encoding="utf-8", newline="")
    table = one(path)
    assert table.names == ["t", "x", "y"]
    np.testing.assert_allclose(table.columns(["y", "x"]), np.column_stack([Y, X]), atol=1e-9)
    stamps = table.stamps(Column(column="t"))
    np.testing.assert_allclose(stamps, T * 1e9, atol=1.0)
    assert ("the line after the header has units, and counts as no row" in table.remarks) == (
        "units" in kind
    )
    titles = {"title": 1, "separator": 1, "titles and units": 2}.get(kind)
    said = [r for r in table.remarks if "above the header" in r]
    assert said == ([f"{titles} lines above the header are no row: left out"] if titles else [])


@pytest.mark.parametrize(
    ("encoding", "said"),
    [("cp1252", "is not UTF-8, and was read as Windows-1252"), ("utf-16", None), ("utf-8-sig", None)],
)  # fmt: skip
def test_text_of_other_encodings_gives_the_same_numbers(tmp_path, encoding, said):
    path = tmp_path / "log.csv"
    path.write_text(text_of(";", comma=True, head="t,x,y [°]"), encoding=encoding, newline="")
    table = one(path)
    assert table.names == ["t", "x", "y [°]"]
    np.testing.assert_allclose(table.columns(["y [°]"])[:, 0], Y, atol=1e-9)
    assert table.remarks == ([said] if said else [])


def test_a_header_with_too_few_names_is_no_title(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,x\n1,2,3\n4,5,6\n")
    with pytest.raises(SeatrialError, match="3 cells, expected 2; name every column"):
        one(path)


def test_a_name_that_is_twice_in_the_header_names_two_columns(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,x,x,x_2,x\n1,2,3,4,5\n")
    table = one(path)
    assert table.names == ["t", "x", "x_2", "x_2_2", "x_3"]
    assert table.columns(["x", "x_2", "x_2_2", "x_3"]).tolist() == [[2, 3, 4, 5]]
    assert table.remarks[0] == ("column 'x' is in the header 2 times; number 2 is read as 'x_2'")
    assert len(table.remarks) == 3


def test_text_cells_beside_the_numbers_do_no_harm(tmp_path):
    """A quoted cell may hold the separator; a column of text is no number."""
    path = tmp_path / "log.csv"
    path.write_text('t,mode,x\n1,"a,b",2\n2,"",3\n')
    table = one(path)
    assert table.columns(["t", "x"]).tolist() == [[1, 2], [2, 3]]
    assert np.isnan(table.numbers()[:, 1]).all()
    with pytest.raises(SeatrialError, match="line 2: column 'mode' has 'a,b', expected a number"):
        table.columns(["mode"])


# Stamps #

STAMPS = {
    "seconds": (["1.5", "2.25"], {}, [1_500_000_000, 2_250_000_000]),
    "milliseconds": (["1500", "2250.5"], {"unit": "ms"}, [1_500_000_000, 2_250_500_000]),
    "microseconds": (["1500", "2250"], {"unit": "us"}, [1_500_000, 2_250_000]),
    "nanoseconds": (["1500", "2250"], {"unit": "ns"}, [1500, 2250]),
    "unpadded": (["12.45", "12.100000000", "13"], {"unit": "s.ns"}, [12_000_000_045, 12_100_000_000, 13_000_000_000]),
    "iso": (["2025-04-11T10:08:14.5Z", "2025-04-11T10:08:15Z"], {}, [EPOCH * 10**9 + 500_000_000, (EPOCH + 1) * 10**9]),
    "zone": (["2025-04-11T12:08:14+02:00", "2025-04-11 10:08:14 UTC"], {}, [EPOCH * 10**9] * 2),
    "local": (["2025/04/11 10:08:14.123456789"], {}, [EPOCH * 10**9 + 123_456_789]),
    "comma": (["2025-04-11 10:08:14,25"], {}, [EPOCH * 10**9 + 250_000_000]),
    "compact": (["20250411T100814Z"], {}, [EPOCH * 10**9]),
    "day first": (["11.04.2025 10:08:14", "13.04.2025 10:08:14"], {}, [EPOCH * 10**9, (EPOCH + 172_800) * 10**9]),
    "month first": (["4/11/2025 10:08:14 AM", "4/13/2025 12:08:14 AM"], {}, [EPOCH * 10**9, (EPOCH + 136_800) * 10**9]),
    "month's name": (["11-Apr-2025 10:08:14"], {}, [EPOCH * 10**9]),
    "midnight": (["23:59:59.5", "00:00:00.5", "00:00:01"], {}, [86_399_500_000_000, 86_400_500_000_000, 86_401_000_000_000]),
}  # fmt: skip


@pytest.mark.parametrize("kind", STAMPS)
def test_stamps_of_every_kind(tmp_path, kind):
    cells, entry, expected = STAMPS[kind]
    path = tmp_path / "log.csv"
    path.write_text("when;x\n" + "".join(f"{cell};1\n" for cell in cells))
    assert one(path).stamps(Column(column="when", **entry)).tolist() == expected


def test_stamps_in_two_columns_are_exact(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(f"secs,nsecs\n{EPOCH},7\n{EPOCH},999999999\n")
    column = Column(column="secs", nanoseconds="nsecs")
    assert one(path).stamps(column).tolist() == [EPOCH * 10**9 + 7, EPOCH * 10**9 + 999_999_999]
    rows = np.array([False, True])
    assert one(path).stamps(column, rows).tolist() == [EPOCH * 10**9 + 999_999_999]


def unpadded(t):
    return f"{t // 10**9}.{t % 10**9}"


def test_nanoseconds_without_zeros_are_refused_as_seconds(tmp_path):
    nanoseconds = (np.arange(60) * 66_666_667 + 5 * 10**9).tolist()
    path = tmp_path / "log.csv"
    path.write_text("t\n" + "\n".join(map(unpadded, nanoseconds)))
    table = one(path)
    with pytest.raises(SeatrialError, match=r"jump back 4 times as seconds.*write unit: s\.ns"):
        table.stamps(Column(column="t"))
    assert table.stamps(Column(column="t", unit="s.ns")).tolist() == nanoseconds


@pytest.mark.parametrize(
    ("cells", "entry", "words"),
    [
        (["1", ""], {}, "line 3: column 't' has no stamp"),
        (["2025-04-11 10:00:00", ""], {}, "line 3: column 't' has no stamp"),
        (["2025-04-11 10:00:00", "soon"], {}, "line 3: column 't' has 'soon', expected a date and time"),
        (["2025-13-11 10:00:00"], {}, "'2025-13-11 10:00:00', which is no date and time"),
        (["1.5", "x"], {}, "line 3: column 't' has 'x', expected a number"),
        (["1.5"], {"nanoseconds": "ns"}, "have 1.5 and 3, expected whole seconds"),
        (["1.1234567890"], {"unit": "s.ns"}, "at most 9 digits of nanoseconds"),
        (["1e300"], {}, "is its unit ms, us or ns"),
        (["1"], {"unit": "m"}, "use s, ms, us or ns"),
    ],
)  # fmt: skip
def test_a_bad_stamp_is_one_line_that_names_the_place(tmp_path, cells, entry, words):
    path = tmp_path / "log.csv"
    path.write_text("t;ns;x\n" + "".join(f"{cell};3;1\n" for cell in cells))
    with pytest.raises(SeatrialError, match=words) as caught:
        one(path).stamps(Column(column="t", **entry))
    assert "\n" not in str(caught.value)


# Parquet #


@pytest.mark.parametrize("compression", ["none", "snappy", "gzip", "zstd", "lz4"])
def test_parquet(tmp_path, compression):
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    start = datetime.datetime(2025, 4, 11, 10, 8, 14, tzinfo=datetime.timezone.utc)
    path = tmp_path / "log.parquet"
    pq.write_table(
        pa.table({
            "time": pa.array([start + datetime.timedelta(seconds=t) for t in T.tolist()], pa.timestamp("us", tz="UTC")),
            "pose": [{"position": {"x": x, "y": y}} for x, y in zip(X.tolist(), Y.tolist(), strict=True)],
            "armed": [True] * N, "gap": [None, *range(1, N)], "mode": ["manual"] * N, "list": [[1.0]] * N,
            "when": ["2025-04-11 10:08:14"] * N, "half": X.astype(np.float16),
        }),
        path, compression=compression, row_group_size=7,
    )  # fmt: skip
    table = one(path)
    assert table.names == [
        "time", "pose.position.x", "pose.position.y", "armed", "gap", "mode", "when", "half",
    ]  # fmt: skip
    values = table.columns(["pose.position.x", "pose.position.y", "armed", "gap"])
    np.testing.assert_array_equal(values[:, :2], np.column_stack([X, Y]))
    assert (values[:, 2] == 1).all()
    assert np.isnan(values[0, 3])
    assert values[1:, 3].tolist() == list(range(1, N))
    np.testing.assert_allclose(
        table.stamps(Column(column="time")) - EPOCH * 10**9, T * 1e9, atol=1.0
    )
    assert table.stamps(Column(column="when"))[0] == EPOCH * 10**9
    np.testing.assert_allclose(table.columns(["half"])[:, 0], X, atol=1e-3)
    with pytest.raises(SeatrialError, match="row 1: column 'mode' has 'manual', expected a number"):
        table.columns(["mode"])
    with pytest.raises(SeatrialError, match="row 1: column 'gap' has no stamp"):
        table.stamps(Column(column="gap"))


def test_a_parquet_file_that_claims_rows_is_refused(tmp_path):
    """A run of equal numbers: 900 bytes that would be 8 GB."""
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    path = tmp_path / "log.parquet"
    columns = dict.fromkeys((f"c{i}" for i in range(200)), pa.array(np.zeros(1 << 20)))
    pq.write_table(pa.table(columns), path, compression="zstd")
    assert path.stat().st_size < 1 << 20
    with pytest.raises(SeatrialError, match="1048576 rows of 200 columns are more than"):
        one(path).numbers()
    assert len(one(path).columns(["c7"])) == 1 << 20


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.mat", b"", "is no MATLAB file of version 5 or 7.3; save it with -v7"),
        ("a.mat", b"\x89HDF\r\n\x1a\n" + bytes(900), "is damaged, or no MATLAB file"),
        ("a.parquet", b"PAR1", "is not a Parquet file, or damaged"),
        ("a.parquet", b"PAR1" + bytes(40) + b"\x20\x00\x00\x00PAR1", "is not a Parquet file, or damaged"),
        ("a.csv", b"", "is empty"),
        ("a.csv", b'a,b\n1,2\n3,"4\n5,6\n7,8\n', "expected a number|a quote"),
    ],
)  # fmt: skip
def test_other_content_is_one_line(tmp_path, name, content, words):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(SeatrialError, match=words) as caught:
        one(path).columns(["a", "b"])
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    ("module", "name", "words"),
    [
        ("pyarrow.parquet", "a.parquet", r"pip install 'seatrial\[parquet\]'"),
        ("scipy.io", "a.mat", r"pip install 'seatrial\[mat\]'"),
        ("h5py", "b.mat", r"pip install 'seatrial\[mat\]'"),
    ],
)
def test_a_missing_library_is_named_with_its_command(tmp_path, monkeypatch, module, name, words):
    content = {"a": b"MATLAB 5.0".ljust(124) + b"\x00\x01IM", "b": b"\x89HDF\r\n\x1a\n"}[name[0]]
    (tmp_path / name).write_bytes(content)
    monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(SeatrialError, match=words):
        open_tables(tmp_path / name)


def test_a_folder_has_its_tables_by_file(tmp_path):
    savemat = pytest.importorskip("scipy.io").savemat
    (tmp_path / "a.csv").write_text(text_of(","))
    (tmp_path / "notes.txt").write_text("t,x\n1,2,3\n")
    savemat(tmp_path / "b.mat", {"pose": {"t": T, "x": X}, "cmd": {"t": T, "u": X}})
    assert list(open_tables(tmp_path)) == ["a.csv", "b.mat:pose", "b.mat:cmd"]
    assert list(open_tables(tmp_path, only={"a.csv"})) == ["a.csv"]
