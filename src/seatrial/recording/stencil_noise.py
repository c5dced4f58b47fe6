# SPDX-License-Identifier: MIT
"""How noisy the stencil's velocities are, and what two of them have in common.

White errors of the poses are shared by stencils up to four poses apart; errors that are correlated by
all that their memory reaches. Of these a derivative sees what they change from pose to pose.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial.boat.schema import CorrelatedEntry, NoiseEntry
from seatrial.recording.pose_noise import coloured_ratio, left_of, noise_beside, pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import EVEN_WEIGHTS, STENCIL_CORRELATION, stencil_deviation
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array


@dataclass(frozen=True)
class StencilNoise:
    """Errors of velocities by the stencil on one recording, under this noise of its poses."""

    noise: NoiseEntry
    recording: Recording

    @classmethod
    def of(
        cls, recording: Recording, stated: NoiseEntry, moved: Array | None = None
    ) -> "StencilNoise":
        """The recording's own noise, as its fourth differences show it beside how the boat `moved` (n, 3).

        How much of that is correlated they don't tell: that is as a model has `stated` it. All is
        as stated where there are too few poses in a row.
        """
        try:
            own = pose_noise(recording) if moved is None else noise_beside(recording, moved)
        except RecordingError:
            return cls(stated, recording)
        entry = stated.correlated
        if entry is None:
            return cls(own, recording)
        seen = coloured_ratio(recording.period, entry)
        position, place = _parted(own.position, stated.position, entry.position, seen)
        heading, turn = _parted(own.heading, stated.heading, entry.heading, seen)
        together = CorrelatedEntry(place, turn, entry.memory, entry.period)
        return cls(NoiseEntry(position, heading, None, together), recording)

    @cached_property
    def _white(self) -> Array:
        return stencil_deviation(self.noise, self.recording) ** 2

    def covariance(self, steps: int) -> Array:
        """Of velocities (3,) so many poses apart [m/s, m/s, rad/s]^2; the variance of one at 0.

        The turn of the boat in between is left out.
        """
        shared = STENCIL_CORRELATION[steps] if steps < len(STENCIL_CORRELATION) else 0.0
        entry = self.noise.correlated
        if entry is None:
            return np.asarray(shared * self._white)
        period = self.recording.period
        places = np.arange(len(EVEN_WEIGHTS))
        apart = np.abs(steps + places[None, :] - places[:, None])
        slope = EVEN_WEIGHTS @ left_of(entry, period * apart) @ EVEN_WEIGHTS / period**2
        size = np.array([entry.position, entry.position, entry.heading])
        return np.asarray(shared * self._white + slope * size**2)


def _parted(own: float, white: float, together: float, seen: float) -> tuple[float, float]:
    """What is white and what is correlated of a recording's `own`, in the proportion that is stated."""
    stated = float(np.hypot(white, seen * together))
    return (own / stated * white, own / stated * together) if stated > 0.0 else (own, 0.0)
