# SPDX-License-Identifier: MIT
"""What the nodes of both ROS are driven by: S7, the model that they have, a reference between its messages."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from bag_tools import pose

import seatrial
from seatrial.control import Reference
from seatrial.simulation.plan import TrialEntry, load_plan
from seatrial.simulation.trials import Trial, simulate
from seatrial.util.frames import Array
from tests.boats.drives import model

CHANGE = {  # as `predict --live` answers to a node
    "state": "confirmed", "cause": "mass", "what": "mass", "probability": 0.97, "size": 0.2, "error": 0.03,
}  # fmt: skip
SETTLED, OVER = 4.0, 24.0  # [s] of the drive, between which it is compared
WORST = (0.003, 0.003, 0.01)  # [m/s, m/s, rad/s] RMS error of the velocity


def s7() -> Trial:
    """S7 by the noise that the model was identified at."""
    plan = load_plan("hard")
    jumps = msgspec.structs.replace(plan.pose.jumps, per_minute=0.0)
    plan = msgspec.structs.replace(
        plan, seed=77, pose=msgspec.structs.replace(plan.pose, jumps=jumps),
        trials={"S7": TrialEntry("courses", OVER + 1.0)},
    )  # fmt: skip
    return next(iter(simulate(plan, seatrial.load_vehicle("mallard-mp"))))


def save_model(folder: Path) -> Path:
    """The identified model's file."""
    path = folder / "model.yaml"
    seatrial.save(model("hard", 5), path)
    return path


def truth_at(trial: Trial, t: Array) -> Array:
    """(n, 6) at t [s]."""
    return np.column_stack([np.interp(t, trial.truth_t, column) for column in trial.truth.T])


def wrong(trial: Trial, t: Array, velocity: Array) -> Array:
    """RMS errors (3) of a velocity (n, 3) at t [s] between SETTLED and OVER."""
    late = (t > SETTLED) & (t < OVER)
    off = velocity[late] - truth_at(trial, t[late])[:, 3:]
    return np.sqrt(np.mean(off**2, axis=0))


def events(trial: Trial) -> Iterator[tuple[int, str, dict[str, Any], int]]:
    """Arrival [ns], topic, members of the message but for its header, stamp [ns]; of the mallard."""
    rows: list[tuple[int, str, dict[str, Any], int]] = []
    for arrival, stamp, (x, y, psi) in zip(
        trial.pose_arrival.tolist(), trial.pose_stamps.tolist(), trial.pose.tolist(), strict=True
    ):
        rows.append((arrival, "/slam/pose", {"pose": pose(x, y, psi)}, stamp))
    for arrival, stamp, (u, v, r) in zip(
        trial.command_arrival.tolist(), trial.command_stamps.tolist(), trial.command.tolist(),
        strict=True,
    ):  # fmt: skip
        rows.append((arrival, "/joy", {"axes": [v, u, 0.0, r], "buttons": []}, stamp))
    yield from sorted(rows, key=lambda row: row[0])


def turn(psi: float) -> Array:
    """From body to earth (3, 3)."""
    c, s = np.cos(psi), np.sin(psi)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def extrapolated(eta: Array, nu: Array, gained: Array, dt: float) -> Reference:
    """A reference dt [s] later with its body-fixed acceleration kept: `seatrial_ros/target.hpp`."""
    there = eta + dt * turn(eta[2] + 0.5 * dt * nu[2]) @ (nu + 0.5 * dt * gained)
    then = nu + dt * gained
    swing = then[2] * np.array([-then[1], then[0], 0.0])
    return Reference(there, turn(there[2]) @ then, turn(there[2]) @ (gained + swing))
