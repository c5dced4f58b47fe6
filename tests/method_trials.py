# SPDX-License-Identifier: MIT
"""Simulated S1-S3 for the tests of the methods."""

from functools import cache

import numpy as np

import seatrial
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import PlanFile, load_plan, with_seed
from seatrial.simulation.trials import plant_model
from tests.boats.plans import driven_by, planned

PULSES = ("S1", "S2", "S3")


def pulses_of(plan: PlanFile, vehicle: seatrial.Vehicle, seconds: float = 200.0) -> list[Recording]:
    """S1-S3 of a plan."""
    return driven_by(planned(plan, *PULSES, seconds=seconds), vehicle)


@cache
def driven(plan: str, vehicle: str, seed: int) -> tuple[seatrial.Vehicle, tuple[Recording, ...]]:
    """The vehicle and its three recordings, of 150 s."""
    boat = seatrial.load_vehicle(vehicle)
    return boat, tuple(pulses_of(with_seed(load_plan(plan), seed), boat, 150.0))


def truth(plan: str, vehicle: str) -> dict[str, float]:
    """True coefficients; under always-forward thrust the gain past the edge of 0.08."""
    found = plant_model(load_plan(plan), seatrial.load_vehicle(vehicle)).values
    gain = 1 / 0.92 if vehicle.endswith("af") else 1.0
    return {n: v * gain if n.endswith("_F") else v for n, v in found.items()}


def changed(recording: Recording, eta, stamps=None) -> Recording:
    """The same recording with other poses."""
    kept = recording.stamps if stamps is None else stamps
    return make_recording(recording.name, kept, np.asarray(eta), recording.commands)
