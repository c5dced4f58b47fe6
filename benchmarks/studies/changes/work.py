# SPDX-License-Identifier: MIT
"""All drives of one seed: its model, each change, weather without a change, a hand."""

import time
from typing import Any

import numpy as np

from benchmarks.studies.changes.boats import CHANGES, Change, identified, unseen
from benchmarks.studies.changes.odometry import DropOutErrors, drop_out_errors
from benchmarks.studies.changes.weather import WEATHER, in_weather, with_hand
from seatrial.boat.model import Model
from seatrial.monitoring.change_detector import ChangeDetector
from seatrial.onboard.boat_change import BoatChange, ChangeState
from seatrial.recording.recording import Recording
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Mask

NANO = 1e9
FEWER = 4  # seeds from one with the further cases to the next
Record = dict[str, Any]


def one(seed: int) -> Record:
    """The record of a seed; the weather of its drive without a change is that of its number."""
    try:
        model = identified(seed)
    except SeatrialError as error:
        return {"failed": str(error)}
    before = drop_out_errors(unseen(None, seed), model)
    weather = list(WEATHER)[seed % len(WEATHER)]
    all_cases = seed % FEWER == 0
    record = {
        "before": _squares(before, np.ones(len(before.t), dtype=bool)),
        "changes": {
            name: _changed(change, model, seed)
            for name, change in CHANGES.items()
            if all_cases or not change.further
        },
        "weather": {"name": weather, **_unchanged(model, in_weather(weather, seed))},
    }
    return record | {"hand": _unchanged(model, with_hand(seed))} if all_cases else record


def findings(model: Model, recording: Recording, *, to_the_end: bool = False) -> list[BoatChange]:
    """What a detector reports along a recording, until a change is confirmed, or with the model again after it."""
    detector, signal = ChangeDetector(model), recording.commands
    rows = [(int(t), "command", v) for t, v in zip(signal.stamps, signal.values, strict=True)]
    rows += [(int(t), "pose", v) for t, v in zip(recording.stamps, recording.raw, strict=True)]
    found: list[BoatChange] = []
    for stamp, kind, values in sorted(rows, key=lambda row: row[:2]):
        detector.use(kind, stamp, values)
        change = detector.look() if kind == "pose" else None
        found += [] if change is None else [change]
        if change is not None and change.state is ChangeState.CONFIRMED:
            if not to_the_end:
                break
            detector.restart(model)
    return found


def _changed(change: Change, model: Model, seed: int) -> Record:
    trial = unseen(change.of, seed)
    recording = trial.recording
    found = findings(model, recording)
    noticed = [c for c in found if c.state is ChangeState.NOTICED]
    last = found[-1] if found and found[-1].state is ChangeState.CONFIRMED else None
    record: Record = {
        "noticed": (noticed[0].stamp - recording.origin) / NANO if noticed else None,
        "first": noticed[0].cause if noticed else None,
    }
    if last is None:
        return record
    at = (last.stamp - recording.origin) / NANO
    off, auto = drop_out_errors(trial, model), drop_out_errors(trial, model, last.model, at)
    return record | {
        "confirmed": at, "cause": last.cause, "what": last.what, "size": last.size, "error": last.error,
        "during": _squares(auto, auto.t < at),
        "after": _squares(auto, auto.t >= at),
        "off": _squares(off, off.t >= at),
    }  # fmt: skip


def _unchanged(model: Model, recording: Recording) -> Record:
    begin = time.process_time()
    found = findings(model, recording)
    return {
        "cpu": time.process_time() - begin,
        "seconds": recording.duration,
        "states": [c.state.value for c in found],
    }


def _squares(errors: DropOutErrors, of: Mask) -> list[float]:
    """Number, and sums of squares of position [m] and heading [rad]."""
    return [
        int(of.sum()),
        float(np.sum(errors.position[of] ** 2)),
        float(np.sum(errors.heading[of] ** 2)),
    ]
