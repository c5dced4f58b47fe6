# SPDX-License-Identifier: MIT
"""What the prediction-error estimator minimises: the filter over all recordings.

Parameters are numbered through: the structure's coefficients, the constants of the actuator
chain, and effects: the lever arm, then for every recording its current, trim and wind.
"""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat.model import thrust_trace
from seatrial.boat.structure import Structure
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.filtering import disturbed, series
from seatrial.recording.recording import Recording
from seatrial.util.frames import SYMBOLS, Array
from seatrial.util.parallel import spread

LEVER = ("lever_x", "lever_y")  # [m] the measured point from the origin
EFFECTS = (  # of one recording, in the order of the core's Effects after the lever arm
    "current_x", "current_y",  # [m/s] earth-fixed
    "trim_u", "trim_v", "trim_r",  # [m/s^2, rad/s^2] body-fixed
    "wind_x", "wind_y",  # [m/s^2] earth-fixed
)  # fmt: skip
KINDS = ("lever", "current", "trim", "wind")
LONG = 100_000  # poses of all recordings from which on memory that was let go is given back
BOUNDS = {  # of the constants that are estimated
    "latency": (-1.0, 2.0),  # [s]
    "lag": (0.002, 3.0),  # [s]
    "edge_forward": (0.0, 0.6),
    "edge_reverse": (0.0, 0.6),
    "reverse_ratio": (0.1, 10.0),
    "power": (0.3, 4.0),
    "scale_power": (-1.0, 5.0),
    "gain": (0.1, 10.0),
    "pair_offset_along": (-0.5, 0.5),
    "pair_offset_across": (-0.5, 0.5),
    "pair_dead_zone": (0.0, 0.6),
}
REACH = {  # of one step of the search
    "latency": 0.1,  # [s]
    "lag": 0.1,  # [s]
    "edge_forward": 0.1,
    "edge_reverse": 0.1,
    "reverse_ratio": 0.5,
    "power": 0.5,
    "scale_power": 0.5,
    "gain": 0.5,
}


def quadratic_drag(structure: Structure) -> set[str]:
    """Coefficients of |u| u in surge, |v| v in sway, |r| r in yaw: what grows without end, and so
    would drive the boat without end if it were positive."""
    terms = [t for t in structure.terms if t.coefficient is not None]
    used = Counter(t.coefficient for t in terms)
    return {
        t.coefficient
        for t in terms
        if t.coefficient is not None
        and used[t.coefficient] == 1
        and t.number > 0.0
        and t.acceleration is None
        and sorted(t.factors) == sorted([f"|{SYMBOLS[t.axis]}|", SYMBOLS[t.axis]])
    }


@dataclass(frozen=True)
class Prior:
    """What is known beforehand: a normal distribution of some parameters."""

    at: Array  # (p,)
    precision: Array  # (p, p), 0 where nothing is known

    def cost(self, theta: Array) -> float:
        """-2 log likelihood, but for a constant."""
        off = theta - self.at
        return float(off @ self.precision @ off)


@dataclass(frozen=True)
class Problem:
    """What does not change during the search."""

    vehicle: Vehicle
    recordings: tuple[Recording, ...]
    free: tuple[int, ...]  # parameters that are sought
    step: float  # [s] longest of the integration
    outlier: float  # [sigma] from which on a pose's error counts linearly
    block: float  # [s] over which scores may be correlated
    prior: Prior | None = None
    earth_fixed: bool = False  # whether what pushes the boat stays with the world, as wind does

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of all parameters."""
        own = (*self.vehicle.structure.coefficients, *self.vehicle.constants.names, *LEVER)
        return (*own, *(f"{name}.{r.name}" for r in self.recordings for name in EFFECTS))

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return len(self.vehicle.structure.coefficients)

    @property
    def constants(self) -> int:
        """Number of constants."""
        return len(self.vehicle.constants.names)

    @cached_property
    def structure(self) -> _core.Structure:
        """The structure with a disturbance in every axis, its last three coefficients."""
        return disturbed(self.vehicle)

    @cached_property
    def series(self) -> list[_core.Series]:
        """The poses, and where each recording starts."""
        return [series(recording) for recording in self.recordings]

    @cached_property
    def blocks(self) -> list[NDArray[np.int32]]:
        """Of every recording, which block each pose (n,) belongs to; blocks without poses are none."""
        numbers = [(r.t // self.block).astype(np.int32) for r in self.recordings]
        return [np.cumsum(np.diff(n, prepend=n[:1]) > 0, dtype=np.int32) for n in numbers]

    @cached_property
    def chosen(self) -> tuple[list[int], list[int]]:
        """Free coefficients and free constants, each counted from their own first."""
        n, m = self.size, self.constants
        return [i for i in self.free if i < n], [i - n for i in self.free if n <= i < n + m]

    @cached_property
    def sought(self) -> tuple[int, ...]:
        """Effects among the free parameters."""
        return tuple(i for i in self.free if i >= self.size + self.constants)

    @property
    def disturbed(self) -> bool:
        """Whether any effect is sought."""
        return bool(self.sought)

    def effects(self, recording: int) -> NDArray[np.int64]:
        """Where the effects on a recording stand among all parameters."""
        lever = self.size + self.constants
        own = lever + len(LEVER) + recording * len(EFFECTS)
        return np.array([*range(lever, lever + len(LEVER)), *range(own, own + len(EFFECTS))])

    def places(self, recording: int) -> NDArray[np.int64]:
        """Where the parameters of a recording's pass stand among the free ones; -1: nowhere."""
        coefficients, constants = self.chosen
        own = [*coefficients, *(self.size + c for c in constants)]
        own += [int(i) for i in self.effects(recording)] if self.disturbed else []
        free = {parameter: i for i, parameter in enumerate(self.free)}
        return np.array([free.get(i, -1) for i in own])

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest values (p,) of the free parameters."""
        kinds = [self.names[i].partition(".")[0] for i in self.free]
        is_constant = [self.size <= i < self.size + self.constants for i in self.free]
        drag = quadratic_drag(self.vehicle.structure)
        found = [
            BOUNDS[kind] if own else (-np.inf, 0.0 if self.names[i] in drag else np.inf)
            for i, kind, own in zip(self.free, kinds, is_constant, strict=True)
        ]
        low, high = np.array(found).reshape(-1, 2).T
        return low, high

    @cached_property
    def reach(self) -> Array:
        """How far (p,) one step may go: what the chain does is far from linear."""
        kinds = [self.names[i].partition(".")[0] for i in self.free]
        return np.array([REACH.get(kind, np.inf) for kind in kinds])

    def bounded(self, theta: Array) -> Array:
        """The nearest parameters within bounds."""
        out, free = theta.copy(), list(self.free)
        out[free] = np.clip(theta[free], *self.bounds)
        return out

    def passes(
        self,
        theta: Array,
        noise: Array,
        counts: list[Array] | None = None,
        *,
        repeatable: bool = True,
        shares: bool = False,
    ) -> "Passes":
        """The filter over all recordings.

        `counts`: how often each pose counts. `repeatable`: its ways are kept, for other noise.
        `shares`: what each block has of the information is kept, too.
        """
        coefficients, constants = self.chosen
        boat = _core.Boat(
            self.structure, np.concatenate([theta[: self.size], np.zeros(3)]), 0, self.step
        )
        columns = [*coefficients, self.size, self.size + 1, self.size + 2]
        q = np.ascontiguousarray(theta[self.size : self.size + self.constants])

        def one(i: int) -> _core.FilterPass:
            trace = thrust_trace(
                self.vehicle, q, self.recordings[i],
                initial=True, coefficients=columns, tangents=constants,
            )  # fmt: skip
            return _core.innovations(
                boat, trace, self.series[i], noise, self.outlier,
                np.ascontiguousarray(theta[self.effects(i)]) if self.disturbed else None,
                None if counts is None else counts[i],
                self.blocks[i],
                repeatable,
                shares,
                self.earth_fixed,
            )  # fmt: skip

        each = spread(one, range(len(self.recordings)))
        return Passes(self, theta, tuple(each))


@dataclass(frozen=True)
class Passes:
    """The filter's passes over all recordings; with the prior's share where there is one."""

    problem: Problem
    theta: Array
    each: tuple[_core.FilterPass, ...]

    @cached_property
    def cost(self) -> float:
        """-2 log likelihood, but for a constant; infinite where the boat diverged, or the numbers ran out."""
        if not all(p.good and np.diag(p.information).min(initial=0.0) >= 0.0 for p in self.each):
            return np.inf
        prior = self.problem.prior
        return sum(p.cost for p in self.each) + (prior.cost(self.theta) if prior else 0.0)

    @cached_property
    def information(self) -> Array:
        """Fisher's (p, p) of the free parameters."""
        free = list(self.problem.free)
        out = np.zeros((len(free), len(free)))
        for i, each in enumerate(self.each):
            to = self.problem.places(i)
            use = to >= 0
            out[np.ix_(to[use], to[use])] += each.information[np.ix_(use, use)]
        prior = self.problem.prior
        return out if prior is None else out + prior.precision[np.ix_(free, free)]

    @cached_property
    def gradient(self) -> Array:
        """Of the log likelihood (p,)."""
        free = list(self.problem.free)
        out = np.zeros(len(free))
        for i, each in enumerate(self.each):
            to = self.problem.places(i)
            out[to[to >= 0]] += each.gradient[to >= 0]
        prior = self.problem.prior
        return out if prior is None else out - (prior.precision @ (self.theta - prior.at))[free]

    @property
    def repeatable(self) -> bool:
        """Whether the ways are there that other noise is tried on."""
        return all(p.repeatable for p in self.each)

    def forget_ways(self) -> None:
        """Lets the ways go, half of what a pass keeps."""
        for each in self.each:
            each.forget_way()
        self._give_back()

    def forget_poses(self) -> None:
        """Lets all go that was kept pose by pose; cost, gradient and information stay."""
        for each in self.each:
            each.forget_poses()
        self._give_back()

    def _give_back(self) -> None:
        if sum(len(r.t) for r in self.problem.recordings) > LONG:
            _core.give_back()

    @cached_property
    def scores(self) -> Array:
        """Terms (blocks, p) of the gradient, block by block of all recordings."""
        found = []
        for i, each in enumerate(self.each):
            to = self.problem.places(i)
            own = each.score
            out = np.zeros((len(own), len(self.problem.free)))
            out[:, to[to >= 0]] = own[:, to >= 0]
            found.append(out)
        return np.concatenate(found)
