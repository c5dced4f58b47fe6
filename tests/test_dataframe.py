# SPDX-License-Identifier: MIT
"""Recordings from and to data frames: the same as a CSV table of the same columns, or the same line."""

import datetime
import sys
from decimal import Decimal

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.util.errors import SeatrialError

N = 200
T = np.arange(N) * 0.05


def boat(axes="forward-left-up", **pose) -> seatrial.Vehicle:
    content = {
        "seatrial": "vehicle 1", "name": "own", "axes": axes,
        "pose": {"stamp": "t", "x": "x", "y": "y", "psi": "psi", **pose},
        "commands": {"stamp": "t", "inputs": {"F_u": "F_u", "F_r": "F_r"}},
        "structure": "auto",
    }  # fmt: skip
    return vehicle_from(content, "own.yaml")


@pytest.fixture
def frame() -> pd.DataFrame:
    return pd.DataFrame(
        {
            "t": T, "x": np.sin(0.3 * T), "y": np.cos(0.2 * T), "psi": 0.4 * T,
            "F_u": np.where(T < 3, 0.0, 0.5), "F_r": np.where(T < 6, 0.0, -0.25),
        }
    )  # fmt: skip


def same(one: seatrial.Recording, other: seatrial.Recording) -> None:
    np.testing.assert_array_equal(one.stamps, other.stamps)
    np.testing.assert_array_equal(one.eta, other.eta)
    np.testing.assert_array_equal(one.valid, other.valid)
    np.testing.assert_array_equal(one.commands.stamps, other.commands.stamps)
    np.testing.assert_array_equal(one.commands.values, other.commands.values)
    assert one.faults == other.faults
    # a remark on a table begins with its name
    assert one.remarks == tuple(r.replace("dataframe.csv", "dataframe") for r in other.remarks)


def from_csv(frame: pd.DataFrame, vehicle: seatrial.Vehicle, folder, **more) -> seatrial.Recording:
    path = folder / "dataframe.csv"
    frame.to_csv(path, index=False, **more)
    return seatrial.read(path, vehicle)


def spoilt(frame: pd.DataFrame, kind: str) -> pd.DataFrame:
    if kind == "no pose":
        frame.loc[20:24, "x"] = np.nan
    elif kind == "unsorted":
        rows = [*range(50), 80, *range(50, 80), *range(81, N)]
        return frame.iloc[rows].reset_index(drop=True)
    elif kind == "jump":
        frame.loc[100:, "y"] += 7.0
    elif kind == "twice":
        return frame.iloc[[*range(30), 29, *range(30, N)]].reset_index(drop=True)
    elif kind == "two at once":
        again = frame.iloc[[*range(30), 29, *range(30, N)]].reset_index(drop=True)
        again.loc[30, "x"] += 0.004
        return again
    elif kind == "gap":
        return frame.drop(index=range(60, 110)).reset_index(drop=True)
    elif kind == "text":
        return frame.map(lambda value: f"{value!r}")
    return frame


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
@pytest.mark.parametrize(
    "kind", ["sound", "no pose", "unsorted", "jump", "twice", "two at once", "gap", "text"]
)
def test_a_frame_is_read_as_the_csv_table_of_its_columns(frame, kind, axes, tmp_path):
    given = spoilt(frame, kind)
    recording = seatrial.Recording.from_dataframe(given, boat(axes))
    same(recording, from_csv(given, boat(axes), tmp_path))
    faults = {fault.kind for fault in recording.faults}
    expected = {
        "no pose": FaultKind.NOT_FINITE, "unsorted": FaultKind.STAMP, "jump": FaultKind.JUMP,
        "two at once": FaultKind.STAMP, "gap": FaultKind.GAP,
    }  # fmt: skip
    assert kind not in expected or expected[kind] in faults
    assert kind != "twice" or recording.usable == 1.0


def test_units_offsets_signs_and_the_flag_are_those_of_the_vehicle_file(frame, tmp_path):
    vehicle = boat(
        psi={"column": "heading", "unit": "deg", "sign": -1, "offset": 90},
        x={"column": "x", "unit": "cm"}, valid="good",
    )  # fmt: skip
    own = frame.assign(
        heading=90 - np.degrees(frame.psi), x=100 * frame.x, good=np.arange(N) % 50 > 2
    )
    recording = seatrial.Recording.from_dataframe(own, vehicle, "pool 3")
    assert recording.name == "pool 3"
    assert recording.sources == ()
    np.testing.assert_allclose(recording.eta[:, 2], 0.4 * T, atol=1e-12)
    np.testing.assert_allclose(recording.eta[:, 0], frame.x, atol=1e-12)
    assert not recording.valid[[0, 1, 2, 50, 51, 100]].any()
    assert recording.valid[[3, 49, 60]].all()
    same(recording, from_csv(own.astype({"good": int}), vehicle, tmp_path))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda f: f.drop(columns="psi"), "dataframe: no column 'psi'"),
        (lambda f: f.rename(columns={"F_u": "F_U"}), "no column 'F_u'; did you mean 'F_r'?"),
        (lambda f: f.iloc[:0], "has columns but no rows"),
        (lambda f: f.assign(x=["a", *f.x[1:].astype(str)]), "dataframe row 1: column 'x' has 'a', expected a number"),
        (lambda f: f.assign(F_u=f.F_u.where(f.index != 7)), "dataframe row 8: 'F_u' is empty or not finite"),
        (lambda f: f.assign(t=f.t.where(f.index != 3)), "dataframe row 4: column 't' has no stamp"),
        (lambda f: f.assign(x=f.x + 0j), "column 'x' has complex numbers"),
        (lambda f: f.set_index(["t", "x"]), "the index of the rows has 2 levels, expected one"),
        (lambda f: pd.concat({"a": f}, axis=1), "the index of the columns has 2 levels"),
        (lambda f: f.assign(t=f.t * 1e12), "is its unit ms, us or ns?"),
        (lambda f: f.x, "expected a DataFrame, got Series"),
        (lambda f: f.iloc[:1], "1 poses; record a few seconds at least"),
        (lambda f: f.assign(x=np.nan), "0 usable poses of 200, most not a number"),
        (lambda f: f.assign(t=pd.to_datetime(f.t, unit="s").where(f.index != 3)), "row 4: column 't' has no stamp"),
        (lambda f: f.assign(t=np.arange(N).astype("datetime64[Y]").astype("datetime64[s]") + np.timedelta64(9 * 10**9, "s")), "out of range"),
    ],
)  # fmt: skip
def test_a_frame_that_is_no_recording_is_one_line(frame, change, said):
    with pytest.raises(SeatrialError) as caught:
        seatrial.Recording.from_dataframe(change(frame), boat())
    assert said in str(caught.value)


def test_columns_of_one_name_are_numbered_as_those_of_a_csv_table(frame, tmp_path):
    twice = pd.concat([frame, frame[["x"]] + 1.0], axis=1)
    vehicle = boat(x="x_2")
    recording = seatrial.Recording.from_dataframe(twice, vehicle)
    assert recording.eta[0, 0] == 1.0
    assert any("is read as 'x_2'" in remark for remark in recording.remarks)
    same(recording, from_csv(twice, vehicle, tmp_path))


STAMPS = {  # of whole milliseconds
    "UTC": lambda ms: pd.to_datetime(ms, unit="ms", utc=True),
    "zone": lambda ms: pd.to_datetime(ms, unit="ms", utc=True).dt.tz_convert("Asia/Kolkata"),
    "naive": lambda ms: pd.to_datetime(ms, unit="ms"),
    "milliseconds": lambda ms: pd.to_datetime(ms, unit="ms").astype("datetime64[ms]"),
    "difference": lambda ms: pd.to_timedelta(ms, unit="ms"),
    "arrow": lambda ms: pd.to_datetime(ms, unit="ms", utc=True).astype(
        "timestamp[us, UTC][pyarrow]"
    ),
    "periods": lambda ms: pd.to_datetime(ms, unit="ms").dt.to_period("ms"),
    "text": lambda ms: pd.to_datetime(ms, unit="ms", utc=True).astype(str),
    "objects": lambda ms: pd.Series(
        [datetime.datetime.fromtimestamp(one / 1e3, datetime.timezone.utc) for one in ms.tolist()],
        dtype=object,
    ),
    "decimals": lambda ms: pd.Series([Decimal(one) / 1000 for one in ms.tolist()], dtype=object),
    "integers": lambda ms: ms * 10**6,
}
EPOCH = 1_744_366_094.0  # [s] 2025-04-11 10:08:14 UTC


@pytest.mark.parametrize("kind", STAMPS)
@pytest.mark.parametrize("index", [False, True], ids=["column", "index"])
def test_stamps_of_every_type_are_the_same_times(frame, kind, index):
    begin = 0.0 if kind == "difference" else EPOCH
    stamps = STAMPS[kind](pd.Series(np.rint(1e3 * (begin + T)).astype(np.int64)))
    stamp = {"column": "t", "unit": "ns"} if kind == "integers" else "t"
    vehicle = boat(stamp=stamp)
    vehicle = vehicle_from(
        {**vehicle.to_mapping(), "commands": {"stamp": stamp, "inputs": {"F_u": "F_u", "F_r": "F_r"}}}, "own"
    )  # fmt: skip
    given = frame.assign(t=stamps)
    recording = seatrial.Recording.from_dataframe(given.set_index("t") if index else given, vehicle)
    np.testing.assert_allclose(recording.stamps, 1e9 * (begin + T), rtol=0, atol=300)
    np.testing.assert_allclose(recording.t, T, atol=1e-6)


def test_an_index_of_times_without_a_name_is_a_column_named_index(frame):
    own = frame.drop(columns="t").set_index(pd.to_datetime(EPOCH + frame.t, unit="s", utc=True))
    own.index.name = None
    vehicle = boat(stamp="index")
    vehicle = vehicle_from(
        {**vehicle.to_mapping(), "commands": {"stamp": "index", "inputs": {"F_u": "F_u", "F_r": "F_r"}}}, "own"
    )  # fmt: skip
    assert seatrial.Recording.from_dataframe(own, vehicle).origin == round(1e9 * EPOCH)
    with pytest.raises(SeatrialError, match="no column 'index'"):
        seatrial.Recording.from_dataframe(frame, vehicle)


def test_nullable_and_categorical_columns_are_numbers(frame, tmp_path):
    own = frame.astype(
        {"F_u": "Float64", "x": "category", "y": "string", "psi": "float64[pyarrow]"}
    )
    own.loc[5, "y"] = pd.NA
    recording = seatrial.Recording.from_dataframe(own, boat())
    assert not recording.valid[5]
    same(recording, from_csv(own, boat(), tmp_path))


def test_a_frame_of_a_recording_has_its_poses_velocities_and_the_commands_that_hold(paper_mp):
    recording = paper_mp["S1"].recording
    shown = recording.to_dataframe(velocities=True)
    assert list(shown) == ["x", "y", "psi", "u", "v", "r", "F_u", "F_v", "F_r", "valid"]
    assert shown.index.name == "t"
    np.testing.assert_array_equal(shown.index, recording.t)
    np.testing.assert_array_equal(shown[["x", "y", "psi"]], recording.eta)
    np.testing.assert_array_equal(shown[["u", "v", "r"]], seatrial.motion(recording).nu)
    np.testing.assert_array_equal(shown.valid, recording.valid)
    assert shown.valid.dtype == bool
    for i in range(0, len(shown), 97):
        before = np.flatnonzero(recording.commands.stamps <= recording.stamps[i])
        held = recording.commands.values[before[-1]] if len(before) else np.full(3, np.nan)
        np.testing.assert_array_equal(shown.iloc[i][["F_u", "F_v", "F_r"]].astype(float), held)
    assert shown.attrs["axes"] == "forward-left-up"
    assert shown.attrs["units"]["r"] == "rad/s"
    assert shown.attrs["first_stamp_ns"] == recording.origin
    shown.loc[:, "x"] = 0.0
    assert recording.eta[:, 0].any()  # a copy
    assert "u" not in recording.to_dataframe()


def test_scales_are_columns_and_names_do_not_collide(cse1):
    assert "propeller_speed" in cse1["run1"].to_dataframe()
    content = boat().to_mapping()
    content["commands"] = {"stamp": "t", "inputs": {"x": "F_u", "valid": "F_r"}}
    content["forces"] = {
        "F_u": {"axis": "surge", "of": {"x": 1.0}},
        "F_r": {"axis": "yaw", "of": {"valid": 1.0}},
    }
    frame = pd.DataFrame({"t": T, "x": T, "y": T, "psi": T, "F_u": 0.5, "F_r": 0.25})
    shown = seatrial.Recording.from_dataframe(frame, vehicle_from(content, "own")).to_dataframe()
    assert list(shown) == ["x", "y", "psi", "command.x", "command.valid", "valid"]
    assert (shown["command.x"] == 0.5).all()
    assert (shown["x"].to_numpy() == T).all()


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    steps=st.lists(st.integers(20_000_000, 300_000_000), min_size=8, max_size=60),
    marked=st.sets(st.integers(0, 59)),
)
def test_a_frame_of_a_recording_is_the_recording(seed, steps, marked):
    """Poses and their validity; commands where the poses are. Headings differ by whole turns at most."""
    t = np.cumsum(np.array(steps)) * 1e-9
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.normal(0.0, [0.05, 0.05, 0.1], (len(t), 3)), axis=0)
    first = pd.DataFrame(np.column_stack([t, walk]), columns=["t", "x", "y", "psi"]).assign(
        F_u=rng.uniform(-1, 1, len(t)), F_r=rng.uniform(-1, 1, len(t)), valid=True
    )
    first.loc[[row for row in marked if 3 < row < len(t)], "valid"] = False
    recording = seatrial.Recording.from_dataframe(first, boat(valid="valid"))
    shown = recording.to_dataframe()
    again = seatrial.Recording.from_dataframe(shown, boat(valid="valid"))
    np.testing.assert_array_equal(again.t, recording.t)
    np.testing.assert_array_equal(again.eta[:, :2], recording.eta[:, :2])
    turns = (again.eta[:, 2] - recording.eta[:, 2]) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.rint(turns), atol=1e-12)
    np.testing.assert_array_equal(again.commands.values, shown[["F_u", "F_r"]])
    np.testing.assert_array_equal(again.valid, recording.valid)


def test_a_model_from_a_frame_is_the_model_from_its_recording(paper_mp, mp):
    recording = paper_mp["S1"].recording.cut(0.0, 60.0)
    commands = recording.commands
    rows = pd.DataFrame({"t": recording.seconds(commands.stamps)}).assign(
        **dict(zip(commands.names, commands.values.T, strict=True))
    )
    poses = pd.DataFrame({"t": recording.t}).assign(
        **dict(zip("xyp", recording.raw.T, strict=True))
    )
    content = mp.to_mapping()
    content["pose"] = {"stamp": "t", "x": "x", "y": "y", "psi": "p"}
    content["commands"] = {"stamp": "t", "inputs": {name: name for name in commands.names}}
    mixed = pd.concat([rows, poses]).sort_values("t", kind="stable")
    again = seatrial.Recording.from_dataframe(mixed, vehicle_from(content, "mp"))
    np.testing.assert_allclose(again.eta, recording.eta, atol=1e-12)
    own = seatrial.identify([recording], mp, method="equation-error")
    found = seatrial.identify([again], mp, method="equation-error")
    np.testing.assert_allclose(found.coefficients, own.coefficients, rtol=1e-6)


@pytest.mark.parametrize("way", ["to", "from"])
def test_without_pandas_there_is_one_line_with_what_to_install(frame, monkeypatch, way):
    recording = seatrial.Recording.from_dataframe(frame, boat())
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(SeatrialError, match=r"need pandas: pip install 'seatrial\[pandas\]'"):
        if way == "to":
            recording.to_dataframe()
        else:
            seatrial.Recording.from_dataframe(frame, boat())
