# SPDX-License-Identifier: MIT
"""The filter along all recordings of a problem: its cost, gradient and information about the free parameters."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from seatrial import _core
from seatrial.boat.noise_scoring import Linearised
from seatrial.identification.likelihood.problem import Problem
from seatrial.util.frames import Array
from seatrial.util.parallel import spread

MANY_POSES = 100_000  # poses of all recordings: from here on, freed memory goes back to the system


@dataclass(frozen=True)
class FilterRuns:
    """The filter's results along all recordings; cost, information and gradient include the prior."""

    problem: Problem
    theta: Array
    by_recording: tuple[_core.FilterRun, ...]

    @cached_property
    def cost(self) -> float:
        """-2 log likelihood, up to a constant; infinite where the model diverges or the filter loses precision."""
        if not all(
            p.good and np.diag(p.information).min(initial=0.0) >= 0.0 for p in self.by_recording
        ):
            return np.inf
        prior = self.problem.prior
        return sum(p.cost for p in self.by_recording) + (prior.cost(self.theta) if prior else 0.0)

    @cached_property
    def information(self) -> Array:
        """Fisher information (p, p) of the free parameters."""
        free, prior = list(self.problem.free), self.problem.prior
        out = np.zeros((len(free), len(free)))
        for i in range(len(self.by_recording)):
            out += self.information_of(i)
        return out if prior is None else out + prior.precision[np.ix_(free, free)]

    def information_of(self, recording: int) -> Array:
        """Fisher information (p, p) of one recording about the free parameters, without the prior."""
        to, out = self.problem.free_columns(recording), np.zeros((len(self.problem.free),) * 2)
        use = to >= 0
        own = np.asarray(self.by_recording[recording].information)
        out[np.ix_(to[use], to[use])] = own[np.ix_(use, use)]
        return out

    @cached_property
    def gradient(self) -> Array:
        """Gradient (p,) of the log likelihood."""
        free, prior = list(self.problem.free), self.problem.prior
        out = np.zeros(len(free))
        for i in range(len(self.by_recording)):
            out += self.gradient_of(i)
        return out if prior is None else out - (prior.precision @ (self.theta - prior.mean))[free]

    def gradient_of(self, recording: int) -> Array:
        """Gradient (p,) of one recording's log likelihood, without the prior."""
        to, out = self.problem.free_columns(recording), np.zeros(len(self.problem.free))
        out[to[to >= 0]] = np.asarray(self.by_recording[recording].gradient)[to >= 0]
        return out

    def _own_steps(self, move: Array) -> list[Array]:
        """A step (names,) of all parameters as that of each run's own."""
        of_free = move[list(self.problem.free)]
        found = []
        for i in range(len(self.by_recording)):
            to = self.problem.free_columns(i)
            found.append(np.where(to >= 0, of_free[to], 0.0))
        return found

    def linearised(self, move: Array | None = None) -> Linearised:
        """The linearisation, a step `move` (names,) of the parameters away."""
        steps = () if move is None else self._own_steps(move)
        problem = self.problem
        return Linearised(
            self.by_recording,
            problem.series,
            problem.period,
            problem.outlier,
            steps,
            problem.has_effects,
        )

    def relinearised(self, noise: Array, move: Array) -> "FilterRuns":
        """Runs by the linearisation, a step `move` (names,) of the parameters away and with other noise (12,)."""
        problem, steps = self.problem, self._own_steps(move)

        def one(i: int) -> _core.FilterRun:
            return _core.relinearised(
                self.by_recording[i], problem.series[i], noise, problem.outlier,
                steps[i], problem.has_effects, problem.blocks[i],
            )  # fmt: skip

        found = tuple(spread(one, range(len(self.by_recording))))
        return FilterRuns(problem, self.theta + move, found)

    def drop_linearisation(self) -> None:
        """Frees the linearised trajectories, half of the memory of a run."""
        for run in self.by_recording:
            run.forget_transitions()
        self._give_back()

    def drop_poses(self) -> None:
        """Frees everything that is kept pose by pose; cost, gradient and information stay."""
        for run in self.by_recording:
            run.forget_poses()
        self._give_back()

    def _give_back(self) -> None:
        if sum(len(r.t) for r in self.problem.recordings) > MANY_POSES:
            _core.give_back()

    @cached_property
    def scores(self) -> Array:
        """Contribution (blocks, p) of every block of all recordings to the gradient."""
        found = []
        for i, run in enumerate(self.by_recording):
            to = self.problem.free_columns(i)
            own = run.score
            out = np.zeros((len(own), len(self.problem.free)))
            out[:, to[to >= 0]] = own[:, to >= 0]
            found.append(out)
        return np.concatenate(found)

    @cached_property
    def shares(self) -> Array:
        """Information (blocks, p, p) in every block of all recordings; of a pass with `shares`."""
        p, found = len(self.problem.free), []
        for i, run in enumerate(self.by_recording):
            to = self.problem.free_columns(i)
            use = to >= 0
            own = run.share.reshape(-1, len(to), len(to))
            out = np.zeros((len(own), p, p))
            out[np.ix_(np.arange(len(own)), to[use], to[use])] = own[:, use][:, :, use]
            found.append(out)
        return np.concatenate(found)


def filter_along(
    problem: Problem,
    theta: Array,
    noise: Array,
    counts: list[Array] | None = None,
    *,
    repeatable: bool = True,
    shares: bool = False,
) -> FilterRuns:
    """The extended Kalman filter along all recordings, with sensitivities to the free parameters.

    `counts`: weight of each pose. `repeatable`: the linearised trajectory is kept, to evaluate other noise
    without integration. `shares`: the information of each block is kept as well.
    """
    boat = problem.boat(theta)

    def one(i: int) -> _core.FilterRun:
        trace = problem.trace(theta, problem.recordings[i])
        return _core.innovations(
            boat, trace, problem.series[i], noise, problem.outlier,
            problem.own_effects(theta, i),
            None if counts is None else counts[i],
            problem.blocks[i],
            repeatable,
            shares,
            problem.earth_fixed,
        )  # fmt: skip

    return FilterRuns(problem, theta, tuple(spread(one, range(len(problem.recordings)))))
