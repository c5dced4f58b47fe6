# SPDX-License-Identifier: MIT
"""What a model says of its own predictions: how far they will be off because of what it does not know.

An identified model states how uncertain its coefficients are and which force it leaves out. Both
make errors of predictions, beside the noise of what they start from and are compared with. A boat
that is as it was when it was identified scores this; one that scores more is not.
"""

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import noise_vector
from seatrial.evaluation.filtering import filter_pass
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array
from seatrial.util.parallel import cores

Poses = NDArray[np.int64]  # places of poses in a recording
KNOWN = np.full(3, 1e-9)  # [m/s, m/s, rad/s] as good as exactly


def pushed(
    model: Model, recording: Recording, begin: Motion, start: Poses, end: Poses
) -> Array | None:
    """Variance (3,) [m/s, m/s, rad/s]^2, at the ends of stretches, of what the stated force makes.

    The model's own filter without poses, from velocities that are known exactly, over stretches one
    after the other. None where the model states no force, or runs away.
    """
    noise = noise_vector(model.noise)
    if noise is None:
        return None
    apart = _apart(start, end)
    use = np.zeros(len(recording.t), dtype=np.int8)
    use[start[apart]] = _core.USE_BEGINNING
    velocity = np.zeros((len(recording.t), 3))
    velocity[start[apart]] = begin.nu[start[apart]]
    eta = np.where(recording.valid[:, None], recording.eta, 0.0)
    poses = _core.Series(
        np.ascontiguousarray(recording.t), np.ascontiguousarray(eta), use, np.zeros(6), KNOWN, velocity
    )  # fmt: skip
    try:
        found = filter_pass(model, recording, poses, noise)
    except ModelError:
        return None
    deviation = np.asarray(found.deviation, dtype=float)[end[apart]]
    return np.asarray(np.mean(deviation**2, axis=0))


def _apart(start: Poses, end: Poses) -> Poses:
    """Places of those stretches, rising, that share no pose."""
    found, free = [], -1
    for i, (first, last) in enumerate(zip(start.tolist(), end.tolist(), strict=True)):
        if first >= free:
            found.append(i)
            free = last + 1
    return np.array(found, dtype=np.int64)


def unsure(model: Model, recording: Recording, begin: Motion, start: Poses, end: Poses) -> Array:
    """Variance (3,) [m/s, m/s, rad/s]^2, at the ends of stretches, of what errors of parameters make.

    To first order: the covariance of coefficients and constants through the model's slopes.
    """
    slopes = slopes_of(model, recording, begin, start, end)
    return np.asarray(np.einsum("nip,pq,niq->i", slopes, model.covariance, slopes) / len(start))


def slopes_of(model: Model, recording: Recording, begin: Motion, start: Poses, end: Poses) -> Array:
    """Slopes (n, 3, p) of u, v and r, at the ends of stretches, by coefficients, then constants."""
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
