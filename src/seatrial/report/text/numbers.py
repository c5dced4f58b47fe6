# SPDX-License-Identifier: MIT
"""Numbers in the report: pooled errors, verdicts, lengths of time."""

from collections.abc import Callable, Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import SIGNIFICANT
from seatrial.evaluation.scores import GOOD_RATIO
from seatrial.report.evidence.runs import Run
from seatrial.util.format import shortened
from seatrial.util.frames import Array, Mask

AT_FLOOR = 1.1  # times the floor: with a smaller RMS the poses resolve no error of the model
TINY = 1e-12  # of a ratio, against a division by 0
VERY_GOOD_RATIO = 0.2
_RATIO_WORDS = (
    (VERY_GOOD_RATIO, "very well"),
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
    """Verdict on a ratio of errors: the model's over that of constant velocity, see `resolved_ratio`."""
    return next((word for limit, word in _RATIO_WORDS if ratio <= limit), _RATIO_WORDS[-1][1])


def pooled(runs: Sequence[Run], pick: Callable[[Run], Array]) -> Array:
    """RMS (3,) over all predictions of some runs, from squared velocity differences (m, 3)."""
    return np.asarray(np.sqrt(np.mean(np.concatenate([pick(r) for r in runs]), axis=0)))


def rms_and_ratio(runs: Sequence[Run]) -> tuple[Array, Array]:
    """RMS errors (3,) [m/s, m/s, rad/s] over some runs, and over those of constant velocity."""
    rms = pooled(runs, lambda r: r.prediction.squares)
    still = pooled(runs, lambda r: r.prediction.constant_squares)
    return rms, np.divide(rms, still, out=np.full(3, np.inf), where=still > 0)


def at_floor(runs: Sequence[Run]) -> Mask:
    """Axes (3,) whose error a perfect model would have, too: the poses resolve no error of the model."""
    resolved = np.hypot(floors(runs), reference_errors(runs))
    return np.asarray(rms_and_ratio(runs)[0] < AT_FLOOR * resolved)


def resolved_ratio(runs: Sequence[Run]) -> Array:
    """Excess of the error over the noise floor (3,), over that of constant velocity.

    0 at the floor; infinite where constant velocity is at the floor and the model is not.
    """
    rms, ratio = rms_and_ratio(runs)
    floor = floors(runs)
    own = np.where(at_floor(runs), 0.0, np.sqrt(np.maximum(rms**2 - floor**2, 0.0)))
    still = np.sqrt(np.maximum((rms / np.maximum(ratio, TINY)) ** 2 - floor**2, 0.0))
    return np.divide(own, still, out=np.where(own > 0.0, np.inf, 0.0), where=still > 0.0)


def floors(runs: Sequence[Run]) -> Array:
    """RMS (3,) [m/s, m/s, rad/s] of a perfect model."""
    return pooled(runs, lambda r: np.broadcast_to(r.prediction.floor**2, r.prediction.nu.shape))


def reference_errors(runs: Sequence[Run]) -> Array:
    """RMS standard error (3,) [m/s, m/s, rad/s] of smoothed references; 0 of others."""
    none = np.zeros(3)
    return pooled(
        runs, lambda r: none[None] if r.prediction.variance is None else r.prediction.variance
    )


def expected_rms(runs: Sequence[Run]) -> Array | None:
    """RMS (3,) [m/s, m/s, rad/s] that the model expects; None where it states no process noise."""
    squares = [
        np.broadcast_to(r.prediction.expected_rms**2, r.prediction.errors.shape)
        for r in runs
        if r.prediction.expected_rms is not None
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
