# SPDX-License-Identifier: MIT
"""Drive in X_b, let go, drift: the yaw that follows, with N_ud and N_uu in the model and without."""

from dataclasses import replace
from typing import Any

import msgspec
import numpy as np

from benchmarks.studies.paper.trials import boat
from seatrial import _core, identify
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.from_poses import make_recording
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from tests.boats.scenes import TRAINING, driven

LEVELS = (0.3, 0.6, 1.0)  # of full command
PUSH, DRIFT = 2.0, 3.0  # [s]
RATE = 15.0  # [Hz]
LEFT_OUT = {"both": (), "no N_ud": ("N_ud",), "no N_uu": ("N_uu",), "neither": ("N_ud", "N_uu")}
PLANS = ("paper-like", "hard")


def keys(seeds: range) -> list[tuple[Any, ...]]:
    """What is to be run."""
    return [(plan, seed) for seed in seeds for plan in PLANS]


def without(vehicle: Vehicle, names: tuple[str, ...]) -> Vehicle:
    """The vehicle without these terms."""
    lines = {
        axis: [t for t in terms if not any(t.startswith(f"{n} ") for n in names)]
        for axis, terms in vehicle.structure.lines().items()
    }
    return replace_structure(vehicle, lines)


def replace_structure(vehicle: Vehicle, lines: dict[str, list[str]]) -> Vehicle:
    """The vehicle with another structure, as its file would have it."""
    return replace(vehicle, file=msgspec.structs.replace(vehicle.file, structure=lines))


def turned(model: Model, level: float) -> list[float]:
    """Heading [deg] after the push and after the drift, from rest."""
    stamps = np.rint(np.arange(round((PUSH + DRIFT) * RATE) + 1) / RATE * 1e9).astype(np.int64)
    sticks = np.zeros((len(stamps), 3))
    sticks[stamps < PUSH * 1e9, 0] = level
    record = make_recording(
        "push", stamps, np.zeros((len(stamps), 3)), Signal(("F_u", "F_v", "F_r"), stamps, sticks)
    )
    x, _ = _core.simulate(model.boat, model.trace(record), np.zeros(6), record.t)
    psi = np.degrees(x[:, 2])
    return [float(psi[round(PUSH * RATE)]), float(psi[-1])]


def work(plan: str, seed: int) -> dict[str, Any]:
    """Headings of the true boat and of four models of it."""
    vehicle = boat("AF")
    trials = driven(plan, vehicle, seed, TRAINING)
    truth = plant_model(load_plan(plan), vehicle)
    out: dict[str, Any] = {"truth": [turned(truth, level) for level in LEVELS]}
    for name, left_out in LEFT_OUT.items():
        model = identify([t.recording for t in trials.values()], without(vehicle, left_out))
        out[name] = [turned(model, level) for level in LEVELS]
    return out
