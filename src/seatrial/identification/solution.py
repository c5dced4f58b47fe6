# SPDX-License-Identifier: MIT
"""Settings of the prediction-error estimator, and its solution."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import msgspec
import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import FIT_HORIZON, STATED_DELAYS, STATED_LEVER, Model
from seatrial.boat.noise_parameters import (
    OUTLIER,
    folded,
    noise_entry,
    noise_vector,
)
from seatrial.boat.schema import EstimatorEntry, Integration, RecordingEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.effects_as_noise import with_effects_as_noise
from seatrial.identification.likelihood.filter_runs import FilterRuns
from seatrial.identification.likelihood.fit_horizon import likelihood_noise
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.parameters import DELAY_NAMES, EFFECT_NAMES, LEVER_NAMES
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.provenance import envelope, recording_entry
from seatrial.recording.velocity import Motion, motion
from seatrial.util.frames import Array
from seatrial.util.statistics import BLOCK

OUTPUT_ERROR = "output-error"


@dataclass(frozen=True)
class OutputErrorSettings:
    """Settings of output-error."""

    outlier: float = OUTLIER  # [sigma] > 0, beyond which an innovation counts linearly (Huber)
    block: float = BLOCK  # [s] > 0, over which scores may be correlated, for standard errors
    step: float = 1 / 12  # [s] > 0, longest integration step; less where the boat is fast
    effects: tuple[str, ...] = ()  # to estimate, any of lever, current, trim, wind and delay
    hold_noise: bool = False  # the noise stays that of the start model
    select_stages: bool = True  # further actuator stages are tested and estimated where significant


@dataclass(frozen=True)
class StartValues:
    """Where a search starts: parameters by name, and noise."""

    values: Mapping[str, float]
    noise: Array | None  # (12,) of the filter; None: from the poses

    @staticmethod
    def of_model(model: Model) -> "StartValues":
        """Those of a model: coefficients and constants."""
        values = np.concatenate([model.coefficients, model.constants]).tolist()
        return StartValues(
            dict(zip(model.parameters, values, strict=True)), noise_vector(model.noise)
        )

    @staticmethod
    def of_solution(at: "Point | Fit") -> "StartValues":
        """The free parameters and the noise of a solution."""
        problem = at.runs.problem
        return StartValues({problem.names[i]: float(at.theta[i]) for i in problem.free}, at.noise)


@dataclass(frozen=True)
class Fit:
    """A solution: parameters, noise, filter runs, covariance, findings."""

    problem: Problem
    theta: Array  # all parameters, in the problem's order
    noise: Array  # (12,) of the filter
    runs: FilterRuns
    covariance: Array  # (p, p) of the free parameters
    settings: OutputErrorSettings
    findings: tuple[Finding, ...]
    horizon: float  # [s] fit horizon under model mismatch, 0: none
    maximum_noise: Array  # (12,) at the likelihood's maximum, before the horizon
    equal: Point  # the solution with one process noise for surge and sway: see `with_equal_axes`

    @staticmethod
    def of(
        at: Point,
        covariance: Array,
        settings: OutputErrorSettings,
        findings: Sequence[Finding] = (),
        *,
        horizon: float = 0.0,
        maximum: Point | None = None,
        equal: Point | None = None,
    ) -> "Fit":
        """From a solution, whose linearisation is dropped; `maximum`, `equal`: absent, the solution."""
        likely = at if maximum is None else maximum
        alike = at if equal is None else equal
        for point in (at, likely, alike):
            point.runs.drop_linearisation()
        return Fit(
            at.runs.problem, at.theta, at.noise, at.runs, covariance, settings, tuple(findings), horizon,
            likely.noise, alike,
        )  # fmt: skip

    @property
    def point(self) -> Point:
        """Parameters, noise and filter runs."""
        return Point(self.theta, self.noise, self.runs)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the free parameters."""
        return tuple(self.problem.names[i] for i in self.problem.free)

    @cached_property
    def errors(self) -> dict[str, float]:
        """Standard errors by name."""
        return dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    def model_covariance(self) -> Array:
        """Covariance (n, n) of all coefficients and constants, 0 of those that were given."""
        size = self.problem.n_coefficients + self.problem.n_constants
        own = [k for k, i in enumerate(self.problem.free) if i < size]
        at = [self.problem.free[k] for k in own]
        covariance = np.zeros((size, size))
        covariance[np.ix_(at, at)] = self.covariance[np.ix_(own, own)]
        return covariance

    def model(self) -> Model:
        """The model, with the covariance of coefficients and constants."""
        problem, theta, n = self.problem, self.theta, self.problem.n_coefficients
        size = n + problem.n_constants
        settings: dict[str, str | float | int | bool | None] = {
            "outlier": self.settings.outlier, "block": self.problem.block, FIT_HORIZON: self.horizon,
            "effects": ", ".join(self.settings.effects),
        }  # fmt: skip
        if self._lever() and (stated := problem.vehicle.stated_lever) is not None:
            settings[STATED_LEVER] = stated
        if self._delays() and (stated := problem.vehicle.stated_delays) is not None:
            settings[STATED_DELAYS] = stated
        recordings = problem.recordings
        noise = likelihood_noise(self.point, self.maximum_noise) if self.horizon else self.noise
        noise = folded(noise, min(r.period for r in recordings))
        entries = tuple(self._entry(i) for i in range(len(recordings)))
        moving = self._moving()
        noise, earth = with_effects_as_noise(
            noise,
            [entry.effects for entry in entries],
            moving,
            problem.vehicle,
            np.ascontiguousarray(theta[:n]),
        )
        constants = theta[n:size]
        lever = theta[problem.effects(0)[: len(LEVER_NAMES)]]
        vehicle = with_further_delays(problem, theta)
        return Model(
            with_lever(vehicle, *lever.tolist()), theta[:n], self.model_covariance(), constants,
            Integration("runge-kutta", problem.step),
            noise_entry(noise, earth=problem.earth_fixed if earth is None else earth),
            envelope(problem.vehicle, constants, recordings, moving),
            entries,
            EstimatorEntry(OUTPUT_ERROR, settings, findings=[*self.findings, *self._lever(), *self._delays()]),
        )  # fmt: skip

    def _moving(self) -> list[Motion]:
        """Velocity of the boat's origin through the water, by recording."""
        whole = range(len(self.problem.recordings))
        return [motion(self.problem.origin_poses(i, self.theta)) for i in whole]

    def _entry(self, recording: int) -> RecordingEntry:
        """A recording with its estimated effects."""
        own = recording_entry(self.problem.recordings[recording])
        first = len(LEVER_NAMES)
        places = self.problem.effects(recording)[first : first + len(EFFECT_NAMES)].tolist()
        sought = {
            name: float(self.theta[i])
            for name, i in zip(EFFECT_NAMES, places, strict=True)
            if i in self.problem.free
        }
        errors = {name: self.errors[f"{name}.{own.name}"] for name in sought}
        entry: RecordingEntry = msgspec.structs.replace(own, effects=sought, errors=errors)
        return entry

    def _lever(self) -> list[Finding]:
        """Standard errors of the lever arm, where it was estimated."""
        errors = [self.errors[name] for name in LEVER_NAMES if name in self.errors]
        if not errors:
            return []
        ahead, aside = errors
        return [finding_of(FindingKind.LEVER_ARM_ERRORS, ahead=ahead, aside=aside)]

    def _delays(self) -> list[Finding]:
        """The delays of position and heading with standard errors, where estimated and not at a bound."""
        errors = [self.errors.get(name) for name in DELAY_NAMES]
        late = with_further_delays(self.problem, self.theta).delays
        if None not in errors:
            return [
                finding_of(FindingKind.DELAY, what, delay=delay, error=error)
                for what, delay, error in zip(("position", "heading"), late, errors, strict=True)
                if error
            ]
        older, newer = ("position", "heading") if late[0] >= late[1] else ("heading", "position")
        return [
            finding_of(
                FindingKind.DELAY_DIFFERENCE,
                older,
                newer,
                delay=abs(late[0] - late[1]),
                error=error,
            )
            for error in errors
            if error
        ]


def with_further_delays(problem: Problem, theta: Array) -> Vehicle:
    """The vehicle with the estimated delays added to those of its file."""
    if not any(problem.names[i] in DELAY_NAMES for i in problem.free):
        return problem.vehicle
    position, heading = np.add(problem.vehicle.delays, theta[problem.delays]).tolist()
    return problem.vehicle.with_delays(position, heading)


def with_lever(vehicle: Vehicle, ahead: float, left: float) -> Vehicle:
    """The vehicle with the estimated step [m] added to its lever arm, forward-left-up."""
    if ahead == left == 0.0:
        return vehicle
    return vehicle.with_lever((vehicle.lever[0] + ahead, vehicle.lever[1] + left))
