# SPDX-License-Identifier: MIT
"""S7 played over DDS to the odometry node of a real ROS 2, and what it published."""

import os
import signal
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from ros2_tools import Heard, Peer, Publisher, Ros2, finish, header, said, stamp_of
from ros_drive import events
from waiting import PATIENCE, until

from seatrial.simulation.trials import Trial

LISTENED = {
    "odom": "nav_msgs/msg/Odometry", "map_pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "tf": "tf2_msgs/msg/TFMessage", "diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}  # fmt: skip
RATE = 50  # [Hz]
TICK = 10**9 // RATE  # [ns]
REPEAT, REPEATS = 0.02, 1000  # [s] after which a time is said again, at most so often
PLAYED = {"/slam/pose": "geometry_msgs/msg/PoseStamped", "/joy": "sensor_msgs/msg/Joy"}


@dataclass
class Recorded:
    """What came from the node while S7 was played."""

    begin: int  # [ns] the trial's time zero
    heard: dict[str, Heard] = field(default_factory=dict)
    answer: str = ""
    said: str = ""

    def odometry(self) -> tuple[Any, Any, Any]:
        """Stamps [s] since the trial's begin, poses (n, 3) in odom, velocities (n, 3)."""
        rows = []
        for m in self.heard["odom"].messages:
            p, q, v = m.pose.pose.position, m.pose.pose.orientation, m.twist.twist
            rows.append(
                ((stamp_of(m) - self.begin) * 1e-9, p.x, p.y, 2 * np.arctan2(q.z, q.w),
                 v.linear.x, v.linear.y, v.angular.z)
            )  # fmt: skip
        found = np.array(rows)
        return found[:, 0], found[:, 1:4], found[:, 4:]


def connected(peer: Peer) -> dict[str, Publisher]:
    """Publishers of what is played, by topic, once a node hears them all."""
    outlets = {topic: peer.publisher(topic, kind) for topic, kind in PLAYED.items()}
    until(lambda: all(o.connected() for o in outlets.values()), "a node hears all that is played")
    return outlets


def play(ros: Ros2, peer: Peer, trial: Trial, model: Path, **parameters: object) -> Recorded:
    """By a simulated clock that waits for the node; the model is reloaded on the way, by service and by signal."""
    node = ros.node(
        "odometry", model=model, publish_map_to_odom="true", rate=RATE, use_sim_time="true", **parameters
    )  # fmt: skip
    heard = {topic: peer.listen(topic, kind) for topic, kind in LISTENED.items()}
    clock = peer.publisher("/clock", "rosgraph_msgs/msg/Clock")
    outlets = connected(peer)
    until(clock.connected, "the node hears the clock")
    found, reload, now = Recorded(time.time_ns(), heard), None, 0
    for arrival, topic, values, stamp in events(trial):
        # the clock's next tick is that of the node's timer: its odometry is waited for
        while now + TICK <= arrival:
            now += TICK
            _tick(clock, found.begin + now, heard)
        outlets[topic].publish({"header": header(found.begin + stamp), **values})
        if reload is None and arrival > 8_000_000_000:
            reload = ros.start("peer", "reload")
            os.kill(node.pid, signal.SIGHUP)
    assert reload is not None
    assert reload.wait(PATIENCE) == 0, said(reload)
    found.answer = said(reload)
    until(lambda: said(node).count(": reloaded") == 2, "reloaded by service and by signal")
    # a diagnosis comes once a second of the wall's clock, which the drive runs ahead of: the second from here has it all
    diagnoses = heard["diagnostics"]
    diagnoses.take()
    enough = len(diagnoses.messages) + 2
    until(lambda: diagnoses.take() is not None and len(diagnoses.messages) >= enough, "a diagnosis")
    finish(node)  # with exit code 0, as it was asked to
    for one in heard.values():
        one.take()
    found.said = said(node)
    return found


def _tick(clock: Publisher, now: int, heard: dict[str, Heard]) -> None:
    """Set the clock; then wait for the odometry of this time, once there is some."""
    time.sleep(0.001)  # the node takes what was published before
    sec, nanosec = divmod(now, 10**9)
    for one in heard.values():
        one.take()
    # a node's clock hears as sensors are heard: what is lost is not sent again
    for _ in range(REPEATS if heard["odom"].messages else 1):
        clock.publish({"clock": {"sec": sec, "nanosec": nanosec}})
        end = time.monotonic() + REPEAT
        while time.monotonic() < end:
            if heard["odom"].take() and stamp_of(heard["odom"].messages[-1]) >= now:
                return
            time.sleep(0.001)
