# SPDX-License-Identifier: MIT
"""Drives through Hector mapping, with ROS 1: Hector, the odometry node, and a player in lock-step."""

import json
import signal
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.studies.slam.drives import Drive
from benchmarks.studies.slam.lidar import BEAMS, FARTHEST, FIELD, RATE, TIMES, Scan
from benchmarks.studies.slam.se2 import between, compose
from seatrial.util.frames import Array
from tests import hector_tools
from tests.ros1_node_tools import NODE
from tests.ros1_tools import Ros1

PLAYER = Path(__file__).parents[3] / "tests" / "ros1_player.py"
AXES = (1, 0, 3)  # of the joypad, by input of the vehicle
FIRST = float(TIMES[0])  # [s] of the first beam, which stamps a scan, from the one that looks ahead
SWEEP = float(TIMES[-1] - TIMES[0])  # [s]
LIDAR = {
    "angle_min": -0.5 * FIELD, "angle_max": 0.5 * FIELD, "angle_increment": FIELD / (BEAMS - 1),
    "time_increment": SWEEP / (BEAMS - 1), "scan_time": 1.0 / RATE, "range_min": 0.05,
    "range_max": FARTHEST,
}  # fmt: skip
LONGEST = 900.0  # [s] of this machine's time for a drive
PACE = 4.0  # simulated seconds in one, where simulated time does not wait


@dataclass(frozen=True)
class Start:
    """What Hector starts a match from: its last pose, the player's guess, or the node's odometry."""

    guess: str | None = None  # of the player: constant velocity, true motion
    # with the node, by: node, hector, relay (Hector's, kept current)
    map_to_odom: str | None = None
    model: str = "model"  # of the node

    @property
    def lock_step(self) -> bool:
        """Simulated time waits for Hector, but where Hector waits for simulated time."""
        return self.map_to_odom != "hector"

    @property
    def parameters(self) -> dict[str, object]:
        """Hector's."""
        own = self.map_to_odom in ("hector", "relay")
        return {
            "use_tf_pose_start_estimate": bool(self.guess or self.map_to_odom),
            "pub_map_odom_transform": own,
            "odom_frame": "odom" if own else "base_link",
            "map_pub_period": 10.0,
        }


@dataclass(frozen=True)
class Forced:
    """A start estimate that is replaced by a false one."""

    scan: int
    offset: tuple[float, float, float]  # [m], [m], [rad] from the last match


@dataclass(frozen=True)
class Found:
    """What Hector made of a drive, seen from the pose at the start."""

    t: Array  # (n,) [s] of the poses: the middle of their scans
    pose: Array  # (n, 3)
    start: Array  # (n, 3) what each match began from
    map_points: Array  # (m, 2) [m] centres of occupied cells


def play(
    ros: Ros1,
    start: Start,
    drive: Drive,
    scans: Sequence[Scan],
    models: Path,
    *,
    forced: Forced | None = None,
    bag: Path | None = None,
) -> Found:
    """A drive, in `models` those of the node. The first scan is of the boat at rest at the start.

    Into `bag`: Hector's poses, and the commands.
    """
    job = ros.folder / "job.json"
    job.write_text(json.dumps(_job(start, drive, scans, forced)))
    running = [hector_tools.start(ros, **start.parameters)]
    ros.until(lambda: hector_tools.NODE in ros.subscribers("/scan"), "hector")
    topics = ["/scan", "/tf", "/tf_static", "/clock", hector_tools.POSE, "/map"]
    if start.map_to_odom is not None:
        by_node = "true" if start.map_to_odom == "node" else "false"
        running.append(ros.start(
            str(NODE), f"_model:={models / start.model}.yaml", f"_pose_topic:={hector_tools.POSE}",
            f"_publish_map_to_odom:={by_node}",
        ))  # fmt: skip
        ros.until(lambda: "/seatrial_odometry" in ros.subscribers("/joy"), "odometry node")
        topics += ["/joy", "/odom"]
    player = ros.start("python3", PLAYER, job)
    ros.until(lambda: "/player" in ros.subscribers("/map"), "player")
    if bag is not None:
        running.append(ros.record("-O", bag, topics=(hector_tools.POSE, "/joy")))
    ros.until(lambda: all(map(ros.connected, topics)), "connections")
    player.communicate(b"go\n", timeout=LONGEST)
    if player.returncode:
        raise RuntimeError(f"player: {player.said.read_text()[-1000:]}")  # type: ignore[attr-defined]
    for process in reversed(running):
        if process.poll() is None:  # Hector may have ended in a lost drive
            ros.finish(process, signal.SIGINT)
    return _found(start, json.loads(job.with_suffix(".found.json").read_text()))


def _job(
    start: Start, drive: Drive, scans: Sequence[Scan], forced: Forced | None
) -> dict[str, Any]:
    """What the player plays."""
    axes = np.zeros((len(drive.command), 4))
    axes[:, AXES] = drive.command
    rows = zip(drive.command_sent.tolist(), drive.command_t.tolist(), axes.tolist(), strict=True)
    rest = drive.poses(np.zeros(1))[0]
    truth = between(rest, drive.poses(np.array([s.stamp for s in scans])))
    return {
        "guess": start.guess, "relay": start.map_to_odom == "relay",
        "lock_step": start.lock_step, "pace": PACE, "lidar": LIDAR, "commands": list(rows),
        "scans": [[s.end, s.stamp + FIRST, ranges(s)] for s in scans], "truth": truth.tolist(),
        "forced": forced and {"scan": forced.scan, "offset": forced.offset},
    }  # fmt: skip


def ranges(scan: Scan) -> list[float | None]:
    """Of all beams [m], to a millimetre; None: no return."""
    found: list[float | None] = [None] * BEAMS
    beams = np.rint((scan.t - scan.stamp - FIRST) / SWEEP * (BEAMS - 1)).astype(int)
    for beam, r in zip(beams.tolist(), np.hypot(*scan.points.T).tolist(), strict=True):
        found[beam] = round(r, 3)
    return found


def _found(start: Start, said: dict[str, Any]) -> Found:
    poses = np.array(said["poses"])
    grid = said["map"]
    index = np.array(grid["occupied"], dtype=int)
    cells = np.column_stack([index % grid["width"], index // grid["width"]])
    points = np.array(grid["origin"]) + grid["resolution"] * (cells + 0.5)
    starts = _starts(start, said, poses)
    known = np.isfinite(poses[1:]).all(axis=1)  # the first is of the rest before the drive
    return Found(poses[1:][known, 0] - FIRST, poses[1:][known, 1:], starts[known], points)


def _starts(start: Start, said: dict[str, Any], poses: Array) -> Array:
    """What each match began from (n, 3), for poses (n + 1, 4) with their times."""
    t, last = poses[1:, 0], poses[:-1, 1:]
    if start.guess is not None:
        return at(np.array(said["starts"]), t)
    if start.map_to_odom == "node":
        return at(np.array(said["map_pose"]), t)
    if start.map_to_odom == "relay":
        odom = np.array(said["odom"])
        return compose(last, between(at(odom, poses[:-1, 0]), at(odom, t)))
    return last


def at(rows: Array, t: Array) -> Array:
    """Poses (n, 3) at times (n,) [s], between rows (m, 4) of time and pose."""
    columns = [rows[:, 1], rows[:, 2], np.unwrap(rows[:, 3])]
    return np.column_stack([np.interp(t, rows[:, 0], column) for column in columns])
