# SPDX-License-Identifier: MIT
"""What the paper left open: Eq. (17)'s delay, the floor of the score, whiteness k steps ahead."""

from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.studies.paper.trials import HORIZON, boat, rms
from seatrial.boat.model import Model
from seatrial.boat.schema import Integration, NoiseEntry
from seatrial.evaluation.prediction import predict
from seatrial.identification.methods import EquationErrorSettings, equation_error
from seatrial.recording.pose_noise import pose_noise
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.statistics import autocorrelation, white_band
from tests.boats.scenes import ALLOCATIONS, TRAINING, UNSEEN, driven

PLANS = ("paper-like", "hard")
LAGS = 60


def keys(seeds: range) -> list[tuple[Any, ...]]:
    """What is to be run."""
    return [(plan, a, seed) for seed in seeds for plan in PLANS for a in ALLOCATIONS]


def work(plan: str, allocation: str, seed: int) -> dict[str, Any]:
    """The coupling coefficients both ways; the true model's score, floor and autocorrelation."""
    vehicle = boat(allocation)
    trials = driven(plan, vehicle, seed, (*TRAINING, UNSEEN))
    known = [trials[name].recording for name in TRAINING]
    out: dict[str, Any] = {}
    for name, literal in (("simultaneous", False), ("literal", True)):
        found = equation_error(known, vehicle, settings=EquationErrorSettings(literal=literal))
        out[name] = [found.values["N_ud"], found.values["N_uu"]]
    last = predict(
        _perfect(plan, allocation, trials[UNSEEN].recording), trials[UNSEEN].recording, HORIZON
    )
    rho = autocorrelation(last.errors, last.index, LAGS)
    band = white_band(len(last.errors))
    out["rms"], out["floor"], out["steps"] = rms(last.errors), last.floor.tolist(), last.steps
    out["white"] = np.mean(np.abs(rho[1 : last.steps]) > band, axis=0).tolist()
    out["beyond"] = np.mean(np.abs(rho[last.steps :]) > band, axis=0).tolist()
    return out


def _perfect(plan: str, allocation: str, recording: Recording) -> Model:
    """The truth, with the noise that the recording's poses show."""
    truth = plant_model(load_plan(plan), boat(allocation))
    own = pose_noise(recording)
    return replace(
        truth,
        integration=Integration("runge-kutta", 1 / 60),
        noise=NoiseEntry(own.position, own.heading),
    )
