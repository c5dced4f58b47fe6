# SPDX-License-Identifier: MIT
"""Velocity predicted one second ahead by the model so far."""

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.poolside.state import PredictionState
from seatrial.util.frames import Array


class LivePrediction:
    """PLACEHOLDER until engine's."""

    def __init__(self, vehicle: Vehicle, model: Model | None = None) -> None:
        pass

    def use(self, kind: str, stamp: int, values: Array) -> None:
        pass

    def reload(self, model: Model) -> None:
        pass

    def states(self) -> tuple[PredictionState, ...]:
        return ()
