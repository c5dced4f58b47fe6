# SPDX-License-Identifier: MIT
"""A reference pose with its derivatives, earth-fixed and in body axes."""

from dataclasses import dataclass

import numpy as np

from seatrial.util.frames import Array, body_velocity, freeze


@dataclass(frozen=True)
class Reference:
    """Pose with its first two derivatives, earth-fixed."""

    eta: Array  # (3,) x, y [m], psi [rad]
    rate: Array  # (3,) [m/s, m/s, rad/s]
    acceleration: Array  # (3,) [m/s^2, m/s^2, rad/s^2]

    def __post_init__(self) -> None:
        freeze(self, "eta", "rate", "acceleration")

    @classmethod
    def still(cls, eta: Array) -> "Reference":
        """At rest at a pose."""
        return cls(eta, np.zeros(3), np.zeros(3))

    @property
    def rows(self) -> Array:
        """Rows for the core (3, 3)."""
        return np.vstack([self.eta, self.rate, self.acceleration])

    def body(self) -> tuple[Array, Array]:
        """nu (3,) and nu_dot (3,) of a boat on the reference: nu_dot = R' eta_ddot - r S nu."""
        psi = np.array([self.eta[2]] * 2)
        nu, turned = body_velocity(psi, np.vstack([self.rate, self.acceleration]))
        swing = nu[2] * np.array([nu[1], -nu[0], 0.0])
        return nu, turned + swing
