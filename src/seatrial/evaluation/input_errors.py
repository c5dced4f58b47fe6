# SPDX-License-Identifier: MIT
"""Errors of the velocity where the commands are samples: a change between two samples has no stamp.

The thrust of samples T apart counts as changed halfway between them. Where its change differs from the one before
by an acceleration a, this is wrong by an unknown time: the velocity is off by a standard deviation of
|a| T / sqrt(12). The thrusters follow with their lag, so half of the variance is in each of the next two
intervals. A ramp through several samples is known but at its ends.
"""

import numpy as np

from seatrial import _core
from seatrial.boat.static_forces import static_forces
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

InputErrors = tuple[Array, Array]  # time (m,) [s]; covariance (m, 6): uu, uv, ur, vv, vr, rr
ROWS, COLUMNS = np.triu_indices(3)


def input_errors(vehicle: Vehicle, coefficients: Array, recording: Recording) -> InputErrors | None:
    """Covariance of all that these errors changed the velocity by, up to each sample of the commands.

    coefficients: of the vehicle's structure; None: every change of the commands has its own stamp.
    """
    period = recording.command_period
    if period == 0.0:
        return None
    at, commands = recording.seconds(recording.commands.stamps), recording.commands.values
    thrust = _core.accelerations(
        vehicle.structure.compiled, np.ascontiguousarray(coefficients), np.zeros((len(at), 3)),
        static_forces(vehicle, commands),
    )  # fmt: skip
    # how much each change differs from the one before
    changes = np.diff(np.asarray(thrust), axis=0)
    bends = np.diff(changes, axis=0, prepend=0.0)
    # samples that were lost do not make a change less certain
    time = np.minimum(np.diff(at), 2.0 * period)[:, None]
    variance = bends[:, ROWS] * bends[:, COLUMNS] * time**2 / 12.0
    variance[1:] = 0.5 * (variance[1:] + variance[:-1])
    return at, np.concatenate([np.zeros((1, 6)), np.cumsum(variance, axis=0)])
