# SPDX-License-Identifier: MIT
"""The work of one boat: drive, identify, compare with the truth."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.fleet.draw import draw
from seatrial.boat.findings import finding_text
from seatrial.boat.model import Model
from seatrial.identification.estimator import output_error
from seatrial.identification.selection.actuator_selection import CURVE_STAGES
from seatrial.identification.selection.actuator_stages import STAGES_SELECTED
from seatrial.util.errors import SeatrialError


@dataclass(frozen=True)
class Row:
    """The result of one boat."""

    seed: int
    off: dict[str, float]  # standard errors by name, of what was found
    missed: tuple[str, ...]  # stages that it has and that were not selected
    spurious: tuple[str, ...]  # and the other way round
    notes: tuple[str, ...]
    refused: str = ""


def in_errors(model: Model, truth: Mapping[str, float]) -> dict[str, float]:
    """What was found less the truth, in standard errors, of all that has one."""
    values = np.concatenate([model.coefficients, model.constants]).tolist()
    found, errors = dict(zip(model.parameters, values, strict=True)), model.standard_errors
    known = [n for n in found if n in truth and errors[n] > 0.0]
    return {n: (found[n] - truth[n]) / errors[n] for n in known}


def identified(seed: int) -> Row:
    """One boat, drawn, driven and found."""
    boat = draw(seed)
    vehicle, recordings = boat.trials()
    try:
        model = output_error(recordings, vehicle)
    except SeatrialError as error:
        return Row(seed, {}, (), (), (), str(error))
    found = model.parameters
    freed = set(CURVE_STAGES) - boat.chain.keys()
    return Row(
        seed,
        in_errors(model, boat.truth),
        tuple(n for n in CURVE_STAGES if n in boat.chain and n not in found),
        tuple(n for n in found if n not in boat.truth or n in freed),
        tuple(finding_text(f) for f in model.estimator.findings if f.kind not in STAGES_SELECTED),
    )
