# SPDX-License-Identifier: MIT
"""The covariance that a model states: all that is known about the errors of its parameters."""

from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.uncertainty.command_shape import with_unknown_shape
from seatrial.identification.uncertainty.covariance import sandwich_covariance, with_lag_by_square
from seatrial.identification.uncertainty.dead_zone import with_dead_zone_profile
from seatrial.util.frames import Array


def estimation_covariance(at: Point) -> Array:
    """Covariance (p, p) of the free parameters at a solution.

    From the sandwich, the profile of dead zones, the unknown shape of sampled commands, and the square of lags.
    Raises IdentificationError where coefficients are not separable.
    """
    covariance = with_dead_zone_profile(at, sandwich_covariance(at))
    return with_lag_by_square(at, with_unknown_shape(at, covariance))
