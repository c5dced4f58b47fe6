# SPDX-License-Identifier: MIT
"""The odometry node with a real ROS 1: a bag is played, the node runs, what it says is compared."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import ROOT
from cpp_tools import built
from programs import printed
from ros1_node_tools import (
    LATENCY,
    SYSTEM_PYTHON,
    heading,
    messages,
    needed,
    nodes,
    odometry,
    script,
    stamp_of,
)
from ros_drive import OVER, SETTLED, WORST, s7, save_model
from ros_drive import truth_at as truth
from test_live_command import until as shown
from waiting import PATIENCE, free_port

import seatrial
from seatrial.io.trial_files import BAG_EPOCH, write_trial

pytestmark, ros = needed, nodes
RECORDED = ("/odom", "/map_pose", "/tf", "/diagnostics", "/joy", "/slam/pose")


@pytest.fixture(scope="module")
def trial():
    return s7()


@pytest.fixture(scope="module")
def played(trial, tmp_path_factory):
    return write_trial(trial, tmp_path_factory.mktemp("bag"), "bag")


@pytest.fixture(scope="module")
def known(tmp_path_factory):
    return save_model(tmp_path_factory.mktemp("model"))


class Run:
    """Node and recorder, while a bag is played in lock-step, to `stop` [s] and from `go_on`."""

    def __init__(self, ros, bag, model, out, *, stop=(), **parameters):
        self.ros, self.bag, self.out, self.stop = ros, bag, out, stop
        self.parameters = {"model": model, "publish_map_to_odom": "true", **parameters}

    def __enter__(self):
        self.process = self.ros.node("odometry", hears="/joy", **self.parameters)
        self.recorder = self.ros.record("-O", self.out, topics=RECORDED)
        lockstep = ("python3", ROOT / "tests" / "ros1_lockstep.py", self.bag, *self.stop)
        self.player = self.ros.start(*lockstep)
        if self.stop:
            self.ros.until(lambda: "stopped" in self.player.said.read_text(), "the stop")
        return self

    def go_on(self):
        self.player.stdin.write(b"\n")
        self.player.stdin.flush()

    def __exit__(self, *_):
        self.player.wait(PATIENCE)
        self.ros.finish(self.player)
        self.ros.finish(self.recorder, signal.SIGINT)
        self.ros.finish(self.process, signal.SIGINT)


@pytest.fixture(scope="module")
def recorded(ros, played, known, tmp_path_factory):
    out = tmp_path_factory.mktemp("recorded") / "out.bag"
    with Run(ros, played, known, out, stop=[10.0]) as going:
        # the node looks at signals after each service or diagnosis: two of the latter come before it is ended
        os.kill(going.process.pid, signal.SIGHUP)
        going.answer = ros.run("rosservice", "call", "/seatrial_odometry/reload")
        going.go_on()
    return out, going


def compared(stamps):
    return (stamps > BAG_EPOCH + SETTLED * 1e9) & (stamps < BAG_EPOCH + OVER * 1e9)


def truth_at(trial, stamps):
    return truth(trial, (stamps - BAG_EPOCH) * 1e-9)


def test_velocity_is_near_the_truth_in_steps_of_the_timer(recorded, trial):
    got = odometry(recorded[0])
    assert np.median(np.diff(got.stamp) * 1e-9) == pytest.approx(0.02, abs=1e-6)
    late = compared(got.stamp)
    assert late.sum() > 0.95 * 50 * (OVER - SETTLED)
    wrong = got.velocity[late] - truth_at(trial, got.stamp[late])[:, 3:]
    rms = np.sqrt(np.mean(wrong**2, axis=0))
    assert np.all(rms < WORST), rms
    assert np.all(got.spread[:, [0, 7, 35]] > 0.0)


def test_odom_never_jumps_and_tf_says_the_same(recorded):
    got = odometry(recorded[0])
    steps = np.hypot(*np.diff(got.pose[:, :2], axis=0).T)
    assert np.all(steps <= 1.0 * np.diff(got.stamp) * 1e-9 + 1e-6)
    of_tf, of_map = {}, 0
    for _, message in messages(recorded[0], "/tf"):
        for t in message.transforms:
            if (t.header.frame_id, t.child_frame_id) == ("odom", "base_link"):
                p = t.transform
                row = (p.translation.x, p.translation.y, heading(p.rotation))
                of_tf[stamp_of(t.header)] = row
            else:
                assert (t.header.frame_id, t.child_frame_id) == ("map", "odom")
                of_map += 1
    shared = [i for i, stamp in enumerate(got.stamp.tolist()) if stamp in of_tf]
    assert len(shared) > 0.95 * len(got.stamp)
    np.testing.assert_allclose([of_tf[got.stamp[i]] for i in shared], got.pose[shared], atol=1e-12)
    assert of_map > 0.95 * len(got.stamp)


def test_the_pose_in_the_map_is_near_the_truth_and_seatrial_reads_it(recorded, trial):
    content = trial.vehicle.to_mapping()
    content["pose"]["topic"] = "/map_pose"
    from seatrial.boat.vehicle import vehicle_from

    again = seatrial.read(recorded[0], vehicle_from(content, "again"))
    late = compared(again.stamps)
    wrong = again.eta[late] - truth_at(trial, again.stamps[late])[:, :3]
    wrong[:, 2] = (wrong[:, 2] + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(wrong[:, :2]).max() < 0.03
    assert np.abs(wrong[:, 2]).max() < 0.03
    assert len(again.commands.stamps) > 100


def test_diagnostics_name_the_model_and_what_is_wrong(recorded, known):
    (_, first), *_, (_, last) = messages(recorded[0], "/diagnostics")
    assert first.status[0].name == "seatrial_odometry: odometry"
    values = {pair.key: pair.value for pair in last.status[0].values}
    assert str(known) in values["model"]
    assert int(values["poses used"]) > 100
    assert {m.status[0].level for _, m in messages(recorded[0], "/diagnostics")} <= {0, 1, 2}


def test_the_model_is_read_once_more_by_service_and_by_signal(recorded):
    _, going = recorded
    assert "success: True" in going.answer
    said = going.process.said.read_text()
    assert said.count(": reloaded") == 2


def test_the_node_without_ros_says_the_same_to_the_same_events(recorded, played, known):
    given = "\n".join(script(recorded[0], played))
    shown = printed(built("script"), f"model={known}", input=given)
    rows = [line.split() for line in shown.splitlines() if line[0].isdigit()]
    by_stamp = {
        int(row[0]): [float.fromhex(x) for x in row[1:13]] for row in rows if row[1] != "unknown"
    }
    got = odometry(recorded[0])
    late = [i for i in np.flatnonzero(compared(got.stamp)) if got.stamp[i] in by_stamp]
    assert len(late) > 500
    off = got.velocity[late] - [by_stamp[got.stamp[i]][3:6] for i in late]
    # the same but for the headings' last digits; what was read once more begins with the last
    # inputs only, and a message may have come to the recorder on the other side of a tick
    assert np.mean(np.abs(off).max(axis=1) < 1e-5) > 0.9
    assert np.sqrt(np.mean(off**2, axis=0)).max() < 2e-3


def test_killed_and_restarted_it_goes_on_within_a_second(ros, played, known, trial, tmp_path):
    """By simulated time, which stands while it starts; its start costs a part of a second of CPU time."""
    with Run(ros, played, known, tmp_path / "out.bag", stop=[6.0]) as going:
        os.kill(going.process.pid, signal.SIGKILL)
        going.process.wait(PATIENCE)
        going.process.stdin.close()
        going.process = ros.node("odometry", hears="/joy", model=known)
        ros.until(
            lambda: ros.hears("/seatrial_odometry", ("/clock", "/joy", "/slam/pose")), "links"
        )
        started = cpu_seconds(going.process.pid)
        going.go_on()
    assert started < 1.0
    got = odometry(tmp_path / "out.bag")
    # a new filter begins with a large variance; no stamp is missing if a pose comes before its first tick
    grown = np.diff(got.spread[:, 0])
    at = int(np.argmax(grown))
    assert grown[at] > 100.0 * got.spread[at, 0]
    assert np.diff(got.stamp).max() < 1_000_000_000
    after = got.stamp[at + 1]
    settled = (got.stamp > after + 1_000_000_000) & (got.stamp < after + 5_000_000_000)
    assert settled.sum() > 190
    wrong = got.velocity[settled] - truth_at(trial, got.stamp[settled])[:, 3:]
    assert np.sqrt(np.mean(wrong**2, axis=0)).max() < 0.03


def cpu_seconds(process):
    """What a process has used so far (proc(5), fields 14 and 15)."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("__name:=a",), "parameter model is empty"),
        (("__name:=b", "_model:=nowhere.yaml"), "nowhere.yaml"),
        (("__name:=c", "_model:={model}", "_rate:=900"), "rate is 900"),
        (
            ("__name:=d", "_model:={model}", "_window:=text"),
            "window is of another type; expected a number: how late",
        ),
        (("__name:=e", "_model:={model}", "_pose_topic:=odom"), "/odom is what this node publishes"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(ros, known, arguments, words):
    assert words in ros.complaint("odometry", *(a.format(model=known) for a in arguments))


def test_the_packages_configure_alone_as_bloom_exports_them(tmp_path):
    """Each from its folder elsewhere; the nodes beside seatrial_core as catkin installs it."""
    core, nodes = tmp_path / "core", tmp_path / "nodes"
    shutil.copytree(ROOT / "core", core)
    shutil.copytree(ROOT / "ros", nodes)
    python, installed = f"-DPYTHON_EXECUTABLE={SYSTEM_PYTHON}", tmp_path / "installed"
    for command in (
        ["-S", core, "-B", "b1", python, "-DCATKIN_BUILD_BINARY_PACKAGE=1",
         f"-DCMAKE_INSTALL_PREFIX={installed}"],
        ["--build", "b1", "--target", "install"],
        ["-S", nodes, "-B", "b2", python, f"-DCMAKE_PREFIX_PATH={installed}"],
    ):  # fmt: skip
        printed(
            "cmake", *command, cwd=tmp_path, env={"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
        )
    flags = (tmp_path / "b2/common/CMakeFiles/seatrial_nodes.dir/flags.make").read_text()
    assert f"{installed}/include" in flags


def test_the_launch_file_passes_on_what_is_given(ros, known, tmp_path):
    """By roslaunch itself; the rest is as in the parameter file, else as the node has it."""
    (tmp_path / "own.yaml").write_text("window: 1.5\nrate: 10\n")
    text = ros.run(
        "roslaunch", "--dump-params", ROOT / "ros/ros1/launch/odometry.launch", f"model:={known}",
        "rate:=20", "publish_tf:=false", f"params:={tmp_path / 'own.yaml'}",
    )  # fmt: skip
    name = "/seatrial_odometry/"
    assert yaml.safe_load(text) == {
        f"{name}model": str(known), f"{name}rate": 20, f"{name}publish_tf": False,
        f"{name}window": 1.5,
    }  # fmt: skip


def test_a_topic_of_another_type_is_said(ros, known):
    ros.run("rosparam", "set", "use_sim_time", "false")
    # a name of its own, as the master keeps a node's parameters
    node = ros.node(
        "odometry", name="of_words", hears="/words", model=known, command_topic="/words"
    )
    other = ros.start("rostopic", "pub", "-r", "10", "/words", "std_msgs/String", "data: hello")
    ros.until(lambda: "std_msgs/String; expected one of" in node.said.read_text(), "complaint")
    for process in (other, node):
        os.killpg(process.pid, signal.SIGINT)
        process.wait(PATIENCE)
        process.stdin.close()
    ros.run("rosparam", "set", "use_sim_time", "true")


def answered(ros, known, rate, commands):
    """How many commands, and how many odometries came after the first of them, in 3 s of system time."""
    ros.run("rosparam", "set", "use_sim_time", "false")
    node = ros.node("odometry", model=known, rate=rate)
    sent, heard, *_ = map(
        float, ros.run(str(LATENCY), "_seconds:=3", f"_commands:={commands}").split()
    )
    ros.finish(node, signal.SIGINT)
    ros.run("rosparam", "set", "use_sim_time", "true")
    return sent, heard


def test_odometry_follows_each_command_at_once(ros, known):
    sent, heard = answered(ros, known, 0, 100)
    assert sent > 10  # of 300, fewer where the machine is busy
    assert 0.8 * sent < heard <= sent


def test_odometry_keeps_its_rate_by_system_time(ros, known, tmp_path):
    """By its stamps: on a busy machine some ticks are late or lost, none is one too many, none drifts."""
    ros.run("rosparam", "set", "use_sim_time", "false")  # a recorder waits for simulated time
    recorder = ros.record("-O", tmp_path / "out.bag", topics=("/odom",))
    answered(ros, known, 100, 20)
    ros.finish(recorder, signal.SIGINT)
    stamps = np.sort(odometry(tmp_path / "out.bag").stamp)
    ticks = (stamps - stamps[0]) / 1e7  # periods of 100 Hz since the first
    assert ticks[-1] > 200
    assert 0.5 * ticks[-1] < len(ticks) <= ticks[-1] + 2
    # prompt ticks are at multiples of the period: the phase that most of them share stays from half to half
    first, second = map(commonest_phase, np.array_split(ticks, 2))
    assert abs(np.mod(first - second + 0.5, 1.0) - 0.5) < 0.15


def commonest_phase(ticks):
    """Of a tick that has most others within 5 % of a period, whole periods apart or not."""
    apart = np.mod(ticks[:, None] - ticks + 0.5, 1.0) - 0.5
    return ticks[np.argmax((np.abs(apart) < 0.05).sum(axis=1))]


def test_a_live_session_hears_the_node(ros, played, known, trial, tmp_path):
    """`seatrial live` on `live_port`: its recording has the poses and commands of the bag, by their stamps."""
    port, page, out = free_port(), free_port(), tmp_path / "drive"
    session = subprocess.Popen(
        [sys.executable, "-m", "seatrial", "live", str(known), f"udp:{port}", "-o", str(out),
         "--port", str(page), "--no-browser", "--quiet"],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        shown(page, lambda _: True)
        with Run(ros, played, known, tmp_path / "out.bag", live_port=port):
            pass
        shown(page, lambda state: state["poses"] > 0.9 * len(trial.pose_stamps))
        session.send_signal(signal.SIGINT)
        complained, _ = session.communicate(timeout=PATIENCE)
    finally:
        session.kill()
        ros.run("rosparam", "delete", "/seatrial_odometry")
    assert str(out / "recording") in complained
    vehicle = seatrial.load_vehicle(out / "recording" / "vehicle.yaml")
    kept = seatrial.read(out / "recording", vehicle)
    sent = {
        s + BAG_EPOCH: row for s, row in zip(trial.pose_stamps.tolist(), trial.pose, strict=True)
    }
    assert set(kept.stamps.tolist()) <= set(sent)
    assert len(kept.stamps) > 0.9 * len(sent)
    of_bag = np.array([sent[stamp] for stamp in kept.stamps.tolist()])
    np.testing.assert_allclose(kept.raw[:, :2], of_bag[:, :2], atol=1e-6)
    assert len(kept.commands.stamps) > 0.9 * len(trial.command_stamps)
