# SPDX-License-Identifier: MIT
"""The report's words for numbers."""

from collections.abc import Callable, Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import SIGNIFICANT
from seatrial.report.evidence.runs import Run
from seatrial.util.format import shortened
from seatrial.util.frames import Array

GOOD_RATIO = 0.8  # above this share of the constant-velocity error an axis needs work
AT_FLOOR = 1.1  # an RMS below this many floors says no more about the model
UNITS = (("cm/s", 100.0), ("cm/s", 100.0), ("rad/s", 1.0))  # of errors, and what makes them
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
    """How well that predicts, by its error over that of 'velocity stays constant'."""
    return next((word for limit, word in _RATIO_WORDS if ratio <= limit), _RATIO_WORDS[-1][1])


def pooled(runs: Sequence[Run], pick: Callable[[Run], Array]) -> Array:
    """RMS (3,) over all predictions of some runs of a velocity difference (m, 3)."""
    return np.asarray(np.sqrt(np.mean(np.concatenate([pick(r) for r in runs]) ** 2, axis=0)))


def rms_and_ratio(runs: Sequence[Run]) -> tuple[Array, Array]:
    """RMS errors (3,) [m/s, m/s, rad/s] over some runs, and as shares of 'stays constant'."""
    rms = pooled(runs, lambda r: r.prediction.errors)
    still = pooled(runs, lambda r: r.prediction.measured - r.prediction.start)
    return rms, np.divide(rms, still, out=np.full(3, np.inf), where=still > 0)


def floors(runs: Sequence[Run]) -> Array:
    """RMS (3,) [m/s, m/s, rad/s] that a perfect model would score."""
    squares = [np.broadcast_to(r.prediction.floor**2, r.prediction.errors.shape) for r in runs]
    return np.asarray(np.sqrt(np.mean(np.concatenate(squares), axis=0)))


def foreseen(runs: Sequence[Run]) -> Array | None:
    """RMS (3,) [m/s, m/s, rad/s] that the model says of itself; None where it does not."""
    squares = [
        np.broadcast_to(r.prediction.foreseen**2, r.prediction.errors.shape)
        for r in runs
        if r.prediction.foreseen is not None
    ]
    if not squares or len(squares) < len(runs):
        return None
    return np.asarray(np.sqrt(np.mean(np.concatenate(squares), axis=0)))


def not_told_apart(model: Model) -> list[str]:
    """Coefficients within two standard errors of 0."""
    errors = model.standard_errors
    return [n for n, v in model.values.items() if abs(v) < SIGNIFICANT * errors[n]]


def names_of(runs: Sequence[Run]) -> str:
    """`S1, S2 and S3`; of many the first, and how many more."""
    return shortened([run.name for run in runs])
