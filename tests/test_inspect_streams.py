# SPDX-License-Identifier: MIT
"""Inspect on clocks, stamps, gaps and holes of streams."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from inspect_tools import GOOD, fault, said, stream
from logs import EPOCH, JOY, POSE, drive, nanoseconds

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.inspection.console import inspection_text
from seatrial.io.bags.write import write_bag
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal

# Clocks. #


@pytest.mark.parametrize("ahead", [0.02, 0.1, 5.0, 40.0])
def test_a_joypad_ahead_of_the_recorder(inspected, ahead):
    log = drive()
    text, found = inspected(log.but(command_t=log.command_t + ahead))
    late = log.command_arrival - log.command_t - ahead
    assert stream(found, JOY)["delay"]["least"] == pytest.approx(late.min(), abs=1e-6)
    assert stream(found, JOY)["delay"]["most"] == pytest.approx(late.max(), abs=1e-6)
    shown = f"{-late.min():.6g} s" if ahead > 10 else f"{-1e3 * late.min():.0f} ms"
    (verdict,) = [v for v in found["verdicts"] if JOY in v]
    assert verdict.startswith(f"/joy: stamps are up to {shown} ahead of the recorder's clock")
    assert verdict in said(text)
    assert "after arrival" in text


@pytest.mark.parametrize(("behind", "late"), [(0.1, False), (0.6, True), (20.0, True)])
def test_a_joypad_behind_the_recorder(inspected, behind, late):
    log = drive()
    text, found = inspected(log.but(command_t=log.command_t - behind))
    least = (log.command_arrival - log.command_t).min() + behind
    apart = least - (log.pose_arrival - log.pose_t).min()
    assert stream(found, JOY)["delay"]["least"] == pytest.approx(least, abs=1e-6)
    shown = f"{least:.6g} s" if behind > 10 else f"{1e3 * least:.0f} ms"
    expected = (
        f"/joy: every message arrives {shown} or more after its stamp"
        if late
        else f"stamps of /joy are {1e3 * apart:.0f} ms further behind their arrival than those of {POSE}"
    )
    (verdict,) = [v for v in found["verdicts"] if JOY in v]
    assert verdict.startswith(expected)
    assert verdict in said(text)


@pytest.mark.parametrize("jump", [-0.4, 0.4])
@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_clock_that_is_set_while_it_records(look, tmp_path, jump, kind):
    """Forward: the stamps come later than the messages. --start counts from the first pose."""
    log = drive()
    late = 5.0  # [s] the poses begin after the sticks
    stamps = log.command_t + np.where(log.command_t >= 60.0, jump, 0.0)
    poses = log.pose_t >= late
    log = log.but(
        command_t=stamps, pose_t=log.pose_t[poses], pose=log.pose[poses],
        pose_arrival=log.pose_arrival[poses],
    )  # fmt: skip
    text, found = look(log.write(tmp_path / f"log.{kind}"), vehicle="mallard-mp")
    (recording,) = found["recordings"]
    delay = stream(recording, JOY)["delay"]
    assert delay["step"] == pytest.approx(-jump, abs=0.001)
    assert delay["step_at"] == pytest.approx(60.0, abs=0.03)
    assert delay["drift"] == 0.0
    way = "ahead" if jump > 0 else "back"
    at = 60.0 - poses.argmax() / 15 - 0.02
    verdict = f"/joy: its clock jumps {way} by 400 ms against the recorder's at {at:.1f} s"
    assert any(v.startswith(verdict) for v in recording["verdicts"])
    assert f"=> {verdict}" in text
    assert f"--end {at:.1f}" in text
    backward = 0 if jump > 0 else 1
    assert stream(recording, JOY)["backward"] == backward
    assert any("stamps go back in time once" in v for v in recording["verdicts"]) == bool(backward)


def test_the_place_of_a_step_is_counted_from_the_start_of_the_whole_recording(inspected):
    log = drive()
    log = log.but(command_t=log.command_t + np.where(log.command_t >= 60.0, 0.4, 0.0))
    text, _ = inspected(log, more=("--start", "20", "--end", "80"))
    assert "at 60.0 s: use the part before (--end 60.0)" in text
    assert "log: 59.9 s" in text


def test_a_recorder_that_is_set_is_told_from_a_robot_that_is(inspected):
    log = drive()
    later = [t + np.where(t >= 50.0, 2.0, 0.0) for t in (log.pose_arrival, log.command_arrival)]
    _, found = inspected(log.but(pose_arrival=later[0], command_arrival=later[1]))
    (verdict,) = [v for v in found["verdicts"] if "clock" in v]
    assert verdict.startswith(
        "all stamps jump back by 2000 ms against the recorder's clock at 49.9 s"
    )


@pytest.mark.parametrize("drift", [-0.1, 0.1])
def test_a_clock_that_drifts(inspected, drift):
    log = drive()
    text, found = inspected(log.but(command_t=log.command_t * (1 + drift / 90.0)))
    delay = stream(found, JOY)["delay"]
    assert delay["step"] == 0.0
    assert delay["drift"] == pytest.approx(-0.9 * drift, abs=0.002)
    word = "gains" if drift > 0 else "loses"
    shown = re.search(rf"/joy: its clock {word} (\d+) ms against the recorder's", text)
    assert int(shown[1]) == pytest.approx(90, abs=2)
    assert any(shown[0] in v for v in found["verdicts"])


@pytest.mark.parametrize("which", ["pose", "command"])
def test_headers_without_a_time(inspected, which):
    log = drive()
    zero = np.zeros(len(getattr(log, f"{which}_t"))) - EPOCH * 1e-9
    text, found = inspected(log.but(**{f"{which}_t": zero}))
    source = POSE if which == "pose" else JOY
    assert stream(found, source)["clock"] == "arrival in the bag, as its headers hold no time"
    assert stream(found, source)["delay"] is None
    verdict = f"{source}: header stamps are all 0, so arrival times in the bag are used"
    assert any(v.startswith(verdict) for v in found["verdicts"])
    assert f"=> {verdict}" in text


def test_commands_without_a_header(inspected, tmp_path):
    content = seatrial.load_vehicle("mallard-mp").to_mapping()
    for name, at in (("F_u", 1), ("F_v", 0), ("F_r", 3)):
        content["commands"]["inputs"][name] = {"column": name, "field": f"data[{at}]"}
    (tmp_path / "v.yaml").write_text(json.dumps(content))
    log = drive()
    array = "std_msgs/msg/Float64MultiArray"
    text, found = inspected(log, tmp_path / "v.yaml", joy_type=array)
    assert stream(found, JOY)["clock"] == "arrival in the bag"
    assert "/joy (std_msgs/Float64MultiArray) is stamped by its arrival in the bag" in text
    assert not any("off by" in v for v in found["verdicts"])
    old = log.but(pose_t=log.pose_t - 0.2)
    text, found = inspected(old, tmp_path / "v.yaml", joy_type=array)
    least = 1e3 * (old.pose_arrival - old.pose_t).min()
    assert (
        f"{POSE} is stamped {least:.0f} ms or more before its arrival, but /joy has arrival times only"
        in text
    )


@pytest.mark.parametrize("kind", ["Twist", "Joy"])
def test_commands_that_may_be_velocities_of_a_controller(kind, tmp_path):
    """Set points of a controller give drag and thrust of boat and controller, with narrow intervals."""
    log, content = drive(), seatrial.load_vehicle("mallard-mp").to_mapping()
    pose, joy = log.topics()
    if kind == "Twist":
        columns = dict(zip(("linear.x", "linear.y", "angular.z"), log.command.T, strict=True))
        joy = replace(joy, type_name="geometry_msgs/msg/Twist", columns=columns)
        for name, field in zip(("F_u", "F_v", "F_r"), columns, strict=True):
            content["commands"]["inputs"][name] = {"column": name, "field": field}
    vehicle = vehicle_from(content, "v.yaml")
    recording = seatrial.read(write_bag(tmp_path / "run.bag", [pose, joy]), vehicle)
    found = seatrial.inspect([recording], vehicle).recordings[0].verdicts
    assert sum("that a controller holds" in text for text in found) == (kind == "Twist")


def test_clocks_of_commands_can_be_chosen(inspected, tmp_path):
    content = seatrial.load_vehicle("mallard-mp").to_mapping()
    content["commands"]["clock"] = "bag"
    (tmp_path / "v.yaml").write_text(json.dumps(content))
    log = drive()
    _, found = inspected(log.but(command_t=log.command_t + 7.0), tmp_path / "v.yaml")
    assert stream(found, JOY)["clock"] == "arrival in the bag"
    assert not any("ahead" in v for v in found["verdicts"])


# Stamps, gaps and poses. #


def test_duplicated_and_backward_stamps(inspected):
    log = drive()
    t = log.pose_t.copy()
    same, back = np.arange(100, 700, 20), np.arange(801, 1301, 100)
    t[same] = t[same - 1]
    t[back] -= 0.1
    text, found = inspected(log.but(pose_t=t))
    seen = stream(found, POSE)
    assert (seen["duplicated"], seen["backward"]) == (30, 5)
    assert ", 30 duplicate stamps, 5 stamps out of order" in text
    assert found["usable"] == pytest.approx(1 - 35 / 1350)
    assert f"{100 * (1 - 35 / 1350):.1f} % of the poses usable" in text
    assert fault(found, "stamp out of order")["count"] == 35
    assert any("30 of 1350 stamps equal that of the message before" in v for v in found["verdicts"])
    assert any("stamps go back in time 5 times" in v for v in found["verdicts"])


def test_frozen_poses(inspected):
    log = drive()
    pose = log.pose.copy()
    pose[400:412] = pose[399]
    pose[900:904] = pose[899]
    text, found = inspected(log.but(pose=pose))
    seen = fault(found, "frozen")
    assert seen["count"] == 2
    assert seen["longest"] == pytest.approx(11 / 15)
    assert seen["longest_at"] == pytest.approx(400 / 15)
    assert f"2 x frozen while the boat moved: left out; longest 0.73 s, at {400 / 15:.1f} s" in text


def test_jumps(inspected):
    log = drive()
    pose = log.pose.copy()
    pose[300:303, 0] += 0.5
    pose[700:702, 1] -= 0.4
    pose[1000:, 0] += 0.6
    text, found = inspected(log.but(pose=pose))
    assert fault(found, "jumped away and back")["count"] == 2
    assert fault(found, "jumped away and back")["longest"] == pytest.approx(2 / 15)
    assert fault(found, "jumped for good")["longest_at"] == pytest.approx(1000 / 15)
    assert "2 x jumped away and back: left out; longest 0.13 s, at 20.0 s" in text
    assert "1 x jumped for good: not bridged; at 66.7 s" in text


def test_gaps_and_uneven_stamps(inspected):
    log = drive()
    keep = np.ones(1350, dtype=bool)
    keep[200:230] = keep[600:660] = False
    t = log.pose_t + np.random.default_rng(8).uniform(-0.01, 0.01, 1350)
    text, found = inspected(
        log.but(pose_t=t[keep], pose_arrival=log.pose_arrival[keep], pose=log.pose[keep])
    )
    seen = fault(found, "no poses")
    assert seen["count"] == 2
    assert seen["longest"] == pytest.approx(t[660] - t[599], abs=1e-6)
    assert stream(found, POSE)["longest"] == pytest.approx(t[660] - t[599], abs=1e-6)
    assert "longest gap 4.07 s" in text or "longest gap 4.06 s" in text
    steps = np.diff(t[keep])
    expected = np.std(steps[steps < 0.09])
    assert found["jitter"] == pytest.approx(expected, rel=1e-3)
    assert stream(found, POSE)["jitter"] == pytest.approx(expected, rel=1e-3)
    assert f"stamps have {1e3 * expected:.1f} ms of jitter" in text
    assert f"jitter {1e3 * expected:.2f} ms" in text


def test_poses_or_commands_that_are_not_numbers(inspected):
    log = drive()
    pose, command = log.pose.copy(), log.command.copy()
    pose[100:106, 1] = np.inf
    pose[300, 2] = np.nan
    command[2000:2100, 0] = np.nan
    text, found = inspected(log.but(pose=pose, command=command))
    (seen,) = [f for f in found["faults"] if f["kind"] == "not a number: left out"]
    assert seen["count"] == 2
    muted = fault(found, "command not a number")
    assert muted["longest"] == pytest.approx(2.0)
    assert muted["longest_at"] == pytest.approx(40.0)
    assert "1 x command not a number: left out; longest 2.00 s, at 40.0 s" in text
    assert found["usable"] == pytest.approx((1350 - 7 - 30) / 1350)


@pytest.mark.parametrize("which", ["start", "middle", "end"])
def test_a_hole_in_a_rhythm_of_commands(inspected, which):
    log = drive()
    begin, end = {"start": (0.0, 9.0), "middle": (30.0, 37.0), "end": (82.0, 91.0)}[which]
    kept = (log.command_t < begin) | (log.command_t >= end)
    text, found = inspected(
        log.but(
            command_t=log.command_t[kept], command=log.command[kept],
            command_arrival=log.command_arrival[kept],
        )
    )  # fmt: skip
    seen = fault(found, "no commands")
    length = min(end, 89.93) - begin
    assert seen["longest"] == pytest.approx(length, abs=0.04)
    assert f"no commands: left out; longest {seen['longest']:.2f} s" in text
    assert found["usable"] == pytest.approx(1 - length / 89.93, abs=0.002)


# Sticks. #


def changes_only(log):
    """What a joypad sends that speaks only when a stick has moved, in steps of 1/127."""
    command = np.round(log.command * 127) / 127
    kept = np.concatenate([[True], np.any(np.diff(command, axis=0) != 0, axis=1)])
    return log.but(
        command=command[kept], command_t=log.command_t[kept],
        command_arrival=log.command_arrival[kept],
    )  # fmt: skip


def pressed(t, seed=0):
    """Sticks that rest for a second or two between short pushes."""
    rng = np.random.default_rng(seed + 10)
    sticks = np.zeros((len(t), 3))
    for axis in range(3):
        at = 1.0 + axis
        while at < t[-1]:
            length, size = rng.uniform(0.8, 2.0), rng.choice([-1, 1]) * rng.uniform(0.3, 1.0)
            inside = (t >= at) & (t < at + length)
            sticks[inside, axis] = size * np.sin(np.pi * (t[inside] - at) / length)
            at += length + rng.uniform(2.0, 5.0)
    return sticks


def test_a_joypad_that_speaks_only_when_it_is_moved_has_no_drop_outs(inspected, tmp_path):
    log = changes_only(drive(sticks=pressed))
    assert np.diff(log.command_t).max() > 1.0
    text, found = inspected(log)
    assert stream(found, JOY)["on_change"]
    assert "50 Hz while it changes" in text
    assert found["faults"] == []
    assert found["verdicts"] == [GOOD]
    content = seatrial.load_vehicle("mallard-mp").to_mapping() | {"command_timeout": 0.5}
    (tmp_path / "v.yaml").write_text(json.dumps(content))
    _, found = inspected(log, tmp_path / "v.yaml")
    assert found["faults"] == []  # let go each time: nothing is in force then, timeout or not
    held = replace(log, command=log.command + 0.05)
    _, found = inspected(held, tmp_path / "v.yaml")
    steps = np.diff(log.command_t)
    long = steps[steps > 0.5]
    seen = fault(found, "no commands")
    assert seen["count"] == pytest.approx(len(long), abs=1)  # and after the last
    assert seen["longest"] == pytest.approx(long.max() - 0.5, abs=1e-6)


def test_a_timeout_below_the_rhythm_of_the_commands_is_named():
    log = drive()
    mallard = seatrial.load_vehicle("mallard-mp").to_mapping()
    vehicle = vehicle_from({**mallard, "command_timeout": 0.001}, "v.yaml")
    commands = Signal(vehicle.inputs, nanoseconds(log.command_t), log.command)
    record = make_recording("r", nanoseconds(log.pose_t), log.pose, commands, timeout=0.001)
    text = inspection_text(seatrial.inspect([record], vehicle))
    assert "command_timeout is shorter than the period of the commands" in text
    assert "units, signs and order are not checked" in text
    assert "consistent with" not in text


def test_a_bag_that_was_played_back_and_recorded_again_is_called_that(inspected):
    log = drive()
    again = log.but(pose_arrival=log.pose_t / 5 + 1e5, command_arrival=log.command_t / 5 + 1e5)
    text, found = inspected(again)
    assert (
        sum(
            "simulated time (use_sim_time), or the log was played back and recorded again" in v
            for v in found["verdicts"]
        )
        == 2
    )
    assert "chrony" not in text
    assert "slow source" not in text
