# SPDX-License-Identifier: MIT
"""The result of `select`."""

from dataclasses import dataclass

from seatrial.boat.findings import Finding
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.selection.terms.cross_validation import Fold
from seatrial.identification.selection.terms.decisions import Row


@dataclass(frozen=True)
class Selection:
    """The chosen structure, with the tests behind it."""

    vehicle: Vehicle  # with the chosen terms; otherwise unchanged
    model: Model  # fitted to all recordings together
    rows: tuple[Row, ...]
    folds: tuple[Fold, ...]
    horizon: float  # [s] of the held-out prediction
    asked: tuple[Finding, ...] = ()  # to be looked at before any term
