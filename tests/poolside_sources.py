# SPDX-License-Identifier: MIT
"""What tests of a session's sources share: a vehicle, a table, events that a thread gathers."""

import os
import sys
import threading
from contextlib import contextmanager

import numpy as np
import pytest
from waiting import PATIENCE

from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.onboard.live.endpoints import Pipes
from seatrial.poolside.sources.lines import LineSource

VEHICLE = {
    "seatrial": "vehicle 1",
    "name": "boat",
    "axes": "forward-left-up",
    "pose": {"stamp": "t", "x": "x", "y": "y", "psi": {"column": "psi", "unit": "deg"}},
    "commands": {"stamp": "t", "inputs": {"F_u": "F_u", "F_v": "F_v", "F_r": "F_r"}},
    "structure": "mallard",
}


def vehicle(**changed) -> Vehicle:
    return vehicle_from({**VEHICLE, **changed}, "vehicle.yaml")


@pytest.fixture
def no_silence(monkeypatch):
    """A machine that stands still is no recorder that has stopped."""
    monkeypatch.setattr("seatrial.poolside.sources.follow_bag.SILENT", float("inf"))


def through_pipe(text: bytes, boat: Vehicle) -> tuple[list[object], tuple[str, ...]]:
    """The events of text on standard input, and what is said of it."""
    inlet, outlet = os.pipe()

    def write() -> None:
        with os.fdopen(outlet, "wb") as file:
            file.write(text)

    threading.Thread(target=write).start()
    with os.fdopen(inlet, "rb") as file:
        source = LineSource("-", boat, Pipes(file, sys.stdout.buffer))
        return list(source), source.problems


@contextmanager
def gathered(source):
    """A list that fills with the source's events; at the end it is closed."""
    found: list[object] = []
    thread = threading.Thread(target=lambda: found.extend(source))
    with source:
        thread.start()
        yield found
        source.close()
        thread.join(PATIENCE)
    assert not thread.is_alive()


def poses_of(events):
    return [e for e in events if e.kind == "pose"]


def table(path, rows=200, begin=0):
    t = begin + np.arange(rows) * 0.05
    cells = np.column_stack(
        [t, np.sin(t), np.cos(t), np.degrees(0.3 * t), np.sign(np.sin(3 * t)), 0.1 * t, 0 * t]
    )
    lines = [",".join(map(repr, row)) for row in cells.tolist()]
    path.write_text("t,x,y,psi,F_u,F_v,F_r\n" + "\n".join(lines) + "\n")
    return lines
