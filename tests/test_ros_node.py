# SPDX-License-Identifier: MIT
"""The node without ROS: what it makes of messages, by scripts of events, beside Python's odometer."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from board_boats import changed, skiff
from conftest import ROOT, TABLE_II, make_model
from cpp_tools import built, fed

import seatrial
from seatrial.boat.schema import EnvelopeEntry, NoiseEntry
from seatrial.boat.vehicle import vehicle_from
from seatrial.onboard.odometer import Odometer

pytestmark = pytest.mark.system
SECOND = 10**9  # [ns]
EPOCH = 1_700_000_000 * SECOND


@pytest.fixture(scope="module")
def program() -> Path:
    return built("script")


@pytest.fixture
def model(mp, tmp_path):
    model = replace(
        make_model(mp, TABLE_II["MP"], step=1 / 60),
        noise=NoiseEntry(0.004, 0.004),
        envelope=EnvelopeEntry({"u": (-0.3, 0.3), "v": (-0.3, 0.3), "r": (-2.0, 2.0)}, {}),
    )
    seatrial.save(model, tmp_path / "model.yaml")
    return model, tmp_path / "model.yaml"


def play(program, events, **settings) -> list[list[str]]:
    done = fed(program, events, **settings)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return [line.split() for line in done.stdout.splitlines()]


def numbers(row: list[str]) -> np.ndarray:
    return np.array([float.fromhex(x) for x in row[1:13]])


def of(out) -> np.ndarray:
    return np.concatenate([out.pose, out.motion.velocity, out.motion.pose, out.map_to_odom])


def joy(t: int, *axes: float) -> str:
    return f"{t} numbers sensor_msgs/Joy /joy {t} {' '.join(map(str, axes))} | 0 0"


def drive(seed: int) -> list[tuple[int, str, np.ndarray]]:
    """Arrival, what, numbers: sticks at 50 Hz, late poses at 15 Hz, ticks at 20 Hz."""
    random = np.random.default_rng(seed)
    found = []
    stick = np.zeros(3)
    for k in range(500):
        if k % 40 == 0:
            stick = random.uniform(-0.8, 0.8, 3).astype(np.float32).astype(float)
        found.append((EPOCH + k * 20_000_000, "command", stick))
    for k in range(150):
        eta = 0.002 * random.standard_normal(3) + [0.001 * k, 0.0, 0.002 * k]
        found.append((EPOCH + k * 66_666_667 + 30_000_000, "pose", eta))
    found += [(EPOCH + k * 50_000_000 + 1, "tick", np.zeros(0)) for k in range(200)]
    return sorted(found, key=lambda one: one[0])


def test_it_says_what_pythons_odometer_says(program, model):
    known, path = model
    odometer, expected, events = Odometer(known), [], []
    for t, kind, row in drive(3):
        if kind == "command":
            events.append(joy(t, row[1], row[0], 0.0, row[2]))
            odometer.command(t, row)
        elif kind == "pose":
            late = t - 30_000_000
            events.append(f"{t} pose {late} map {' '.join(map(repr, row.tolist()))}")
            odometer.pose(late, row)
        else:
            events.append(f"{t} tick")
            expected.append(odometer.at(t))
    rows = play(program, events, model=path)
    got = [row for row in rows if row[0].isdigit()]
    assert len(got) == len(expected)
    for row, out in zip(got, expected, strict=True):
        assert int(row[0]) == out.stamp
        assert (row[1] != "unknown") == out.known
        if out.known:
            np.testing.assert_allclose(numbers(row), of(out), rtol=1e-9, atol=1e-12)
            assert int(row[13]) == out.motion.health.value
    assert rows[len(got)][:2] == ["diagnosis", "0"]
    assert ["poses", "used:", "150"] in rows


def test_every_kind_of_message_drives_the_same_way(program, model, tmp_path):
    known, _ = model
    kinds = {
        "geometry_msgs/msg/Wrench": (("force.x", "force.y", "torque.z"), "{0} {1} 0 0 0 {2}"),
        "geometry_msgs/WrenchStamped": (
            ("wrench.force.x", "wrench.force.y", "wrench.torque.z"), "{0} {1} 0 0 0 {2}"),
        "geometry_msgs/msg/Twist": (("linear.x", "linear.y", "angular.z"), "{0} {1} 0 0 0 {2}"),
        "geometry_msgs/TwistStamped": (
            ("twist.linear.x", "twist.linear.y", "twist.angular.z"), "{0} {1} 0 0 0 {2}"),
        "std_msgs/msg/Float64MultiArray": (("data[0]", "data[1]", "data[2]"), "{0} {1} {2}"),
        "std_msgs/Float32MultiArray": (("data[2]", "data[1]", "data[0]"), "{2} {1} {0}"),
        "sensor_msgs/msg/JointState": (
            ("effort[0]", "effort[1]", "velocity[0]"), "9 9 9 | {2} | {0} {1}"),
        "sensor_msgs/Joy": (("axes[1]", "axes[0]", "buttons[1]"), "{1} {0} | 0 {2}"),
    }  # fmt: skip
    answers = []
    for kind, (fields, words) in kinds.items():
        inputs = dict(zip(("F_u", "F_v", "F_r"), fields, strict=True))
        vehicle = changed(known.vehicle, commands={"topic": "/cmd", "inputs": inputs})
        path = tmp_path / "kind.yaml"
        seatrial.save(replace(known, vehicle=vehicle), path)
        events = [f"{EPOCH} pose {EPOCH} map 0 0 0"]
        for k in range(1, 100):
            t = EPOCH + k * 20_000_000
            values = words.format(0.5, -0.25, 1 if k > 50 else 0)
            events.append(f"{t} numbers {kind} /cmd {t} {values}")
        events.append(f"{EPOCH + 2_000_000_000} tick")
        answers.append(numbers(play(program, events, model=path)[0]))
    assert abs(answers[0][3]) > 0.01
    for answer in answers[1:]:
        np.testing.assert_array_equal(answer, answers[0])


def test_commands_of_several_topics_count_once_all_have_come(program, tmp_path):
    vehicle = skiff()
    values = {
        n: -0.4 if n[0] in "XYN" and "F" not in n else 0.2 for n in vehicle.structure.coefficients
    }
    model = replace(make_model(vehicle, values, step=1 / 60), noise=NoiseEntry(0.01, 0.01))
    seatrial.save(model, tmp_path / "m.yaml")
    first = f"{EPOCH} numbers std_msgs/Float64MultiArray /rc - 0 0 1700"
    with pytest.raises(
        RuntimeError,
        match=r"/rc \(std_msgs/Float64MultiArray\) has no field 'channels\[2\]' for port",
    ):
        play(program, [first], model=tmp_path / "m.yaml")


def test_a_header_without_a_stamp_is_stamped_on_arrival(program, model):
    _, path = model
    stamped = [joy(EPOCH, 0, 0, 0, 0), f"{EPOCH} pose {EPOCH} map 1 2 0.5", f"{EPOCH + 10**8} tick"]
    bare = [
        line.replace(f" /joy {EPOCH} ", " /joy - ").replace(f"pose {EPOCH}", "pose -")
        for line in stamped
    ]
    assert bare != stamped
    assert play(program, bare, model=path) == play(program, stamped, model=path)


def test_poses_of_other_frames_are_not_used(program, model, tmp_path):
    known, _ = model
    pose = {**known.vehicle.to_mapping()["pose"], "parent": "world"}
    seatrial.save(replace(known, vehicle=changed(known.vehicle, pose=pose)), tmp_path / "m.yaml")
    events = [f"{EPOCH} pose {EPOCH} {{}} 1 2 0.5", f"{EPOCH + 1} tick"]
    other = play(program, [e.format("odom") for e in events], model=tmp_path / "m.yaml")
    own = play(program, [e.format("world") for e in events], model=tmp_path / "m.yaml")
    assert other[0][1] == "unknown"
    np.testing.assert_allclose(numbers(own[0])[6:9], [1, 2, 0.5])
    assert other[1][:2] == ["diagnosis", "2"]


def test_silence_is_handled_as_the_vehicle_says(program, model, tmp_path):
    known, _ = model
    quiet = changed(known.vehicle, command_timeout=0.5)
    seatrial.save(replace(known, vehicle=quiet), tmp_path / "m.yaml")
    events = [f"{EPOCH} pose {EPOCH} map 0 0 0", joy(EPOCH, 0, 0.8, 0, 0)]
    ticks = [f"{EPOCH + k * 10**8} tick" for k in (4, 30)]
    holds = play(program, events + ticks, model=model[1])
    stops = play(program, events + ticks, model=tmp_path / "m.yaml")
    assert numbers(holds[0])[3] == numbers(stops[0])[3] > 0.0
    assert numbers(stops[1])[3] < numbers(holds[1])[3]
    assert int(stops[1][13]) & 16
    assert not int(holds[1][13]) & 16


def lines_of(steps, late=0) -> list[str]:
    events = []
    for t, kind, row in steps:
        if kind == "command":
            events.append(joy(t, row[1], row[0], 0.0, row[2]))
        elif kind == "pose":
            events.append(f"{t} pose {t - late} map {' '.join(map(repr, row.tolist()))}")
        else:
            events.append(f"{t} tick")
    return events


MISTAKES = [
    ({}, "parameter model is empty"),
    ({"rate": "900"}, "rate is 900"),
    ({"window": "0"}, "window is 0; expected 0.05 to 5: how late"),
    ({"current_x": "9"}, "current_x is 9"),
    ({"speed": "1"}, "no parameter speed"),
]


@pytest.mark.parametrize(("settings", "words"), MISTAKES)
def test_a_parameter_that_can_not_be_used_is_said(program, model, settings, words):
    given = {} if words.startswith("parameter model") else {"model": model[1]}
    with pytest.raises(RuntimeError, match=words) as caught:
        play(program, [], **given, **settings)
    assert str(caught.value).count("\n") == 1


def test_a_vehicle_without_topics_is_said(program, model, tmp_path):
    known, _ = model
    mapping = known.vehicle.to_mapping()
    del mapping["commands"]["topic"]
    seatrial.save(replace(known, vehicle=vehicle_from(mapping, "bare")), tmp_path / "m.yaml")
    with pytest.raises(
        RuntimeError, match="names no topic for F_u; write it into the vehicle file"
    ):
        play(program, [], model=tmp_path / "m.yaml")
    assert play(program, [], model=tmp_path / "m.yaml", command_topic="/joy")
    del mapping["pose"]["topic"]
    seatrial.save(replace(known, vehicle=vehicle_from(mapping, "bare")), tmp_path / "m.yaml")
    with pytest.raises(RuntimeError, match="pose_topic"):
        play(program, [], model=tmp_path / "m.yaml", command_topic="/joy")


def test_the_parameters_stand_in_the_document():
    text = (ROOT / "ros/common/include/seatrial_ros/settings.hpp").read_text()
    names = [part.split('"')[1] for part in text.split("Parameter{")[1:]]
    assert len(names) == 16
    page = (ROOT / "docs" / "ros.md").read_text()
    for name in names:
        assert f"`{name}`" in page, name


TENTHS = range(EPOCH, EPOCH + 6 * SECOND, SECOND // 10)  # [ns]


def at_rest(late=0):
    """A pose for each command, that much older [ns]."""
    return [
        event
        for t in TENTHS[:30]
        for event in (joy(t, 0, 0.5, 0, 0), f"{t} pose {t - late} map 0 0 0", f"{t} tick")
    ]


def test_inputs_stamped_ahead_of_the_clock_stop_the_odometry(program, model):
    """Within the window it is that of the clock's time; beyond it the filter has no state so old."""
    events = []
    for k, t in enumerate(TENTHS):
        ahead = t + (3 * SECOND // 10 if k < 30 else 2 * SECOND)
        events += [joy(ahead, 0, 0.5, 0, 0).replace(f"{ahead} numbers", f"{t} numbers"),
                   f"{t} pose {ahead} map 0 0 0", f"{t} tick"]  # fmt: skip
    rows = play(program, events, model=model[1])
    known = [row[1] != "unknown" for row in rows if row[0].isdigit()]
    assert all(known[5:30])
    assert not any(known[30:])
    diagnosis = rows[60]
    assert diagnosis[:2] == ["diagnosis", "2"]
    text = " ".join(diagnosis)
    assert "the newest input is stamped 2 s ahead of this node's clock" in text
    assert "the parameter window allows 0.5 s" in text


@pytest.mark.parametrize("rate", [50, 0])
def test_inputs_that_have_stopped_are_diagnosed_without_a_tick(program, model, rate):
    """With rate: 0 there is none after the last command."""
    told = []
    for later in (0, 7):
        asked = f"{TENTHS[29] + later * SECOND} diagnose"
        rows = play(program, [*at_rest(), asked], model=model[1], rate=rate)
        told.append("\n".join(" ".join(row) for row in rows[30:]))
    silent = "no odometry: it follows each command (rate: 0), and none has come for 7 s"
    assert told[0].startswith("diagnosis 0 odometry by the model and poses")
    assert "age of the last pose used [s]: 0.000000" in told[0]
    assert told[1].startswith("diagnosis 1 no recent pose: dead reckoning")
    assert (silent in told[1]) == (rate == 0)
    assert "age of the last pose used [s]: 7.000000" in told[1]


def test_poses_that_come_too_late_are_told_by_how_much(program, model):
    events = at_rest(late=7 * SECOND // 10)
    text = [" ".join(row) for row in play(program, events, model=model[1])]
    told = next(row for row in text if row.startswith("diagnosis"))
    assert told.startswith("diagnosis 2 a pose is not used: its stamp is 0.7 s before the newest")
    assert "the parameter window allows 0.5 s. Raise window" in told
    assert "no pose received yet" not in told
    wide = [" ".join(row) for row in play(program, events, model=model[1], window=1)]
    assert "  poses used: 30".strip() in [row.strip() for row in wide]
