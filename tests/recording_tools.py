# SPDX-License-Identifier: MIT
"""Poses of a wander, and the faults that were found in them."""

from dataclasses import replace

import numpy as np

from seatrial.io.poses import of_origin, pose_columns
from seatrial.io.signals import scaled
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.recording.timing import Clock, describe

COMMANDS = Signal(("F_u", "F_v", "F_r"), np.array([0]), np.zeros((1, 3)))


def poses(n=600, rate=15.0, noise=0.0, seed=0, rest=0):
    """A smooth wander with turns, sampled at `rate` Hz; with a rest of so many poses on its way."""
    t = np.arange(n) / rate
    s = t
    if rest:
        goes = np.interp(
            np.arange(n),
            [n // 3, n // 3 + 15, n // 3 + 15 + rest, n // 3 + 30 + rest],
            [1, 0, 0, 1],
        )
        s = np.cumsum(goes) / rate
    eta = np.column_stack([0.8 * np.sin(0.3 * s), 0.5 * np.sin(0.5 * s + 1), 2.5 * np.sin(0.2 * s)])
    eta += noise * np.random.default_rng(seed).normal(size=eta.shape)
    return np.rint(t * 1e9).astype(np.int64), eta


def in_vehicle_terms(raw, vehicle):
    """Poses (n, 3) of the boat's origin, forward-left-up, from raw x, y and heading, as the vehicle file has them."""
    columns = pose_columns(vehicle)
    return of_origin(np.column_stack(list(map(scaled, raw.T, columns))), vehicle)


def turned(recording: Recording, *signs: float) -> Recording:
    """With commands times `signs`."""
    c = recording.commands
    return replace(recording, commands=Signal(c.names, c.stamps, c.values * signs))


def stamped(recording: Recording, later: float) -> Recording:
    """With stamps of its commands so much later [s]."""
    c = recording.commands
    return replace(recording, commands=Signal(c.names, c.stamps + round(later * 1e9), c.values))


def kinds(record):
    return {f.kind for f in record.faults}


def beside_poses(recording: Recording, period: float) -> Recording:
    """The recording as from one table, whose commands have rows `period` [s] apart and may be samples."""
    place = {"source": "run.csv", "kind": "table", "clock": Clock.COLUMN}
    streams = [
        describe("poses", stamps=recording.stamps, **place),
        describe("commands", stamps=recording.commands.stamps, **place),
    ]
    return replace(recording, streams=streams, command_period=period)
