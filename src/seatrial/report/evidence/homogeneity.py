# SPDX-License-Identifier: MIT
"""Whether recordings agree about the parameters: what each makes of them alone."""

from dataclasses import dataclass

import numpy as np

from seatrial.identification.uncertainty.parameter_verdict import TYPICAL_SIZES
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.util.distributions import chi2_sf, holm
from seatrial.util.frames import Array

ENOUGH = 0.35  # relative error from which on a recording says too little to be shown
SIGNIFICANT = 0.05


@dataclass(frozen=True)
class Row:
    """One parameter; shares of its value, or of what is typical of such a constant."""

    name: str
    shifts: tuple[float, ...]  # by recording: its own value less the model's
    errors: tuple[float, ...]  # standard errors; infinite: it says too little
    spread: float  # weighted RMS of the shifts around their mean; NaN below two recordings
    p: float | None  # that they differ by chance (Cochran's Q); None below two recordings


@dataclass(frozen=True)
class Repeat:
    """All parameters that were estimated."""

    recordings: tuple[str, ...]
    rows: tuple[Row, ...]
    unlike: tuple[str, ...]  # parameters that differ by more than chance, Holm's correction


def repeat(evidence: Evidence) -> Repeat | None:
    """What each recording alone makes of the parameters; None where that is not known."""
    point = evidence.point
    if point is None or not evidence.alone:
        return None
    steps = np.array([one.values - point.theta for one in evidence.alone])
    errors = np.array([one.errors for one in evidence.alone])
    rows = [
        _row(name, value, steps[:, k], errors[:, k])
        for k, (name, value) in enumerate(zip(point.names, point.theta.tolist(), strict=True))
    ]
    rows = [row for row in rows if np.isfinite(row.errors).any()]
    tested = [row for row in rows if row.p is not None]
    chance = holm([row.p or 0.0 for row in tested]).tolist() if tested else []
    unlike = tuple(r.name for r, p in zip(tested, chance, strict=True) if p < SIGNIFICANT)
    return Repeat(tuple(one.recording for one in evidence.alone), tuple(rows), unlike)


def _row(name: str, value: float, steps: Array, errors: Array) -> Row:
    size = max(abs(value), TYPICAL_SIZES.get(name.partition(".")[0], 0.0)) or 1.0
    shift, width = steps / size, errors / size
    told = np.isfinite(shift) & (width < ENOUGH) & (width > 0)
    shift, width = np.where(told, shift, np.nan), np.where(told, width, np.inf)
    spread, p = float("nan"), None
    if told.sum() > 1:
        weight = 1.0 / np.square(width[told])
        mean = float(np.sum(weight * shift[told]) / weight.sum())
        off = np.square(shift[told] - mean)
        spread = float(np.sqrt(np.sum(weight * off) / weight.sum()))
        p = float(chi2_sf(float(np.sum(weight * off)), int(told.sum()) - 1))
    return Row(name, tuple(shift.tolist()), tuple(width.tolist()), spread, p)
