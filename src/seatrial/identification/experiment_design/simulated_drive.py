# SPDX-License-Identifier: MIT
"""A drive that the model simulates, as a recording: from a state, by commands."""

from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array

DIVERGED_SPEED = 10.0  # [m/s, rad/s] a simulation beyond it diverges
BEFORE = 10.0  # [s] of released sticks before


@dataclass(frozen=True)
class SimulatedDrive:
    """States at the poses, and the recording with exact poses."""

    states: Array  # (n, 6) x, y, psi, u, v, r
    recording: Recording


def simulated_drive(
    model: Model,
    state: Array,
    sticks: tuple[Array, Array],
    times: Array,
    name: str = "simulated",
) -> SimulatedDrive:
    """From a state (6,) at times[0], by commands (m, inputs) from times (m,) [s] on; poses at times (n,) [s].

    Scales are at their reference. Raises ModelError where the model diverges.
    """
    t, commands = sticks
    vehicle = model.vehicle
    scales = np.array([[vehicle.file.scales[name].reference for name in vehicle.scales]])
    scales = scales.astype(float).reshape(1, len(vehicle.scales))
    begin = np.array([times[0] - BEFORE])
    t = np.concatenate([begin, t])
    commands = np.ascontiguousarray(np.vstack([np.zeros((1, commands.shape[1])), commands]))
    trace = _core.ThrustTrace(vehicle.chain, model.constants, t, commands, begin, scales)
    states, _ = _core.simulate(model.boat, trace, np.ascontiguousarray(state), times)
    if not np.isfinite(states).all() or np.abs(states[:, 3:]).max() > DIVERGED_SPEED:
        raise ModelError(f"{model.name}: the model diverges in a simulated drive")
    held = np.rint(1e9 * t).astype(np.int64)
    every = np.ones(len(times), dtype=bool)
    recording = Recording(
        name, np.rint(1e9 * times).astype(np.int64), states[:, :3], states[:, :3], every,
        np.zeros(len(times), dtype=np.int64), Signal(vehicle.inputs, held, commands),
        Signal(vehicle.scales, held[:1], scales) if vehicle.scales else None,
    )  # fmt: skip
    return SimulatedDrive(np.asarray(states), recording)
