# SPDX-License-Identifier: MIT
"""Homogeneity across recordings: each recording's own estimate of the parameters."""

from dataclasses import dataclass

import numpy as np

from seatrial.identification.likelihood.parameters import typical_size
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.util.distributions import chi2_sf, holm
from seatrial.util.frames import Array

LARGEST_RELATIVE_ERROR = 0.35  # above it a recording's own estimate is not shown
HOMOGENEITY_LEVEL = 0.05  # of the test that recordings are equal, after Holm


@dataclass(frozen=True)
class Row:
    """One parameter; relative to its value, or to the typical size of such a constant."""

    name: str
    shifts: tuple[float, ...]  # by recording: its own value less the model's
    errors: tuple[float, ...]  # standard errors; infinite where the recording does not determine it
    spread: float  # weighted RMS of the shifts around their mean; NaN below two recordings
    p: float | None  # that they differ by chance (Cochran's Q); None below two recordings


@dataclass(frozen=True)
class Homogeneity:
    """All parameters that were estimated."""

    recordings: tuple[str, ...]
    rows: tuple[Row, ...]
    inhomogeneous: tuple[str, ...]  # parameters that differ significantly, Holm's correction


def homogeneity(evidence: Evidence) -> Homogeneity | None:
    """Each recording's own estimates; None where their information is not available."""
    point = evidence.point
    if point is None or not evidence.by_recording:
        return None
    steps = np.array([one.values - point.theta for one in evidence.by_recording])
    errors = np.array([one.errors for one in evidence.by_recording])
    rows = [
        _row(name, value, steps[:, k], errors[:, k])
        for k, (name, value) in enumerate(zip(point.names, point.theta.tolist(), strict=True))
    ]
    rows = [row for row in rows if np.isfinite(row.errors).any()]
    tested = [row for row in rows if row.p is not None]
    chance = holm([row.p or 0.0 for row in tested]).tolist() if tested else []
    inhomogeneous = tuple(
        r.name for r, p in zip(tested, chance, strict=True) if p < HOMOGENEITY_LEVEL
    )
    return Homogeneity(
        tuple(one.recording for one in evidence.by_recording), tuple(rows), inhomogeneous
    )


def _row(name: str, value: float, steps: Array, errors: Array) -> Row:
    size = max(abs(value), typical_size(name)) or 1.0
    shift, width = steps / size, errors / size
    shown = np.isfinite(shift) & (width < LARGEST_RELATIVE_ERROR) & (width > 0)
    shift, width = np.where(shown, shift, np.nan), np.where(shown, width, np.inf)
    spread, p = float("nan"), None
    if shown.sum() > 1:
        weight = 1.0 / np.square(width[shown])
        mean = float(np.sum(weight * shift[shown]) / weight.sum())
        off = np.square(shift[shown] - mean)
        spread = float(np.sqrt(np.sum(weight * off) / weight.sum()))
        p = float(chi2_sf(float(np.sum(weight * off)), int(shown.sum()) - 1))
    return Row(name, tuple(shift.tolist()), tuple(width.tolist()), spread, p)
