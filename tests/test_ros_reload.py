# SPDX-License-Identifier: MIT
"""A model file that is reloaded: what the node makes of messages from then on, and of recent ones."""

import json
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from board_boats import changed
from test_ros_live_stream import inlet, received
from test_ros_node import EPOCH, drive, joy, lines_of, model, numbers, play, program

import seatrial

pytestmark = pytest.mark.system
__all__ = ["inlet", "model", "program"]


def test_a_model_that_is_read_once_more_goes_on(program, model):
    events = lines_of(drive(8))
    half = len(events) // 2
    at = events[half].split()[0]
    plain = [r for r in play(program, events, model=model[1]) if r[0].isdigit()]
    again = play(program, [*events[:half], f"{at} reload", *events[half:]], model=model[1])
    assert ["reload", "done"] in again
    again = [r for r in again if r[0].isdigit()]
    assert len(again) == len(plain)
    for a, b in zip(plain, again, strict=True):
        if a[1] != "unknown":
            np.testing.assert_allclose(numbers(a), numbers(b), atol=5e-3)


def other_topic(known, path):
    commands = {**known.vehicle.to_mapping()["commands"], "topic": "/sticks"}
    seatrial.save(replace(known, vehicle=changed(known.vehicle, commands=commands)), path)


def other_field(known, path):
    commands = {**known.vehicle.to_mapping()["commands"]}
    commands["inputs"] = {**commands["inputs"], "F_u": "data[0]"}
    seatrial.save(replace(known, vehicle=changed(known.vehicle, commands=commands)), path)


def interrupted(program, path, events, half, change) -> list[str]:
    """Lines that it answers, where `change` is called between the halves of its events."""
    first, second = (
        "".join(line + "\n" for line in part) for part in (events[:half], events[half:])
    )
    count = sum(line.endswith(("tick", "reload")) for line in events[:half])
    with subprocess.Popen(
        [program, f"model={path}"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        process.stdin.write(first)
        process.stdin.flush()
        lines = [process.stdout.readline().rstrip("\n") for _ in range(count)]
        change()
        process.stdin.write(second)
        process.stdin.close()
        return lines + process.stdout.read().splitlines()


READINGS = {
    "sign": {"inputs": {"F_u": {"field": "axes[1]", "sign": -1}}},
    "scale": {"inputs": {"F_u": {"field": "axes[1]", "scale": 2}}},
    "index": {"inputs": {"F_u": "axes[3]", "F_r": "axes[1]"}},
    "field": {"inputs": {"F_u": "buttons[0]"}},
    "order": {"inputs": {}},
    "pose": {"pose": {"y": {"field": "pose.position.y", "sign": -1, "offset": 0.2}}},
    "heading": {"pose": {"psi": {"field": "pose.orientation", "sign": -1}}},
    "frame": {"pose": {"parent": "earth"}},
    "clock": {"pose": {"clock": "bag"}},
    "lever": {"pose": {"lever": [0.4, 0.1]}},
}


@pytest.mark.parametrize("kind", READINGS)
def test_a_reload_reads_messages_as_the_new_model_says_also_recent_ones(
    program, model, tmp_path, kind
):
    """As if it had been so from the beginning, but for the pose in odom, which does not jump."""
    known, right = model
    own = known.vehicle.to_mapping()
    inputs = own["commands"]["inputs"]
    inputs = dict(reversed(inputs.items())) if kind == "order" else inputs
    commands = {**own["commands"], "inputs": {**inputs, **READINGS[kind].get("inputs", {})}}
    pose = {**own["pose"], **READINGS[kind].get("pose", {})}
    wrong = tmp_path / "wrong.yaml"
    vehicle = changed(known.vehicle, commands=commands, pose=pose)
    seatrial.save(replace(known, vehicle=vehicle), wrong)
    events = [line.replace(" map ", " world ") for line in lines_of(drive(8), late=30_000_000)]
    half = len(events) // 2
    again = [*events[:half], f"{events[half].split()[0]} reload", *events[half:]]
    plain = play(program, events, model=right)
    file, text = tmp_path / "model.yaml", right.read_text()
    file.write_text(wrong.read_text())
    rows = interrupted(program, file, again, half, lambda: file.write_text(text))
    rows = [row.split() for row in rows]
    at = rows.index(["reload", "done"])
    assert rows[at - 1] != plain[at - 1]
    for row, want in zip(rows[at + 1 :], plain[at:], strict=True):
        if row[0].isdigit():
            np.testing.assert_array_equal(numbers(row)[3:9], numbers(want)[3:9])
        elif row[0] in ("commands", "poses"):
            assert row == want


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda _, path: path.unlink(), "no such file"),
        (lambda _, path: path.write_text("seatrial: model 1\n"), "expected 'seatrial: model 3'"),
        (other_field, "/joy (sensor_msgs/Joy) has no field 'data[0]' for F_u"),
        (
            other_topic,
            "the new model has other topics: /slam/pose, /sticks; expected /slam/pose, /joy as before; restart the node",
        ),
    ],
)
def test_a_bad_model_leaves_the_one_before(program, model, spoil, words):
    known, path = model
    look = f"{EPOCH + 10**8} tick"
    begin = [joy(EPOCH, 0, 0.3, 0, 0), f"{EPOCH} pose {EPOCH} map 1 2 0.5", f"{EPOCH} tick"]
    before, plain, said, after, *_ = interrupted(
        program, path, [*begin, look, f"{EPOCH} reload", look], 4, lambda: spoil(known, path)
    )
    assert words in said
    assert "unknown" not in before
    assert after == plain


def test_messages_that_are_read_again_are_not_sent_again(program, model, inlet):
    events = [joy(EPOCH, 0, 0.1, 0, 0), f"{EPOCH} pose {EPOCH} map 1 2 0.5", f"{EPOCH} reload", joy(EPOCH + 1, 0, 0.2, 0, 0)]  # fmt: skip
    play(program, events, model=model[1], live_port=inlet.getsockname()[1])
    assert [json.loads(line)["stamp"] for line in received(inlet, 3)] == [EPOCH, EPOCH, EPOCH + 1]
