# SPDX-License-Identifier: MIT
"""Whether the thrust gains of two models are of curves with the same stages."""

import numpy as np

from seatrial.boat.actuators import CURVE, STAGES
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle

EDGES = ("edge_forward", "edge_reverse")
LEAST_GAIN_CHANGE = 0.01  # by a stage of the curve that one model lacks, for gains to be apart


def stages_apart(a: Model, b: Model, edges_converted: bool) -> list[str]:
    """Stages of the thrust curve that only one of the two has, where they change the gain.

    A curve's gain is the thrust at full command, a straight line's an average over the commands.
    """
    only = _curve(a.vehicle) ^ _curve(b.vehicle)
    if edges_converted:
        only -= {*EDGES}
    gains = [straight_gain(model, only) for model in (a, b)]
    apart = "table" in only or bool(abs(np.log(gains[0] / gains[1])) > LEAST_GAIN_CHANGE)
    return sorted(only) if apart else []


def _curve(vehicle: Vehicle) -> set[str]:
    index = vehicle.constants.index
    found = {stage for stage in CURVE if np.any(index[:, STAGES.index(stage)] >= 0)}
    tables = any(group.table or group.pair for group in vehicle.file.chain)
    return found | {"table"} if tables else found


def straight_gain(model: Model, stages: set[str]) -> float:
    """Gain of the line through 0 nearest to these stages of the curve, mean over the actuators."""
    constants = model.vehicle.constants
    held = {"edge_forward": 0.0, "edge_reverse": 0.0, "reverse_ratio": 1.0, "power": 1.0}
    own = stages & _curve(model.vehicle)
    edge_forward, edge_reverse, ratio, power = (
        np.where(
            constants.index[:, STAGES.index(stage)] >= 0,
            constants.of_each(stage, model.constants),
            neutral,
        )
        if stage in own
        else np.full(len(constants.index), neutral)
        for stage, neutral in held.items()
    )
    command = np.linspace(0.0, 1.0, 101)[:, None]
    sides = [
        k * np.clip((command - edge) / (1.0 - edge), 0.0, 1.0) ** power
        for edge, k in ((edge_forward, 1.0), (edge_reverse, ratio))
    ]
    return float(np.mean(np.sum(command * (sides[0] + sides[1]) / 2.0, 0) / np.sum(command**2)))
