# SPDX-License-Identifier: MIT
"""Filtering: velocity from a model's own extended Kalman filter along a recording.

The stencil uses two later poses and no model; the filter is causal. This module also has what other
users of the core's filter share: its pose series, the structure with a disturbance, and noise by
maximum likelihood.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import INTEGRATORS, Model
from seatrial.boat.noise_parameters import (
    COLOURED,
    NOISE_FIRST,
    NOISE_START,
    OUTLIER,
    earth_fixed,
    noise_vector,
)
from seatrial.boat.noise_scoring import Linearised, fitted_noise
from seatrial.boat.structure import Row
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.input_errors import InputErrors, input_errors
from seatrial.recording.asynchronous import used_asynchronous
from seatrial.recording.delays import at_one_time
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.pose_noise import known_pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion, motion, stencil_deviation
from seatrial.util.errors import DivergenceError, RecordingError
from seatrial.util.frames import Array, body_velocity
from seatrial.util.frozen import once
from seatrial.util.parallel import spread

# [m/s, m/s, rad/s] standard deviation of the first velocity
START_VELOCITY_DEVIATION = np.array([0.1, 0.1, 0.2])
NOISY_START = 0.3  # of it; with more stencil noise a restart uses a parabola through more poses
PARABOLA_SPAN = 0.75  # [s] on either side of a restart
PARABOLA_POSES = 7  # fewest poses of the parabola
NOISE_ROUNDS = 4  # of filter run and noise estimate in turn
NOISE_GAIN = 3.0  # of the cost; a smaller gain ends the estimate
FILTER_SETTLING = 2.0  # [s] in which the filter forgets its start
# treatment of the first pose after a fault
USE_AFTER = {FaultKind.GAP: _core.USE_GAPPED, FaultKind.JUMP: _core.USE_JUMPED}
COMMAND_MEMORY = 1.0  # [s] after the next command, in which earlier ones still act: latency and lag
START_POSES = 200  # usable poses for the pose noise at the start
# [s] of all recordings together for estimating the noise: enough for seven numbers
NOISE_DURATION = 240.0
NOISE_PIECE = 10.0  # [s] of each piece of them
FEW_PIECES = 1.5  # pieces; a recording not longer than that is used whole


@dataclass(frozen=True)
class Filtered:
    """A filter run along a recording. NaN while it settles, and where a pose was not used."""

    motion: Motion  # state after each pose, with the filter's own standard deviations
    residual: Array  # (n, 3) innovations in body axes, in standard deviations
    noise: Array  # (12,) of the filter
    run: _core.FilterRun
    series: _core.Series  # what it ran along

    @property
    def state(self) -> Array:
        """Pose, velocity and disturbance (n, 9) after each pose."""
        return np.asarray(self.run.state)

    def prediction_variance(
        self, start: NDArray[np.int64], end: NDArray[np.int64], *, disturbed: bool = False
    ) -> Array:
        """Variances (m, 3) [m/s, m/s, rad/s]^2 of predictions between poses (m,), `start` rising.

        They start from the filter's velocity, with its disturbance or without.
        """
        begin, to = start.astype(np.int32), end.astype(np.int32)
        return np.asarray(
            _core.lookahead_variance(
                self.run, self.series, self.noise, OUTLIER, begin, to, disturbed=disturbed
            )
        )


def filter_series(recording: Recording, errors: InputErrors | None = None) -> _core.Series:
    """The pose series of the core's filter, with the start state; errors of sampled commands."""
    return _exact_series(recording) if errors is None else _series(recording, errors)


@once
def _exact_series(recording: Recording) -> _core.Series:
    """The same where each command is at its stamp: with any model."""
    return _series(recording, None)


def _series(recording: Recording, errors: InputErrors | None) -> _core.Series:
    moving = motion(recording)
    use = recording.valid.astype(np.int8)
    good = np.flatnonzero(recording.valid)
    for kind, code in USE_AFTER.items():
        for fault in recording.faults:
            if fault.kind is kind:
                use[good[recording.t[good] >= fault.end][:1]] = code
    first = int(good[0])
    spread = START_VELOCITY_DEVIATION.copy()
    start = np.zeros(6)
    start[:3] = recording.eta[first]
    if moving.valid.any():
        start[3:] = moving.nu[np.flatnonzero(moving.valid)[0]]
        # noise of the first poses only, so that the run stays causal
        if noise := known_pose_noise(recording, first=START_POSES):
            spread = np.hypot(spread, stencil_deviation(noise, recording, first=START_POSES))
    afresh = _restarts(recording, use, moving, start[3:], spread)
    eta = np.where(recording.valid[:, None], recording.eta, 0.0)
    return _core.Series(
        np.ascontiguousarray(recording.t), np.ascontiguousarray(eta), use, start, spread, afresh,
        recording.position_delay, recording.parts, _asynchronous(recording, use), errors,
    )  # fmt: skip


def simulated_series(
    recording: Recording, velocity: Array, errors: InputErrors | None = None
) -> _core.Series:
    """The same of simulated poses, all usable, from the known velocity (3,) at the first of them."""
    start = np.concatenate([recording.eta[0], velocity])
    return _core.Series(
        np.ascontiguousarray(recording.t), np.ascontiguousarray(recording.eta),
        np.ones(len(recording.t), dtype=np.int8), start, START_VELOCITY_DEVIATION.copy(),
        input_errors=errors,
    )  # fmt: skip


def series_for(model: Model, recording: Recording) -> _core.Series:
    """The same for a model's filter: where commands are samples, with what their errors do to the model."""
    return filter_series(recording, input_errors(model.vehicle, model.coefficients, recording))


def _asynchronous(
    recording: Recording, use: NDArray[np.int8]
) -> tuple[Array, NDArray[np.int8], Array, float] | None:
    """Times [s], parts, values and the rates' deviation of the asynchronous measurements."""
    if recording.asynchronous is None:
        return None
    measured = recording.asynchronous.between(recording.stamps)
    lost = (*USE_AFTER.values(), _core.USE_BEGINNING)
    used = used_asynchronous(measured, recording.stamps, use, lost)
    parts = np.where(used, measured.parts, 0).astype(np.int8)
    return recording.seconds(measured.stamps), parts, measured.values, measured.rate_deviation


def _restarts(
    recording: Recording, use: NDArray[np.int8], moving: Motion, begin: Array, spread: Array
) -> Array | None:
    """Mark restarts of the filter in `use` (n,), and return the velocities (n, 3) there.

    It restarts after an interval of unknown commands, and at the first usable pose. begin: (3,) velocity
    at the first usable pose; spread: (3,) its standard deviation. None without a restart.
    """
    t, velocity = recording.t, np.zeros((len(recording.t), 3))
    noisy = bool((spread > np.hypot(1.0, NOISY_START) * START_VELOCITY_DEVIATION).any())
    first = int(np.flatnonzero(use > 0)[0])
    if first > 0:
        use[first], velocity[first] = _core.USE_BEGINNING, begin
    for begins, ends in recording.unknown:
        if ends + COMMAND_MEMORY > t[first]:
            if begins < t[first] and not (use[t >= ends + COMMAND_MEMORY] > 0).any():
                continue  # too short to wait for the commands' memory
            use[(t >= begins) & (t < ends + COMMAND_MEMORY)] = 0
            after = np.flatnonzero((use > 0) & (t >= ends))[:1]
            known = np.flatnonzero(moving.valid & (t >= ends + COMMAND_MEMORY))[:1]
            use[after] = _core.USE_BEGINNING
            if len(known):
                velocity[after] = moving.nu[known]
            if (
                len(after)
                and noisy
                and (wider := _parabola_velocity(recording, int(after[0]))) is not None
            ):
                velocity[after] = wider
    return velocity if _core.USE_BEGINNING in use else None


def _parabola_velocity(recording: Recording, at: int) -> Array | None:
    """Velocity (3,) at a pose by a parabola through its neighbours; None where they are few.

    The filter linearises about it: with stencil noise as large as the speed, drag is far from linear.
    """
    recording = at_one_time(recording)
    near = recording.valid & (np.abs(recording.t - recording.t[at]) <= PARABOLA_SPAN)
    near &= recording.segment == recording.segment[at]
    if near.sum() < PARABOLA_POSES:
        return None
    rate = np.polynomial.polynomial.polyfit(
        recording.t[near] - recording.t[at], recording.eta[near], 2
    )[1]
    return np.asarray(body_velocity(recording.eta[[at], 2], rate[None, :])[0])


def with_disturbance(vehicle: Vehicle) -> _core.Structure:
    """The structure with a disturbance in every axis, its last three coefficients."""
    size = len(vehicle.structure.coefficients)
    own: list[Row] = [(axis, size + axis, 1.0, -1, []) for axis in range(3)]
    return _core.Structure([*vehicle.structure.rows, *own], size + 3, len(vehicle.forces))


def disturbed_boat(model: Model) -> _core.Boat:
    """The model's boat with a disturbance in every axis, of which the last three coefficients hold none."""
    code = INTEGRATORS.index(model.integration.scheme)
    coefficients = np.concatenate([model.coefficients, np.zeros(3)])
    return _core.Boat(with_disturbance(model.vehicle), coefficients, code, model.integration.step)


def filter_pass(
    model: Model, recording: Recording, poses: _core.Series, noise: Array
) -> _core.FilterRun:
    """The filter along one recording, driven by the recorded commands.

    Raises DivergenceError where the model diverges.
    """
    size = len(model.coefficients)
    trace = model.trace(recording, initial=True, coefficients=range(size, size + 3))
    found = _core.innovations(
        disturbed_boat(model), trace, poses, noise, OUTLIER, earth_fixed=earth_fixed(model.noise)
    )
    if not found.good:
        raise DivergenceError(
            f"{recording.name}: the model diverges in its own filter: it can't be used at these "
            "speeds. Identify from recordings at these speeds"
        )
    return found


def filter_noise(model: Model, recordings: Sequence[Recording]) -> Array:
    """Noise (12,) of the model's filter: the model's own, as identified.

    A model without process noise (the paper's method has none) gets the maximum-likelihood noise of
    these recordings, so that its filter is the best possible.
    """
    own = noise_vector(model.noise)
    return recording_noise(model, recordings) if own is None else own


def recording_noise(
    model: Model, recordings: Sequence[Recording], colour: Array | None = None
) -> Array:
    """Maximum-likelihood noise (12,) of these recordings for the model, whatever noise it states.

    colour: (4,) start of the Gauss-Markov pose noise; none by default.
    """
    parts = [part for r in recordings for part in _pieces(r, NOISE_DURATION / len(recordings))]
    start = _start_noise(recordings)
    if colour is not None:
        start[COLOURED] = colour
    return _maximum_likelihood_noise(model, parts, start)


def _maximum_likelihood_noise(model: Model, recordings: Sequence[Recording], noise: Array) -> Array:
    """Filter runs and noise estimates in turn."""
    items = [(r, series_for(model, r)) for r in recordings]
    for _ in range(NOISE_ROUNDS):
        passes = spread(lambda item: filter_pass(model, *item, noise), items)  # noqa: B023
        before = sum(p.cost for p in passes)
        at = Linearised(passes, [series for _, series in items], recordings[0].period)
        noise, cost = fitted_noise(at, noise, NOISE_GAIN)
        if before - cost < 2.0 * NOISE_GAIN:
            break
    return noise


def _pieces(recording: Recording, length: float) -> list[Recording]:
    """Pieces of a recording, evenly spaced, `length` [s] in all; the whole of a shorter one."""
    pieces = max(1, round(length / NOISE_PIECE))
    every = recording.duration / pieces
    if every <= FEW_PIECES * NOISE_PIECE:
        return [recording]
    found = []
    for i in range(pieces):
        begin = i * every + 0.5 * (every - NOISE_PIECE)
        with suppress(RecordingError):  # no usable pose there
            found.append(recording.cut(begin, begin + NOISE_PIECE))
    return found or [recording]


def _start_noise(recordings: Sequence[Recording]) -> Array:
    """Start of the noise estimate: pose noise from fourth differences."""
    noise = NOISE_START.copy()
    if own := known_pose_noise(*recordings):
        noise[:2] = np.maximum([own.position, own.heading], NOISE_FIRST)
    return noise


def run_filter(model: Model, recording: Recording, noise: Array | None = None) -> Filtered:
    """Velocities by the model's filter, with `noise` (12,), by default from `filter_noise`.

    Raises DivergenceError where the model diverges.
    """
    used_noise = filter_noise(model, [recording]) if noise is None else noise
    series = series_for(model, recording)
    found = filter_pass(model, recording, series, used_noise)
    # Poses count after the settling of a start, and not as outliers.
    begins = recording.t[recording.valid][0]
    used = (np.asarray(found.weight) > 0.0) & (recording.t > begins + FILTER_SETTLING)
    for _, ends in recording.unknown:
        used &= (recording.t < ends) | (recording.t > ends + COMMAND_MEMORY + FILTER_SETTLING)
    state = np.where(used[:, None], found.state, np.nan)
    deviation = np.where(used[:, None], found.deviation, np.nan)
    moving = Motion(recording.t, state[:, :3], state[:, 3:6], used, deviation)
    residual = _normalised_innovation(found, state[:, 2])
    return Filtered(moving, residual, used_noise, found, series)


def _normalised_innovation(found: _core.FilterRun, psi: Array) -> Array:
    """Innovations (n, 3) in body axes over their standard deviations, outliers down-weighted."""
    xx, xy, _, yy, _, turn = np.asarray(found.spread).T
    c, s = np.cos(psi), np.sin(psi)
    along = np.sqrt(np.maximum(c**2 * xx + 2.0 * c * s * xy + s**2 * yy, 0.0))
    across = np.sqrt(np.maximum(s**2 * xx - 2.0 * c * s * xy + c**2 * yy, 0.0))
    body = body_velocity(psi, np.asarray(found.innovation))  # rotates as a velocity does
    return np.asarray(
        body / np.column_stack([along, across, np.sqrt(turn)]) * found.weight[:, None]
    )
