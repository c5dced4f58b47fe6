# SPDX-License-Identifier: MIT
"""Errors of the odometer at the end of intervals without poses."""

from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.onboard.odometer import Odometer
from seatrial.simulation.trials import Trial
from seatrial.util.frames import Array

CYCLE, WITHOUT = 6.0, 2.0  # [s] of poses and drop-out, of the drop-out at its end


@dataclass(frozen=True)
class DropOutErrors:
    """Of each drop-out, at its end."""

    t: Array  # (n,) [s] from the first pose
    position: Array  # (n,) [m]
    heading: Array  # (n,) [rad]


def drop_out_errors(
    trial: Trial, model: Model, changed: Model | None = None, at: float = np.inf
) -> DropOutErrors:
    """The odometer without poses for the last 2 s of every 6 s; `changed` replaces the model at `at` [s]."""
    odometer, recording = Odometer(model), trial.recording
    commands, truth = recording.commands, trial.truth[trial.arrived]
    rows = [
        *((int(t), 0, i) for i, t in enumerate(commands.stamps)),
        *((int(t), 1, i) for i, t in enumerate(recording.stamps)),
    ]
    found, dropped = [], False
    for stamp, kind, i in sorted(rows):
        if kind == 0:
            odometer.command(stamp, commands.values[i])
            continue
        t = float(recording.t[i])
        if changed is not None and t >= at:
            odometer.reload(changed)
            changed = None
        was, dropped = dropped, t % CYCLE >= CYCLE - WITHOUT
        if was and not dropped:
            off = truth[i, :3] - odometer.at(stamp).motion.pose
            turn = (off[2] + np.pi) % (2.0 * np.pi) - np.pi
            found.append((t, float(np.hypot(*off[:2])), abs(float(turn))))
        if not dropped:
            odometer.pose(stamp, recording.raw[i])
    return DropOutErrors(*np.array(found).reshape(-1, 3).T)
