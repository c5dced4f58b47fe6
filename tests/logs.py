# SPDX-License-Identifier: MIT
"""Recordings for tests of `inspect` and `init`: one drive, written in whatever shape is asked for."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

import seatrial
from seatrial import _core
from seatrial.io.bags.write import BagTopic, write_bag
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model

EPOCH = 1_700_000_000 * 10**9  # [ns]
AXES_OF_JOY = (1, 0, 3)  # where F_u, F_v, F_r are in the joypad's axes, by the mallard's file
POSE, JOY = "/slam/pose", "/joy"


def nanoseconds(seconds):
    return np.rint(np.asarray(seconds) * 1e9).astype(np.int64) + EPOCH


@dataclass(frozen=True)
class Log:
    """What was sent when, and when it arrived [s]; forward-left-up."""

    pose_t: np.ndarray
    pose_arrival: np.ndarray
    pose: np.ndarray  # (n, 3)
    command_t: np.ndarray
    command_arrival: np.ndarray
    command: np.ndarray  # (m, 3) F_u, F_v, F_r

    def but(self, **changes):
        """The same with something changed."""
        return replace(self, **changes)

    def topics(self, pose_type="geometry_msgs/msg/PoseStamped", joy_type="sensor_msgs/msg/Joy"):
        """As a robot would send it."""
        prefix = {"PoseStamped": "pose.", "Odometry": "pose.pose.", "Pose": ""}[
            pose_type.rpartition("/")[2]
        ]
        columns = {
            f"{prefix}position.x": self.pose[:, 0], f"{prefix}position.y": self.pose[:, 1],
            f"{prefix}orientation.z": np.sin(self.pose[:, 2] / 2),
            f"{prefix}orientation.w": np.cos(self.pose[:, 2] / 2),
        }  # fmt: skip
        name = "axes" if joy_type.endswith("Joy") else "data"
        sticks = {f"{name}[{at}]": self.command[:, i] for i, at in enumerate(AXES_OF_JOY)}
        return [
            BagTopic(POSE, pose_type, nanoseconds(self.pose_arrival), nanoseconds(self.pose_t), columns),
            BagTopic(
                JOY, joy_type, nanoseconds(self.command_arrival), nanoseconds(self.command_t), sticks
            ),
        ]  # fmt: skip

    def write(self, path: Path, **types) -> Path:
        """As a bag."""
        return write_bag(path, self.topics(**types))


def wave(t, seed=0):
    """Sticks (n, 3) that move smoothly, to both sides and over all sizes."""
    phase = np.array([0.3, 1.1, 2.0]) + seed
    slow, fast = np.array([0.53, 0.71, 0.97]), np.array([1.31, 1.73, 1.13])
    t = np.asarray(t)[:, None]
    return 0.55 * np.sin(slow * t + phase) + 0.4 * np.sin(fast * t + 2 * phase)


def half(t, seed=0):
    """Sticks that never ask for more than the thrusters can."""
    return 0.6 * wave(t, seed)


@lru_cache(maxsize=8)
def drive(
    seconds: float = 90.0, *, rate: float = 15.0, joypad: float = 50.0, seed: int = 0,
    sticks: Callable = wave,
) -> Log:  # fmt: skip
    """A MallARD without dead zones, driven with sticks(t), seen by a good SLAM."""
    plan = load_plan("clean")
    model = plant_model(plan, seatrial.load_vehicle("mallard-mp").with_chain([]))
    model = model.with_vehicle(model.vehicle.with_chain([]))
    plant = _core.Plant(model.boat, model.vehicle.with_chain([]).chain, np.zeros(0))
    plant.state = np.zeros(6)
    rng = np.random.default_rng(seed)
    command_t = np.arange(0.0, seconds, 1 / joypad)
    command = sticks(command_t, seed)
    pose_t = np.arange(0.0, seconds, 1 / rate)
    pose = np.zeros((len(pose_t), 3))
    j = 0
    for t, stick in zip(command_t.tolist(), command, strict=True):
        while j < len(pose_t) and pose_t[j] < t:
            plant.advance_to(float(pose_t[j]))
            pose[j] = plant.state[:3]
            j += 1
        plant.advance_to(t)
        plant.command(t, np.ascontiguousarray(stick))
    for k in range(j, len(pose_t)):
        plant.advance_to(float(pose_t[k]))
        pose[k] = plant.state[:3]
    pose += rng.normal(size=pose.shape) * [0.0007, 0.0007, 0.003]
    return Log(
        pose_t, pose_t + 0.002 + rng.exponential(0.001, len(pose_t)), pose,
        command_t, command_t + 0.001 + rng.exponential(0.001, len(command_t)), command,
    )  # fmt: skip
