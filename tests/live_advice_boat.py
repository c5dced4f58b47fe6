# SPDX-License-Identifier: MIT
"""The paper's boat as a model whose parameters are known to given relative errors."""

from dataclasses import replace

import numpy as np
from conftest import in_coarse_steps

import seatrial
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import NOISE_START, noise_entry
from seatrial.boat.schema import ChainGroup, DeadZone, EnvelopeEntry
from seatrial.boat.vehicle import vehicle_from
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model

ENVELOPE = EnvelopeEntry(
    {"u": (-0.2, 0.2), "v": (-0.3, 0.3), "r": (-1.0, 1.0)},
    dict.fromkeys(("F_u", "F_v", "F_r"), (-1.0, 1.0)),
)


def known_boat(relative: float = 0.02, *, axes: str = "forward-left-up", **other: float) -> Model:
    """Every parameter to `relative` of its value, those of `other` (X, Y, N) to another part; a lag of 0.08 s."""
    plant = in_coarse_steps(
        plant_model(load_plan("paper-like"), seatrial.load_vehicle("mallard-mp"))
    )
    content = {**seatrial.load_vehicle("mallard-mp").to_mapping(), "axes": axes}
    vehicle = vehicle_from(content, "boat").with_chain(
        [ChainGroup(latency=0.0, lag=0.08, dead_zone=DeadZone(0.08, 0.08))]
    )
    names = (*plant.structure.coefficients, *vehicle.constants.names)
    values = np.concatenate([plant.coefficients, vehicle.constants.values])
    parts = np.array([other.get(name[0], relative) for name in names])
    constants = np.arange(len(names)) >= len(plant.coefficients)
    errors = np.where(constants, 0.001, parts * np.abs(values))
    return replace(
        plant, vehicle=vehicle, constants=vehicle.constants.values, covariance=np.diag(errors**2),
        envelope=ENVELOPE, noise=noise_entry(NOISE_START),
    )  # fmt: skip
