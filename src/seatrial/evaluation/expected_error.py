# SPDX-License-Identifier: MIT
"""Expected error of predictions, from the model's parameter covariance and process noise.

Both add to the noise floor, the noise of start and reference. An unchanged boat scores the expected
RMS; a larger score indicates a change of the boat, or model mismatch.
"""

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import noise_vector
from seatrial.evaluation.filtering import filter_pass
from seatrial.evaluation.input_errors import input_errors
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array
from seatrial.util.parallel import cores

Poses = NDArray[np.int64]  # indices of poses in a recording
EXACT = np.full(3, 1e-9)  # [m/s, m/s, rad/s] standard deviation of an exact velocity
MOST_PREDICTIONS = 250  # over which the variance by process noise is averaged


def process_noise_variance(
    model: Model, recording: Recording, begin: Motion, start: Poses, end: Poses
) -> Array | None:
    """Variance (3,) [m/s, m/s, rad/s]^2 at the ends of predictions, from process noise.

    The model's filter without poses, from exact velocities, over some disjoint predictions one after
    another. None where the model has no process noise, or diverges.
    """
    noise = noise_vector(model.noise)
    if noise is None:
        return None
    apart = _disjoint(start, end)
    apart = apart[:: max(1, len(apart) // MOST_PREDICTIONS)]
    start, end = start[apart], end[apart]
    use = np.zeros(len(recording.t), dtype=np.int8)
    use[start] = _core.USE_BEGINNING
    velocity = np.zeros((len(recording.t), 3))
    velocity[start] = begin.nu[start]
    eta = np.where(recording.valid[:, None], recording.eta, 0.0)
    # only the poses from a start to its end
    inside = np.zeros(len(recording.t) + 1, dtype=np.int64)
    inside[start] += 1
    inside[end + 1] -= 1
    kept = np.cumsum(inside[:-1]) > 0
    poses = _core.Series(
        recording.t[kept], eta[kept], use[kept], np.zeros(6), EXACT, velocity[kept],
        input_errors=input_errors(model.vehicle, model.coefficients, recording),
    )  # fmt: skip
    try:
        found = filter_pass(model, recording, poses, noise)
    except ModelError:
        return None
    deviation = np.asarray(found.deviation, dtype=float)[np.cumsum(kept)[end] - 1]
    return np.asarray(np.mean(deviation**2, axis=0))


def _disjoint(start: Poses, end: Poses) -> Poses:
    """Indices of predictions that share no pose, in order of time."""
    found, free = [], -1
    for i, (first, last) in enumerate(zip(start.tolist(), end.tolist(), strict=True)):
        if first >= free:
            found.append(i)
            free = last + 1
    return np.array(found, dtype=np.int64)


def variance_of(slopes: Array, covariance: Array) -> Array:
    """Mean variance (3,) by sensitivities (n, 3, p) to parameters with this covariance (p, p)."""
    return np.asarray(np.sum((slopes @ covariance) * slopes, axis=(0, 2)) / len(slopes))


def parameter_sensitivities(
    model: Model, recording: Recording, begin: Motion, start: Poses, end: Poses
) -> Array:
    """Sensitivities (n, 3, p) of u, v and r at the ends of predictions to coefficients, then constants."""
    coefficients, constants = len(model.coefficients), len(model.constants)
    trace = model.trace(
        recording, initial=True, coefficients=range(coefficients), tangents=range(constants)
    )
    x0 = np.ascontiguousarray(np.column_stack([begin.eta[start], begin.nu[start]]))
    _, tangents = _core.predict(
        model.boat, trace, recording.t, start.astype(np.int32), end.astype(np.int32), x0,
        threads=cores(), sensitivities=True,
    )  # fmt: skip
    return np.asarray(tangents[:, 3:, 6:])
