# SPDX-License-Identifier: MIT
"""What `seatrial inspect` says of recordings into which defects were put, in words and in numbers."""

import json
import math
import re

import msgspec
import numpy as np
import pytest
from logs import EPOCH, JOY, POSE, drive, nanoseconds, wave
from test_model import frd

import seatrial
from seatrial.cli import main
from seatrial.inspect.coverage import input_use
from seatrial.inspect.text import inspection_text
from seatrial.io.write_bag import BagTopic, write_bag
from seatrial.recording import Signal, make_recording
from seatrial.vehicle import vehicle_from

GOOD = "good for identification"


@pytest.fixture
def look(tmp_path, capsys):
    """Inspect by the command line: what is shown, and the JSON beside."""

    def run(*recordings, vehicle=None, more=()):
        out = tmp_path / "inspect.json"
        extra = [] if vehicle is None else ["--vehicle", str(vehicle)]
        code = main(["inspect", *map(str, recordings), *extra, *more, "--json", str(out)])
        shown = capsys.readouterr()
        assert (code, shown.err) == (0, "")
        return shown.out, json.loads(out.read_text(), parse_constant=pytest.fail)

    return run


@pytest.fixture
def inspected(look, tmp_path):
    """Write a log, inspect it with the mallard's file: the text, and the only recording's JSON."""

    def run(log, vehicle="mallard-mp", more=(), **types):
        text, found = look(log.write(tmp_path / "log.bag", **types), vehicle=vehicle, more=more)
        (recording,) = found["recordings"]
        return text, recording

    return run


def stream(recording, source):
    (found,) = [s for s in recording["streams"] if s["source"] == source]
    return found


def fault(recording, word):
    (found,) = [f for f in recording["faults"] if word in f["kind"]]
    return found


def said(text):
    """The verdicts."""
    return [line.strip()[3:] for line in text.splitlines() if line.startswith("  => ")]


# Nothing wrong. #


def test_a_good_recording_is_called_good_and_nothing_else(inspected):
    log = drive()
    text, found = inspected(log)
    assert found["verdicts"] == [GOOD]
    assert said(text) == [GOOD, "nothing against the vehicle file's units, signs and order"]
    assert "fault " not in text
    assert found["faults"] == []
    assert found["poses"] == len(log.pose_t)
    assert found["duration"] == pytest.approx(log.pose_t[-1])
    assert found["rate"] == pytest.approx(15.0)
    assert found["usable"] == 1.0
    assert found["noise"]["position"] == pytest.approx(0.0007, rel=0.1)
    assert found["noise"]["heading"] == pytest.approx(0.003, rel=0.1)
    for source, rate, late in (
        (POSE, 15.0, log.pose_arrival - log.pose_t), (JOY, 50.0, log.command_arrival - log.command_t)
    ):  # fmt: skip
        seen = stream(found, source)
        assert seen["rate"] == pytest.approx(rate)
        assert (seen["duplicated"], seen["backward"], seen["on_change"]) == (0, 0, False)
        assert seen["delay"]["least"] == pytest.approx(late.min(), abs=1e-6)
        assert seen["delay"]["median"] == pytest.approx(np.median(late), abs=1e-6)
        assert seen["delay"]["most"] == pytest.approx(late.max(), abs=1e-6)
        assert f"{1e3 * late.min():.0f} to {1e3 * late.max():.0f} ms before arrival" in text
        assert f"{source} (" in text
    assert "1350 at 15 Hz, longest gap 0.0667 s" in text
    assert "4500 at 50 Hz, longest gap 0.02 s" in text


def test_trials_in_the_clean_plan_have_no_complaints_but_what_is_true(clean_af, af):
    """One axis alone in S1 to S6."""
    found = seatrial.inspect([t.recording for t in clean_af.values()], af)
    axes = ["surge", "sway", "yaw"]
    for view, axis in zip(found.recordings, [*axes, *axes, None], strict=True):
        if axis is not None:
            assert view.verdicts == (f"drives {axis} nearly alone: identifies that axis",)
        else:
            assert view.verdicts == (GOOD,)
        assert view.faults == ()
    assert found.signs.findings == ()


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
    verdict = f"{source}: header stamps are all 0, so the bag's times of arrival are used"
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
    assert f"{POSE} is stamped {least:.0f} ms before its arrival or more, but of /joy only" in text


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
    assert ", 30 twice, 5 backward" in text
    assert found["usable"] == pytest.approx(1 - 35 / 1350)
    assert f"{100 * (1 - 35 / 1350):.1f} % of the poses usable" in text
    assert fault(found, "stamp out of order")["count"] == 35
    assert any("30 of 1350 stamps are those of the message before" in v for v in found["verdicts"])
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
    assert f"stamps are off an even rhythm by {1e3 * expected:.1f} ms" in text
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
    steps = np.diff(log.command_t)
    long = steps[steps > 0.5]
    seen = fault(found, "no commands")
    assert seen["count"] == pytest.approx(len(long), abs=1)  # and after the last
    assert seen["longest"] == pytest.approx(long.max() - 0.5, abs=1e-6)


def rounded(step):
    return lambda t, seed: np.round(wave(t, seed) / step) * step


def limited(t, seed):
    return np.clip(3.0 * wave(t, seed), -1.0, 1.0)


def three_sizes(t, seed):
    return 0.6 * np.sign(np.round(wave(t, seed)))


def yaw_never(t, seed):
    return wave(t, seed) * [1, 1, 0]


@pytest.mark.parametrize(
    ("sticks", "field", "value", "words"),
    [
        (rounded(0.1), "resolution", 0.1, None),
        (rounded(0.25), "resolution", 0.25, "F_u moves in coarse steps of 0.25"),
        (rounded(1 / 127), "resolution", 1 / 127, None),
        (limited, "at_limit", 0.77, "F_u is at its limit for"),
        (three_sizes, "levels", 3, "F_u has only 3 different values"),
        (yaw_never, "never_moves", True, "F_r is 0 all the time: is it the right column or field?"),
    ],
    ids=["tenths", "quarters", "8 bits", "saturated", "one size", "never moves"],
)
def test_how_sticks_are_used(inspected, sticks, field, value, words):
    log = drive(sticks=sticks)
    text, found = inspected(log)
    use = {u["name"]: u for u in found["inputs"]}["F_r" if field == "never_moves" else "F_u"]
    if field == "at_limit":  # of the time that it is not at rest
        own = log.command[:, 0]
        value = np.mean(np.abs(own[np.abs(own) > 0.05]) > 0.998)
        assert f"at its limit for {100 * value:.0f} %" in text
    assert use[field] == pytest.approx(value, rel=0.03)
    if words is None:
        assert found["verdicts"] == [GOOD]
        assert f"in steps of {value:.3g}" in text
    else:
        assert any(v.startswith(words) for v in found["verdicts"])
        assert f"=> {words}" in text
    assert use["least"] == pytest.approx(
        log.command[:, 2 if field == "never_moves" else 0].min(), abs=1e-6
    )


@pytest.mark.parametrize("odd", [0.0, 0.03])
@pytest.mark.parametrize("rest", [0.0, 0.9, 0.99])
@pytest.mark.parametrize("step", [0.0, 0.003, 0.05])
def test_a_grid_is_found_under_a_few_odd_values_and_much_rest(mp, odd, rest, step):
    rng = np.random.default_rng(9)
    values = rng.uniform(-1, 1, (20_000, 3))
    if step:
        values = np.round(values / step) * step
    values[rng.random(20_000) < rest] = 0.0
    some = np.flatnonzero(values[:, 0])
    some = some[rng.random(len(some)) < odd]
    values[some] = rng.choice(rng.uniform(-1, 1, 6), (len(some), 3))
    t = np.arange(20_000) * 0.01
    eta = np.column_stack([np.sin(t), np.cos(t), 0.1 * t])
    record = make_recording("grid", nanoseconds(t), eta, Signal(mp.inputs, nanoseconds(t), values))
    for use in input_use(mp, record):
        assert use.resolution == pytest.approx(step, rel=1e-6)
        assert use.levels == len(np.unique(values[:, mp.inputs.index(use.name)]))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_axis_driven_to_one_side(inspected, side):
    log = drive(
        sticks=lambda t, seed: np.column_stack(
            [wave(t)[:, 0], side * np.abs(wave(t)[:, 1]), wave(t)[:, 2]]
        )
    )
    text, found = inspected(log)
    assert found["verdicts"] == ["sway is driven mostly to one side: drive both"]
    sway = found["axes"][1]
    assert not sway["both_directions"]
    minutes = sway["minutes_positive" if side > 0 else "minutes_negative"]
    assert minutes == pytest.approx(
        np.mean(np.abs(wave(log.command_t)[:, 1]) > 0.05) * 1.5, abs=0.01
    )
    assert sway["minutes_negative" if side > 0 else "minutes_positive"] == 0.0
    left, right = (f"{m:.1f}" for m in ((minutes, 0.0) if side > 0 else (0.0, minutes)))
    assert f"left {left} min, right {right} min" in text


# Coverage. #

LEVELS = (0.02, 0.2, -0.2, 0.5, -0.5, 0.9, -0.9, 0.0)  # 8, 6, 4, 10, 2, 12, 14 and 34 s of them
SECONDS = (8, 6, 4, 10, 2, 12, 14, 34)


def staircase(t, seed=0):
    """Surge in known sizes for known times; the other axes at rest."""
    sticks = np.zeros((len(t), 3))
    sticks[:, 0] = np.repeat(LEVELS, np.array(SECONDS) * 50)
    return sticks


def test_minutes_by_direction_and_size_are_those_that_were_driven(inspected):
    text, found = inspected(drive(sticks=staircase))
    surge, sway, yaw = found["axes"]
    expected = {
        "minutes_positive": 28 / 60, "minutes_negative": 20 / 60, "minutes_small": 10 / 60,
        "minutes_medium": 12 / 60, "minutes_large": 26 / 60, "largest": 0.9, "share": 1.0,
        "rms": math.sqrt(np.dot(np.square(LEVELS), SECONDS) / 90),
    }  # fmt: skip
    for name, value in expected.items():
        assert surge[name] == pytest.approx(value, abs=0.002), name
    assert surge["both_directions"]
    assert "forward 0.5 min, back 0.3 min; small 0.2, medium 0.2, large 0.4 min" in text
    for axis, view in (("sway", sway), ("yaw", yaw)):
        assert view["rms"] == 0.0
        assert f"{axis} is not excited: take it from another recording" in found["verdicts"]
        assert re.search(rf"{axis} +rms 0.000: not driven", text)
    assert "drives surge nearly alone: identifies that axis" in found["verdicts"]


def test_minutes_count_only_while_there_are_poses(inspected):
    log = drive(sticks=staircase)
    kept = (log.pose_t < 35.0) | (log.pose_t >= 45.0)  # ten seconds of 0.9 and of -0.9 are lost
    _, found = inspected(
        log.but(pose_t=log.pose_t[kept], pose_arrival=log.pose_arrival[kept], pose=log.pose[kept])
    )
    assert found["axes"][0]["minutes_large"] == pytest.approx(16 / 60, abs=0.005)
    assert found["axes"][0]["minutes_medium"] == pytest.approx(12 / 60, abs=0.005)


def starboard(t, seed=0):
    """Sway to the left only, turning to the right only (forward-left-up)."""
    return np.column_stack([wave(t)[:, 0], np.abs(wave(t)[:, 1]), -np.abs(wave(t)[:, 2])])


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
def test_left_and_right_are_where_they_are_in_either_axes(inspected, tmp_path, axes):
    log = drive(sticks=starboard)
    vehicle = seatrial.load_vehicle("mallard-mp")
    if axes == "forward-right-down":
        vehicle, turned = frd(vehicle), [1.0, -1.0, -1.0]
        log = log.but(pose=log.pose * turned, command=log.command * turned)
    (tmp_path / "v.yaml").write_text(json.dumps(vehicle.to_mapping()))
    text, found = inspected(log, tmp_path / "v.yaml")
    _, sway, yaw = found["axes"]
    first = "minutes_positive" if axes == "forward-left-up" else "minutes_negative"
    other = "minutes_negative" if axes == "forward-left-up" else "minutes_positive"
    assert sway[first] > 1.0
    assert yaw[other] > 1.0
    assert sway[other] == yaw[first] == 0.0
    assert re.search(r"left 1\.\d min, right 0\.0 min|right 0\.0 min, left 1\.\d min", text)
    assert re.search(
        r"turning left 0\.0 min, turning right 1\.\d min|turning right 1\.\d min, turning left 0\.0 min",
        text,
    )
    by_name = {u["name"]: u for u in found["inputs"]}
    for i, name in enumerate(("F_u", "F_v", "F_r")):  # as the file's columns have them
        assert by_name[name]["least"] == pytest.approx(log.command[:, i].min(), abs=1e-6)
        assert by_name[name]["most"] == pytest.approx(log.command[:, i].max(), abs=1e-6)
    assert "nothing against the vehicle file" in text


# Units and signs come through. #


def test_a_recording_in_degrees_or_with_a_stick_turned_round_is_found_out(inspected, tmp_path):
    log = drive()
    content = seatrial.load_vehicle("mallard-mp").to_mapping()
    content["commands"]["inputs"]["F_v"]["sign"] = -1
    (tmp_path / "v.yaml").write_text(json.dumps(content))
    text, _ = inspected(log, tmp_path / "v.yaml")
    assert any("F_v" in v and "set sign: 1" in v for v in said(text))
    assert "nothing against" not in text


# The JSON. #


def numbers(content):
    if isinstance(content, dict):
        for value in content.values():
            yield from numbers(value)
    elif isinstance(content, list):
        for value in content:
            yield from numbers(value)
    elif isinstance(content, float):
        yield content


def test_json_is_finite_and_complete(look, tmp_path):
    """Everything that the text is made of, for several recordings, one of them cut by --start."""
    paths = [drive(seed=s).write(tmp_path / f"log{s}.mcap") for s in range(2)]
    text, found = look(*paths, vehicle="mallard-mp", more=("--start", "5"))
    assert set(found) == {"vehicle", "axes", "recordings", "signs"}
    assert (found["vehicle"], found["axes"]) == ("mallard", "forward-left-up")
    assert all(math.isfinite(x) for x in numbers(found))
    records = [seatrial.read(p, seatrial.load_vehicle("mallard-mp")).cut(5.0) for p in paths]
    inspection = seatrial.inspect(records, seatrial.load_vehicle("mallard-mp"))
    assert found["recordings"] == json.loads(msgspec.json.encode(inspection.recordings))
    assert inspection_text(inspection) + "\n" == text
    assert [r["name"] for r in found["recordings"]] == ["log0", "log1"]
    assert found["recordings"][0]["duration"] == pytest.approx(84.93, abs=0.07)
    assert found["signs"]["findings"] == []
    assert len(found["signs"]["gains"]) == 9
    for line in found["signs"]["seen"]:
        assert f"  {line}" in text


# Without a vehicle file. #


def test_the_topics_of_a_bag(look, tmp_path):
    log = drive()
    t = nanoseconds(np.arange(0.0, 90.0, 0.5))
    more = [
        BagTopic(
            "/temperature", "sensor_msgs/msg/Temperature", t, t, {"temperature": np.ones(180)}
        ),
        BagTopic("/lonely", "std_msgs/msg/Float64", t[:1], t[:1], {"data": np.ones(1)}),
    ]
    for kind, name in (("bag", "ROS 1 bag"), ("mcap", "ROS 2 bag"), ("db3", "ROS 2 bag")):
        path = write_bag(tmp_path / f"log.{kind}", [*log.topics(), *more])
        text, found = look(path)
        (bag,) = found["recordings"]
        assert bag["kind"] == name
        assert bag["length"] == pytest.approx(90.0, abs=0.05)
        topics = {x["source"]: x for x in bag["topics"]}
        assert {n: (x["kind"], x["count"], x["role"]) for n, x in topics.items()} == {
            POSE: ("geometry_msgs/PoseStamped", 1350, "poses"),
            JOY: ("sensor_msgs/Joy", 4500, "commands"),
            "/temperature": ("sensor_msgs/Temperature", 180, None),
            "/lonely": ("std_msgs/Float64", 1, "commands"),
        }
        assert topics[JOY]["rate"] == pytest.approx(50.0)
        assert topics[JOY]["delay"]["least"] == pytest.approx(0.001, abs=1e-4)
        for x in topics.values():
            row = next(line for line in text.splitlines() if line.startswith(f"  {x['source']} "))
            assert f" {x['count']} " in row
            assert x["kind"] in row
        assert said(text) == [
            f"seatrial init {path} -o vehicle.yaml writes a vehicle file to start from"
        ]


def test_clocks_of_a_bag_are_seen_without_a_vehicle_file(look, tmp_path):
    log = drive()
    stamps = log.command_t + np.where(log.command_t > 30.0, -3.0, 0.0)
    text, found = look(log.but(command_t=stamps).write(tmp_path / "log.mcap"))
    assert (
        "/joy: its clock jumps back by 3000 ms against the recorder's 30.0 s after the first"
        in text
    )
    topics = {x["source"]: x for x in found["recordings"][0]["topics"]}
    assert topics[JOY]["delay"]["step"] == pytest.approx(3.0, abs=0.001)


def test_a_bag_without_poses_or_without_anything(look, tmp_path):
    log = drive()
    text, _ = look(write_bag(tmp_path / "joy.bag", log.topics()[1:]))
    assert said(text) == ["nothing here looks like poses; see docs/recording.md for what to record"]
    for kind in ("bag", "mcap", "db3"):
        text, found = look(write_bag(tmp_path / f"empty.{kind}", []))
        assert found["recordings"][0]["topics"] == []
        assert len(said(text)) == 2
        assert "nothing here looks like commands" in text


def test_types_that_are_not_known_are_listed(look, tmp_path):
    """A .db3 brings no definitions: a type of one's own is a name, and no more."""
    import sqlite3

    path = drive().write(tmp_path / "log.db3")
    with sqlite3.connect(path) as base:
        base.execute("UPDATE topics SET type = 'boat_msgs/msg/Motors' WHERE name = '/joy'")
    text, found = look(path)
    topics = {x["source"]: x for x in found["recordings"][0]["topics"]}
    assert (topics[JOY]["kind"], topics[JOY]["role"]) == ("boat_msgs/Motors", None)
    assert "boat_msgs/Motors" in text
    assert "nothing here looks like commands" in text


def test_the_columns_of_tables(look, tmp_path):
    folder = tmp_path / "log"
    folder.mkdir()
    log = drive()
    rows = np.column_stack([1e3 * (log.pose_t + EPOCH * 1e-9), log.pose, np.zeros(1350)])
    np.savetxt(
        folder / "poses.csv",
        rows,
        delimiter=",",
        header="stamp,x,y,psi,ok",
        comments="",
        fmt="%.16g",
    )
    rows = zip(log.command_t, log.command[:, 0], strict=True)
    lines = ["t;mode;F_u", *(f"{t};manual;{f}" for t, f in rows)]
    lines[50] = "0.98;;n/a"
    (folder / "sticks.csv").write_text("\n".join(lines) + "\n")
    text, found = look(folder)
    poses, sticks = found["recordings"][0]["tables"]
    columns = {c["name"]: c for c in poses["columns"]}
    assert poses["rows"] == 1350
    assert columns["stamp"]["unit"] == "ms"
    assert columns["x"]["least"] == pytest.approx(log.pose[:, 0].min(), rel=1e-6)
    assert columns["x"]["most"] == pytest.approx(log.pose[:, 0].max(), rel=1e-6)
    assert (columns["ok"]["changes"], columns["x"]["changes"]) == (False, True)
    assert {c["name"]: c["least"] for c in sticks["columns"]}["mode"] is None
    assert "ok     0 to 0; never changes" in text
    assert "mode  no numbers" in text
    assert {c["name"]: c["empty"] for c in sticks["columns"]} == {"t": 0, "mode": 4500, "F_u": 1}
    assert re.search(r"F_u +-0.9\d+ to 0.9\d+, 1 without a number", text)
    assert said(text) == [
        f"seatrial init {folder} -o vehicle.yaml writes a vehicle file to start from"
    ]


def test_what_is_known_of_a_recording_in_a_table(look, tmp_path, mp):
    """No arrivals, so no delays; everything else as from a bag."""
    log = drive()
    folder = tmp_path / "log"
    folder.mkdir()
    for name, t, values, head in (
        ("poses", log.pose_t, log.pose, "t,x,y,psi"),
        ("commands", log.command_t, log.command, "t,F_u,F_v,F_r"),
    ):
        rows = np.column_stack([t, values])
        np.savetxt(folder / f"{name}.csv", rows, delimiter=",", header=head, comments="")
    text, found = look(folder, vehicle="mallard-mp")
    (recording,) = found["recordings"]
    assert recording["verdicts"] == [GOOD]
    assert [s["clock"] for s in recording["streams"]] == ["column of the table"] * 2
    assert [s["delay"] for s in recording["streams"]] == [None, None]
    assert "poses.csv (table): 1350 at 15 Hz" in text
    assert "commands.csv (table): 4500 at 50 Hz" in text


def test_a_vehicle_with_two_forces_along_one_axis_is_covered_by_the_larger(cse1, cse1_vehicle):
    """The ship's bow thruster and propellers both push sway; by hand from the commands."""
    record = cse1["random_run3"]
    _, sway, _ = seatrial.inspect([record], cse1_vehicle).recordings[0].axes
    names = cse1_vehicle.inputs
    columns = {n: record.commands.values[:, names.index(n)] for n in names}
    speed = record.scales.values[:, 0] / 0.4
    stern = speed**2 * (columns["port_sway"] + columns["starboard_sway"]) / 2
    largest = np.where(np.abs(stern) >= np.abs(columns["bow"]), stern, columns["bow"])
    seen = record.valid  # rows of poses and commands are those of one table
    assert sway.minutes_positive == pytest.approx(
        np.sum(seen & (largest > 0.05)) * 0.05 / 60, abs=0.1
    )
    assert sway.minutes_negative == pytest.approx(
        np.sum(seen & (largest < -0.05)) * 0.05 / 60, abs=0.1
    )


def test_commands_far_beyond_full_are_asked_about(inspected):
    text, found = inspected(drive(sticks=lambda t, seed: 1500 + 400 * wave(t, seed)))
    assert any("full command is 1: give offset and scale" in v for v in found["verdicts"])
    assert "F_u reaches 1" in text


def test_a_timeout_below_the_rhythm_of_the_commands_is_named():
    log = drive()
    mallard = seatrial.load_vehicle("mallard-mp").to_mapping()
    vehicle = vehicle_from({**mallard, "command_timeout": 0.001}, "v.yaml")
    commands = Signal(vehicle.inputs, nanoseconds(log.command_t), log.command)
    record = make_recording("r", nanoseconds(log.pose_t), log.pose, commands, timeout=0.001)
    text = inspection_text(seatrial.inspect([record], vehicle))
    assert "command_timeout is shorter than the rhythm of the commands" in text
    assert "units, signs and order could not be checked" in text
    assert "nothing against" not in text


def test_a_bag_that_was_played_back_and_recorded_again_is_called_that(inspected):
    log = drive()
    again = log.but(pose_arrival=log.pose_t / 5 + 1e5, command_arrival=log.command_t / 5 + 1e5)
    text, found = inspected(again)
    assert sum("played back and recorded again" in v for v in found["verdicts"]) == 2
    assert "chrony" not in text
    assert "slow source" not in text
