# SPDX-License-Identifier: MIT
"""How far two estimates of one boat predict apart.

One of the two is always nearer to the boat than the other, by luck; recordings that are long enough show it,
and the boat has not changed for that. What both models say of their own errors says how much is luck.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.evaluation.comparison.parameters import Pair, View
from seatrial.evaluation.expected_error import Poses, slopes_of
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion
from seatrial.util.frames import Array
from seatrial.util.statistics import inverse_of

MOST = 2000  # predictions of a recording whose slopes are taken: more say nothing that is new


@dataclass(frozen=True)
class Luck:
    """Errors of both models' parameters, A's before B's, were both of one boat: what was found given.

    Both are Gaussian, independent before their difference is seen; that they differ by what they do
    leaves them `mean` (n,) and `covariance` (n, n). Of A are the first `size`.
    """

    mean: Array
    covariance: Array
    size: int

    def difference(self, forms: tuple[Array, Array]) -> tuple[float, float]:
        """Mean and variance of the mean squared error of A's prediction less that of B's.

        `forms` (p, p) of each: the mean of slope slope' of a predicted velocity. A quadratic form of
        Gaussian errors (Mathai and Provost, Quadratic Forms in Random Variables, section 3.2b).
        """
        form = np.zeros_like(self.covariance)
        form[: self.size, : self.size] = forms[0]
        form[self.size :, self.size :] = -forms[1]
        through, along = form @ self.covariance, form @ self.mean
        mean = float(self.mean @ along + np.trace(through))
        variance = 2.0 * np.trace(through @ through) + 4.0 * along @ self.covariance @ along
        return mean, max(float(variance), 0.0)


def luck(a: Model, b: Model, seen: tuple[View, View], found: Sequence[Pair]) -> Luck:
    """Of two models, by the parameters that both have."""
    names = [pair.name for pair in found if pair.z is not None]
    size = len(a.covariance)
    whole = np.zeros((size + len(b.covariance),) * 2)
    whole[:size, :size], whole[size:, size:] = a.covariance, b.covariance
    if not names:
        return Luck(np.zeros(len(whole)), whole, size)
    rows = [view.slopes[[list(view.values).index(n) for n in names]] for view in seen]
    apart = np.hstack([-rows[0], rows[1]])
    across = whole @ apart.T
    gain = across @ inverse_of(apart @ across)
    shift = np.array([seen[1].values[n] - seen[0].values[n] for n in names])
    return Luck(gain @ shift, whole - gain @ across.T, size)


def forms(model: Model, recording: Recording, begin: Motion, start: Poses, end: Poses) -> Array:
    """Mean of slope slope' (3, p, p) of u, v and r at the ends of stretches, by the model's parameters."""
    few = slice(None, None, max(1, len(start) // MOST))
    slopes = slopes_of(model, recording, begin, start[few], end[few])
    return np.asarray(np.einsum("nip,niq->ipq", slopes, slopes) / len(slopes))
