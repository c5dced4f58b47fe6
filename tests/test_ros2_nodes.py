# SPDX-License-Identifier: MIT
"""Simulator, tracking controller, mimic and components with a real ROS 2."""

import shutil
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from bag_tools import pose
from conftest import ROOT
from programs import piped
from ros2_tools import FIXTURES, WORKSPACE, finish, header, needed, said, shell, stamp_of, status
from waiting import PATIENCE, until

import seatrial
from seatrial.control import save_gains, tune

pytestmark = needed
ros, peer, _alone = FIXTURES
ODOMETRY, JOY = "nav_msgs/msg/Odometry", "sensor_msgs/msg/Joy"
GOAL = (0.6, 0.3, 0.5)  # x, y [m], psi [rad]
SCENE = """seatrial: scene 1
sensors:
  pose: {rate: 15, position_noise: 0.001, heading_noise: 0.001, delay: 0.05}
"""


@pytest.fixture(scope="module")
def files(boat, tmp_path_factory):
    folder = tmp_path_factory.mktemp("boat")
    seatrial.save(boat, folder / "model.yaml")
    save_gains(tune(boat, 1.0, draws=5), folder / "gains.yaml")
    (folder / "scene.yaml").write_text(SCENE)
    return folder


def test_simulator_odometry_and_controller_bring_the_boat_to_its_goal(ros, peer, files):
    model = files / "model.yaml"
    truth, joy = peer.listen("truth", ODOMETRY), peer.listen("joy", JOY)
    odometry = peer.listen("odom", ODOMETRY)
    diagnosed = peer.listen("diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    ros.node("odometry", model=model, use_sim_time="true")
    tracking = ros.node("tracking", model=model, gains=files / "gains.yaml", use_sim_time="true")
    simulator = ros.node("simulator", models=model, scene=files / "scene.yaml", real_time_factor=2)
    goal = peer.publisher("goal", "geometry_msgs/msg/PoseStamped")
    until(lambda: goal.connected() and truth.latest() and odometry.latest(), "all nodes")
    goal.publish({"header": header(stamp_of(truth.latest())), "pose": pose(*GOAL)})

    def settled():  # odometry after its first four seconds
        begin = min(stamp_of(m) for m in truth.messages) + 4 * 10**9
        return [m for m in odometry.messages if begin < stamp_of(m) < stamp_of(truth.latest())]

    def there():
        joy.take()
        odometry.take()
        p = truth.latest().pose.pose.position
        return np.hypot(p.x - GOAL[0], p.y - GOAL[1]) < 0.02 and len(settled()) > 50

    until(there, "the boat at its goal and 50 odometry messages")
    assert any(np.abs(m.axes).max() > 0.05 for m in joy.messages)
    found = until(lambda: status(diagnosed, "seatrial_tracking: tracking"), "diagnosis")
    assert "error forward [m]" in {pair.key for pair in found.values}
    late = settled()
    by_stamp = {stamp_of(m): m.twist.twist for m in truth.messages}
    stamps = np.array(sorted(by_stamp))
    off = [
        m.twist.twist.linear.x
        - np.interp(stamp_of(m), stamps, [by_stamp[s].linear.x for s in stamps.tolist()])
        for m in late
    ]
    assert np.sqrt(np.mean(np.square(off))) < 0.01  # [m/s]
    finish(tracking)
    joy.take()
    assert np.abs(joy.messages[-1].axes).max() == 0.0  # the boat is left with its thrusters off
    finish(simulator, signal.SIGTERM)


@pytest.mark.parametrize("stamped", ["false", "true"])
def test_the_mimic_drives_its_carrier_and_leaves_it_standing(ros, peer, files, stamped):
    kind = "geometry_msgs/msg/TwistStamped" if stamped == "true" else "geometry_msgs/msg/Twist"
    cmd_vel = peer.listen("cmd_vel", kind)
    mimic = ros.node("mimic", model=files / "model.yaml", enable_stamped_cmd_vel=stamped, rate=20)
    joypad, carrier = peer.publisher("/joy", JOY), peer.publisher("odom", ODOMETRY)
    until(lambda: joypad.connected() and carrier.connected(), "mimic")

    def twists():
        cmd_vel.take()
        return [m.twist if stamped == "true" else m for m in cmd_vel.messages]

    def driven():
        now = header(time.time_ns(), "carrier_odom")
        joypad.publish({"header": now, "axes": [0.0, 0.5, 0.0, 0.0], "buttons": []})
        carrier.publish(
            {"header": now, "child_frame_id": "wheels", "pose": {"pose": pose(0, 0, 0)}}
        )
        time.sleep(0.03)
        return any(t.linear.x > 0.05 for t in twists())

    until(driven, "a velocity ahead")
    finish(mimic)
    until(lambda: (t := twists()[-1]) and t.linear.x == t.linear.y == t.angular.z == 0.0, "rest")
    if stamped == "true":
        assert cmd_vel.messages[-1].header.frame_id == "wheels"
        assert np.all(np.diff([stamp_of(m) for m in cmd_vel.messages]) > 0)


@pytest.mark.parametrize("program", ["odometry", "simulator", "mimic", "tracking"])
@pytest.mark.parametrize("word", ["__node:=a/b", "no rule"])
def test_arguments_that_are_none_are_one_line(ros, program, word):
    node = ros.start(program, "--ros-args", "-r", word)
    assert node.wait(PATIENCE) == 1
    own = [line for line in said(node).splitlines() if "[rcl]" not in line]
    assert len(own) == 1, own
    assert own[0].startswith(f"seatrial_{program}: ")
    assert word in own[0]


def test_a_mimic_that_can_not_publish_is_one_line(ros, files):
    node = ros.start("mimic", "--ros-args", "-p", f"model:={files / 'model.yaml'}", "-r", f"cmd_vel:=/{'v' * 300}")  # fmt: skip
    assert node.wait(PATIENCE) == 1
    assert said(node).startswith("seatrial_mimic: ")
    assert said(node).count("\n") == 1


def test_the_registered_components_are_the_nodes():
    listed = (WORKSPACE / "build/seatrial_odometry/components.txt").read_text().split()
    names = [f"seatrial_odometry::{n}Node" for n in ("Odometry", "Simulator", "Mimic", "Tracking")]
    assert listed == names
    for name in names:
        stem = name.split("::")[1].removesuffix("Node").lower()
        text = (ROOT / f"ros/ros2/src/{stem}.cpp").read_text()
        assert f"SEATRIAL_COMPONENT({name})" in text


def test_components_share_a_process_with_intra_process_communication(ros, peer, files):
    both = ros.start(
        "peer", "compose", "seatrial_odometry::OdometryNode", "seatrial_odometry::SimulatorNode",
        "--ros-args", "-p", f"model:={files / 'model.yaml'}", "-p",
        f"models:={files / 'model.yaml'}", "-p", "publish_clock:=false",
    )  # fmt: skip
    odometry, truth = peer.listen("odom", ODOMETRY), peer.listen("truth", ODOMETRY)
    joypad = peer.publisher("/joy", JOY)
    until(joypad.connected, "a component")

    def agree():
        joypad.publish({"header": header(time.time_ns()), "axes": [0.0, 0.5, 0.0, 0.0]})
        time.sleep(0.03)
        if not (odometry.latest() and truth.latest()):
            return False
        got, want = (one.messages[-1].twist.twist.linear.x for one in (odometry, truth))
        return want > 0.1 and got == pytest.approx(want, abs=0.02)

    until(agree, "odometry that is the simulator's velocity")
    finish(both)


def test_colcon_finds_and_tests_both_packages():
    """`colcon list` from the workspace, and the package's own linters."""
    done = shell("colcon list", WORKSPACE)
    found = {tuple(line.split()) for line in done.stdout.splitlines()}
    assert found == {
        ("seatrial_core", "src/seatrial/core", "(ros.cmake)"),
        ("seatrial_odometry", "src/seatrial/ros", "(ros.ament_cmake)"),
    }
    assert done.stderr == ""


def test_ament_cpplint_has_nothing_to_say():
    """But for the licence (one SPDX line), order and guards of includes (clang-format, once), marks for clang-tidy."""
    without = (
        "legal/copyright build/include_order build/header_guard readability/nolint runtime/int"
    )
    filters = ",".join(f"-{name}" for name in without.split())
    done = shell(
        f"ament_cpplint --linelength=100 --filters={filters} {ROOT / 'ros/ros2'}", WORKSPACE
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "odometry.cpp" in done.stdout + done.stderr


def test_the_package_configures_alone_as_bloom_exports_it(ros, tmp_path):
    """Its folder elsewhere, beside seatrial_core as it was installed."""
    shutil.copytree(ROOT / "ros", tmp_path / "exported")
    core = WORKSPACE / "install" / "seatrial_core"
    done = shell(f"cmake -S exported -B build -DCMAKE_PREFIX_PATH={core}", tmp_path)
    assert done.returncode == 0, done.stderr
    flags = (tmp_path / "build/common/CMakeFiles/seatrial_nodes.dir/flags.make").read_text()
    assert f"{core}/include" in flags
    assert str(ROOT / "core") not in flags


def test_launch_files_find_what_they_share(ros, tmp_path):
    """As Python finds it after `source install/setup.bash`; that Jazzy has no `launch` to run them with."""
    line = "import importlib.util as u; print(u.find_spec('seatrial_odometry.node_launch').origin)"
    done = piped(["python3", "-c", line], env=ros.environment, cwd=tmp_path, check=True)
    assert Path(done.stdout.strip()).is_relative_to(WORKSPACE / "install")
