# SPDX-License-Identifier: MIT
"""Velocity some time ahead, from every instant of a recording."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import earth_fixed, noise_vector
from seatrial.evaluation.expected_error import Poses, process_noise_variance, variance_of
from seatrial.evaluation.filtering import Filtered, disturbed_boat
from seatrial.evaluation.predicted import Prediction
from seatrial.evaluation.starts_and_ends import starts_and_ends
from seatrial.recording.recording import Recording
from seatrial.recording.stencil_noise import StencilNoise
from seatrial.recording.velocity import Motion, five_point_stencil, motion
from seatrial.util.arguments import expect
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array, body_velocity
from seatrial.util.parallel import cores

DEFAULT_HORIZON = 1.0  # [s] the paper's 15 steps at 15 Hz
FLOOR_STARTS = 250  # starts whose sensitivities the floor is averaged over


def _why(model: Model) -> str:
    """The first note of the identification; without one the usual advice."""
    noted = list(model.warnings)
    if noted:
        return f"Note of the identification: {noted[0]}"
    return "Identify from driving as fast as this"


def predict(
    model: Model,
    recording: Recording,
    horizon: float = DEFAULT_HORIZON,
    *,
    velocities: Motion | None = None,
    starts: Motion | None = None,
    every: int = 1,
) -> Prediction:
    """Predict from every usable pose: the recorded commands drive the model for `horizon` [s].

    Starts and references are the stencil's velocities. `velocities` are references instead (the
    truth of a simulated trial), and starts, too, unless `starts` are given (a filter's, with their
    deviation; without one they count as the stencil's). `every`: poses from start to start.
    Raises RecordingError where no interval is as long as the horizon, and ModelError where the
    model diverges.
    """
    expect(model, Model, "model")
    expect(recording, Recording, "recording")
    return Lookahead(model, recording, velocities).predict(horizon, every, starts)


@dataclass(frozen=True)
class Lookahead:
    """Predictions along one recording, whatever the horizon and the starts; see `predict`."""

    model: Model
    recording: Recording
    velocities: Motion | None = None
    filtered: Filtered | None = None  # with `smoothed`: what predictions start from
    smoothed: Motion | None = None  # the reference in place of the stencil's velocities
    _known: list[tuple[Motion, Poses, Array]] = field(default_factory=list, init=False, repr=False)

    @cached_property
    def reference(self) -> Motion:
        """What is to be predicted."""
        if self.smoothed is not None:
            return self.smoothed
        return motion(self.recording) if self.velocities is None else self.velocities

    @cached_property
    def trace(self) -> _core.ThrustTrace:
        """What the thrusters did."""
        return self.model.trace(self.recording)

    @cached_property
    def trace_of_starts(self) -> _core.ThrustTrace:
        """The same with sensitivities to the initial state, and to parameters of known process noise."""
        model, known = self.model, noise_vector(self.model.noise) is not None
        return model.trace(
            self.recording, initial=True,
            coefficients=range(len(model.coefficients) if known else 0),
            tangents=range(len(model.constants) if known else 0),
        )  # fmt: skip

    @cached_property
    def driven(self) -> Array | None:
        """States (n, 6) of the model, driven by the commands from the first velocity on; NaN before.

        None if the model diverges, or no pose has a velocity.
        """
        recording, seen = self.recording, motion(self.recording)
        states = np.full((len(recording.t), 6), np.nan)
        if not seen.valid.any():
            return None
        first = int(np.flatnonzero(seen.valid)[0])
        x0 = np.concatenate([seen.eta[first], seen.nu[first]])
        t = np.ascontiguousarray(recording.t[first:])
        states[first:] = _core.simulate(self.model.boat, self.trace, x0, t)[0]
        return states if np.isfinite(states[first:]).all() else None

    @cached_property
    def stencil(self) -> StencilNoise:
        """How noisy the stencil's velocities are."""
        moved = None if self.driven is None else self.driven[:, :3]
        return StencilNoise.of(self.recording, self.model.noise, moved)

    @cached_property
    def missed(self) -> Array:
        """Stencil's velocities less true ones (n, 3) [m/s, m/s, rad/s] without any noise.

        A stencil smooths motion that is faster than a few poses. The model's own motion shows by how much; 0 where
        that is unknown.
        """
        found = np.zeros((len(self.recording.t), 3))
        if self.driven is not None:
            slope, _ = five_point_stencil(self.recording, self.driven[:, :3])
            apart = body_velocity(self.driven[:, 2], slope) - self.driven[:, 3:]
            whole = np.isfinite(apart).all(axis=1)
            found[whole] = apart[whole]
        return found

    def errors(self, horizon: float) -> tuple[Array, Array]:
        """Times (m,) [s] and errors (m, 3) as of `predict`, without what they are expected to be."""
        begin = self.reference
        start, end = starts_and_ends(self.recording, begin, begin, horizon)
        states, _ = self._run(begin, start, end)
        self._check_states(states, horizon)
        return self.recording.t[end], np.asarray(begin.nu[end] - states[:, 3:])

    def predict(
        self,
        horizon: float,
        every: int = 1,
        starts: Motion | None = None,
        *,
        disturbed: bool = False,
    ) -> Prediction:
        """Velocities `horizon` [s] ahead, from every so many poses; `starts` as in `predict`.

        With a smoothed reference they start from the filter. `disturbed`: the filter's disturbance continues and
        decays: the k-step predictor with the noise model (Ljung, System Identification, section 3.2), as on board
        between poses and without poses.
        """
        if self.filtered is not None and self.smoothed is not None:
            starts = self.filtered.motion
        recording, begin = self.recording, self.reference if starts is None else starts
        # pairs of poses, one horizon apart
        start, end = starts_and_ends(recording, begin, self.reference, horizon, every)
        # the commands drive the model from each start
        if disturbed:
            states = self._run_disturbed(begin, start, end)
        else:
            states, _ = self._run(begin, start, end)
        self._check_states(states, horizon)
        # noise floor and expected error, over some of the starts
        steps = int(np.median(end - start))
        few = slice(None, None, max(1, len(start) // FLOOR_STARTS))
        slopes = self._slopes(begin, start[few], end[few])
        floor = self._floor(starts, start[few], end[few], steps, slopes[:, :, 3:6])
        noise = self._noise_variance(floor, begin, start, end, few, disturbed=disturbed)
        expected, parameters = self._expected(noise, slopes[:, :, 6:])
        floor, expected, variance = self._resolved(floor, expected, end)
        return Prediction(
            recording.stamps[end], recording.t[end], states[:, 3:], self.reference.nu[end], begin.nu[start],
            start, end, steps, floor, expected, parameters, variance,
        )  # fmt: skip

    def _check_states(self, states: Array, horizon: float) -> None:
        """Raises ModelError where a predicted state (m, 6) is not finite."""
        lost = int((~np.isfinite(states).all(axis=1)).sum())
        if lost:
            raise ModelError(
                f"{self.recording.name}: the model diverges from {lost} of {len(states)} start states within "
                f"{horizon:g} s; it can't be used at these speeds. {_why(self.model)}"
            )

    def _resolved(
        self, floor: Array, expected: Array | None, end: Poses
    ) -> tuple[Array, Array | None, Array | None]:
        """Floor and expected error, not below the standard error of a smoothed reference, and its variance."""
        if self.smoothed is None:
            return floor, expected, None
        variance = _deviation(self.smoothed, end, np.zeros(3)) ** 2
        least = np.sqrt(variance.mean(axis=0))
        expected = None if expected is None else np.maximum(expected, least)
        return np.maximum(floor, least), expected, variance

    def _run(
        self, begin: Motion, start: Poses, end: Poses, *, tangents: bool = False
    ) -> tuple[Array, Array]:
        x0 = np.column_stack([begin.eta[start], begin.nu[start]])
        return _core.predict(
            self.model.boat, self.trace_of_starts if tangents else self.trace, self.recording.t,
            start.astype(np.int32), end.astype(np.int32), np.ascontiguousarray(x0),
            threads=cores(), sensitivities=tangents,
        )  # fmt: skip

    def _slopes(self, begin: Motion, start: Poses, end: Poses) -> Array:
        """d nu(end) / d (state at the start, parameters): (n, 3, 6 + p).

        The last ones are kept: predictions with the disturbance and without have the same starts.
        """
        known = self._known[:1]
        if known and known[0][0] is begin and np.array_equal(known[0][1], [start, end]):
            return known[0][2]
        slopes = self._run(begin, start, end, tangents=True)[1][:, 3:]
        self._known[:] = [(begin, np.array([start, end]), slopes)]
        return slopes

    def _run_disturbed(self, begin: Motion, start: Poses, end: Poses) -> Array:
        """States (m, 6) at the ends of predictions with the filter's disturbance."""
        if self.filtered is None:
            raise ModelError("the disturbance is the filter's: give `filtered`")
        x0 = np.column_stack([begin.eta[start], begin.nu[start], self.filtered.state[start, 6:]])
        return _core.lookahead(
            disturbed_boat(self.model), self.trace, self.recording.t,
            start.astype(np.int32), end.astype(np.int32),
            np.ascontiguousarray(x0), self.filtered.noise,
            earth_fixed=earth_fixed(self.model.noise), threads=cores(),
        )  # fmt: skip

    def _noise_variance(
        self, floor: Array, begin: Motion, start: Poses, end: Poses, few: slice, *, disturbed: bool
    ) -> Array | None:
        """Variance (3,) from the noise of start (and reference), and process noise; None without the latter.

        From a filter's start both together: its error is correlated with the disturbance.
        """
        if self.smoothed is None or self.filtered is None:
            force = process_noise_variance(self.model, self.recording, begin, start, end)
            return None if force is None else np.asarray(floor**2 + force)
        if noise_vector(self.model.noise) is None:
            return None
        return np.asarray(
            self.filtered.prediction_variance(start[few], end[few], disturbed=disturbed).mean(
                axis=0
            )
        )

    def _expected(self, noise: Array | None, slopes: Array) -> tuple[Array | None, Array | None]:
        """Expected RMS^2 = variance by noise + parameter errors'^2; and the latter.

        slopes: (n, 3, p) d nu(end) / d parameters.
        """
        if noise is None:
            return None, None
        parameters = variance_of(slopes, self.model.covariance)
        return np.sqrt(noise + parameters), np.sqrt(parameters)

    def _floor(
        self, starts: Motion | None, start: Poses, end: Poses, steps: int, slopes: Array
    ) -> Array:
        """floor^2 = noise of the reference^2 + noise of the start, propagated through the model^2.

        The error of stencils (`missed`) is added in the same way. If the two stencils share poses, or errors are
        correlated, twice their covariance is subtracted (without the boat's turn in between). Against a smoothed
        reference only the start's noise counts: see `Prediction.squares`.
        slopes: (n, 3, 3) d nu(end) / d nu(start).
        """
        given = self.velocities
        if given is not None and given.deviation is None and starts is None:
            return np.zeros(3)
        if self.smoothed is not None and starts is not None:
            own = _deviation(starts, start, np.zeros(3))
            return np.asarray(np.sqrt(np.einsum("nij,nj->i", slopes**2, own**2) / len(start)))
        noisy = np.sqrt(self.stencil.covariance(0))
        reference = _deviation(given, end, noisy if given is None else np.zeros(3))
        first = _deviation(given if starts is None else starts, start, noisy)
        variance = reference**2 + np.einsum("nij,nj->ni", slopes**2, first**2)
        if given is None and starts is None:
            variance -= 2.0 * np.einsum("nii->ni", slopes) * self.stencil.covariance(steps)
        if given is None:
            missed = self.missed[end]
            if starts is None:
                missed = missed - np.einsum("nij,nj->ni", slopes, self.missed[start])
            variance += missed**2
        return np.asarray(np.sqrt(variance.mean(axis=0)))


def _deviation(moving: Motion | None, index: Poses, otherwise: Array) -> Array:
    """Standard deviations (m, 3) of velocities: their own, if they have any."""
    if moving is None or moving.deviation is None:
        return np.broadcast_to(otherwise, (len(index), 3))
    return np.asarray(moving.deviation[index])
