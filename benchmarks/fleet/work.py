# SPDX-License-Identifier: MIT
"""The work of one boat: drive, identify, compare with the truth."""

from dataclasses import dataclass

import numpy as np

from benchmarks.fleet.draw import draw
from seatrial.boat.findings import finding_text
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


def identified(seed: int) -> Row:
    """One boat, drawn, driven and found."""
    boat = draw(seed)
    vehicle, recordings = boat.trials()
    try:
        model = output_error(recordings, vehicle)
    except SeatrialError as error:
        return Row(seed, {}, (), (), (), str(error))
    truth, errors = boat.truth, model.standard_errors
    values = np.concatenate([model.coefficients, model.constants])
    found = dict(zip(model.parameters, values.tolist(), strict=True))
    known = [n for n in found if n in truth and errors[n] > 0.0]
    return Row(
        seed,
        {n: (found[n] - truth[n]) / errors[n] for n in known},
        tuple(n for n in CURVE_STAGES if n in boat.chain and n not in found),
        tuple(n for n in found if n not in truth or (n in CURVE_STAGES and n not in boat.chain)),
        tuple(finding_text(f) for f in model.estimator.findings if f.kind not in STAGES_SELECTED),
    )
