# SPDX-License-Identifier: MIT
"""The mimic's node with a real ROS 1: driven by Joy, it drives a carrier that slips."""

import re
import signal

import numpy as np
import pytest
from conftest import ROOT
from ros1_node_tools import messages, needed, nodes, plant_states, stamp_of, track

pytestmark, ros = needed, nodes
RECORDED = ("/cmd_vel", "/virtual_boat", "/odom", "/joy", "/diagnostics")
DRIVES = ([0.1, 0.6, 0.0, 0.2], [-0.3, 0.2, 0.0, -0.5])  # axes of the joypad


@pytest.fixture(scope="module")
def recorded(ros, path, tmp_path_factory):
    out = tmp_path_factory.mktemp("recorded") / "out.bag"
    recorder = ros.record("-O", out, topics=RECORDED)
    words = [",".join(map(str, axes)) for axes in DRIVES]
    carrier = ros.start("python3", ROOT / "tests" / "ros1_carrier.py", *words)
    mimic = ros.node("mimic", hears="/joy", model=path, lag=0.1, speed=0.3, rate=100.0)
    ros.finish(carrier)
    ros.finish(mimic, signal.SIGINT)
    ros.finish(recorder, signal.SIGINT)
    return out


def poses(bag, topic):
    """Stamps [s] and poses (n, 3)."""
    stamps, poses, _ = track(bag, topic)
    return stamps * 1e-9, poses


def test_the_carrier_follows_the_virtual_boat(recorded):
    t, boat = poses(recorded, "/virtual_boat")
    at, carrier = poses(recorded, "/odom")
    late = (at > t[0] + 1.0) & (at < t[-1])
    off = carrier[late] - np.column_stack([np.interp(at[late], t, boat[:, i]) for i in range(3)])
    assert late.sum() > 150
    assert np.sqrt(np.mean(np.sum(off[:, :2] ** 2, axis=1))) < 0.02
    assert np.hypot(*(boat[-1] - boat[0])[:2]) > 0.3


def test_the_virtual_boat_begins_at_the_carrier_and_moves_as_the_plant_does(recorded, boat):
    t, seen = poses(recorded, "/virtual_boat")
    later = next(
        i for i in range(len(t)) if abs(seen[i, 0] - 1.0) < 0.01
    )  # placed by the first pose
    np.testing.assert_allclose(seen[later], [1.0, 2.0, 0.5], atol=1e-9)
    commands = [
        (stamp_of(m.header) * 1e-9 - t[later], np.array([m.axes[1], m.axes[0], m.axes[3]]))
        for _, m in messages(recorded, "/joy")
    ]
    want = plant_states(boat, (1.0, 2.0, 0.5), commands, (t - t[later])[later:])[:, :3]
    assert np.all(np.abs(want - seen[later:]).max(axis=0) < [0.02, 0.02, 0.05])


def test_the_limit_is_kept_and_the_carrier_is_left_standing(recorded):
    twists = [m for _, m in messages(recorded, "/cmd_vel")]
    speed = np.array([np.hypot(m.linear.x, m.linear.y) for m in twists])
    assert 0.05 < speed.max() <= 0.3 + 1e-9
    assert (twists[-1].linear.x, twists[-1].linear.y, twists[-1].angular.z) == (0.0, 0.0, 0.0)


def test_diagnostics_say_how_far_it_is_off(recorded, path):
    *_, (_, last) = messages(recorded, "/diagnostics")
    (status,) = last.status
    values = {pair.key: pair.value for pair in status.values}
    assert status.name == "seatrial_mimic: mimic"
    assert str(path) in values["model"]
    assert abs(float(values["mismatch forward [m]"])) < 0.05
    assert int(values["poses used"]) > 100
    assert int(values["inputs not used"]) == 0


def test_at_its_limit_it_says_what_was_asked_and_what_is_allowed(ros, path):
    ros.run("rosparam", "set", "use_sim_time", "false")
    mimic = ros.node("mimic", hears="/joy", model=path, speed=0.02)
    joypad = ros.joypad(3600.0, 0.0, 0.8, 0.0, 0.0)
    words = r"exceeds the carrier.s speed limit.*\(commanded ([\d.]+) m/s, \S+ rad/s; at most 0\.02, 2\)"
    said = []

    def exceeded():
        text = " ".join(ros.run("rostopic", "echo", "-n1", "/diagnostics").split())
        said[:] = re.findall(words, text.replace("\\", ""))
        return said

    ros.until(exceeded, "a diagnosis of the limit")
    assert all(0.02 < float(asked) < 1.0 for asked in said)
    for process in (joypad, mimic):
        ros.finish(process, signal.SIGINT)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("__name:=a",), "parameter model is empty"),
        (("__name:=b", "_model:=nowhere.yaml"), "nowhere.yaml"),
        (("__name:=c", "_model:={model}", "_lag:=5.0"), "parameter lag is 5; expected 0 to 1: its delay"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(ros, path, arguments, words):
    assert words in ros.complaint("mimic", *(a.format(model=path) for a in arguments))
