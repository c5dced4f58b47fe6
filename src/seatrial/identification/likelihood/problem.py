# SPDX-License-Identifier: MIT
"""The cost that the prediction-error estimator minimises: -2 log likelihood of the innovations.

The parameter vector theta has the structure's coefficients, then the constants of the actuator chain,
then the effects: the lever arm, the delays of position and heading, and current, trim and wind of every recording.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import Model, thrust_trace
from seatrial.boat.noise_parameters import least_noise
from seatrial.boat.schema import EnvelopeEntry, Integration, NoiseEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.filtering import filter_series, simulated_series, with_disturbance
from seatrial.evaluation.input_errors import InputErrors
from seatrial.identification.likelihood.parameters import (
    CHAIN_CONSTANTS,
    DELAY_NAMES,
    DELAY_STEP,
    EFFECT_NAMES,
    LEVER_NAMES,
    LONGEST_DELAY,
    ChainConstant,
    quadratic_drag,
)
from seatrial.recording.delays import at_one_time, with_delays
from seatrial.recording.origin import poses_of_origin
from seatrial.recording.recording import Recording
from seatrial.recording.resolution import heading_step
from seatrial.util.frames import Array


@dataclass(frozen=True)
class Prior:
    """A normal prior distribution of some parameters."""

    mean: Array  # (p,)
    precision: Array  # (p, p), 0 for parameters without a prior

    def cost(self, theta: Array) -> float:
        """-2 log density, up to a constant."""
        off = theta - self.mean
        return float(off @ self.precision @ off)


@dataclass(frozen=True)
class Problem:
    """Everything that stays constant during the search."""

    vehicle: Vehicle
    recordings: tuple[Recording, ...]
    free: tuple[int, ...]  # indices of the parameters that are estimated
    step: float  # [s] longest step of the integration
    outlier: float  # [sigma] innovations beyond it count linearly (Huber)
    block: float  # [s] length of a block; scores of two blocks count as independent
    prior: Prior | None = None
    input_errors: tuple[InputErrors | None, ...] = ()  # of each recording; empty: none
    # whether the disturbance force keeps its direction in the world, as wind does
    earth_fixed: bool = False
    whole_period: float = 0.0  # [s] of all poses, where these are some of them; 0: these are all
    # (3,) at the first pose of simulated recordings; empty: not known
    start_velocities: tuple[Array, ...] = ()

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all parameters."""
        own = (*self.vehicle.structure.coefficients, *self.vehicle.constants.names)
        sensor = (*LEVER_NAMES, *DELAY_NAMES)
        return (
            *own,
            *sensor,
            *(f"{name}.{r.name}" for r in self.recordings for name in EFFECT_NAMES),
        )

    @property
    def n_coefficients(self) -> int:
        """Number of coefficients."""
        return len(self.vehicle.structure.coefficients)

    @property
    def n_constants(self) -> int:
        """Number of constants."""
        return len(self.vehicle.constants.names)

    @cached_property
    def structure(self) -> _core.Structure:
        """The structure with a disturbance in every axis, its last three coefficients."""
        return with_disturbance(self.vehicle)

    @cached_property
    def series(self) -> list[_core.Series]:
        """The poses of every recording, as the core takes them."""
        errors = self.input_errors or (None,) * len(self.recordings)
        if self.start_velocities:
            own = zip(self.recordings, self.start_velocities, errors, strict=True)
            return [simulated_series(*each) for each in own]
        return [filter_series(r, e) for r, e in zip(self.recordings, errors, strict=True)]

    @cached_property
    def blocks(self) -> list[NDArray[np.int32]]:
        """Of every recording, the number of the block of each pose (n,); only those with usable poses count."""
        found = []
        for r in self.recordings:
            places = (r.t // self.block).astype(np.int32)
            used = np.unique(places[r.valid])
            numbers = np.searchsorted(used, places).clip(max=len(used) - 1)
            found.append(numbers.astype(np.int32))
        return found

    @property
    def n_blocks(self) -> int:
        """Number of blocks of all recordings."""
        return sum(int(numbers[-1]) + 1 for numbers in self.blocks)

    @cached_property
    def free_of_model(self) -> tuple[list[int], list[int]]:
        """Indices of the free coefficients, and of the free constants among the constants."""
        n, m = self.n_coefficients, self.n_constants
        return [i for i in self.free if i < n], [i - n for i in self.free if n <= i < n + m]

    @cached_property
    def free_effects(self) -> tuple[int, ...]:
        """Indices of the free effects among all parameters."""
        return tuple(i for i in self.free if i >= self.n_coefficients + self.n_constants)

    @cached_property
    def least_noise(self) -> Array:
        """Lower bounds (12,) of the noise; white heading errors are no less than those of rounded headings.

        These have a deviation of step / sqrt(12), about which an estimate scatters.
        """
        least = least_noise()
        least[1] = max(least[1], 0.25 * min(heading_step(r) for r in self.recordings))
        return least

    @cached_property
    def period(self) -> float:
        """Period [s] of the poses."""
        return float(np.median([r.period for r in self.recordings]))

    @property
    def has_effects(self) -> bool:
        """Whether any effect is estimated."""
        return bool(self.free_effects)

    def effects(self, recording: int) -> NDArray[np.int64]:
        """Indices of a recording's effects among all parameters, in the core's order."""
        first = self.n_coefficients + self.n_constants
        lever, delays = np.arange(first, first + 2), np.arange(first + 2, first + 4)
        own = np.arange(len(EFFECT_NAMES)) + first + 4 + recording * len(EFFECT_NAMES)
        return np.concatenate([lever, own, delays])

    @property
    def delays(self) -> slice:
        """Where the delays of position and heading are in theta."""
        first = self.n_coefficients + self.n_constants + len(LEVER_NAMES)
        return slice(first, first + len(DELAY_NAMES))

    def origin_poses(
        self, recording: int, theta: Array, span: tuple[float, float] | None = None
    ) -> Recording:
        """A recording, or a span [s] of it, with poses of the boat's origin at one time, in axes that drift with
        the current."""
        lever, current = np.split(theta[self.effects(recording)][:4], 2)
        own = self.recordings[recording]
        own = own if span is None else own.cut(*span)
        late = with_delays(own, *theta[self.delays].tolist())
        return poses_of_origin(at_one_time(late), lever, current)

    def free_columns(self, recording: int) -> NDArray[np.int64]:
        """For every parameter of a recording's filter run its index among the free ones; -1: not free."""
        coefficients, constants = self.free_of_model
        own = [*coefficients, *(self.n_coefficients + c for c in constants)]
        own += [int(i) for i in self.effects(recording)] if self.has_effects else []
        free = {parameter: i for i, parameter in enumerate(self.free)}
        return np.array([free.get(i, -1) for i in own])

    @cached_property
    def _kinds(self) -> list[tuple[str, ChainConstant | None]]:
        """Of the free parameters: the name without its group or recording, and what is assumed of a constant."""
        n, m = self.n_coefficients, self.n_constants
        kinds = [self.names[i].partition(".")[0] for i in self.free]
        return [
            (kind, CHAIN_CONSTANTS[kind] if n <= i < n + m else None)
            for i, kind in zip(self.free, kinds, strict=True)
        ]

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest values (p,) of the free parameters."""
        drag = quadratic_drag(self.vehicle.structure)
        late = dict(zip(DELAY_NAMES, self.vehicle.delays, strict=True))
        found = []
        for i, (kind, constant) in zip(self.free, self._kinds, strict=True):
            if constant is not None:
                found.append(self.vehicle.constants.bounds(i - self.n_coefficients))
            elif kind in late:
                found.append((-LONGEST_DELAY - late[kind], LONGEST_DELAY - late[kind]))
            else:
                found.append((-np.inf, 0.0 if self.names[i] in drag else np.inf))
        low, high = np.array(found).reshape(-1, 2).T
        return low, high

    @cached_property
    def step_limits(self) -> Array:
        """Largest change (p,) of the free parameters in one step."""
        return np.array(
            [
                constant.step
                if constant is not None
                else DELAY_STEP
                if kind in DELAY_NAMES
                else np.inf
                for kind, constant in self._kinds
            ]
        )

    def clipped(self, theta: Array) -> Array:
        """The nearest parameters within the bounds."""
        out, free = theta.copy(), list(self.free)
        out[free] = np.clip(theta[free], *self.bounds)
        return out

    def model(self, theta: Array, noise: NoiseEntry) -> Model:
        """The model with these parameters for predictions, without uncertainty."""
        n, m = self.n_coefficients, self.n_constants
        return Model(
            self.vehicle, theta[:n], np.zeros((n + m, n + m)), theta[n : n + m],
            Integration("runge-kutta", self.step), noise, EnvelopeEntry({}, {}),
        )  # fmt: skip

    def boat(self, theta: Array) -> _core.Boat:
        """The boat with these parameters, and a disturbance in every axis."""
        coefficients = np.concatenate([theta[: self.n_coefficients], np.zeros(3)])
        return _core.Boat(self.structure, coefficients, 0, self.step)

    def trace(self, theta: Array, recording: Recording) -> _core.ThrustTrace:
        """Thrust along a recording, with the columns of the free parameters."""
        n, m = self.n_coefficients, self.n_constants
        coefficients, constants = self.free_of_model
        return thrust_trace(
            self.vehicle, np.ascontiguousarray(theta[n : n + m]), recording,
            initial=True, coefficients=[*coefficients, n, n + 1, n + 2], tangents=constants,
        )  # fmt: skip

    def own_effects(self, theta: Array, recording: int) -> Array | None:
        """A recording's effects (_core.EFFECTS,), where any is free."""
        if not self.has_effects:
            return None
        return np.ascontiguousarray(theta[self.effects(recording)])
