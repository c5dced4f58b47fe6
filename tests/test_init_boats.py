# SPDX-License-Identifier: MIT
"""Init finds thrusters, units and axes out of the data, and leaves what nothing drove."""

import re

import numpy as np
import pytest
import steered_boat
import yaml
from conftest import CSE1, at_length
from init_tools import NAMES, refused, same_boat, tables, with_papers_terms
from logs import drive, half, nanoseconds
from sheets import sheet, two_sheets

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.inspection.consistency.check import check_consistency
from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.recording.origin import poses_of_origin
from tests.boats.hulls import MIDDLE, driven

# Thrusters. #

T = seatrial.load_vehicle("mallard-mp").mix  # (3, 4)


def thrust(t, seed=0):
    """Four commands (n, 4), each by itself."""
    t = np.asarray(t)[:, None]
    slow, fast = np.array([0.41, 0.53, 0.67, 0.83]), np.array([1.9, 1.7, 1.3, 1.1])
    return 0.55 * np.sin(slow * t + np.arange(4)) + 0.4 * np.sin(fast * t + np.arange(4) ** 2)


@pytest.mark.parametrize("shape", ["topics", "array"])
def test_thrusters_become_forces_as_they_were_seen_to_push(shape, tmp_path, propose):
    log = drive(120.0, sticks=lambda t, seed: thrust(t) @ T.T)
    f = thrust(log.command_t)
    arrival, stamps = nanoseconds(log.command_arrival), nanoseconds(log.command_t)
    if shape == "topics":
        topics = [
            BagTopic(
                f"/thruster_{k + 1}/cmd", "std_msgs/msg/Float64", arrival, stamps, {"data": f[:, k]}
            )
            for k in range(4)
        ]
        slow = nanoseconds(np.arange(0.0, 120.0, 1.0))
        topics.append(  # another of the same type, that moves nothing
            BagTopic(
                "/battery", "std_msgs/msg/Float64", slow, slow, {"data": np.linspace(25, 24, 120)}
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
        np.testing.assert_allclose(weights, expected, atol=1e-12)  # alike, as they seem so
    record = seatrial.read(path, vehicle)
    np.testing.assert_allclose(record.commands.values, f, atol=1e-6)
    assert check_consistency([record], vehicle).findings == ()
    content = seatrial.load_vehicle("mallard-mp").to_mapping() | {
        "allocation": {"scheme": "direct"}
    }
    content["commands"] = yaml.safe_load(text)["commands"]
    inputs = content["commands"]["inputs"]
    content["commands"]["inputs"] = {f"F_{k + 1}": inputs[n] for k, n in enumerate(names)}
    right = vehicle_from(content, "right")
    expected = seatrial.identify([seatrial.read(path, right)], right, method="equation-error")
    vehicle = with_papers_terms(vehicle)
    model = seatrial.identify([record], vehicle, method="equation-error")
    for name, value in expected.values.items():
        scale = 2.0 if name in ("X_F", "Y_F", "N_F") else 1.0  # weights sum to 1 there, to 2 in T
        close = 4 * expected.standard_errors[name] + 0.02 * abs(value)
        assert model.values[name] == pytest.approx(scale * value, abs=scale * close), name


@pytest.mark.parametrize(("kind", "run"), [("csv", "random_run1"), at_length("mcap", "run1")])
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
    least = {"F_u": 2, "F_v": 3, "F_r": 3 if run == "run1" else 5}
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
    assert check_consistency([record], vehicle).findings == ()
    if run == "run1":
        return  # alone it does not show enough of sway's drag for a model
    papers = with_papers_terms(vehicle)
    model = seatrial.identify([record], papers, method="equation-error")
    assert all(model.values[name] > 0 for name in ("X_F", "Y_F", "N_F"))


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
            rf"# {names[axis]}: {{...}} +# check: which input drives {axis}\? No channel moves it",
            text,
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


@pytest.mark.system
def test_what_is_filled_in_as_the_comments_say_is_the_whole_boat(tmp_path, propose):
    """The lines for sway and yaw without their '#': the file for all trials."""
    surge = drive(sticks=lambda t, seed: half(t) * [1, 0, 0]).write(tmp_path / "surge.bag")
    _, text = propose(surge)
    for name, at in (("F_v", 0), ("F_r", 3)):
        text = re.sub(rf"# {name}: {{\.\.\.}}", f'{name}: {{field: "axes[{at}]"}}', text)
        text = re.sub(rf"# ({name}: {{axis)", r"\1", text)
    vehicle = vehicle_from(yaml.safe_load(text), "filled in")
    path = drive(120.0, sticks=half).write(tmp_path / "all.bag")
    record = seatrial.read(path, vehicle)
    assert check_consistency([record], vehicle).findings == ()
    right = seatrial.load_vehicle("mallard-mp")
    expected = seatrial.identify([seatrial.read(path, right)], right)
    same_boat(seatrial.identify([record], with_papers_terms(vehicle)), expected)


def test_a_short_look_goes_by_names_or_says_what_is_missing(tmp_path, propose, capsys):
    log = drive(8.0, sticks=half)
    folder = tables(log, tmp_path / "pool")
    vehicle, text = propose(folder)
    assert vehicle.inputs == NAMES
    assert text.count("check: chosen by name; no axis moves significantly with it") == 3
    unnamed = tables(log, tmp_path / "unnamed", commands="t,a,b,c")
    line = refused(capsys, unnamed, "-o", tmp_path / "v.yaml")
    assert "8 s do not show which of a, b, c move the boat; record some minutes" in line


# Sensors off the origin. #


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
@pytest.mark.parametrize("lever", [(0.25, 0.0), (-0.15, 0.1)])
def test_a_sensor_off_the_origin_is_a_lever_not_a_force(lever, axes, tmp_path, propose):
    """Turning moves it aside: F_r was taken for a part of what drives the boat sideways."""
    log = drive(120.0)
    x, y, psi = log.pose.T
    c, s = np.cos(psi), np.sin(psi)
    moved = [x + c * lever[0] - s * lever[1], y + s * lever[0] + c * lever[1], psi]
    turn = np.array([1.0, -1.0, -1.0]) if axes == "forward-right-down" else np.ones(3)
    log = log.but(pose=np.column_stack(moved) * turn, command=log.command * turn)
    vehicle, text = propose(tables(log, tmp_path / "off"), "--axes", axes)
    assert set(vehicle.inputs) == set(NAMES)
    assert not vehicle.file.forces
    assert vehicle.lever == pytest.approx(lever, abs=0.04)
    assert "check: position of the sensor" in text


@pytest.mark.parametrize("lever", [(0.4, 0.0), (-0.3, 0.15), (0.0, 0.3)])
def test_a_lever_of_a_boat_that_is_quick_in_yaw_does_not_hide_the_stick_for_sway(
    lever, tmp_path, propose
):
    """Turning moves such a sensor aside more than any command for sway does."""
    _, recordings = driven(MIDDLE, {"lag": 0.1}, seed=3, white=2e-3, seconds=300.0, drives=1)
    eta = poses_of_origin(recordings[0], -np.array(lever)).eta
    folder = tmp_path / "quick"
    folder.mkdir()
    vehicle, _ = propose(two_sheets(folder, recordings[0], *NAMES, poses=eta))
    assert set(vehicle.inputs) == set(NAMES)
    assert not vehicle.file.forces
    assert vehicle.lever == pytest.approx(lever, abs=0.1)


def test_the_sensors_place_is_asked_for_where_nothing_is_seen_of_it(tmp_path, propose):
    vehicle, text = propose(tables(drive(120.0), tmp_path / "at"))
    assert vehicle.lever == (0.0, 0.0)
    assert re.search(r"# lever: \[0, 0\] +# check: position of the sensor", text)


def test_two_thrusters_astern_push_nothing_sideways(tmp_path, propose):
    """A boat sways as it turns, as poses of a point off its middle do: a third force of two thrusters is none."""
    mix = np.array([[0.5, 0.5], [0.0, 0.0], [-0.5, 0.5]])  # left, right
    log = drive(120.0, sticks=lambda t, seed: thrust(t)[:, :2] @ mix.T)
    x, y, psi = log.pose.T
    moved = np.column_stack([x - 0.25 * np.cos(psi), y - 0.25 * np.sin(psi), psi])
    log = log.but(pose=moved, command=thrust(log.command_t)[:, :2])
    vehicle, text = propose(tables(log, tmp_path / "cat", commands="t,left,right"))
    of = {name: force.of for name, force in vehicle.file.forces.items()}
    assert of == {"F_u": {"left": 0.5, "right": 0.5}, "F_r": {"left": -0.5, "right": 0.5}}
    assert "which input drives sway? It moves with the inputs of other axes only" in text
    assert (
        "# origin: the middle of thrusters around the boat; of thrusters astern only, the" in text
    )
    assert re.search(r"left: .*sway \(t", text)


def test_places_that_are_given_are_used_where_the_recording_shows_weights(
    tmp_path, propose, capsys
):
    """Moments are force times arm, y to port: a thruster to port turns the boat to starboard."""
    mix = np.array([[0.5, 0.5], [0.0, 0.0], [-0.5, 0.5]])  # left, right
    log = drive(120.0, sticks=lambda t, seed: thrust(t)[:, :2] @ mix.T)
    log = log.but(command=thrust(log.command_t)[:, :2])
    path = tables(log, tmp_path / "cat", commands="t,left,right")
    vehicle, text = propose(path, "--thrusters", "-0.4 0.25 0; -0.4 -0.3 0")
    of = {name: force.of for name, force in vehicle.file.forces.items()}
    assert of == {"F_u": {"left": 1.0, "right": 1.0}, "F_r": {"left": -0.25, "right": 0.3}}
    assert "by the places [m] of the thrusters as given" in text
    assert "No channel moves it" not in text
    said = refused(capsys, path, "-o", tmp_path / "v.yaml", "--thrusters", "-0.4 0.25 0")
    assert "1 of 2 thrusters given; one each for left and right" in said
    sticks = tables(drive(120.0), tmp_path / "two")
    rows = np.loadtxt(sticks / "commands.csv", delimiter=",", skiprows=1)
    sheet(sticks / "commands.csv", "t,F_u,F_r", rows[:, [0, 1, 3]])
    said = refused(capsys, sticks, "-o", tmp_path / "v.yaml", "--thrusters", "0 0.3 0; 0 -0.3 0")
    assert (
        "--thrusters: the commands are F_u and F_r. Places are used with sticks of surge, sway and yaw"
        in said
    )


def test_two_sources_of_one_command_are_to_be_checked(tmp_path, propose):
    """Sticks while the pilot drives, the autopilot's outputs else, each 0 in the other's time, in percent."""
    mix = np.array([[0.5, 0.5], [0.0, 0.0], [-0.5, 0.5]])  # left, right
    log = drive(240.0, sticks=lambda t, seed: thrust(t)[:, :2] @ mix.T)
    both, manual = 100.0 * thrust(log.command_t)[:, :2], (log.command_t // 20 % 2 == 0)[:, None]
    log = log.but(command=np.hstack([both * manual, both * ~manual]))
    head = "t,rc_left,rc_right,auto_left,auto_right"
    vehicle, text = propose(tables(log, tmp_path / "cat", commands=head))
    shares = dict.fromkeys(head.split(",")[1:], 0.25)
    assert vehicle.file.forces["F_u"].of == pytest.approx(shares, abs=0.03)
    for one, other in (("rc_left", "auto_left"), ("auto_right", "rc_right")):
        assert re.search(f"{one}: .*check: acts as {other} does, never at the same time", text)


def test_of_a_pilot_and_an_autopilot_the_one_that_moves_the_boat_is_proposed(tmp_path, propose):
    """The autopilot drives for three minutes, the pilot, whose sticks are never quite still, for one."""
    mix = np.array([[0.5, 0.5], [0.0, 0.0], [-0.5, 0.5]])  # left, right
    log = drive(240.0, sticks=lambda t, seed: thrust(t)[:, :2] @ mix.T)
    driven, idle = thrust(log.command_t)[:, :2], 0.3 * thrust(log.command_t + 100.0)[:, 2:]
    auto = log.command_t[:, None] < 180.0
    rows = np.hstack([np.where(auto, idle, driven), np.where(auto, driven, 0.0), auto])
    head = "t,cmd_manual_left,cmd_manual_right,cmd_auto_left,cmd_auto_right,mode"
    path = tables(log.but(command=rows), tmp_path / "cat", commands=head)
    vehicle, text = propose(path)
    assert vehicle.inputs == ("cmd_auto_left", "cmd_auto_right")
    assert vehicle.file.forces["F_u"].of == dict.fromkeys(vehicle.inputs, 0.5)
    assert "check: cmd_manual_left and cmd_manual_right command the same actuators" in text
    assert "--commands cmd_manual_left,cmd_manual_right" in text
    assert "mode: says which source drives, and when?" in text
    # the autopilot's outputs are what the pilot commands: either will do, and both at once are none
    twice = log.but(command=np.hstack([driven, driven]))
    path = tables(twice, tmp_path / "copy", commands=head.removesuffix(",mode"))
    vehicle, text = propose(path)
    assert vehicle.inputs == ("cmd_manual_left", "cmd_manual_right")
    chosen = re.search(r"--commands (\S+)", text)[1]
    other, _ = propose(path.rename(tmp_path / "auto"), "--commands", chosen)
    assert other.inputs == ("cmd_auto_left", "cmd_auto_right")


def test_a_single_thruster_at_the_bow_is_a_force(tmp_path, propose):
    """It pushes sideways and turns at once, and nothing else pushes sideways: that is no lever."""
    mix = np.array([[0.5, 0.5, 0.0], [0.0, 0.0, 1.0], [-0.4, 0.4, 0.8]])  # left, right, bow
    log = drive(120.0, sticks=lambda t, seed: thrust(t)[:, :3] @ mix.T)
    log = log.but(command=thrust(log.command_t)[:, :3])
    vehicle, _ = propose(tables(log, tmp_path / "bow", commands="t,left,right,bow"))
    assert vehicle.lever == (0.0, 0.0)
    assert set(vehicle.file.forces["F_v"].of) == {"bow"}
    assert vehicle.file.forces["F_r"].of == pytest.approx(
        {"left": -0.25, "right": 0.25, "bow": 0.5}, abs=0.03
    )


@pytest.mark.parametrize(
    ("helm", "named"), [("rudder_deg", True), ("steering", True), ("servo2", False)]
)
def test_a_rudder_is_no_stick_of_yaw(helm, named, tmp_path, propose):
    """Its moment grows with thrust and speed: it is an angle; of a name that says nothing, as a comment."""
    recording = steered_boat.driven(steered_boat.known(), seed=1)
    log = tmp_path / "boat"
    log.mkdir()
    vehicle, text = propose(two_sheets(log, recording, "throttle", helm))
    (entry,) = re.findall(r"^(#? *)- .*steered: \{of: \[\[throttle, (\w+)\]\]", text, re.MULTILINE)
    assert entry == ("  " if named else "#   ", helm)
    if named:
        assert vehicle.inputs == ("throttle", helm)
        assert vehicle.file.forces["F_v"].of == {helm: 1.0}
        return
    line = next(line for line in text.splitlines() if f"column: {helm}" in line)
    question = "check: turns the boat only with the thrust of throttle: is it the angle of a rudder"
    assert question in line
    assert text.count("Then write 'steered'") == 1
