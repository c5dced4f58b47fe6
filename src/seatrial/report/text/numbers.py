# SPDX-License-Identifier: MIT
"""Numbers in the report: pooled errors, verdicts, lengths of time."""

from collections.abc import Callable, Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import SIGNIFICANT
from seatrial.report.evidence.runs import Run
from seatrial.util.format import shortened
from seatrial.util.frames import Array

GOOD_RATIO = 0.8  # RMS over constant velocity's: above it an axis gets advice
AT_FLOOR = 1.1  # times the floor: a smaller RMS does not measure the model
# of errors, and the factor from SI
ERROR_UNITS = (("cm/s", 100.0), ("cm/s", 100.0), ("rad/s", 1.0))
_RATIO_WORDS = (
    (0.2, "very well"),
    (0.5, "well"),
    (GOOD_RATIO, "fairly"),
    (0.95, "hardly better than no model"),
    (1.05, "no better than no model"),
    (np.inf, "worse than no model"),
)


def minutes(seconds: float) -> str:
    """A length of time in the unit that suits it."""
    return f"{seconds / 60:.1f} min" if seconds >= 90 else f"{seconds:.0f} s"


def ratio_word(ratio: float) -> str:
    """Verdict on a ratio: RMS error over that of constant velocity."""
    return next((word for limit, word in _RATIO_WORDS if ratio <= limit), _RATIO_WORDS[-1][1])


def pooled(runs: Sequence[Run], pick: Callable[[Run], Array]) -> Array:
    """RMS (3,) over all predictions of some runs of a velocity difference (m, 3)."""
    return np.asarray(np.sqrt(np.mean(np.concatenate([pick(r) for r in runs]) ** 2, axis=0)))


def rms_and_ratio(runs: Sequence[Run]) -> tuple[Array, Array]:
    """RMS errors (3,) [m/s, m/s, rad/s] over some runs, and over those of constant velocity."""
    rms = pooled(runs, lambda r: r.prediction.errors)
    still = pooled(runs, lambda r: r.prediction.measured - r.prediction.start)
    return rms, np.divide(rms, still, out=np.full(3, np.inf), where=still > 0)


def floors(runs: Sequence[Run]) -> Array:
    """RMS (3,) [m/s, m/s, rad/s] of a perfect model."""
    squares = [np.broadcast_to(r.prediction.floor**2, r.prediction.errors.shape) for r in runs]
    return np.asarray(np.sqrt(np.mean(np.concatenate(squares), axis=0)))


def expected_rms(runs: Sequence[Run]) -> Array | None:
    """RMS (3,) [m/s, m/s, rad/s] that the model expects; None where it states no process noise."""
    squares = [
        np.broadcast_to(r.prediction.foreseen**2, r.prediction.errors.shape)
        for r in runs
        if r.prediction.foreseen is not None
    ]
    if not squares or len(squares) < len(runs):
        return None
    return np.asarray(np.sqrt(np.mean(np.concatenate(squares), axis=0)))


def insignificant(model: Model) -> list[str]:
    """Coefficients within two standard errors of 0."""
    errors = model.standard_errors
    return [n for n, v in model.values.items() if abs(v) < SIGNIFICANT * errors[n]]


def names_of(runs: Sequence[Run]) -> str:
    """`S1, S2 and S3`; of many the first, and the number of the others."""
    return shortened([run.name for run in runs])
