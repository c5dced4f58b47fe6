# SPDX-License-Identifier: MIT
"""Covariance of the stencil's velocity errors, of one velocity and between two.

Stencils up to four poses apart share white pose errors. Gauss-Markov pose errors correlate stencils
over their whole memory; a derivative contains their change from pose to pose.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial.boat.schema import CorrelatedEntry, NoiseEntry
from seatrial.recording.pose_noise import (
    correlated_difference_ratio,
    pose_error_correlation,
    pose_noise,
    pose_noise_given_motion,
)
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import EVEN_WEIGHTS, STENCIL_CORRELATION, stencil_deviation
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array


@dataclass(frozen=True)
class StencilNoise:
    """Errors of the stencil's velocities on one recording, for given pose noise."""

    noise: NoiseEntry
    recording: Recording

    @classmethod
    def of(
        cls, recording: Recording, stated: NoiseEntry, moved: Array | None = None
    ) -> "StencilNoise":
        """The recording's own noise from fourth differences, without the motion `moved` (n, 3).

        They do not determine the correlated share, so that is as `stated` by the model. All is as
        stated where too few poses are in a row.
        """
        try:
            own = pose_noise(recording)
            own = own if moved is None else pose_noise_given_motion(recording, moved)
        except RecordingError:
            return cls(stated, recording)
        entry = stated.correlated
        if entry is None:
            return cls(own, recording)
        seen = correlated_difference_ratio(recording.period, entry)
        position, place = _split(own.position, stated.position, entry.position, seen)
        heading, turn = _split(own.heading, stated.heading, entry.heading, seen)
        together = CorrelatedEntry(place, turn, entry.memory, entry.period)
        return cls(NoiseEntry(position, heading, None, together), recording)

    @cached_property
    def _white(self) -> Array:
        return stencil_deviation(self.noise, self.recording) ** 2

    def covariance(self, steps: int) -> Array:
        """Covariance (3,) [m/s, m/s, rad/s]^2 of velocities `steps` poses apart; the variance at 0.

        The rotation of the boat in between is neglected.
        """
        shared = STENCIL_CORRELATION[steps] if steps < len(STENCIL_CORRELATION) else 0.0
        entry = self.noise.correlated
        if entry is None:
            return np.asarray(shared * self._white)
        period = self.recording.period
        places = np.arange(len(EVEN_WEIGHTS))
        apart = np.abs(steps + places[None, :] - places[:, None])
        correlation = pose_error_correlation(entry, period * apart)
        slope = EVEN_WEIGHTS @ correlation @ EVEN_WEIGHTS / period**2
        size = np.array([entry.position, entry.position, entry.heading])
        return np.asarray(shared * self._white + slope * size**2)


def _split(own: float, white: float, together: float, seen: float) -> tuple[float, float]:
    """White and correlated parts of a recording's `own` noise, in the stated proportion."""
    stated = float(np.hypot(white, seen * together))
    return (own / stated * white, own / stated * together) if stated > 0.0 else (own, 0.0)
