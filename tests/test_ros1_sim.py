# SPDX-License-Identifier: MIT
"""The simulator's node with a real ROS 1: driven by Joy, beside the odometry node."""

import re
import signal
import time

import numpy as np
import pytest
from ros1_node_tools import (
    heading,
    messages,
    needed,
    nodes,
    odometry,
    plant_states,
    stamp_of,
    track,
)

import seatrial
from seatrial import _core

pytestmark, ros = needed, nodes
SCENE = """seatrial: scene 1
pool: {length: 12, width: 8}
boxes: [{x: 4, y: 1, length: 1, width: 0.5, turn_deg: 30}]
posts: [{x: -2, y: 2, radius: 0.2}]
walls: [[-5, -1, -4, -2]]
current: [0.02, -0.01]
sensors:
  pose: {rate: 20, position_noise: 0.002, delay: 0.1}
  imu: {rate: 50}
  lidar: {rate: 10, beams: 181, noise: 0, mount: [0.2, 0.0, 0.1]}
boats: [{name: tug, start: [-1, 0.5, 0.3], radius: 0.35}]
"""
START, CURRENT, RATE = (-1.0, 0.5, 0.3), (0.02, -0.01), 50  # [Hz] of the truth
RECORDED = (
    "/truth",
    "/taken",
    "/slam/pose",
    "/scan",
    "/imu",
    "/odom",
    "/joy",
    "/clock",
    "/tf_static",
)
DRIVES = ([0.1, 0.6, 0.0, 0.3], [-0.3, 0.2, 0.0, -0.5])  # axes of the joypad


@pytest.fixture(scope="module")
def files(boat, tmp_path_factory):
    folder = tmp_path_factory.mktemp("sim")
    seatrial.save(boat, folder / "model.yaml")
    (folder / "scene.yaml").write_text(SCENE)
    return folder


@pytest.fixture(scope="module")
def recorded(ros, files, tmp_path_factory):
    """Twenty seconds of simulated time at twice real time; and how long [s] that was at most."""
    begin, out = time.monotonic(), tmp_path_factory.mktemp("recorded") / "out.bag"
    model = files / "model.yaml"
    recorder = ros.record("-O", out, topics=RECORDED)
    odometer = ros.node("odometry", hears="/joy", model=model, current_x=0.02, current_y=-0.01)
    simulator = ros.node(
        "simulator", hears="/joy", models=model, scene=files / "scene.yaml", real_time_factor=2
    )
    ros.until(lambda: ros.connected("/scan"), "recorder")
    ros.run("rostopic", "echo", "-n2", "/scan")  # a scan or two at rest
    for axes in DRIVES:
        ros.finish(ros.joypad(10.0, *axes))
    for process in (odometer, recorder, simulator):
        ros.finish(process, signal.SIGINT)
    (files / "took").write_text(str(time.monotonic() - begin))
    return out


def truth_of(bag):
    """Stamps [ns] and states (n, 6)."""
    stamps, poses, velocities = track(bag, "/truth")
    return stamps, np.hstack([poses, velocities])


def begin_of(bag):
    """Stamp [ns] of simulated time 0: before the first command the boat drifts with the water."""
    stamps, states = truth_of(bag)
    drifted = (states[0, 0] - START[0]) / CURRENT[0]  # [s]
    return stamps[0] - round(drifted * RATE) * 10**9 // RATE


def test_it_moves_as_the_plant_does_by_the_recorded_commands(recorded, boat):
    (stamps, states), begin = truth_of(recorded), begin_of(recorded)
    t = (stamps - begin) * 1e-9
    taken = [m for _, m in messages(recorded, "/taken")]
    assert {tuple(m.name) for m in taken} == {("F_u", "F_v", "F_r")}
    commands = [((stamp_of(m.header) - begin) * 1e-9, m.position) for m in taken]
    asked = {(m.axes[1], m.axes[0], m.axes[3]) for _, m in messages(recorded, "/joy")}
    assert {tuple(np.float32(values)) for _, values in commands} == asked
    want = plant_states(boat, START, commands, t)
    want[:, :2] += np.outer(t, CURRENT)  # the water carries it
    flow = np.tile([*CURRENT, 0.0], (len(t), 1))
    want[:, 3:] += _core.rotate(np.ascontiguousarray(want[:, 2]), flow, True)
    assert t[-1] > 15.0
    np.testing.assert_allclose(np.diff(t), 1 / RATE, atol=1e-6)
    off = np.abs(want - states).max(axis=0)
    assert np.all(off < 1e-5), off
    # the way gone: where it ends depends on how long each command was held, as a busy machine sends them
    assert np.hypot(*np.diff(states[:, :2], axis=0).T).sum() > 0.5


def test_poses_come_late_and_are_near_the_truth(recorded):
    stamps, states = truth_of(recorded)
    poses = messages(recorded, "/slam/pose")
    at = np.array([stamp_of(m.header) for _, m in poses])
    seen = np.array([[m.pose.position.x, m.pose.position.y] for _, m in poses])
    want = np.column_stack([np.interp(at, stamps, states[:, i]) for i in (0, 1)])
    inside = (at > stamps[0]) & (at < stamps[-1])
    assert np.std((seen - want)[inside]) == pytest.approx(0.002, rel=0.2)
    assert {m.header.frame_id for _, m in poses} == {"map"}
    late = np.array([arrival for arrival, _ in poses]) - at
    # the earlier half: a busy machine is late, never early
    assert np.quantile(late, 0.25) * 1e-9 == pytest.approx(0.1, abs=0.03)


def test_the_scan_is_that_of_the_library_in_the_same_scene(recorded, boat, files):
    """At rest, without noise: both read the same scene file."""
    (_, first), begin = messages(recorded, "/scan")[0], begin_of(recorded)
    stamp = (stamp_of(first.header) - begin) * 1e-9
    simulator = seatrial.Simulator(boat, scene=files / "scene.yaml")
    simulator.advance_to(0.11 + round(stamp, 1))
    want = simulator.scan()
    assert first.header.frame_id == "laser"
    np.testing.assert_allclose(first.ranges, want.ranges, rtol=1e-5)
    assert np.isfinite(want.ranges).all()
    assert first.angle_min == pytest.approx(want.angles[0])
    assert first.time_increment * 180 == pytest.approx(want.sweep, rel=1e-5)
    assert (stamp_of(first.header) - begin_of(recorded)) * 1e-9 == pytest.approx(
        want.stamp, abs=1e-6
    )
    (_, tf), *_ = messages(recorded, "/tf_static")
    where = tf.transforms[0]
    assert (where.header.frame_id, where.child_frame_id) == ("base_link", "laser")
    assert where.transform.translation.x == pytest.approx(0.2)
    assert heading(where.transform.rotation) == pytest.approx(0.1)


def test_the_imu_turns_as_the_truth_and_feels_gravity(recorded):
    stamps, states = truth_of(recorded)
    rows = [
        (stamp_of(m.header), m.angular_velocity.z, m.linear_acceleration.z)
        for _, m in messages(recorded, "/imu")
    ]
    at, rate, up = (np.array(column) for column in zip(*rows, strict=True))
    inside = (at > stamps[0]) & (at < stamps[-1])
    off = rate - np.interp(at - 10_000_000, stamps, states[:, 5])
    assert np.std(off[inside]) < 0.006
    assert np.allclose(up, 9.80665)


def test_the_clock_keeps_to_twice_real_time_and_the_odometry_node_lives_on_it(recorded, files):
    clock = [m.clock.sec * 10**9 + m.clock.nanosec for _, m in messages(recorded, "/clock")]
    assert np.all(np.diff(clock) >= 0)
    stamps, states = truth_of(recorded)
    # a busy machine is late, never early: the drives began when the clock did, or later
    assert 20.0 < (stamps[-1] - stamps[0]) * 1e-9 <= 2.0 * float((files / "took").read_text())
    got = odometry(recorded)
    late = (got.stamp > stamps[0] + 4 * 10**9) & (got.stamp < stamps[-1] - 10**9)
    assert late.sum() > 300
    truth = np.column_stack([np.interp(got.stamp[late], stamps, states[:, i]) for i in (3, 4, 5)])
    rms = np.sqrt(np.mean((got.velocity[late] - truth) ** 2, axis=0))
    assert np.all(rms < [0.01, 0.01, 0.03]), rms


def test_two_boats_have_names_of_their_own(ros, files):
    model = files / "model.yaml"
    node = ros.node(
        "simulator", name="fleet", hears="/mallard_2/joy", models=f"{model}, {model}",
        publish_clock="false",
    )  # fmt: skip
    assert "/fleet" in ros.subscribers("/mallard/joy")
    topics = ros.run("rostopic", "list")
    for topic in ("slam/pose", "truth", "scan", "imu"):
        assert f"/mallard_2/{topic}" in topics
    frame = re.search(
        r'child_frame_id: "?([\w/]+)', ros.run("rostopic", "echo", "-n1", "/mallard_2/truth")
    )
    assert frame[1] == "mallard_2/base_link"
    ros.finish(node, signal.SIGINT)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("__name:=a",), "parameter models is empty"),
        (("__name:=b", "_models:=nowhere.yaml"), "nowhere.yaml"),
        (("__name:=c", "_models:={model}", "_scene:={model}"), "seatrial: scene 1"),
        (("__name:=d", "_models:={model}", "_real_time_factor:=1000"), "real_time_factor is 1000"),
        (("__name:=e", "_models:={model}", "_scene:={bad}"), "sensors: lidar: beams: expected 2"),
        (("__name:=f", "_models:={model}", "_scene:={odd}"), "unknown key 'wals'"),
        (("__name:=g", "_models:={model},{model}", "_scene:={named}"), "boat '2nd': expected a name that"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(ros, files, arguments, words):
    (files / "bad.yaml").write_text("seatrial: scene 1\nsensors: {lidar: {beams: 1}}\n")
    (files / "odd.yaml").write_text("seatrial: scene 1\nwals: []\n")
    (files / "named.yaml").write_text("seatrial: scene 1\nboats: [{name: tug}, {name: 2nd}]\n")
    names = {name: files / f"{name}.yaml" for name in ("model", "bad", "odd", "named")}
    assert words in ros.complaint("simulator", *(a.format(**names) for a in arguments))
