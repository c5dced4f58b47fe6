# SPDX-License-Identifier: MIT
"""How well each use must know the model: the criteria of `workflow/fitness.py`, linearised in the parameters.

A need is a quantity, or its RMS over many instants, with slopes to the parameters and the 95 % half-width that the
criterion allows. Its width follows from any covariance: the model's, or the one expected after a manoeuvre.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import axis_physics
from seatrial.evaluation.assessment import HORIZONS
from seatrial.evaluation.expected_error import parameter_sensitivities, process_noise_variance
from seatrial.identification.experiment_design.simulated_drive import (
    SimulatedDrive,
    simulated_drive,
)
from seatrial.poolside.state import ParameterState
from seatrial.poolside.stick_patterns import stick_directions
from seatrial.recording.velocity import Motion
from seatrial.util.frames import AXES, Array, frozen_array
from seatrial.util.statistics import NORMAL_95
from seatrial.workflow.fitness import (
    BETTER_THAN_NONE,
    ODOMETRY_HORIZON,
    SIMULATED_WELL,
    Use,
    control_quantities,
)

REFERENCE_LENGTH = 60.0  # [s] of the drive that predictions are needed for
REFERENCE_PERIOD = 0.1  # [s] of its poses
# [s] as of the paper-like plan's operator
REFERENCE_PULSES, REFERENCE_PAUSES = (0.5, 3.0), (0.2, 2.0)
PREDICTED_EVERY = 1.0  # [s] between the starts of its predictions
# of a need's variance, which exact knowledge of a parameter takes away: it is needed
TAKES_PART = 0.1


@dataclass(frozen=True)
class Need:
    """A quantity that a use needs, and how well."""

    use: Use
    subject: str
    slopes: Array  # (k, p) of the quantity to the model's parameters, at k instants
    allowed: float  # 95 % half-width, of the RMS over the instants
    beyond: bool = False  # process noise alone exceeds the criterion: no drive meets it

    def __post_init__(self) -> None:
        object.__setattr__(self, "slopes", frozen_array(np.atleast_2d(self.slopes)))

    @cached_property
    def form(self) -> Array:
        """The matrix (p, p) whose product with the covariance has the quantity's variance as its trace."""
        return np.asarray(self.slopes.T @ self.slopes / len(self.slopes))

    def width(self, covariance: Array) -> float:
        """95 % half-width by a covariance (p, p)."""
        return NORMAL_95 * float(np.sqrt(max(np.sum(self.form * covariance), 0.0)))

    def ratio(self, covariance: Array) -> float:
        """The width over the allowed one: at most 1 where it is known."""
        return self.width(covariance) / self.allowed if self.allowed > 0.0 else float("inf")

    def parts(self, covariance: Array) -> Array:
        """Shares (p,) of the variance that exact knowledge of each parameter would take away."""
        variance, total = np.diag(covariance), float(np.sum(self.form * covariance))
        removed = np.sum((covariance @ self.form) * covariance, axis=1)
        known = (variance <= 0.0) | (total <= 0.0)
        return np.where(known, 0.0, removed / np.where(known, 1.0, variance * total))


def needs_of(model: Model, uses: Sequence[Use]) -> list[Need]:
    """The needs of some uses. Raises ModelError where the model is unstable."""
    found: list[Need] = []
    physics = axis_physics(model)
    if Use.CONTROL in uses:
        for one in control_quantities(model, physics):
            subject = one.subject or "latency and lag"
            found.append(Need(Use.CONTROL, subject, one.weights, one.limits[0] * one.size))
    horizons = {
        Use.ODOMETRY: (ODOMETRY_HORIZON, BETTER_THAN_NONE),
        Use.SIMULATION: (max(HORIZONS), SIMULATED_WELL),
    }
    asked = [use for use in (Use.ODOMETRY, Use.SIMULATION) if use in uses]
    if asked:
        drive = reference_drive(model)
        for use in asked:
            found += _prediction_needs(model, drive, use, *horizons[use])
    return found


def parameter_states(model: Model, needs: Sequence[Need]) -> tuple[ParameterState, ...]:
    """Every estimated parameter, with the half-width that the needs it takes part in leave it."""
    names = model.parameters
    values = np.concatenate([model.coefficients, model.constants])
    widths = NORMAL_95 * np.sqrt(np.maximum(np.diag(model.covariance), 0.0))
    rooms = [_room(need, model.covariance, widths) for need in needs]
    needed = np.min([np.full(len(names), np.inf), *rooms], axis=0)
    found = []
    for i in np.flatnonzero(widths > 0.0).tolist():
        name, error = names[i], model.standard_errors[names[i]]
        unit = model.units[name]
        room = float(needed[i]) if np.isfinite(needed[i]) else None
        known = bool(widths[i] <= needed[i])
        found.append(ParameterState(name, unit, float(values[i]), error, room, known))
    return tuple(found)


def _room(need: Need, covariance: Array, widths: Array) -> Array:
    """Half-widths (p,) that one need leaves the parameters; infinite for those that it does not depend on.

    A need that is not met leaves each the same part of its width. One that is met leaves what an error of this
    parameter alone may be, and its width where that is larger: errors of others then cancel its own.
    """
    ratio, alone = need.ratio(covariance), np.sqrt(np.diag(need.form))
    if ratio > 1.0:
        room = widths / ratio
    else:
        own = np.divide(need.allowed, alone, out=np.full(len(alone), np.inf), where=alone > 0.0)
        room = np.maximum(widths, own)
    return np.where(need.parts(covariance) >= TAKES_PART, room, np.inf)


def reference_drive(model: Model) -> SimulatedDrive:
    """A simulated drive with pulses of all sticks, of random size and length, as of the paper's operator.

    Raises ModelError where the model diverges.
    """
    rng = np.random.default_rng(1)
    directions = [one.command for one in stick_directions(model.vehicle)]
    grid = np.arange(0.0, REFERENCE_LENGTH, REFERENCE_PERIOD)
    commands = np.zeros((len(grid), len(model.vehicle.inputs)))
    for direction in directions:
        t = 0.0
        while t < REFERENCE_LENGTH:
            end = t + rng.uniform(*REFERENCE_PULSES)
            size = rng.uniform(0.2, 1.0) * rng.choice([-1.0, 1.0])
            commands[(grid >= t) & (grid < end)] += size * direction
            t = end + rng.uniform(*REFERENCE_PAUSES)
    return simulated_drive(model, np.zeros(6), (grid, np.clip(commands, -1.0, 1.0)), grid)


def _prediction_needs(
    model: Model, drive: SimulatedDrive, use: Use, horizon: float, limit: float
) -> Iterator[Need]:
    """Errors `horizon` [s] ahead, with process noise at most `limit` times constant velocity's."""
    count, ahead = len(drive.states), round(horizon / REFERENCE_PERIOD)
    start = np.arange(0, count - ahead, round(PREDICTED_EVERY / REFERENCE_PERIOD))
    end = start + ahead
    nu = drive.states[:, 3:]
    begin = Motion(drive.recording.t, drive.states[:, :3], nu, drive.recording.valid)
    slopes = parameter_sensitivities(model, drive.recording, begin, start, end)
    process = process_noise_variance(model, drive.recording, begin, start, end)
    noise = np.zeros(3) if process is None else process
    still = np.mean((nu[end] - nu[start]) ** 2, axis=0) + noise
    for axis, name in enumerate(AXES):
        room = limit**2 * still[axis] - noise[axis]
        # beyond it, parameters that are known as well as the process noise is large are known well enough
        allowed = float(np.sqrt(max(room, noise[axis])))
        subject = f"{name} {horizon:g} s ahead"
        yield Need(use, subject, slopes[:, axis], allowed, beyond=bool(room <= 0.0))
