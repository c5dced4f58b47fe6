# SPDX-License-Identifier: MIT
"""Nonlinear model predictive control: thruster commands that follow a path within limits and walls."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from seatrial.boat.model import Model
from seatrial.boat.physics import axis_physics
from seatrial.control.mpc.problem import MOTION, POSE, Grid, Weights
from seatrial.control.mpc.step import Layout, step_function
from seatrial.control.mpc.thrusters import by_thrusters, thrusters_of
from seatrial.export.casadi import casadi_module
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array, frozen_array

if TYPE_CHECKING:
    import casadi

FIRST, LATER = 10, 3  # Gauss-Newton steps at most: without a last solution, and from it
SETTLED = 0.02  # of full thrust: a plan that a step moves by less is taken
SOLVED = np.array([1e-3, 0.1])  # a programme: rows violated by, cost above the least
OPEN = (np.inf, np.inf)


class Nmpc:
    """Follows a reference with every thruster on its own side of its dead zone.

    The boat is `self.model`: that of the argument with its thrusters' commands as inputs; a predictor
    or simulator beside this controller is to be made of it. Call `command` with what the predictor
    says of `latency` [s] from now, when the command begins to act. pool: (2,) its length and width [m],
    round the origin; the boat's origin keeps `clearance` [m] from its walls. Needs CasADi. Raises
    ModelError for a model that runs away, SeatrialError. A programme that is not solved counts in
    `self.unsolved`; one more begins at standing still, and where that fails, too, thrusters idle.
    """

    def __init__(
        self,
        model: Model,
        *,
        pool: Sequence[float] = OPEN,
        clearance: float = 0.0,
        grid: Grid = Grid(),  # noqa: B008 frozen
        weights: Weights = Weights(),  # noqa: B008 frozen
    ) -> None:
        size = np.array(pool, dtype=float)
        if size.shape != (2,) or not (size > 2.0 * clearance).all() or not clearance >= 0.0:
            raise ControlError(
                f"pool {pool}, clearance {clearance:g} m: expected length and width [m], above twice the "
                "clearance"
            )
        axis_physics(model)
        self.model = by_thrusters(model)
        self.thrusters = thrusters_of(self.model)
        self.grid, self.layout = grid, Layout(len(self.thrusters.lag), grid.stages)
        self.reach = frozen_array(size / 2 - clearance)  # (2,) of |x| and |y| [m]
        walls = np.repeat(self.reach, 2)
        self.function = step_function(self.model, self.thrusters, grid, weights, walls)
        self._call: casadi.Function = self.function
        self.forget()

    @property
    def latency(self) -> float:
        """From a command to where it begins to act [s]."""
        return self.thrusters.latency

    def forget(self) -> None:
        """As at the start: thrusters idle, no plan, no programme unsolved."""
        self._level = self.thrusters.idle
        self._thrust = self.thrusters.idle
        self._plan: Array | None = None
        self.unsolved = 0
        self._time = -np.inf

    def command(
        self, t: float, eta: ArrayLike, nu: ArrayLike, reference: ArrayLike, disturbance: ArrayLike = (0, 0, 0)
    ) -> Array:  # fmt: skip
        """Commands (n,) to the thrusters at t [s], by a pose (3,) and velocity (3,) of t + latency.

        reference: (stages, 6) eta and nu at `grid.times` after that. disturbance: (3,) earth-fixed
        acceleration, as of the predictor. A path beyond a wall is taken to go along it. Raises
        ControlError where a number is none.
        """
        motion = np.concatenate([np.asarray(eta, float), np.asarray(nu, float)])
        wanted, push = np.array(reference, dtype=float), np.asarray(disturbance, dtype=float)
        if (
            motion.shape != (MOTION,)
            or wanted.shape != (self.grid.stages, MOTION)
            or push.shape != (3,)
        ):
            raise ControlError(
                f"eta and nu of {motion.shape}, reference {wanted.shape}, disturbance {push.shape}: "
                f"expected (6,), ({self.grid.stages}, 6) and (3,)"
            )
        if not (
            np.isfinite(motion).all() and np.isfinite(wanted).all() and np.isfinite(push).all()
        ):
            raise ControlError("pose, velocity, reference or disturbance is not a number")
        wanted[:, 2] = np.unwrap(np.concatenate([motion[2:POSE], wanted[:, 2]]))[1:]
        wanted[:, :2] = np.clip(wanted[:, :2], -self.reach, self.reach)
        self._advance(t)
        z = np.concatenate([motion, self._level])
        self._solve(z, wanted, push)
        return self.thrusters.commands(self._thrust)

    def _advance(self, t: float) -> None:
        """Levels as they will be when a command of t begins to act."""
        if not t > self._time:
            raise ControlError(f"command at {t:g} s after one at {self._time:g} s: time goes on")
        gone = self.thrusters.decay(min(t - self._time, 1e3))
        self._level = self._thrust + (self._level - self._thrust) * gone
        self._time = t

    def _solve(self, z: Array, wanted: Array, push: Array) -> None:
        """A better plan from the last, or from standing still where there is none or that fails."""
        begins = [(self._standing(z), FIRST)]
        if self._plan is not None:
            begins.insert(0, (self._plan, LATER))
        found = (self._improved(plan, steps, z, wanted, push) for plan, steps in begins)
        self._plan = next((plan for plan in found if plan is not None), None)
        thrust = self.thrusters.idle if self._plan is None else self._plan[self.layout.thrust(0)]
        self._thrust = np.clip(thrust, self.thrusters.lowest, self.thrusters.highest)

    def _standing(self, z: Array) -> Array:
        """The plan of staying where it is, thrusters idle."""
        stage = np.concatenate([z, self.thrusters.idle, [0.0]])
        return np.concatenate([np.tile(stage, self.layout.stages), z])

    def _improved(
        self, plan: Array, steps: int, z: Array, wanted: Array, push: Array
    ) -> Array | None:
        """Up to so many Gauss-Newton steps further. None where a programme was not solved."""
        for _ in range(steps):
            found, off = self._call(plan, z, wanted.T, self._thrust, push)
            before, plan = plan, np.asarray(found).ravel()
            if not (np.asarray(off).ravel() <= SOLVED).all():
                self.unsolved += 1
                return None
            if not self._moved(before, plan) > SETTLED:
                break
        return plan

    def _moved(self, before: Array, after: Array) -> float:
        """Largest change of a thrust in the plan."""
        stages = range(self.layout.stages)
        return max(
            float(np.abs(after[g] - before[g]).max()) for g in map(self.layout.thrust, stages)
        )

    @property
    def path(self) -> Array:
        """Poses (stages + 1, 3) of the last plan. Raises ControlError before the first command."""
        if self._plan is None:
            raise ControlError("no plan yet: give a command first")
        blocks = [self._plan[k * self.layout.block :][:POSE] for k in range(self.grid.stages + 1)]
        return frozen_array(np.array(blocks))

    def generate(self, folder: str | Path) -> Path:
        """C of one step, seatrial_nmpc.c with its header; it needs the C library alone."""
        ca = casadi_module()

        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        generator = ca.CodeGenerator("seatrial_nmpc.c", {"with_header": True})
        generator.add(self.function)
        generator.generate(f"{folder}/")
        return folder / "seatrial_nmpc.c"

    def use(self, library: str | Path) -> None:
        """Take the compiled step from now on: a shared library of what `generate` wrote."""
        ca = casadi_module()

        self._call = ca.external(self.function.name(), str(library))
