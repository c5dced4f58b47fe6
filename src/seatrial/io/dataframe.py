# SPDX-License-Identifier: MIT
"""Recordings from and to DataFrames of pandas. A frame is read as a CSV table of the same columns is."""

from typing import TYPE_CHECKING

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.io.assemble import assemble
from seatrial.io.tables.frame_table import FrameTable, pandas_for
from seatrial.io.tables.signals import TableSignals
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.recording.velocity import motion
from seatrial.util.arguments import expect
from seatrial.util.frames import POSE, POSE_UNITS, SPEED_UNITS, SYMBOLS, Array, Axes

if TYPE_CHECKING:
    from pandas import DataFrame

VALID, TIME = "valid", "t"


def recording_from(frame: "DataFrame", vehicle: Vehicle, name: str) -> Recording:
    """A recording of the columns that the vehicle file names. Raises RecordingError."""
    expect(vehicle, Vehicle, "vehicle")
    pandas_for(name)
    return assemble(TableSignals(FrameTable(frame, name), vehicle), vehicle, name)


def frame_of(recording: Recording, *, velocities: bool) -> "DataFrame":
    """A row a pose, forward-left-up, in SI; commands and scales as they hold at its stamp."""
    pd = pandas_for(recording.name)
    columns: dict[str, Array] = dict(zip(POSE, recording.eta.T, strict=True))
    units = dict(zip(POSE, POSE_UNITS, strict=True))
    if velocities:
        columns |= dict(zip(SYMBOLS, motion(recording).nu.T, strict=True))
        units |= dict(zip(SYMBOLS, SPEED_UNITS, strict=True))
    taken = {*columns, VALID, TIME}
    for kind, signal in (("command", recording.commands), ("scale", recording.scales)):
        if signal is None:
            continue
        for own, values in zip(signal.names, _held(signal, recording).T, strict=True):
            shown = f"{kind}.{own}" if own in taken else own
            taken.add(shown)
            columns[shown] = values
            units[shown] = "-"
    index = pd.Index(recording.t, name=TIME)
    frame = pd.DataFrame(columns | {VALID: recording.valid}, index=index, copy=True)
    frame.attrs = {
        "name": recording.name, "axes": Axes.FLU.value, "units": units | {TIME: "s"},
        "first_stamp_ns": recording.origin,
    }  # fmt: skip
    return frame


def _held(signal: Signal, recording: Recording) -> Array:
    """Values (poses, names) that hold at the stamps of the poses; NaN before the first."""
    row = np.searchsorted(signal.stamps, recording.stamps, side="right") - 1
    if not len(signal.stamps):
        return np.full((len(row), len(signal.names)), np.nan)
    return np.asarray(np.where(row[:, None] >= 0, signal.values[np.maximum(row, 0)], np.nan))
