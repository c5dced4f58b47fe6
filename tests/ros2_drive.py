# SPDX-License-Identifier: MIT
"""S7 played over DDS to the odometry node of a real ROS 2, and what it published."""

import os
import signal
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from ros2_tools import Heard, Peer, Ros2, finish, header, said, spent, stamp_of, until
from ros_drive import events

from seatrial.simulation.trials import Trial

LISTENED = {
    "odom": "nav_msgs/msg/Odometry", "map_pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "tf": "tf2_msgs/msg/TFMessage", "diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}  # fmt: skip
PLAYED = {"/slam/pose": "geometry_msgs/msg/PoseStamped", "/joy": "sensor_msgs/msg/Joy"}


@dataclass
class Recorded:
    """What came from the node while S7 was played in real time."""

    begin: int  # [ns] the trial's time zero
    heard: dict[str, Heard] = field(default_factory=dict)
    answer: str = ""
    said: str = ""
    share: float = 0.0  # of a core

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


def play(ros: Ros2, peer: Peer, trial: Trial, model: Path, **parameters: object) -> Recorded:
    """In real time; the model is reloaded on the way, by service and by signal."""
    node = ros.node("odometry", model=model, publish_map_to_odom="true", rate=50, **parameters)
    heard = {topic: peer.listen(topic, kind) for topic, kind in LISTENED.items()}
    outlets = {topic: peer.publisher(topic, kind) for topic, kind in PLAYED.items()}
    until(lambda: all(o.connected() for o in outlets.values()), "the node hears both topics")
    found = Recorded(time.time_ns() + 200_000_000, heard)
    reload, before = None, spent(node.pid)
    for arrival, topic, values, stamp in events(trial):
        while (now := time.time_ns() - found.begin) < arrival:
            time.sleep(min(0.005, (arrival - now) * 1e-9))
        outlets[topic].publish({"header": header(found.begin + stamp), **values})
        for one in heard.values():
            one.take()
        if reload is None and arrival > 8_000_000_000:
            reload = ros.start("peer", "reload")
            os.kill(node.pid, signal.SIGHUP)
    found.share = (spent(node.pid) - before) / (1e-9 * (time.time_ns() - found.begin))
    assert reload is not None
    assert reload.wait(20.0) == 0, said(reload)
    found.answer = said(reload)
    finish(node)  # with exit code 0, as it was asked to
    for one in heard.values():
        one.take()
    found.said = said(node)
    return found
