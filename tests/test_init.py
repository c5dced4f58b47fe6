# SPDX-License-Identifier: MIT
"""What `seatrial init` proposes: a file that reads, has the right signs, and gives the same model."""

import contextlib
import io
import json
import re

import numpy as np
import pytest
import yaml
from bag_tools import START, Sent, header, quaternion, ros2
from conftest import CSE1
from hypothesis import given, settings
from hypothesis import strategies as st
from logs import AXES_OF_JOY, JOY, POSE, drive, nanoseconds, wave
from test_model import frd

import seatrial
from seatrial.cli import main
from seatrial.errors import RecordingError
from seatrial.identify import DEFAULT_METHOD
from seatrial.init import Choices, init
from seatrial.io.write_bag import BagTopic, write_bag
from seatrial.plan import load_plan
from seatrial.signs import check_signs
from seatrial.vehicle import vehicle_from

NAMES = ("F_u", "F_v", "F_r")


def half(t, seed=0):
    """Sticks that never ask for more than the thrusters can."""
    return 0.6 * wave(t, seed)


@pytest.fixture(scope="module")
def log():
    return drive(sticks=half)


@pytest.fixture
def propose(tmp_path, capsys):
    """`seatrial init` by the command line: the vehicle that its file describes, and the text."""

    def run(recording, *more):
        out = tmp_path / f"{recording.name}.yaml"
        code = main(["init", str(recording), "-o", str(out), "-q", *map(str, more)])
        shown = capsys.readouterr()
        assert (code, shown.err) == (0, "")
        text = out.read_text()
        assert text in shown.out
        assert f"wrote {out}; next: seatrial inspect {recording} --vehicle {out}" in shown.out
        return seatrial.load_vehicle(out), text

    return run


def refused(capsys, *arguments):
    """The one line with which it is refused."""
    code = main(["init", *map(str, arguments), "-q"])
    shown = capsys.readouterr()
    assert (code, shown.out, shown.err.count("\n")) == (1, "", 1)
    return shown.err


def tables(log, folder, **changes):
    """The log as two tables."""
    folder.mkdir()
    for name, t, values, head in (
        ("poses", log.pose_t, log.pose, changes.get("pose", "t,x,y,psi")),
        ("commands", log.command_t, log.command, changes.get("commands", "t,F_u,F_v,F_r")),
    ):
        rows = np.column_stack([t * changes.get("second", 1.0), values])
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header=head, comments="")
    return folder


def one_table(log, path):
    """The log as one table: a line for each pose or command, empty cells elsewhere."""
    lines = [
        (t, f"{t!r},{','.join(map(repr, p))},,,") for t, p in zip(log.pose_t.tolist(), log.pose.tolist(), strict=True)
    ]  # fmt: skip
    lines += [
        (t, f"{t!r},,,,{','.join(map(repr, c))}")
        for t, c in zip(log.command_t.tolist(), log.command.tolist(), strict=True)
    ]
    body = "\n".join(line for _, line in sorted(lines))
    path.write_text(f"t,x,y,psi,F_u,F_v,F_r\n{body}\n")
    return path


WRITERS = {
    "ros1": lambda log, out: log.write(out / "pool.bag"),
    "mcap": lambda log, out: log.write(out / "pool.mcap"),
    "db3": lambda log, out: log.write(out / "pool.db3"),
    "odometry": lambda log, out: log.write(out / "pool.mcap", pose_type="nav_msgs/msg/Odometry"),
    "array": lambda log, out: log.write(
        out / "pool.bag", joy_type="std_msgs/msg/Float32MultiArray"
    ),
    "folder": lambda log, out: tables(log, out / "pool"),
    "table": lambda log, out: one_table(log, out / "pool.csv"),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_the_file_proposed_identifies_the_model_that_the_right_one_does(
    kind, log, tmp_path, propose
):
    recording = WRITERS[kind](log, tmp_path)
    vehicle, text = propose(recording)
    record = seatrial.read(recording, vehicle)
    assert len(record.t) == len(log.pose_t)
    np.testing.assert_allclose(record.commands.values, log.command, atol=1e-6)
    np.testing.assert_allclose(record.eta[:, :2], log.pose[:, :2], atol=1e-6)
    assert check_signs([record], vehicle).findings == ()
    right = seatrial.load_vehicle("mallard-mp")
    reference = seatrial.read(tables(log, tmp_path / "reference"), right)
    expected = seatrial.identify([reference], right, method="equation-error")
    found = seatrial.identify([record], vehicle, method="equation-error")
    exact = 1e-2 if kind == "array" else 1e-4  # stamped by arrival
    for name, value in expected.values.items():
        error = 2.0 * expected.standard_errors[name] if kind == "array" else 1e-6
        assert found.values[name] == pytest.approx(value, rel=exact, abs=error), name
    assert "structure: mallard" in text
    assert vehicle.inputs == NAMES
    assert vehicle.name == "pool"


def same_boat(found, expected):
    """Of one recording, but dead zones are sought at the forces here and at the thrusters there."""
    assert found.structure.coefficients == expected.structure.coefficients
    for name, value in expected.values.items():
        assert found.values[name] == pytest.approx(value, abs=expected.standard_errors[name]), name
    delays = [
        sum(
            value
            for name, value in zip(m.vehicle.constants.names, m.constants, strict=True)
            if name in ("latency", "lag")
        )
        for m in (found, expected)
    ]
    assert delays[0] == pytest.approx(delays[1], abs=1e-3)  # [s]


def test_from_a_bag_to_a_model_by_two_commands(tmp_path, propose, capsys):
    """The file proposed, with the method that is taken where none is named."""
    path = drive(180.0, sticks=half).write(tmp_path / "pool.bag")
    _, _ = propose(path)
    model = tmp_path / "model.yaml"
    arguments = ["identify", path, "--vehicle", tmp_path / "pool.bag.yaml", "-o", model, "-q"]
    assert main([*map(str, arguments)]) == 0
    assert capsys.readouterr().err == ""
    found = seatrial.load(model)
    assert found.estimator.method == DEFAULT_METHOD
    right = seatrial.load_vehicle("mallard-mp")
    same_boat(found, seatrial.identify([seatrial.read(path, right)], right))
    for name, value in found.values.items():  # drive() is the clean plan's boat
        true = load_plan("clean").plant.coefficients[name]
        assert value == pytest.approx(true, abs=4.5 * found.standard_errors[name]), name


# Joypads. #


def joy(log, axes, signs=(1, 1, 1), *, kind="sensor_msgs/msg/Joy", name="axes", make=None):
    """Sticks at other places, and others that do something else or nothing."""
    n = len(log.command_t)
    columns = {f"{name}[{i}]": np.zeros(n) for i in range(6)}
    columns[f"{name}[{min(set(range(6)) - set(axes))}]"] = 0.01 * np.cumsum(
        np.random.default_rng(1).normal(size=n)
    )  # a trigger
    for i, (at, sign) in enumerate(zip(axes, signs, strict=True)):
        columns[f"{name}[{at}]"] = sign * log.command[:, i]
    if make is not None:
        columns = {path: make(values) for path, values in columns.items()}
    return BagTopic(
        JOY, kind, nanoseconds(log.command_arrival), nanoseconds(log.command_t), columns
    )  # fmt: skip


@given(st.permutations(range(6)), st.tuples(*[st.sampled_from([-1, 1])] * 3))
@settings(max_examples=6)
def test_sticks_are_found_wherever_they_are_and_whichever_way_round(tmp_path_factory, order, signs):
    log = drive(sticks=half)
    path = tmp_path_factory.mktemp("joy") / "pool.bag"
    write_bag(path, [log.topics()[0], joy(log, order[:3], signs)])
    content = yaml.safe_load(init(path).text)
    assert content["commands"]["inputs"] == {
        name: {"field": f"axes[{at}]"} | ({} if sign > 0 else {"sign": -1})
        for name, at, sign in zip(NAMES, order[:3], signs, strict=True)
    }
    vehicle = vehicle_from(content, "proposed")
    record = seatrial.read(path, vehicle)
    np.testing.assert_allclose(record.commands.values, log.command, atol=1e-6)
    assert check_signs([record], vehicle).findings == ()


def test_what_is_not_used_is_named(log, tmp_path, propose):
    path = write_bag(tmp_path / "pool.bag", [log.topics()[0], joy(log, (3, 4, 2))])
    _, text = propose(path)
    assert "# not used: axes[0], axes[1], axes[5]" in text
    for name, at in (("F_u", 3), ("F_v", 4), ("F_r", 2)):
        assert re.search(rf'{name}: {{field: "axes\[{at}\]"}} +# seen to move \w+ \(t \d+\)', text)


@pytest.mark.parametrize(
    "case",
    [
        (
            "mavros_msgs/msg/RCOut",
            "channels",
            lambda f: 1500 + 400 * f,
            {"offset": 1500, "scale": 400},
        ),
        ("std_msgs/msg/Int16MultiArray", "data", lambda f: 1000 * f, {"scale": 1000}),
        ("std_msgs/msg/Int16MultiArray", "data", lambda f: 220 * f, {"scale": 127}),
        ("std_msgs/msg/Float64MultiArray", "data", lambda f: 12.0 * f, {"scale": 7}),
        ("std_msgs/msg/Float64MultiArray", "data", lambda f: 0.9 * f, {}),
    ],
    ids=["PWM", "thousands", "7 bits", "newtons", "fractions"],
)
def test_full_command_is_one(log, tmp_path, propose, case):
    kind, name, make, column = case
    message = joy(log, (0, 1, 2), kind=kind, name=name, make=make)
    path = write_bag(tmp_path / "pool.mcap", [log.topics()[0], message])
    vehicle, text = propose(path)
    inputs = yaml.safe_load(text)["commands"]["inputs"]
    for i, entry in enumerate(inputs.values()):
        assert entry == {"field": f"{name}[{i}]"} | column
    record = seatrial.read(path, vehicle)
    largest = np.abs(record.commands.values).max()
    assert 0.5 < largest <= 1.05
    raw = make(log.command)
    expected = (raw - column.get("offset", 0.0)) / column.get("scale", 1.0)
    np.testing.assert_allclose(
        record.commands.values, expected, atol=1.1 / column.get("scale", 1e6)
    )
    assert check_signs([record], vehicle).findings == ()


def test_of_more_channels_than_inputs_those_that_move_most_are_asked(tmp_path, propose):
    """An autopilot logs 16 outputs, and those of a camera, too."""
    log = drive(150.0, sticks=half)
    n = len(log.command_t)
    columns = {f"channels[{i}]": np.full(n, 1500.0) for i in range(16)}
    for i in range(3, 8):
        columns[f"channels[{i}]"] = 1500.0 + 100 * np.sign(np.sin(0.1 * i * log.command_t))
    for i, at in enumerate((9, 10, 14)):
        columns[f"channels[{at}]"] = np.round(1500 + 400 * log.command[:, i])
    topic = BagTopic(
        "/mavros/rc/out", "mavros_msgs/msg/RCOut", nanoseconds(log.command_arrival),
        nanoseconds(log.command_t), columns,
    )  # fmt: skip
    vehicle, text = propose(write_bag(tmp_path / "pool.bag", [log.topics()[0], topic]))
    inputs = yaml.safe_load(text)["commands"]["inputs"]
    assert [e["field"] for e in inputs.values()] == [f"channels[{i}]" for i in (9, 10, 14)]
    assert vehicle.inputs == NAMES


def test_columns_that_read_alike_are_kept_apart(log, tmp_path, propose):
    vehicle, text = propose(tables(log, tmp_path / "pool", commands="t,a b,a_b,a-b"))
    assert [e["column"] for e in yaml.safe_load(text)["commands"]["inputs"].values()] == [
        "a b",
        "a_b",
        "a-b",
    ]
    assert vehicle.inputs == NAMES


def test_manual_control_is_in_thousandths(log, tmp_path, propose):
    columns = {
        "x": 1000 * log.command[:, 0],
        "y": 700 * log.command[:, 1],
        "r": -1000 * log.command[:, 2],
    }
    columns["z"] = np.full(len(log.command), 500.0)
    topic = BagTopic(
        "/mavros/manual_control/control", "mavros_msgs/msg/ManualControl",
        nanoseconds(log.command_arrival), nanoseconds(log.command_t), columns,
    )  # fmt: skip
    path = write_bag(tmp_path / "pool.bag", [log.topics()[0], topic])
    vehicle, text = propose(path)
    assert yaml.safe_load(text)["commands"]["inputs"] == {
        "F_u": {"field": "x", "scale": 1000}, "F_v": {"field": "y", "scale": 1000},
        "F_r": {"field": "r", "scale": 1000, "sign": -1},
    }  # fmt: skip
    np.testing.assert_allclose(
        seatrial.read(path, vehicle).commands.values, log.command * [1.0, 0.7, 1.0], atol=1e-6
    )


def test_a_joypad_that_speaks_only_when_it_is_moved_is_noticed(log, tmp_path, propose):
    kept = np.sort(np.random.default_rng(3).choice(len(log.command_t), 900, replace=False))
    changed = log.but(
        command=log.command[kept], command_t=log.command_t[kept],
        command_arrival=log.command_arrival[kept],
    )  # fmt: skip
    _, text = propose(changed.write(tmp_path / "pool.bag"))
    assert "Commands are written only when they change, so the last one holds" in text
    assert "while it changes" in text
    _, text = propose(log.write(tmp_path / "steady.bag"))
    assert "only when they change" not in text
    assert (
        yaml.safe_load(text.replace("# command_timeout", "command_timeout"))["command_timeout"]
        == 0.5
    )


# Thrusters. #

T = seatrial.load_vehicle("mallard-mp").mix  # (3, 4)


def thrust(t, seed=0):
    """Four commands (n, 4), each by itself."""
    t = np.asarray(t)[:, None]
    slow, fast = np.array([0.41, 0.53, 0.67, 0.83]), np.array([1.9, 1.7, 1.3, 1.1])
    return 0.55 * np.sin(slow * t + np.arange(4)) + 0.4 * np.sin(fast * t + np.arange(4) ** 2)


@pytest.mark.parametrize("shape", ["topics", "array"])
def test_thrusters_become_forces_as_they_were_seen_to_push(shape, tmp_path, propose):
    log = drive(180.0, sticks=lambda t, seed: thrust(t) @ T.T)
    f = thrust(log.command_t)
    arrival, stamps = nanoseconds(log.command_arrival), nanoseconds(log.command_t)
    if shape == "topics":
        topics = [
            BagTopic(
                f"/thruster_{k + 1}/cmd",
                "std_msgs/msg/Float64",
                arrival,
                stamps,
                {"data": f[:, k]},
            )
            for k in range(4)
        ]
        slow = nanoseconds(np.arange(0.0, 180.0, 1.0))
        topics.append(  # another of the same type, that moves nothing
            BagTopic(
                "/battery", "std_msgs/msg/Float64", slow, slow, {"data": np.linspace(25, 24, 180)}
            )
        )
        names = [f"thruster_{k + 1}_cmd" for k in range(4)]
    else:
        data = {f"data[{k}]": f[:, k] for k in range(4)}
        topics = [BagTopic("/thrusters", "std_msgs/msg/Float64MultiArray", arrival, stamps, data)]
        names = [f"data_{k}" for k in range(4)]
    path = write_bag(tmp_path / "pool.mcap", [log.topics()[0], *topics])
    vehicle, text = propose(path)
    assert vehicle.inputs == tuple(names)
    found = yaml.safe_load(text)["forces"]
    for axis, (name, label) in enumerate(zip(NAMES, ("surge", "sway", "yaw"), strict=True)):
        assert found[name]["axis"] == label
        weights = np.array([found[name]["of"].get(n, 0.0) for n in names])
        expected = T[axis] / np.abs(T[axis]).sum()
        np.testing.assert_allclose(weights, expected, atol=0.02)
    record = seatrial.read(path, vehicle)
    np.testing.assert_allclose(record.commands.values, f, atol=1e-6)
    assert check_signs([record], vehicle).findings == ()
    content = seatrial.load_vehicle("mallard-mp").to_mapping() | {
        "allocation": {"scheme": "direct"}
    }
    content["commands"] = yaml.safe_load(text)["commands"]
    inputs = content["commands"]["inputs"]
    content["commands"]["inputs"] = {f"F_{k + 1}": inputs[n] for k, n in enumerate(names)}
    right = vehicle_from(content, "right")
    expected = seatrial.identify([seatrial.read(path, right)], right, method="equation-error")
    model = seatrial.identify([record], vehicle, method="equation-error")
    for name, value in expected.values.items():
        scale = 2.0 if name in ("X_F", "Y_F", "N_F") else 1.0  # weights sum to 1 there, to 2 in T
        close = 4 * expected.standard_errors[name] + 0.02 * abs(value)
        assert model.values[name] == pytest.approx(scale * value, abs=scale * close), name


@pytest.mark.parametrize(("kind", "run"), [("csv", "random_run1"), ("mcap", "run1")])
def test_the_model_ships_thrusters_push_where_they_stand(kind, run, propose, tmp_path):
    """tau = [u1 + u3, u2 + u4 + u5, ly u1 - lx u2 - ly u3 - lx u4 + lb u5], all levers positive."""
    path = CSE1 / kind / f"CSE1_data_{run}.{kind}"
    vehicle, text = propose(path, "--axes", "forward-right-down")
    assert vehicle.axes.value == "forward-right-down"
    names = [f"u{k}" if kind == "csv" else f"data_{k - 1}" for k in range(1, 6)]
    assert vehicle.inputs == tuple(names)
    assert "# not used: " + ("bt_limit, vsp_speed" if kind == "csv" else "data[5], data[6]") in text
    signs = {"F_u": "+0+00", "F_v": "0+0++", "F_r": "+---+"}
    found = yaml.safe_load(text)["forces"]
    least = {"F_u": 2, "F_v": 3, "F_r": 4 if run == "run1" else 5}
    for force, geometry in signs.items():
        of = [found[force]["of"].get(n, 0.0) for n in names]
        own = [w * {"+": 1, "-": -1, "0": 0}[s] for w, s in zip(of, geometry, strict=True)]
        assert min(own) >= 0, force
        assert sum(w > 0 for w in own) >= least[force], force
        strange = [abs(w) for w, s in zip(of, geometry, strict=True) if s == "0"]
        assert max(strange, default=0.0) < max(own) / 2, force
    if kind == "csv":
        assert yaml.safe_load(text)["pose"]["valid"] == "pose_valid"
    record = seatrial.read(path, vehicle)
    assert check_signs([record], vehicle).findings == ()
    if run == "run1":
        return  # alone it does not show enough of sway's drag for a model
    model = seatrial.identify([record], vehicle, method="equation-error")
    assert all(model.values[name] > 0 for name in ("X_F", "Y_F", "N_F"))


# Units and axes. #


def test_degrees_and_millimetres_are_noticed(log, tmp_path, propose):
    other = log.but(pose=log.pose * [1000.0, 1000.0, 180 / np.pi])
    folder = tables(other, tmp_path / "pool")
    vehicle, text = propose(folder)
    pose = yaml.safe_load(text)["pose"]
    assert (pose["x"], pose["y"]) == ({"column": "x", "unit": "mm"}, {"column": "y", "unit": "mm"})
    assert pose["psi"] == {"column": "psi", "unit": "deg"}
    for said in ("x is in mm", "y is in mm", "psi is in deg"):
        assert f"# {said}, by the way that the boat moves" in text
    record = seatrial.read(folder, vehicle)
    np.testing.assert_allclose(record.eta, log.pose, atol=1e-9)


@pytest.mark.parametrize(
    "case",
    [
        ("t [ms],X [cm],Y [cm],yaw [deg]", "time_ms,a,b,c", 1e3, ("ms", "cm", "deg")),
        ("stamp,pos_x,pos_y,heading", "ns,a,b,c", 1e9, ("ns", None, None)),
        ("time,x_mm,y_mm,psi_deg", "t,a,b,c", 1e6, ("us", "mm", "deg")),
        ("seconds;x;y;theta".replace(";", ","), "t,a,b,c", 1.0, (None, None, None)),
    ],
)
def test_units_in_the_names_of_columns_are_believed(log, tmp_path, propose, case):
    pose, commands, second, units = case
    scale = {None: 1.0, "cm": 100.0, "mm": 1000.0, "deg": 180 / np.pi}
    other = log.but(pose=log.pose * [scale[units[1]], scale[units[1]], scale[units[2]]])
    folder = tables(other, tmp_path / "pool", pose=pose, commands=commands, second=second)
    vehicle, text = propose(folder)
    content = yaml.safe_load(text)
    assert content["pose"]["stamp"].get("unit") == units[0]
    assert content["commands"]["stamp"].get("unit") == units[0]
    assert content["pose"]["x"].get("unit") == units[1]
    assert content["pose"]["psi"].get("unit") == units[2]
    record = seatrial.read(folder, vehicle)
    np.testing.assert_allclose(record.eta, log.pose, atol=1e-9)
    np.testing.assert_allclose(record.t, log.pose_t, atol=1e-6)
    assert [e["column"] for e in content["commands"]["inputs"].values()] == ["a", "b", "c"]


@pytest.mark.parametrize("sticks", ["turned", "as they were"])
def test_a_recording_in_forward_right_down_axes(tmp_path, propose, sticks):
    """The same boat; sticks that are positive to port have sign -1 in a file that is to starboard."""
    log = drive(180.0, sticks=half)
    turned = np.array([1.0, -1.0, -1.0])
    other = log.but(
        pose=log.pose * turned, command=log.command * (turned if sticks == "turned" else 1.0)
    )
    path = other.write(tmp_path / "pool.bag")
    vehicle, text = propose(path, "--axes", "forward-right-down")
    assert "axes: forward-right-down" in text
    assert "y to starboard, psi clockwise" in text
    inputs = yaml.safe_load(text)["commands"]["inputs"]
    assert [e.get("sign", 1) for e in inputs.values()] == (
        [1, 1, 1] if sticks == "turned" else [1, -1, -1]
    )
    record = seatrial.read(path, vehicle)
    np.testing.assert_allclose(record.commands.values, log.command, atol=1e-6)
    assert check_signs([record], vehicle).findings == ()
    right = frd(seatrial.load_vehicle("mallard-mp"))
    left = log.write(tmp_path / "left.bag")
    port, _ = propose(left)
    reference = seatrial.identify([seatrial.read(left, port)], port)
    model = seatrial.identify([record], vehicle)
    np.testing.assert_allclose(model.coefficients, reference.coefficients, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(model.constants, reference.constants, rtol=1e-4, atol=1e-5)
    assert right.axes is vehicle.axes


def test_pulse_widths_to_starboard(log, tmp_path, propose):
    """A file's own axes and its offset are two things: neither is turned with the other."""
    turned = np.array([1.0, -1.0, -1.0])
    other = log.but(pose=log.pose * turned, command=1500 + 400 * log.command * turned)
    folder = tables(other, tmp_path / "pool")
    vehicle, text = propose(folder, "--axes", "forward-right-down")
    for entry in yaml.safe_load(text)["commands"]["inputs"].values():
        assert (entry["offset"], entry["scale"]) == (1500, 400)
    np.testing.assert_allclose(
        seatrial.read(folder, vehicle).commands.values, log.command, atol=1e-9
    )


def test_several_recordings_show_together_what_one_does_not(tmp_path, propose):
    """One axis each, as the paper's S1 to S3."""
    paths = [
        drive(seed=i, sticks=lambda t, seed, i=i: half(t, seed) * np.eye(3)[i]).write(tmp_path / f"S{i + 1}.bag")
        for i in range(3)
    ]  # fmt: skip
    _, alone = propose(paths[0])
    assert [*yaml.safe_load(alone)["commands"]["inputs"]] == ["F_u"]
    out = tmp_path / "all.yaml"
    assert main(["init", *map(str, paths), "-o", str(out), "-q"]) == 0
    content = yaml.safe_load(out.read_text())
    assert {n: e["field"] for n, e in content["commands"]["inputs"].items()} == {
        "F_u": "axes[1]", "F_v": "axes[0]", "F_r": "axes[3]",
    }  # fmt: skip
    vehicle = seatrial.load_vehicle(out)
    records = [seatrial.read(path, vehicle) for path in paths]
    assert check_signs(records, vehicle).findings == ()
    right = seatrial.load_vehicle("mallard-mp")
    expected = seatrial.identify([seatrial.read(path, right) for path in paths], right)
    same_boat(seatrial.identify(records, vehicle), expected)


def test_columns_named_north_and_east_are_a_hint(log, tmp_path, propose):
    folder = tables(log, tmp_path / "pool", pose="t,north,east,heading")
    _, text = propose(folder)
    assert "columns named north and east mean forward-right-down (--axes)" in text


# What was not driven. #


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
@pytest.mark.parametrize(
    ("driven", "missing"),
    [((1, 0, 0), ("sway", "yaw")), ((1, 0, 1), ("sway",)), ((0, 1, 0), ("surge", "yaw"))],
)
def test_axes_that_nothing_drove_are_left_to_be_filled_in(tmp_path, propose, driven, missing, axes):
    log = drive(sticks=lambda t, seed: half(t) * driven)
    turned = np.array([1.0, -1.0, -1.0]) if axes == "forward-right-down" else np.ones(3)
    other = log.but(pose=log.pose * turned, command=log.command * turned)
    path = other.write(tmp_path / "pool.bag")
    vehicle, text = propose(path, "--axes", axes)
    names = {"surge": "F_u", "sway": "F_v", "yaw": "F_r"}
    for axis in missing:
        assert re.search(
            rf"# {names[axis]}: {{...}} +# check: what drives {axis}\? Nothing was seen to", text
        )
        assert f"# {names[axis]}: {{axis: {axis}, of: {{{names[axis]}: 1}}}}" in text
    kept = [names[a] for a in names if a not in missing]
    assert vehicle.inputs == tuple(kept)
    assert [f.name for f in vehicle.forces] == kept
    assert {
        t.factors[-1] for t in vehicle.structure.terms if t.factors and t.factors[-1][:2] == "F_"
    } == set(kept)
    record = seatrial.read(path, vehicle)
    expected = log.command[:, [i for i in range(3) if driven[i]]]
    np.testing.assert_allclose(record.commands.values, expected, atol=1e-6)
    report = seatrial.inspect([record], vehicle)
    assert report.signs.findings == ()
    for i, axis in enumerate(("surge", "sway", "yaw")):
        assert (report.recordings[0].axes[i].rms == 0.0) == (axis in missing)


def test_what_is_filled_in_as_the_comments_say_is_the_whole_boat(tmp_path, propose):
    """The lines for sway and yaw without their '#', and their terms: the file for all trials."""
    surge = drive(sticks=lambda t, seed: half(t) * [1, 0, 0]).write(tmp_path / "surge.bag")
    _, text = propose(surge)
    for name, at in (("F_v", 0), ("F_r", 3)):
        text = re.sub(rf"# {name}: {{\.\.\.}}", f'{name}: {{field: "axes[{at}]"}}', text)
        text = re.sub(rf"# ({name}: {{axis)", r"\1", text)
    text = text.replace("Y_vv * |v| * v]", "Y_vv * |v| * v, Y_F * F_v]")
    text = text.replace("N_uu * |u| * u]", "N_uu * |u| * u, N_F * F_r]")
    vehicle = vehicle_from(yaml.safe_load(text), "filled in")
    path = drive(180.0, sticks=half).write(tmp_path / "all.bag")
    record = seatrial.read(path, vehicle)
    assert check_signs([record], vehicle).findings == ()
    right = seatrial.load_vehicle("mallard-mp")
    expected = seatrial.identify([seatrial.read(path, right)], right)
    same_boat(seatrial.identify([record], vehicle), expected)


def test_a_short_look_goes_by_names_or_says_what_is_missing(tmp_path, propose, capsys):
    log = drive(8.0, sticks=half)
    folder = tables(log, tmp_path / "pool")
    vehicle, text = propose(folder)
    assert vehicle.inputs == NAMES
    assert text.count("check: by its name; nothing was seen to move") == 3
    unnamed = tables(log, tmp_path / "unnamed", commands="t,a,b,c")
    line = refused(capsys, unnamed, "-o", tmp_path / "v.yaml")
    assert "8 s do not show which of a, b, c move the boat; record some minutes" in line


# Which topics. #


def tf_log(log, frames=(("map", "odom"), ("odom", "base_link"))):
    """Poses as transforms by way of odom, which stands still; and sticks."""
    sent = []
    for t, (x, y, psi) in zip(
        (log.pose_t * 1e9).astype(int).tolist(), log.pose.tolist(), strict=True
    ):
        still = {"translation": {"x": 0.0, "y": 0.0, "z": 0.0}, "rotation": quaternion(0.0)}
        moved = {"translation": {"x": x, "y": y, "z": 0.0}, "rotation": quaternion(psi)}
        transforms = [
            {"header": header(START + t, parent), "child_frame_id": child, "transform": where}
            for (parent, child), where in zip(frames, (still, moved), strict=True)
        ]
        sent.append(
            Sent("/tf", "tf2_msgs/msg/TFMessage", START + t + 2_000_000, {"transforms": transforms})
        )
    for t, row in zip(
        (log.command_t * 1e9).astype(int).tolist(), log.command.tolist(), strict=True
    ):
        axes = [0.0] * 4
        for at, value in zip(AXES_OF_JOY, row, strict=True):
            axes[at] = value
        sent.append(
            Sent(
                JOY,
                "sensor_msgs/msg/Joy",
                START + t + 1_000_000,
                {"header": header(START + t), "axes": axes},
            )
        )
    return sent


def test_poses_from_tf_with_the_usual_frames(tmp_path, propose, capsys):
    log = drive(joypad=20.0, sticks=half)
    path = ros2(tmp_path / "pool", tf_log(log))
    vehicle, text = propose(path)
    assert yaml.safe_load(text)["pose"] == {"topic": "/tf", "parent": "map", "child": "base_link"}
    record = seatrial.read(path, vehicle)
    np.testing.assert_allclose(record.eta[:, :2], log.pose[:, :2], atol=1e-9)
    assert check_signs([record], vehicle).findings == ()
    odd = ros2(tmp_path / "odd", tf_log(log, (("lake", "dock"), ("dock", "duck"))))
    line = refused(capsys, odd, "-o", tmp_path / "v.yaml")
    assert "name the world's frame with --parent and the boat's with --child" in line
    assert "dock -> duck (moves)" in line
    vehicle, text = propose(odd, "--parent", "lake", "--child", "duck")
    assert yaml.safe_load(text)["pose"] == {"topic": "/tf", "parent": "lake", "child": "duck"}
    np.testing.assert_allclose(seatrial.read(odd, vehicle).eta[:, 0], log.pose[:, 0], atol=1e-9)


@pytest.fixture
def two_boats(log, tmp_path):
    """Two robots in one bag, each with its pose and its sticks."""
    topics = []
    for i, name in enumerate(("duck", "swan")):
        for topic in log.but(pose=np.add(log.pose, [3.0 * i, 0, 0])).topics():
            topics.append(
                BagTopic(
                    f"/{name}{topic.name}",
                    topic.type_name,
                    topic.arrival,
                    topic.stamps,
                    topic.columns,
                )
            )
    return write_bag(tmp_path / "lake.bag", topics)


def test_of_two_boats_one_must_be_named(two_boats, log, tmp_path, propose, capsys):
    line = refused(capsys, two_boats, "-o", tmp_path / "v.yaml")
    assert (
        "several could be the poses: /duck/slam/pose, /swan/slam/pose; name one with --pose" in line
    )
    assert "two robots?" in line
    line = refused(capsys, two_boats, "-o", tmp_path / "v.yaml", "--pose", "/swan/slam/pose")
    assert "several could be the commands: /duck/joy, /swan/joy; name one with --commands" in line
    line = refused(capsys, two_boats, "-o", tmp_path / "v.yaml", "--pose", "/goose/pose")
    assert "no topic /goose/pose (--pose); the topics are" in line
    vehicle, text = propose(
        two_boats, "--pose", "/swan/slam/pose", "--commands", "swan/joy", "--name", "swan"
    )
    content = yaml.safe_load(text)
    assert (content["pose"]["topic"], content["commands"]["topic"]) == (
        "/swan/slam/pose",
        "/swan/joy",
    )
    assert content["name"] == "swan"
    assert "# could also be: /duck/slam/pose (geometry_msgs/PoseStamped)" in text
    record = seatrial.read(two_boats, vehicle)
    assert record.eta[0, 0] == pytest.approx(log.pose[0, 0] + 3.0)


def test_of_two_boats_the_user_chooses_one(two_boats):
    asked = []

    def ask(question, options):
        asked.append((question, tuple(options)))
        return options[1]

    content = yaml.safe_load(init(two_boats, ask=ask).text)
    assert (content["pose"]["topic"], content["commands"]["topic"]) == (
        "/swan/slam/pose",
        "/swan/joy",
    )
    assert asked == [
        ("Which are the poses of the boat?", ("/duck/slam/pose", "/swan/slam/pose")),
        ("Which are the commands of the boat?", ("/duck/joy", "/swan/joy")),
    ]


def test_nothing_is_asked_that_is_known(log, tmp_path):
    def ask(question, options):
        pytest.fail(f"{question} {options}")

    odometry = log.topics(pose_type="nav_msgs/msg/Odometry")[0]
    odometry = BagTopic(
        "/odometry/filtered",
        odometry.type_name,
        odometry.arrival,
        odometry.stamps,
        odometry.columns,
    )
    path = write_bag(tmp_path / "pool.mcap", [*log.topics(), odometry])
    assert yaml.safe_load(init(path, ask=ask).text)["pose"]["topic"] == POSE
    chosen = init(path, choices=Choices(pose="/odometry/filtered"), ask=ask).text
    assert yaml.safe_load(chosen)["pose"]["topic"] == "/odometry/filtered"


def test_of_several_tables_that_of_the_commands_is_found_or_named(log, tmp_path, propose, capsys):
    folder = tables(log, tmp_path / "pool")
    rows = np.column_stack([np.arange(90.0), np.linspace(25, 24, 90)])
    np.savetxt(folder / "battery.csv", rows, delimiter=",", header="t,volt", comments="")
    _, text = propose(folder)
    assert yaml.safe_load(text)["commands"]["file"] == "commands.csv"
    (folder / "commands.csv").rename(folder / "sent.csv")
    line = refused(capsys, folder, "-o", tmp_path / "v.yaml")
    assert "several could be the commands: battery.csv, sent.csv; name one with --commands" in line
    vehicle, text = propose(folder, "--commands", "sent.csv", "--force")
    assert yaml.safe_load(text)["commands"]["file"] == "sent.csv"
    assert len(seatrial.read(folder, vehicle).commands.stamps) == len(log.command_t)
    line = refused(capsys, folder, "-o", tmp_path / "v.yaml", "--commands", "nothing.csv")
    assert "no table nothing.csv (--commands); there are battery.csv, poses.csv, sent.csv" in line


def test_columns_with_empty_cells_are_left_out(log, tmp_path, propose):
    folder = tables(log, tmp_path / "pool")
    lines = (folder / "commands.csv").read_text().splitlines()
    lines = [
        f"{lines[0]},battery",
        *(f"{line},{i if i % 50 == 0 else ''}" for i, line in enumerate(lines[1:])),
    ]
    (folder / "commands.csv").write_text("\n".join(lines) + "\n")
    vehicle, text = propose(folder)
    assert "left out, as cells are empty: battery" in text
    assert vehicle.inputs == NAMES
    assert len(seatrial.read(folder, vehicle).commands.stamps) == len(log.command_t)


BARE = {
    "no poses": (lambda log, out: write_bag(out / "a.bag", log.topics()[1:]), "no topic looks like poses; if one is, name it with --pose. The topics are /joy (sensor_msgs/Joy)"),
    "no commands": (lambda log, out: write_bag(out / "a.mcap", log.topics()[:1]), "no topic looks like commands; if one is, name it with --commands"),
    "empty": (lambda log, out: write_bag(out / "a.db3", []), "no topic looks like poses; if one is, name it with --pose. The topics are none"),
    "at rest": (lambda log, out: log.but(command=0 * log.command).write(out / "a.bag"), "no command ever changes; record while the boat is driven"),
    "still at rest": (lambda log, out: tables(log.but(command=0 * log.command), out / "a"), "no column that changes is left for the commands"),
    "no headings": (lambda log, out: tables(log, out / "a", pose="t,x,y,foo"), "no table has columns named like x, y and psi"),
    "no time": (lambda log, out: tables(log.but(pose_t=log.pose_t[::-1]), out / "a", pose="back,x,y,psi"), "no column of stamps; it has back, x, y, psi"),
    "nowhere": (lambda log, out: out / "none.bag", "none.bag: no such file or folder"),
    "no bag": (lambda log, out: out, "no .csv file and no bag in this folder"),
}  # fmt: skip


@pytest.mark.parametrize("case", BARE)
def test_what_can_not_be_proposed_is_one_line(case, log, tmp_path, capsys):
    make, words = BARE[case]
    (tmp_path / "in").mkdir()
    line = refused(capsys, make(log, tmp_path / "in"), "-o", tmp_path / "v.yaml")
    assert words in line
    assert not (tmp_path / "v.yaml").exists()


# The file. #


def test_an_existing_file_is_not_written_over_unless_it_is_said(log, tmp_path, propose, capsys):
    path = log.write(tmp_path / "pool.bag")
    out = tmp_path / "pool.bag.yaml"
    out.write_text("mine")
    line = refused(capsys, path, "-o", out)
    assert "exists already; give another name, or --force to write over it" in line
    assert out.read_text() == "mine"
    vehicle, _ = propose(path, "--force")
    assert vehicle.name == "pool"


ODD = (
    "x y", "yes", "off", "null", "~", "1e3", "0x10", "a: b", "a #b", "- a", "{a}", "a\"b", "back\\slash", "'",
    "*", "&a", "!tag", "%", "@", "`", "|", ">", "?", "Ä", "推力", "a\u2028b", "\x7f", "🛥", "=", "<<", ".nan", "1:30", "NO",
)  # fmt: skip


@pytest.mark.parametrize("words", list(zip(*[iter(ODD)] * 3, strict=True)))
def test_names_that_yaml_would_take_for_something_else(words, log, tmp_path):
    folder = tables(log, tmp_path / "log", commands=",".join(("t", *words)))
    text = init(folder, choices=Choices(name=words[0])).text
    content = yaml.safe_load(text)
    assert content["name"] == "".join(c if c.isprintable() else "_" for c in words[0])
    assert [e["column"] for e in content["commands"]["inputs"].values()] == list(words)
    vehicle = vehicle_from(content, "proposed")
    assert len(seatrial.read(folder, vehicle).commands.stamps) == len(log.command_t)


@pytest.mark.parametrize("word", ["x y", "yes", "a: b", 'a"b', "back\\slash", "- a", "1e3"])
def test_names_of_topics(word, log, tmp_path):
    """A recorder's names are checked by nobody."""
    poses, sticks = log.topics()
    topics = [
        BagTopic(f"/{word}/pose", poses.type_name, poses.arrival, poses.stamps, poses.columns),
        BagTopic(word, sticks.type_name, sticks.arrival, sticks.stamps, sticks.columns),
    ]
    path = write_bag(tmp_path / "pool.mcap", topics)
    content = yaml.safe_load(init(path).text)
    assert content["pose"]["topic"] == f"/{word}/pose"
    assert content["commands"]["topic"] == word
    assert len(seatrial.read(path, vehicle_from(content, "proposed")).t) == len(log.pose_t)


headers = st.text(
    st.characters(exclude_categories=("Cs",), exclude_characters="\n\r,;\t\0"), min_size=1, max_size=8
) | st.sampled_from(["t", "x", "y", "psi", "valid", "F_u", "yaw", "x [mm]", "a_b", "a b", "z", "stamp"])  # fmt: skip


@settings(max_examples=40)
@given(st.lists(headers, min_size=3, max_size=9), st.booleans())
def test_whatever_the_columns_are_called_there_is_a_file_or_one_line(
    tmp_path_factory, names, usual
):
    log = drive(sticks=half)
    names = ["t", "x", "y", "psi", *names] if usual else names
    at = np.searchsorted(log.command_t, log.pose_t)
    data = np.column_stack(
        [log.pose_t, log.pose, log.command[at], -log.command[at], log.pose, log.pose]
    )
    folder = tmp_path_factory.mktemp("names")
    path, out = folder / "log.csv", folder / "v.yaml"
    body = "\n".join(",".join(map(repr, row)) for row in data[:, : len(names)].tolist())
    path.write_text(f"{','.join(names)}\n{body}\n", encoding="utf-8")
    shown, wrong = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(shown), contextlib.redirect_stderr(wrong):
        code = main(["init", str(path), "-o", str(out), "-q"])
    if code == 0:
        vehicle = seatrial.load_vehicle(out)
        assert len(seatrial.read(path, vehicle).t) == len(log.pose_t)
        json.dumps(yaml.safe_load(out.read_text()))
    else:
        assert code == 1
        assert wrong.getvalue().startswith("seatrial: ")
        assert wrong.getvalue().count("\n") == 1
        assert not out.exists()


def test_init_is_there_in_python_too(log, tmp_path):
    path = log.write(tmp_path / "pool.bag")
    found = seatrial.init(path)
    assert found.sources.pose == {"topic": POSE}
    assert found.drive.undriven == ()
    with pytest.raises(RecordingError, match="no topic looks like poses"):
        seatrial.init(write_bag(tmp_path / "joy.bag", log.topics()[1:]))


@pytest.mark.parametrize("answers", [["2"], ["x", ""]])
def test_at_a_terminal_the_axes_are_asked_for(answers, log, tmp_path, monkeypatch, capsys):
    axes = "right-down" if answers == ["2"] else "left-up"  # enter is the first
    bag = log.write(tmp_path / "log.bag")
    given = iter(answers)
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    monkeypatch.setattr("builtins.input", lambda _: next(given))
    assert main(["init", str(bag), "-o", str(tmp_path / "v.yaml")]) == 0
    assert "does psi rise" in capsys.readouterr().out
    assert seatrial.load_vehicle(tmp_path / "v.yaml").axes.value == f"forward-{axes}"
    assert (
        main(["init", str(bag), "--axes", "forward-left-up", "-o", str(tmp_path / "w.yaml")]) == 0
    )
    assert "does psi rise" not in capsys.readouterr().out
