# SPDX-License-Identifier: MIT
"""Init from a bag or tables to a model; sticks wherever they are."""

import re

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from init_tools import NAMES, one_table, refused, tables, with_papers_terms
from logs import JOY, drive, half, nanoseconds
from sheets import sheet

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.commands.cli import main
from seatrial.guide.answers import proposed
from seatrial.identification.methods import DEFAULT_METHOD
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.proposal.by_name import ThrustersUnknownError
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices
from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.simulation.plan import load_plan

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
    assert check_consistency([record], vehicle).findings == ()
    right = seatrial.load_vehicle("mallard-mp")
    reference = seatrial.read(tables(log, tmp_path / "reference"), right)
    expected = seatrial.identify([reference], right, method="equation-error")
    found = seatrial.identify([record], with_papers_terms(vehicle), method="equation-error")
    exact = 1e-2 if kind == "array" else 1e-4  # stamped by arrival
    for name, value in expected.values.items():
        error = 2.0 * expected.standard_errors[name] if kind == "array" else 1e-6
        assert found.values[name] == pytest.approx(value, rel=exact, abs=error), name
    assert "structure: auto" in text
    assert vehicle.inputs == NAMES
    assert vehicle.name == "pool"


@pytest.mark.system
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
    truth = load_plan("clean").plant.coefficients  # drive() is the clean plan's boat
    assert {"X_u", "X_uu", "X_F", "Y_v", "Y_vv", "Y_F", "N_r", "N_rr", "N_F"} <= set(found.values)
    for name, value in found.values.items():
        if name[0] in "XY":
            error = 4.5 * found.standard_errors[name]
            assert value == pytest.approx(truth.get(name, 0.0), abs=error), name  # X_vr, Y_ur: none
        elif name in truth:  # N_ud u_dot is not in the library: its v r, u and F_u are
            error = max(4.5 * found.standard_errors[name], 0.1 * abs(truth[name]))
            assert value == pytest.approx(truth[name], abs=error), name


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
    assert check_consistency([record], vehicle).findings == ()


def test_what_is_not_used_is_named(log, tmp_path, propose):
    path = write_bag(tmp_path / "pool.bag", [log.topics()[0], joy(log, (3, 4, 2))])
    _, text = propose(path)
    assert "# not used: axes[0], axes[1], axes[5]" in text
    for name, at in (("F_u", 3), ("F_v", 4), ("F_r", 2)):
        assert re.search(rf'{name}: {{field: "axes\[{at}\]"}} +# moves \w+ \(t \d+\)', text)


@pytest.mark.parametrize(
    "case",
    [
        ("mavros_msgs/msg/RCOut", "channels", lambda f: 1500 + 400 * f, {"offset": 1500, "scale": 400}),
        ("std_msgs/msg/Int16MultiArray", "data", lambda f: 1000 * f, {"scale": 1000}),
        ("std_msgs/msg/Int16MultiArray", "data", lambda f: 220 * f, {"scale": 127}),
        ("std_msgs/msg/Float64MultiArray", "data", lambda f: 12.0 * f, {"scale": 7}),
        ("std_msgs/msg/Float64MultiArray", "data", lambda f: 0.9 * f, {}),
    ],
    ids=["PWM", "thousands", "7 bits", "newtons", "fractions"],
)  # fmt: skip
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
    assert check_consistency([record], vehicle).findings == ()


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
    assert "Commands are recorded only when they change, so the last one holds" in text
    assert "while it changes" in text
    _, text = propose(log.write(tmp_path / "steady.bag"))
    assert "only when they change" not in text
    assert (
        yaml.safe_load(text.replace("# command_timeout", "command_timeout"))["command_timeout"]
        == 0.5
    )


@pytest.mark.parametrize("folder", [True, False])
def test_an_input_that_rests_in_the_first_of_several_tables_is_an_input(log, tmp_path, folder):
    """Surge first, then sway, then yaw, as is asked for: no recording moves all inputs."""
    both = []
    for name, still in (("surge", ["F_v", "F_r"]), ("turns", ["F_u"])):
        own = tables(log, tmp_path / name) if folder else one_table(log, tmp_path / f"{name}.csv")
        path = own / "commands.csv" if folder else own
        lines = path.read_text().splitlines()
        head = lines[0].split(",")
        at = {head.index(n) for n in still}
        rows = [
            ",".join("0.0" if i in at and cell else cell for i, cell in enumerate(line.split(",")))
            for line in lines[1:]
        ]
        path.write_text("\n".join([lines[0], *rows]) + "\n")
        both.append(own)
    assert set(init(*both).sources.channels) == {"F_u", "F_v", "F_r"}
    assert set(init(both[0]).sources.channels) == {"F_u"}


def allocated(log, folder):
    """Three sticks drive four thrusters: what one of them does alone is nowhere to be seen."""
    mix = np.array([[1, 1, 1], [1, -1, -1], [1, 1, -1], [1, -1, 1]]) / 3.0
    path = tables(log, folder) / "commands.csv"
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    sheet(path, "t,fl,fr,rl,rr", rows[:, 0], 1500.0 + 400.0 * rows[:, 1:] @ mix.T)
    return folder


CROSSED = "0.3 0 45; 0.3 0 -45; -0.3 0 45; -0.3 0 -45"


def test_thrusters_behind_an_allocation_are_refused_as_such(log, tmp_path, capsys):
    path = allocated(log, tmp_path / "pool")
    said = refused(capsys, path, "-o", tmp_path / "vehicle.yaml")
    assert "fl, fr, rl, rr are always driven in the same 3 combinations" in said
    assert "in this order: --thrusters 'X Y DEG; X Y DEG; ...'" in said
    three = CROSSED.rpartition(";")[0]
    said = refused(capsys, path, "-o", tmp_path / "vehicle.yaml", "--thrusters", three)
    assert "3 of 4 thrusters given; one each for fl, fr, rl and rr, separated by ';'" in said
    for wrong in ("0.3 0.2", "0.3 left 45", "0.3 0.2 45 1", "300 200 45"):
        said = refused(capsys, path, "-o", tmp_path / "vehicle.yaml", "--thrusters", wrong)
        assert f"thruster '{wrong}': expected x [m], y [m] and direction [deg]" in said


def test_thrusters_behind_an_allocation_are_used_where_their_places_are_given(
    log, tmp_path, propose
):
    path = allocated(log, tmp_path / "pool")
    vehicle, text = propose(path, "--thrusters", CROSSED)
    content = yaml.safe_load(text)
    assert content["thrusters"]["rl"] == {"x": -0.3, "y": 0.0, "angle_deg": 45.0}
    assert "No channel moves it" not in text
    assert vehicle.inputs == ("fl", "fr", "rl", "rr")
    assert "forces" not in content
    recording = seatrial.read(path, vehicle)
    assert np.abs(recording.commands.values).max() <= 1.0
    report = check_consistency([recording], vehicle)
    assert report.findings == ()
    # no direction of a thruster alone: the log does not show it
    first, *forces = report.text[:4]
    assert first.startswith("fl, fr, rl and rr are driven in 3 combinations, which do not show")
    moves = ("F_u of these moves surge forward", "F_v of these moves sway to the left",
             "F_r of these moves yaw to the left")  # fmt: skip
    assert [said.partition(" (t ")[0] for said in forces] == [*moves]
    assert not any(re.match(r"(fl|fr|rl|rr) moves", said) for said in report.text)
    # nor where two of them are found to be exchanged
    swapped = text.replace("{column: fl", "{column: other").replace("{column: fr", "{column: fl")
    file = tmp_path / "swapped.yaml"
    file.write_text(swapped.replace("{column: other", "{column: fr"))
    wrong = seatrial.load_vehicle(file)
    found = check_consistency([seatrial.read(path, wrong)], wrong).findings
    assert found and not any(re.search(r"(fl|fr|rl|rr) moves", one.text) for one in found)


def test_auto_asks_for_the_places_of_thrusters_behind_an_allocation(log, tmp_path):
    """In the order of the channels; without an answer, or without somebody to ask, it is refused."""
    path = allocated(log, tmp_path / "pool")
    asked = []

    class Answers:
        def __init__(self, answer):
            self.answer = answer

        def text(self, question):
            asked.append(question)
            return self.answer

        def choose(self, question, options):
            raise AssertionError(question)

    proposal, chosen = proposed([path], Choices(), Answers(CROSSED), salvage=False)
    assert "Where are the thrusters fl, fr, rl and rr? Needed here: " in asked[0]
    assert "For each x ahead [m], y to port [m] and" in asked[0]
    assert chosen.thrusters[2] == (-0.3, 0.0, 45.0)
    assert list(yaml.safe_load(proposal.text)["thrusters"]) == ["fl", "fr", "rl", "rr"]
    assert "they are driven in the same 3 combinations (an allocation)" in asked[0]
    for answers in (Answers(""), None):
        with pytest.raises(ThrustersUnknownError, match="3 combinations"):
            proposed([path], Choices(), answers, salvage=False)
    first, again = asked[1:]
    assert first.endswith("Enter: asked again") and first == asked[0]
    assert again.startswith("Without these places there is no model")
    assert again.endswith("Enter: not known, and stop")
    said = r"--thrusters 'X Y DEG.*; what was answered is the option --lever 0\.05 -0\.1"
    with pytest.raises(ThrustersUnknownError, match=said):
        proposed([path], Choices(lever=(0.05, -0.1)), Answers(""), salvage=False)
