# SPDX-License-Identifier: MIT
"""Difference of prediction errors between two estimates of one unchanged boat.

One of two estimates is always nearer to the boat, and long recordings show it without any change of
the boat. The parameter covariances of both models give the expected size of that difference.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.evaluation.comparison.parameters import Pair, View
from seatrial.evaluation.expected_error import Poses, parameter_sensitivities
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion
from seatrial.util.frames import Array
from seatrial.util.statistics import inverse_of

MOST_SENSITIVITIES = 2000  # predictions of a recording with sensitivities: more add no information


@dataclass(frozen=True)
class SameBoatErrors:
    """Parameter errors of both models (A's first), if both are of one boat, given their difference.

    Gaussian and independent a priori; conditioned on the observed difference they have `mean` (n,)
    and `covariance` (n, n). The first `size` are A's.
    """

    mean: Array
    covariance: Array
    size: int

    def difference(self, sensitivity_forms: tuple[Array, Array]) -> tuple[float, float]:
        """Mean and variance of A's mean squared prediction error minus B's.

        `forms` (p, p) of each: mean of s s' with the sensitivity s of a predicted velocity. A quadratic
        form of Gaussian errors (Mathai and Provost, Quadratic Forms in Random Variables, section 3.2b).
        """
        form = np.zeros_like(self.covariance)
        form[: self.size, : self.size] = sensitivity_forms[0]
        form[self.size :, self.size :] = -sensitivity_forms[1]
        through, along = form @ self.covariance, form @ self.mean
        mean = float(self.mean @ along + np.trace(through))
        variance = 2.0 * np.trace(through @ through) + 4.0 * along @ self.covariance @ along
        return mean, max(float(variance), 0.0)


def same_boat_errors(
    a: Model, b: Model, seen: tuple[View, View], found: Sequence[Pair]
) -> SameBoatErrors:
    """Conditional errors of two models, from the parameters that both have."""
    names = [pair.name for pair in found if pair.z is not None]
    size = len(a.covariance)
    whole = np.zeros((size + len(b.covariance),) * 2)
    whole[:size, :size], whole[size:, size:] = a.covariance, b.covariance
    if not names:
        return SameBoatErrors(np.zeros(len(whole)), whole, size)
    rows = [view.slopes[[list(view.values).index(n) for n in names]] for view in seen]
    apart = np.hstack([-rows[0], rows[1]])
    across = whole @ apart.T
    gain = across @ inverse_of(apart @ across)
    shift = np.array([seen[1].values[n] - seen[0].values[n] for n in names])
    return SameBoatErrors(gain @ shift, whole - gain @ across.T, size)


def sensitivity_forms(
    model: Model, recording: Recording, begin: Motion, start: Poses, end: Poses
) -> Array:
    """Mean of s s' (3, p, p), with the sensitivities s of u, v and r at the ends of predictions."""
    few = slice(None, None, max(1, len(start) // MOST_SENSITIVITIES))
    slopes = parameter_sensitivities(model, recording, begin, start[few], end[few])
    return np.asarray(np.einsum("nip,niq->ipq", slopes, slopes) / len(slopes))
