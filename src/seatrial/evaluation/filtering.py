# SPDX-License-Identifier: MIT
"""Velocity from a model's own extended Kalman filter: what the boat could know at that instant.

The stencil looks two poses ahead and knows no model; the filter looks back only. What both need of
the core's filter (poses as it takes them, the structure with its disturbance, noise by likelihood)
is here once.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import INTEGRATORS, Model
from seatrial.boat.noise_parameters import (
    NOISE_FIRST,
    NOISE_START,
    OUTLIER,
    earth_fixed,
    fitted_noise,
    noise_vector,
)
from seatrial.boat.structure import Row
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.pose_faults import FaultKind
from seatrial.recording.pose_noise import pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion, motion, stencil_deviation
from seatrial.util.errors import ModelError, RecordingError
from seatrial.util.frames import Array, body_velocity
from seatrial.util.parallel import spread

VELOCITY_SPREAD = np.array([0.1, 0.1, 0.2])  # [m/s, m/s, rad/s] what the first velocity is worth
NOISY = 0.3  # of it, from which on a stencil's noise matters where the filter begins afresh;
AROUND = 0.75  # [s] then poses so far to either side tell,
AROUND_POSES = 7  # these at the least
ROUNDS = 4  # of filter and noise in turns
SETTLED = 3.0  # of the cost: a step that gains less is the last
SETTLING = 2.0  # [s] in which the filter forgets how it started
# the first pose after it
AFTER = {FaultKind.GAP: _core.USE_GAPPED, FaultKind.JUMP: _core.USE_JUMPED}
LASTING = 1.0  # [s] after the next command what came before it still acts: latency and lag
START = 200  # usable poses that the noise at the start is found from
STRETCH = 240.0  # [s] of all recordings together from which noise is found: seven numbers
PIECE = 10.0  # [s] that are taken together


@dataclass(frozen=True)
class Causal:
    """A pass of the filter along a recording. NaN at its start, and where a pose was not used."""

    motion: Motion  # state after each pose, with the filter's own standard deviations
    residual: Array  # (n, 3) pose less its prediction, in body axes, in standard deviations
    noise: Array  # (11,) what the filter believed


def series(recording: Recording) -> _core.Series:
    """The poses as the core's filter takes them, and where the recording starts."""
    moving = motion(recording)
    use = recording.valid.astype(np.int8)
    good = np.flatnonzero(recording.valid)
    for kind, code in AFTER.items():
        for fault in recording.faults:
            if fault.kind is kind:
                use[good[recording.t[good] >= fault.end][:1]] = code
    first = int(good[0])
    spread = VELOCITY_SPREAD.copy()
    start = np.zeros(6)
    start[:3] = recording.eta[first]
    if moving.valid.any():
        start[3:] = moving.nu[np.flatnonzero(moving.valid)[0]]
        with suppress(RecordingError):  # what comes later changes nothing
            noise = pose_noise(recording, first=START)
            spread = np.hypot(spread, stencil_deviation(noise, recording, first=START))
    afresh = _afresh(recording, use, moving, start[3:], spread)
    eta = np.where(recording.valid[:, None], recording.eta, 0.0)
    return _core.Series(
        np.ascontiguousarray(recording.t), np.ascontiguousarray(eta), use, start, spread, afresh
    )


def _afresh(
    recording: Recording, use: NDArray[np.int8], moving: Motion, begin: Array, spread: Array
) -> Array | None:
    """Marks in `use` (n,) where the filter begins afresh; velocities (n, 3) there.

    After commands were lost, and where the first poses are not usable: what is before says nothing.
    begin: (3,) velocity at the first usable pose; spread: (3,) what it is worth. None where it never does.
    """
    t, velocity = recording.t, np.zeros((len(recording.t), 3))
    noisy = bool((spread > np.hypot(1.0, NOISY) * VELOCITY_SPREAD).any())
    first = int(np.flatnonzero(use > 0)[0])
    if first > 0:
        use[first], velocity[first] = _core.USE_BEGINNING, begin
    for begins, ends in recording.unknown:
        if ends + LASTING > t[first]:
            if begins < t[first] and not (use[t >= ends + LASTING] > 0).any():
                continue  # too short to be choosy
            use[(t >= begins) & (t < ends + LASTING)] = 0
            after = np.flatnonzero((use > 0) & (t >= ends))[:1]
            known = np.flatnonzero(moving.valid & (t >= ends + LASTING))[:1]
            use[after] = _core.USE_BEGINNING
            if len(known):
                velocity[after] = moving.nu[known]
            if len(after) and noisy and (wider := _around(recording, int(after[0]))) is not None:
                velocity[after] = wider
    return velocity if _core.USE_BEGINNING in use else None


def _around(recording: Recording, at: int) -> Array | None:
    """Velocity (3,) at a pose by a parabola through those around it; None where they are few.

    The filter is linear about it: where a stencil's noise is as large as the boat's speed, drag is not.
    """
    near = recording.valid & (np.abs(recording.t - recording.t[at]) <= AROUND)
    near &= recording.segment == recording.segment[at]
    if near.sum() < AROUND_POSES:
        return None
    rate = np.polynomial.polynomial.polyfit(
        recording.t[near] - recording.t[at], recording.eta[near], 2
    )[1]
    return np.asarray(body_velocity(recording.eta[[at], 2], rate[None, :])[0])


def disturbed(vehicle: Vehicle) -> _core.Structure:
    """The structure with a disturbance in every axis, its last three coefficients."""
    size = len(vehicle.structure.coefficients)
    own: list[Row] = [(axis, size + axis, 1.0, -1, []) for axis in range(3)]
    return _core.Structure([*vehicle.structure.rows, *own], size + 3, len(vehicle.forces))


def filter_pass(
    model: Model, recording: Recording, poses: _core.Series, noise: Array
) -> _core.FilterRun:
    """The filter along one recording, driven by the recorded commands.

    Raises ModelError where the model diverges on its way.
    """
    size = len(model.coefficients)
    code = INTEGRATORS.index(model.integration.scheme)
    coefficients = np.concatenate([model.coefficients, np.zeros(3)])
    boat = _core.Boat(disturbed(model.vehicle), coefficients, code, model.integration.step)
    trace = model.trace(recording, initial=True, coefficients=range(size, size + 3))
    found = _core.innovations(
        boat, trace, poses, noise, OUTLIER, earth_fixed=earth_fixed(model.noise)
    )
    if not found.good:
        raise ModelError(
            f"{recording.name}: the model diverges in its own filter: it can't be used at these "
            "speeds. Identify from driving as fast as this"
        )
    return found


def believed_noise(model: Model, recordings: Sequence[Recording]) -> Array:
    """What the model's filter is to believe (11,): the model's own noise, as it was identified.

    A model without process noise (the paper's method finds none) is given that under which these
    recordings are most likely, so that its filter is as good as it can be.
    """
    own = noise_vector(model.noise)
    if own is not None:
        return own
    parts = [part for r in recordings for part in _parts(r, STRETCH / len(recordings))]
    return _likeliest(model, parts, _start(recordings))


def _likeliest(model: Model, recordings: Sequence[Recording], noise: Array) -> Array:
    """Filter and noise in turns."""
    items = [(r, series(r)) for r in recordings]
    for _ in range(ROUNDS):
        passes = spread(lambda item: filter_pass(model, *item, noise), items)  # noqa: B023
        before = sum(p.cost for p in passes)
        noise, cost = fitted_noise(passes, [s for _, s in items], noise, SETTLED)
        if before - cost < 2.0 * SETTLED:
            break
    return noise


def _parts(recording: Recording, length: float) -> list[Recording]:
    """So many seconds of a recording in pieces from all over it; all of it where it is shorter."""
    pieces = max(1, round(length / PIECE))
    every = recording.duration / pieces
    if every <= 1.5 * PIECE:
        return [recording]
    found = []
    for i in range(pieces):
        begin = i * every + 0.5 * (every - PIECE)
        with suppress(RecordingError):  # nothing usable there
            found.append(recording.cut(begin, begin + PIECE))
    return found or [recording]


def _start(recordings: Sequence[Recording]) -> Array:
    """Where the search for the noise starts: the poses' own is seen without a model."""
    noise = NOISE_START.copy()
    with suppress(RecordingError):  # too few poses in a row
        own = pose_noise(*recordings)
        noise[:2] = np.maximum([own.position, own.heading], NOISE_FIRST)
    return noise


def causal(model: Model, recording: Recording, noise: Array | None = None) -> Causal:
    """Velocities by the model's filter, with `noise` (11,) or what `believed_noise` gives.

    Raises ModelError where the model diverges.
    """
    believed = believed_noise(model, [recording]) if noise is None else noise
    found = filter_pass(model, recording, series(recording), believed)
    begins = recording.t[recording.valid][0]
    used = (np.asarray(found.weight) > 0.0) & (recording.t > begins + SETTLING)
    for _, ends in recording.unknown:
        used &= (recording.t < ends) | (recording.t > ends + LASTING + SETTLING)
    state = np.where(used[:, None], found.state, np.nan)
    deviation = np.where(used[:, None], found.deviation, np.nan)
    moving = Motion(recording.t, state[:, :3], state[:, 3:6], used, deviation)
    return Causal(moving, _residual(found, state[:, 2]), believed)


def _residual(found: _core.FilterRun, psi: Array) -> Array:
    """Innovations (n, 3) in body axes over their standard deviations, outliers held back."""
    xx, xy, _, yy, _, turn = np.asarray(found.spread).T
    c, s = np.cos(psi), np.sin(psi)
    along = np.sqrt(np.maximum(c**2 * xx + 2.0 * c * s * xy + s**2 * yy, 0.0))
    across = np.sqrt(np.maximum(s**2 * xx - 2.0 * c * s * xy + c**2 * yy, 0.0))
    body = body_velocity(psi, np.asarray(found.innovation))  # the same turn as a velocity's
    return np.asarray(
        body / np.column_stack([along, across, np.sqrt(turn)]) * found.weight[:, None]
    )
