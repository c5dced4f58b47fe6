# SPDX-License-Identifier: MIT
"""The term that a given structure lacks most: score tests of the physical library in one filter pass."""

import math
from functools import partial

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.physical_library import library_tiers
from seatrial.boat.structure import Term
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.identification.likelihood.whiteness import without_process_noise
from seatrial.identification.selection.significance import enough_blocks, estimate
from seatrial.identification.selection.terms.block_prediction import BlockPrediction
from seatrial.identification.selection.terms.candidates import aliases, new_to
from seatrial.identification.selection.terms.stepwise import (
    candidate_information,
    predicted,
    room_for,
    significant,
)
from seatrial.identification.selection.terms.term_fit import term_fit_of
from seatrial.identification.solution import Fit
from seatrial.util.frames import AXES

MOST_TRIED = 6  # of the significant terms: their predictions are compared
LEAST_PREDICTION_GAIN = 0.01  # of the RMS error one second ahead: less is not worth a line


def missing_term_findings(found: Fit) -> list[Finding]:
    """The significant term that improves prediction most, if it does by enough; coefficients are not refitted.

    None where no process noise shows that anything is missing, and for fits with a prior or with effects.
    """
    if found.problem.prior is not None or found.problem.has_effects:
        return []
    fit = term_fit_of(found)
    recordings = fit.problem.recordings
    if without_process_noise(fit.at) or not enough_blocks(recordings, len(fit.problem.free) + 1):
        return []
    # Holm's test of all terms that the structure lacks
    tried = _lacking(fit.problem.vehicle)
    if not tried or not room_for(fit.terms):
        return []
    looked = dict(candidate_information(fit, tried))
    tested = {t: estimate(s, str(t.coefficient)) for t, s in looked.items()}
    best = significant(tested, len(tried))[:MOST_TRIED]
    if not best:
        return []
    # the one that predicts left-out blocks best
    blocks = partial(BlockPrediction.of, fit.model(), fit.problem, DEFAULT_HORIZON)
    gains = predicted(fit, {t: looked[t] for t in best}, blocks)
    most = max(best, key=lambda t: gains[t][0].log)
    gain, ratios = gains[most]
    ratio = ratios[most.axis]
    if not gain.clear or not ratio < 1.0 - LEAST_PREDICTION_GAIN:
        return []
    errors = abs(tested[most].z)
    product = most.text().partition(" * ")[2]
    return [
        finding_of(
            FindingKind.MISSING_TERM, AXES[most.axis], product,
            errors=float(errors), improvement=float(1.0 - ratio),
        )
    ] if math.isfinite(errors) else []  # fmt: skip


def _lacking(vehicle: Vehicle) -> list[Term]:
    """Terms of the library that are not in the structure, nor combinations of its terms."""
    tiers = library_tiers(vehicle.forces, explicit=bool(vehicle.file.forces))
    tried = new_to(vehicle.structure, [term for tier in tiers for term in tier])
    hidden = {a.coefficient for a in aliases(vehicle.structure.terms, tried, vehicle.forces)}
    return [t for t in tried if t.coefficient not in hidden]
