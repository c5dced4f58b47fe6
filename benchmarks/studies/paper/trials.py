# SPDX-License-Identifier: MIT
"""Boats, trials and scores that all findings share."""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import msgspec
import numpy as np

import seatrial
from seatrial.boat.model import Model
from seatrial.boat.schema import DeadZone
from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.evaluation.prediction import predict
from seatrial.simulation.plan import PlanFile
from seatrial.simulation.trials import Trial
from seatrial.util.frames import SYMBOLS, Array
from tests.boats.plans import planned
from tests.boats.scenes import TRAINING

PAIRING = (("S4", "u"), ("S5", "v"), ("S6", "r"))  # Table III
ABOVE = 0.04  # of full command, F_os above the dead zone's edge: mallard-af has 0.12 for 0.08
HORIZON = 1.0  # [s]
FIRST = 5001  # seed
Trials = Mapping[str, Trial]


@lru_cache
def boat(allocation: str, edge: float = 0.08) -> Vehicle:
    """MallARD; under AF with F_os a little above the dead zone's edge."""
    vehicle = seatrial.load_vehicle(f"mallard-{allocation.lower()}")
    if allocation == "MP":
        return vehicle
    content = vehicle.to_mapping()
    content["allocation"] = {**content["allocation"], "F_os": round(edge + ABOVE, 6)}
    return vehicle_from(content, "mallard-af")


def changed(
    plan: PlanFile,
    *,
    edge: float | None = None,
    amplitude: tuple[float, float] | None = None,
    noise: tuple[float, float] | None = None,
) -> PlanFile:
    """The plan with another dead zone, sizes of the commands, or noise of the poses [m, rad]."""
    parts: dict[str, dict[str, Any]] = {}
    if edge is not None:
        (group,) = plan.plant.chain
        zone = DeadZone(edge, edge) if edge > 0 else None
        parts["plant"] = {"chain": [msgspec.structs.replace(group, dead_zone=zone)]}
    if amplitude is not None:
        parts["operator"] = {"amplitude": dict.fromkeys(plan.operator.amplitude, amplitude)}
    if noise is not None:
        parts["pose"] = {"position_noise": noise[0], "heading_noise": noise[1]}
    return planned(plan, **parts)


def identified(trials: Trials, vehicle: Vehicle, method: str) -> Model:
    """The model from S1 to S3."""
    return seatrial.identify([trials[n].recording for n in TRAINING], vehicle, method=method)


def measured_errors(model: Model, trial: Trial) -> Array:
    """Measured minus predicted (m, 3), 1 s ahead from the stencil's velocities, as in the paper."""
    return predict(model, trial.recording, HORIZON).errors


def true_error(model: Model, trial: Trial) -> list[float]:
    """RMS [m/s, m/s, rad/s] 1 s ahead of the true velocity, from true starts."""
    moving = replace(trial.true_motion, valid=trial.recording.valid)
    return rms(predict(model, trial.recording, HORIZON, velocities=moving).errors)


def rms(errors: Array) -> list[float]:
    """Of every column."""
    found: list[float] = np.sqrt(np.mean(errors**2, axis=0)).tolist()
    return found


def paired(model: Model, trials: Trials) -> list[float]:
    """RMS by Table III's pairing [m/s, m/s, rad/s]."""
    return [
        rms(measured_errors(model, trials[name]))[SYMBOLS.index(symbol)]
        for name, symbol in PAIRING
        if name in trials
    ]
