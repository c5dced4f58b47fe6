# SPDX-License-Identifier: MIT
"""The nodes for ROS 1, built by catkin_make from an empty workspace; what they published, out of a bag."""

import fcntl
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from cpp_tools import clone_into, optimisation_option
from rosbags.highlevel import AnyReader

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "ros1"
CATKIN = Path("/usr/share/catkin/cmake/catkinConfig.cmake")
SYSTEM_PYTHON = "/usr/bin/python3"  # that ROS's packages are installed for
COMMAND = "catkin_make --pkg seatrial_core seatrial_odometry"  # as docs/ros.md has it
NODE = BUILD / "devel" / "lib" / "seatrial_odometry" / "odometry"
LATENCY, RELAY = NODE.parent / "latency", NODE.parent / "relay"  # what it is timed with


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
    done = subprocess.run(
        command, cwd=BUILD, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]


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
