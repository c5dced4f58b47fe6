# SPDX-License-Identifier: MIT
"""Velocity from a model's own extended Kalman filter: what the boat could know at that instant.

The stencil looks two poses ahead and knows no model; the filter looks back only. What both need of
the core's filter (poses as it takes them, the structure with its disturbance, noise by likelihood)
is here once.
"""

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from seatrial import _core
from seatrial.errors import ModelError, RecordingError
from seatrial.faults import FaultKind
from seatrial.frames import Array, body_velocity
from seatrial.model import INTEGRATORS, Model
from seatrial.noise import pose_noise
from seatrial.recording import Recording
from seatrial.schema import NoiseEntry
from seatrial.structure import Row
from seatrial.vehicle import Vehicle
from seatrial.velocity import Motion, motion

# position [m], heading [rad], walks [m/s, rad/s per sqrt(s)], disturbances [m/s^2, rad/s^2], memory [s]
NOISE_START = np.array([2e-3, 4e-3, 2e-3, 1e-2, 3e-2, 5e-2, 2.0])
NOISE_LEAST = np.array([1e-6, 1e-6, 1e-9, 1e-9, 1e-9, 1e-9, 0.3])
NOISE_FIRST = (1e-5, 1e-5)  # [m], [rad] the least that a search starts from
NOISE_MOST = np.array([1.0, 1.0, 1.0, 5.0, 1.0, 5.0, 30.0])
RAISED = np.array([0.0, 0.0, 5e-4, 2e-3, 1e-3, 3e-3, 0.0])  # where what was at its least is tried
PROCESS, DISTURBANCES, MEMORY = slice(2, 6), [4, 5], 6  # places among the noise
NOISE_STEP = 2.5  # the largest of a logarithm
FALLING = 0.3  # a step of a logarithm that may be one of an endless way down
CURVATURE = 0.3  # at the least, of a logarithm: what the data do not speak of stays where it is
NOISE_SETTLED = 0.1  # of the cost: other noise that gains less is not worth another step
NOISE_TRIALS = 6
VELOCITY_SPREAD = np.array([0.1, 0.1, 0.2])  # [m/s, m/s, rad/s] what the first velocity is worth
OUTLIER = 4.0  # [sigma] from which on a pose's error counts linearly
ROUNDS = 4  # of filter and noise in turns
SETTLED = 3.0  # of the cost: a step that gains less is the last
SETTLING = 2.0  # [s] in which the filter forgets how it started
STRETCH = 240.0  # [s] of all recordings together from which noise is found: seven numbers
PIECE = 10.0  # [s] that are taken together
T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Causal:
    """A pass of the filter along a recording. NaN at its start, and where a pose was not used."""

    motion: Motion  # state after each pose, with the filter's own standard deviations
    residual: Array  # (n, 3) pose less its prediction, in body axes, in standard deviations
    noise: Array  # (7,) what the filter believed


def series(recording: Recording) -> _core.Series:
    """The poses as the core's filter takes them, and where the recording starts."""
    moving = motion(recording)
    use = recording.valid.astype(np.int8)
    good = np.flatnonzero(recording.valid)
    for fault in recording.faults:
        if fault.kind is FaultKind.JUMP:  # after a jump for good the pose may be anywhere
            use[good[recording.t[good] >= fault.end][:1]] = 2
    first = int(good[0])
    start = np.zeros(6)
    start[:3] = recording.eta[first]
    if moving.valid.any():
        start[3:] = moving.nu[np.flatnonzero(moving.valid)[0]]
    eta = np.where(recording.valid[:, None], recording.eta, 0.0)
    return _core.Series(
        np.ascontiguousarray(recording.t), np.ascontiguousarray(eta), use, start, VELOCITY_SPREAD
    )


def disturbed(vehicle: Vehicle) -> _core.Structure:
    """The structure with a disturbance in every axis, its last three coefficients."""
    size = len(vehicle.structure.coefficients)
    own: list[Row] = [(axis, size + axis, 1.0, -1, []) for axis in range(3)]
    return _core.Structure([*vehicle.structure.rows, *own], size + 3, len(vehicle.forces))


def spread(work: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """Work on items in threads; the core lets the interpreter go."""
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return list(pool.map(work, items))


def filter_pass(
    model: Model, recording: Recording, poses: _core.Series, noise: Array
) -> _core.FilterPass:
    """The filter along one recording, driven by the recorded commands.

    Raises ModelError where the model diverges on its way.
    """
    size = len(model.coefficients)
    code = INTEGRATORS.index(model.integration.scheme)
    coefficients = np.concatenate([model.coefficients, np.zeros(3)])
    boat = _core.Boat(disturbed(model.vehicle), coefficients, code, model.integration.step)
    trace = model.trace(recording, initial=True, coefficients=range(size, size + 3))
    found = _core.innovations(boat, trace, poses, noise, OUTLIER)
    if not found.good:
        raise ModelError(
            f"{recording.name}: the model diverges in its own filter: it can't be used at these "
            "speeds. Identify from driving as fast as this"
        )
    return found


def noise_vector(entry: NoiseEntry) -> Array | None:
    """Noise (7,) as the core's filter takes it; None where no process noise was estimated."""
    p = entry.process
    if p is None:
        return None
    walks = [p.walk_linear, p.walk_yaw, p.disturbance_linear, p.disturbance_yaw]
    found = np.array([entry.position, entry.heading, *walks, p.memory])
    return np.asarray(np.clip(found, NOISE_LEAST, None))


def fitted_noise(
    passes: Sequence[_core.FilterPass],
    poses: Sequence[_core.Series],
    noise: Array,
    settled: float = NOISE_SETTLED,
) -> tuple[Array, float]:
    """The noise (7,) under which the errors are most likely, the model as it is; -2 log likelihood.

    No constant in the likelihood. A step that gains less than `settled` of it is the last.
    """
    for _ in range(6):
        noise, gain = likelier_noise(passes, poses, noise)
        if gain < settled:
            break
    pairs = list(zip(passes, poses, strict=True))
    return noise, sum(spread(lambda pair: _core.repeated(*pair, noise, OUTLIER), pairs))


def likelier_noise(
    passes: Sequence[_core.FilterPass],
    poses: Sequence[_core.Series],
    noise: Array,
    outlier: float = OUTLIER,
    least: Array = NOISE_LEAST,
) -> tuple[Array, float]:
    """Noise (7,) under which the errors are more likely, the model as it is; the fall of the cost.

    One step of Fisher's scoring on the logarithms, over linearised repetitions of the passes. What
    falls is tried at its least, too: there the way down is endless and ever flatter; what is at its
    least is tried higher up again.
    """
    pairs = list(zip(passes, poses, strict=True))
    low, high = np.log(least), np.log(NOISE_MOST)

    def cost(phi: Array) -> float:
        one = np.exp(phi)
        return sum(spread(lambda pair: _core.repeated(*pair, one, outlier), pairs))

    phi = np.log(np.maximum(noise, least))
    active = phi > low
    active[MEMORY] = active[DISTURBANCES].any()
    mask = int(np.sum(active.astype(int) << np.arange(len(phi))))
    parts = spread(lambda pair: _core.noise_slopes(*pair, np.exp(phi), outlier, mask), pairs)
    first = here = sum(p[0] for p in parts)
    gradient, information = sum(p[1] for p in parts), sum(p[2] for p in parts)
    damping = 1e-3
    for _ in range(NOISE_TRIALS):
        matrix = information + np.diag(damping * np.diag(information) + CURVATURE)
        move = np.clip(np.linalg.solve(matrix, gradient), -NOISE_STEP, NOISE_STEP)
        trial = np.clip(phi - move, low, high)
        found = cost(trial)
        if found < here:
            phi, here = trial, found
            break
        damping = max(10.0 * damping, 1e-2)
    for i in range(*PROCESS.indices(len(phi))):
        fell = active[i] and move[i] > FALLING
        raised = not active[i] and first - here < NOISE_SETTLED
        if fell or raised:
            trial = phi.copy()
            trial[i] = low[i] if fell else np.log(RAISED[i])
            found = cost(trial)
            phi, here = (trial, found) if found < here else (phi, here)
    return np.exp(phi), first - here


def believed_noise(model: Model, recordings: Sequence[Recording]) -> Array:
    """What the model's filter is to believe (7,): the model's own noise, as it was identified.

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
    """Velocities by the model's filter, with `noise` (7,) or what `believed_noise` gives.

    Raises ModelError where the model diverges.
    """
    believed = believed_noise(model, [recording]) if noise is None else noise
    found = filter_pass(model, recording, series(recording), believed)
    used = (np.asarray(found.weight) > 0.0) & (recording.t > SETTLING)
    state = np.where(used[:, None], found.state, np.nan)
    deviation = np.where(used[:, None], found.deviation, np.nan)
    moving = Motion(recording.t, state[:, :3], state[:, 3:6], used, deviation)
    return Causal(moving, _residual(found, state[:, 2]), believed)


def _residual(found: _core.FilterPass, psi: Array) -> Array:
    """Innovations (n, 3) in body axes over their standard deviations, outliers held back."""
    xx, xy, _, yy, _, turn = np.asarray(found.spread).T
    c, s = np.cos(psi), np.sin(psi)
    along = np.sqrt(np.maximum(c**2 * xx + 2.0 * c * s * xy + s**2 * yy, 0.0))
    across = np.sqrt(np.maximum(s**2 * xx - 2.0 * c * s * xy + c**2 * yy, 0.0))
    body = body_velocity(psi, np.asarray(found.innovation))  # the same turn as a velocity's
    return np.asarray(
        body / np.column_stack([along, across, np.sqrt(turn)]) * found.weight[:, None]
    )
