# SPDX-License-Identifier: MIT
"""What `select` found."""

from dataclasses import dataclass

from seatrial.model import Model
from seatrial.select.folds import Fold
from seatrial.select.verdicts import Row
from seatrial.vehicle import Vehicle


@dataclass(frozen=True)
class Selection:
    """The chosen structure, and why."""

    vehicle: Vehicle  # with the chosen terms; all else as it was
    model: Model  # fitted to all recordings together
    rows: tuple[Row, ...]
    folds: tuple[Fold, ...]
    horizon: float  # [s] of the held-out prediction
    asked: tuple[str, ...] = ()  # effects that the data ask for, before any term
