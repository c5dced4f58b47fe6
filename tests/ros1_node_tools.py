# SPDX-License-Identifier: MIT
"""The nodes for ROS 1: built by catkin_make from an empty workspace, started, and what they published, out of a bag."""

import fcntl
import os
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from cpp_tools import clone_into, optimisation_option
from programs import printed
from ros1_tools import PARTS, Ros1
from rosbags.highlevel import AnyReader
from waiting import PATIENCE

import seatrial
from seatrial import _core

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "ros1"
CATKIN = Path("/usr/share/catkin/cmake/catkinConfig.cmake")
SYSTEM_PYTHON = "/usr/bin/python3"  # that ROS's packages are installed for
COMMAND = "catkin_make --pkg seatrial_core seatrial_odometry"  # as docs/ros.md has it
NODE = BUILD / "devel" / "lib" / "seatrial_odometry" / "odometry"
LATENCY, RELAY = NODE.parent / "latency", NODE.parent / "relay"  # what it is timed with
STANDS = "{header: {stamp: now, frame_id: map}, pose: {pose: {orientation: {w: 1}}%s}}"
GOAL = "{header: {frame_id: %s}, pose: {position: {x: 0.05}, orientation: {w: 1}}}"

needed = [
    pytest.mark.system,
    pytest.mark.skipif(
        not all(part.exists() for part in (*PARTS, CATKIN)),
        reason="Debian's ROS 1 is not installed",
    ),
]


def build(*, quick: bool = True) -> Path:
    """Nodes and what they are timed with; their folder. One process at a time. quick: to test them, not to time them."""
    BUILD.parent.mkdir(exist_ok=True)
    with (BUILD.parent / "ros1.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        _make(optimisation_option(quick=quick))
    return NODE.parent


def _make(option: str) -> None:
    clone_into(BUILD / "src" / "seatrial")
    options = [f"-DPYTHON_EXECUTABLE={SYSTEM_PYTHON}", "-DSEATRIAL_TESTING=ON"]
    # a header once, not five times
    options += ["-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=3", option]
    if shutil.which("ccache"):
        options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    environment = {**os.environ, "PATH": "/usr/bin:/bin"}
    for name in ("PYTHONPATH", "ROS_VERSION", "VIRTUAL_ENV"):
        environment.pop(name, None)
    command = [*COMMAND.split(), "-j2", "-C", str(BUILD), *options]
    printed(*command, cwd=BUILD, env=environment)


class Nodes(Ros1):
    """A private ROS 1 with this package's nodes."""

    def node(
        self,
        program: str,
        *,
        name: str | None = None,
        hears: str | None = None,
        **parameters: object,
    ) -> subprocess.Popen:
        """A node with parameters, that `name` renames; with `hears`, once it has subscribed to that topic."""
        own = [f"_{parameter}:={value}" for parameter, value in parameters.items()]
        if name is not None:
            own.append(f"__name:={name}")
        process = self.start(str(NODE.parent / program), *own)
        if hears is not None:
            node = f"/{name or f'seatrial_{program}'}"
            self.until(lambda: node in self.subscribers(hears), f"{node} to hear {hears}")
        return process

    def stands(self, topic: str, kind: str, extra: str = "") -> subprocess.Popen:
        """Poses or odometry of a boat that stands still at the origin, 20 a second."""
        return self.start("rostopic", "pub", "-s", "-r", "20", topic, kind, STANDS % extra)

    def goal(self, frame: str = "map") -> subprocess.Popen:
        """A goal 5 cm ahead of the origin."""
        return self.start("rostopic", "pub", "/goal", "geometry_msgs/PoseStamped", GOAL % frame)

    def complaint(self, program: str, *arguments: object) -> str:
        """What a node says of a mistake, in one line, before it ends with code 1."""
        process = self.start(str(NODE.parent / program), *arguments)
        code = process.wait(PATIENCE)
        process.stdin.close()
        said = process.said.read_text().strip()
        assert code == 1, (code, said)
        assert said.count("\n") == 0, said
        return said


@pytest.fixture(scope="module")
def nodes(tmp_path_factory) -> Iterator[Nodes]:
    """Built nodes in simulated time, of which nothing is left at the end: a fixture of modules that name it `ros`."""
    build()
    with Nodes(tmp_path_factory.mktemp("ros1")) as ros:
        ros.run("rosparam", "set", "use_sim_time", "true")
        yield ros
    assert ros.processes() == []


@dataclass(frozen=True)
class Published:
    """Odometry out of a bag, by its stamps, and where it was when."""

    arrival: np.ndarray  # (n,) [ns]
    stamp: np.ndarray  # (n,) [ns]
    pose: np.ndarray  # (n, 3) in odom
    velocity: np.ndarray  # (n, 3)
    spread: np.ndarray  # (n, 36) the twist's covariance


def stamp_of(header: object) -> int:
    """[ns]"""
    return header.stamp.sec * 10**9 + header.stamp.nanosec  # type: ignore[attr-defined]


def heading(q: object) -> float:
    """Of a turn about z."""
    return 2.0 * float(np.arctan2(q.z, q.w))  # type: ignore[attr-defined]


def messages(bag: Path, topic: str) -> list[tuple[int, object]]:
    """Arrival [ns] and message, in the order of arrival."""
    with AnyReader([bag]) as reader:
        links = [c for c in reader.connections if c.topic == topic]
        return [
            (arrival, reader.deserialize(raw, link.msgtype))
            for link, arrival, raw in reader.messages(connections=links)
        ]


def odometry(bag: Path) -> Published:
    """The topic /odom."""
    rows = []
    for arrival, m in messages(bag, "/odom"):
        p, v = m.pose.pose, m.twist.twist
        rows.append(
            (arrival, stamp_of(m.header), (p.position.x, p.position.y, heading(p.orientation)),
             (v.linear.x, v.linear.y, v.angular.z), m.twist.covariance)
        )  # fmt: skip
    arrival, stamp, pose, velocity, spread = zip(*rows, strict=True)
    return Published(*map(np.array, (arrival, stamp, pose, velocity, spread)))


def track(bag: Path, topic: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stamps (n,) [ns], poses (n, 3) without a jump of 2 pi, body velocities (n, 3): 0 of a topic that has none."""
    stamps, rows = [], []
    for _, m in messages(bag, topic):
        p, v = m.pose.pose, m.twist.twist if hasattr(m, "twist") else None
        motion = (v.linear.x, v.linear.y, v.angular.z) if v else (0.0, 0.0, 0.0)
        stamps.append(stamp_of(m.header))
        rows.append((p.position.x, p.position.y, heading(p.orientation), *motion))
    found = np.array(rows)
    found[:, 2] = np.unwrap(found[:, 2])
    return np.array(stamps), found[:, :3], found[:, 3:]


def plant_states(
    boat: seatrial.Model, pose: tuple[float, float, float], commands: list, t: np.ndarray
) -> np.ndarray:
    """The model itself at t [s] (n, 6), from rest at a pose: commands are times [s] and values, rising."""
    plant, coming = _core.Plant(boat.boat, boat.vehicle.chain, boat.constants), list(commands)
    plant.state = np.array([*pose, 0.0, 0.0, 0.0])
    states = []
    for now in t:
        while coming and coming[0][0] <= now:
            at, values = coming.pop(0)
            plant.advance_to(at)
            plant.command(at, np.ascontiguousarray(values))
        plant.advance_to(now)
        states.append(plant.state)
    return np.array(states)


def script(bag: Path, played: Path) -> list[str]:
    """What was played in lock-step as events for `ros/common/tests/script.cpp`, and a tick at every odometry."""
    events = []
    for arrival, m in messages(played, "/slam/pose"):
        p = m.pose
        numbers = f"{p.position.x!r} {p.position.y!r} {heading(p.orientation)!r}"
        events.append(
            (arrival, f"{arrival} pose {stamp_of(m.header)} {m.header.frame_id} {numbers}")
        )
    for arrival, m in messages(played, "/joy"):
        axes, buttons = (" ".join(repr(float(x)) for x in part) for part in (m.axes, m.buttons))
        stamp = stamp_of(m.header)
        events.append(
            (arrival, f"{arrival} numbers sensor_msgs/Joy /joy {stamp} {axes} | {buttons}")
        )
    for _, m in messages(bag, "/odom"):
        stamp = stamp_of(m.header)
        events.append((stamp, f"{stamp} tick"))
    return [line for _, line in sorted(events, key=lambda one: one[0])]
