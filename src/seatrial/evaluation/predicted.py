# SPDX-License-Identifier: MIT
"""What is predicted some time ahead, beside what was measured then."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from seatrial.evaluation.expected_error import Poses
from seatrial.util.frames import Array, Stamps


@dataclass(frozen=True, eq=False)
class Prediction:
    """Velocities predicted `horizon` ahead, at the instants of the prediction.

    stamps: (m,) [ns]
    t: (m,) the same in [s] from the recording's start
    nu: (m, 3) predicted [m/s, m/s, rad/s]
    measured: (m, 3) at the same instants
    start: (m, 3) velocity at the start: what "velocity stays constant" predicts
    begun: (m,) index of the pose that each starts from
    index: (m,) index of the pose that each belongs to
    steps: poses from the one to the other, median
    floor: (3,) RMS of a perfect model [m/s, m/s, rad/s]; 0 from true starts
    expected_rms: (3,) RMS that the model expects [m/s, m/s, rad/s]; None without process noise
    parameter_rms: (3,) its part by parameter errors
    variance: (m, 3) of `measured`, where that is smoothed
    """

    stamps: Stamps
    t: Array
    nu: Array
    measured: Array
    start: Array
    begun: Poses
    index: Poses
    steps: int
    floor: Array
    expected_rms: Array | None = None
    parameter_rms: Array | None = None
    variance: Array | None = None

    @property
    def errors(self) -> Array:
        """Measured minus predicted (m, 3), as in the paper."""
        return np.asarray(self.measured - self.nu)

    @property
    def squares(self) -> Array:
        """Squared errors (m, 3) [m^2/s^2, m^2/s^2, rad^2/s^2]; against a smoothed velocity their expectation.

        The smoothed velocity is the mean of the true one given all poses, so that its own error is
        uncorrelated with a prediction from poses: E (true - predicted)^2 = (smoothed - predicted)^2 + variance.
        """
        return self._expected_squares(self.nu)

    @property
    def constant_squares(self) -> Array:
        """The same if the velocity stays as at the start."""
        return self._expected_squares(self.start)

    @property
    def reference_error(self) -> Array | None:
        """RMS standard deviation (3,) of a smoothed velocity."""
        return None if self.variance is None else np.asarray(np.sqrt(self.variance.mean(axis=0)))

    def _expected_squares(self, predicted: Array) -> Array:
        squares = (self.measured - predicted) ** 2
        return np.asarray(squares if self.variance is None else squares + self.variance)
