# SPDX-License-Identifier: MIT
"""Inspect with a vehicle file: verdicts, how sticks are used, minutes, axes, JSON."""

import json
import math
import re
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from inspect_tools import GOOD, said, stream
from logs import JOY, POSE, drive, nanoseconds, wave
from survey_boat import driven, pulses
from test_model import frd

import seatrial
from seatrial.inspection.console import inspection_text
from seatrial.inspection.coverage import input_use
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal

# Nothing wrong. #


def test_a_good_recording_is_called_good_and_nothing_else(inspected):
    log = drive()
    text, found = inspected(log)
    assert found["verdicts"] == [GOOD]
    assert said(text) == [GOOD, "consistent with the vehicle file's units, signs and order"]
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
            (verdict,) = view.verdicts
            assert re.fullmatch(
                rf"9\d % of the effort is in {axis}: this recording identifies {axis} best", verdict
            )
        else:
            assert view.verdicts == (GOOD,)
        assert view.faults == ()
    assert found.signs.findings == ()


def rounded(step):
    return lambda t, seed: np.round(wave(t, seed) / step) * step


def limited(t, seed):
    return np.clip(3.0 * wave(t, seed), -1.0, 1.0)


def three_sizes(t, seed):
    return 0.6 * np.sign(np.round(wave(t, seed)))


def yaw_never(t, seed):
    return wave(t, seed) * [1, 1, 0]


def test_an_input_that_moves_in_a_recording_beside_is_not_asked_about(clean_af, af):
    """A boat driven one axis at a time: the columns are the right ones."""
    s1, _, s3, *_ = (trial.recording for trial in clean_af.values())
    yaw = s1.commands.names.index("F_r")
    still = s1.commands.values * (np.arange(3) != yaw)
    s1 = replace(s1, commands=Signal(s1.commands.names, s1.commands.stamps, still))
    alone, beside = (seatrial.inspect(them, af).recordings[0] for them in ([s1], [s1, s3]))
    assert "F_r is constant at 0: check its column or field" in alone.verdicts
    assert not any("constant at" in verdict for verdict in beside.verdicts)
    assert set(beside.verdicts) < set(alone.verdicts)


@pytest.mark.parametrize(
    ("sticks", "field", "value", "words"),
    [
        (rounded(0.1), "resolution", 0.1, None),
        (rounded(0.25), "resolution", 0.25, "F_u has a coarse resolution of 0.25"),
        (rounded(1 / 127), "resolution", 1 / 127, None),
        (limited, "at_limit", 0.77, "F_u is at its limit for"),
        (three_sizes, "levels", 3, "F_u has only 3 different values"),
        (yaw_never, "never_moves", True, "F_r is constant at 0: check its column or field"),
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
        assert f"at these limits {100 * value:.0f} % of the driven time" in text
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
    assert found["verdicts"] == ["sway is excited mostly in one direction: drive both"]
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
        assert f"{axis} is not excited: add a recording that excites it" in found["verdicts"]
        assert re.search(rf"{axis} +rms 0.000: not excited", text)
    assert (
        "100 % of the effort is in surge: this recording identifies surge best" in found["verdicts"]
    )


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
    assert "consistent with the vehicle file" in text


# Units and signs come through. #


def test_a_recording_in_degrees_or_with_a_stick_turned_round_is_found_out(inspected, tmp_path):
    log = drive()
    content = seatrial.load_vehicle("mallard-mp").to_mapping()
    content["commands"]["inputs"]["F_v"]["sign"] = -1
    (tmp_path / "v.yaml").write_text(json.dumps(content))
    text, _ = inspected(log, tmp_path / "v.yaml")
    assert any("F_v" in v and "set sign: 1" in v for v in said(text))
    assert "consistent with" not in text


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
    assert set(found) == {"seatrial", "vehicle", "axes", "recordings", "signs"}
    assert (found["vehicle"], found["axes"]) == ("mallard", "forward-left-up")
    assert all(math.isfinite(x) for x in numbers(found))
    records = [seatrial.read(p, seatrial.load_vehicle("mallard-mp")).cut(5.0) for p in paths]
    inspection = seatrial.inspect(records, seatrial.load_vehicle("mallard-mp"))
    assert found["recordings"] == json.loads(msgspec.json.encode(inspection.recordings))
    assert text.startswith(inspection_text(inspection) + "\nnext: seatrial identify ")
    assert [r["name"] for r in found["recordings"]] == ["log0", "log1"]
    assert found["recordings"][0]["duration"] == pytest.approx(84.93, abs=0.07)
    assert found["signs"]["findings"] == []
    assert len(found["signs"]["gains"]) == 9
    for line in found["signs"]["seen"]:
        assert f"  {line}" in text


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


def test_a_boat_of_two_thrusters_that_turns_less_than_it_drives_identifies_both_axes():
    """Its yaw coefficients are good to a few per cent: the advice calls surge the best, not the only one."""
    rng = np.random.default_rng(1)
    vehicle, recording = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=120.0)
    ahead, turn = (
        pulses(rng, 120.0, lambda g, most=most: g.uniform(-most, most), 0.3) for most in (0.6, 0.3)
    )
    signal = recording.commands
    values = np.column_stack([ahead - turn, ahead + turn])
    both = replace(recording, commands=Signal(signal.names, signal.stamps, values))
    (view,) = seatrial.inspect([both], vehicle).recordings
    share = np.mean(ahead**2) / np.mean(ahead**2 + turn**2)
    (found,) = (
        re.fullmatch("(.+) % of the effort is in surge: this recording identifies surge best", v)
        for v in view.verdicts
    )
    assert float(found[1]) == pytest.approx(100.0 * share, abs=1.0)
