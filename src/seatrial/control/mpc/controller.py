# SPDX-License-Identifier: MIT
"""Nonlinear model predictive control: thruster commands that track a path within limits and walls."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.physics import axis_physics
from seatrial.control.mpc.problem import (
    MOTION_SIZE,
    PATH_FOLLOWING,
    PATH_GRID,
    POSE_SIZE,
    STEERED_FOLLOWING,
    STEERED_GRID,
    Grid,
    Weights,
)
from seatrial.control.mpc.step import Layout, step_function
from seatrial.control.mpc.thrusters import by_thrusters, thrusters_of
from seatrial.export.casadi import casadi_module
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array, frozen_array

if TYPE_CHECKING:
    import casadi

# Gauss-Newton steps at most: without a previous solution, and from it
COLD_START_STEPS, WARM_START_STEPS = 10, 3
CONVERGED_THRUST = 0.02  # of full thrust: the plan is accepted when a step changes it by less
# of a quadratic programme: constraint violation, duality gap
SOLVED_TOLERANCE = np.array([1e-3, 0.1])
NO_WALLS = (np.inf, np.inf)


class Nmpc:
    """Follows a reference with every thruster on its own side of its dead zone.

    One thruster and the angle that turns its thrust (`steered`) are two inputs; the angle's rate limit is a
    constraint.

    A boat without sway thrust follows the reference's path: heading and sway are free, and grid and weights
    are `PATH_GRID` and `PATH_FOLLOWING` unless given, `STEERED_GRID` and `STEERED_FOLLOWING` of a steered one.

    The boat is `self.model`: that of the argument with its thrusters' commands as inputs; a predictor
    or simulator for this controller uses the same one. Call `command` with the predictor's
    state `latency` [s] from now, when the command takes effect. pool: (2,) its length and width [m],
    around the origin; the boat's origin keeps `clearance` [m] from its walls. Needs CasADi. Raises
    ModelError for an unstable model, SeatrialError. A programme that is not solved counts in
    `self.unsolved`; the next starts from the plan at rest. Where that fails, too, thrusters idle.
    """

    def __init__(
        self,
        model: Model,
        *,
        pool: Sequence[float] = NO_WALLS,
        clearance: float = 0.0,
        grid: Grid | None = None,
        weights: Weights | None = None,
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
        own_grid, own_weights = self._defaults()
        self.grid, self.weights = grid or own_grid, weights or own_weights
        self.layout = Layout(len(self.thrusters.lag), self.grid.stages)
        self.reach = frozen_array(size / 2 - clearance)  # (2,) of |x| and |y| [m]
        walls = np.repeat(self.reach, 2)
        self.function = step_function(self.model, self.thrusters, self.grid, self.weights, walls)
        self._call: casadi.Function = self.function
        self.forget()

    def _defaults(self) -> tuple[Grid, Weights]:
        if self.thrusters.steered:
            return STEERED_GRID, STEERED_FOLLOWING
        return (Grid(), Weights()) if self.thrusters.sways else (PATH_GRID, PATH_FOLLOWING)

    @property
    def latency(self) -> float:
        """From a command to its effect [s]."""
        return self.thrusters.latency

    def forget(self) -> None:
        """Reset: thrusters idle, no plan, no programme unsolved."""
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
        acceleration, as of the predictor. A path beyond a wall is clipped to it. Raises
        ControlError where an input is not a number.
        """
        motion = np.concatenate([np.asarray(eta, float), np.asarray(nu, float)])
        wanted, force = np.array(reference, dtype=float), np.asarray(disturbance, dtype=float)
        if (
            motion.shape != (MOTION_SIZE,)
            or wanted.shape != (self.grid.stages, MOTION_SIZE)
            or force.shape != (3,)
        ):
            raise ControlError(
                f"eta and nu of {motion.shape}, reference {wanted.shape}, disturbance {force.shape}: "
                f"expected (6,), ({self.grid.stages}, 6) and (3,)"
            )
        if not (
            np.isfinite(motion).all() and np.isfinite(wanted).all() and np.isfinite(force).all()
        ):
            raise ControlError("pose, velocity, reference or disturbance is not a number")
        wanted[:, 2] = np.unwrap(np.concatenate([motion[2:POSE_SIZE], wanted[:, 2]]))[1:]
        wanted[:, :2] = np.clip(wanted[:, :2], -self.reach, self.reach)
        self._advance(t)
        z = np.concatenate([motion, self._level])
        self._solve(z, wanted, force)
        return self.thrusters.commands(self._thrust)

    def _advance(self, t: float) -> None:
        """Levels at the time when a command of t takes effect."""
        if not t > self._time:
            raise ControlError(
                f"command at {t:g} s after one at {self._time:g} s: times must increase"
            )
        vehicle = self.model.vehicle
        self._level = _core.levels_after(
            vehicle.chain, self.model.constants, self._level, self._thrust, min(t - self._time, 1e3)
        )
        self._time = t

    def _solve(self, z: Array, wanted: Array, force: Array) -> None:
        """Improve the last plan; without one, or where that fails, the plan at rest."""
        starts = [(self._plan_at_rest(z), COLD_START_STEPS)]
        if self._plan is not None:
            starts.insert(0, (self._plan, WARM_START_STEPS))
        found = (self._improved(plan, steps, z, wanted, force) for plan, steps in starts)
        self._plan = next((plan for plan in found if plan is not None), None)
        thrust = self.thrusters.idle if self._plan is None else self._plan[self.layout.thrust(0)]
        self._thrust = np.clip(thrust, self.thrusters.lowest, self.thrusters.highest)

    def _plan_at_rest(self, z: Array) -> Array:
        stage = np.concatenate([z, self.thrusters.idle, [0.0]])
        return np.concatenate([np.tile(stage, self.layout.stages), z])

    def _improved(
        self, plan: Array, steps: int, z: Array, wanted: Array, force: Array
    ) -> Array | None:
        """The plan after up to `steps` Gauss-Newton steps. None where a programme was not solved."""
        for _ in range(steps):
            found, off = self._call(plan, z, wanted.T, self._thrust, force)
            before, plan = plan, np.asarray(found).ravel()
            if not (np.asarray(off).ravel() <= SOLVED_TOLERANCE).all():
                self.unsolved += 1
                return None
            if not self._moved(before, plan) > CONVERGED_THRUST:
                break
        return plan

    def _moved(self, before: Array, after: Array) -> float:
        """Largest change of a thrust in the plan."""
        stages = map(self.layout.thrust, range(self.layout.stages))
        unit = self.thrusters.unit
        return max(float((np.abs(after[g] - before[g]) / unit).max()) for g in stages)

    @property
    def path(self) -> Array:
        """Poses (stages + 1, 3) of the last plan. Raises ControlError before the first command."""
        if self._plan is None:
            raise ControlError("no plan yet: give a command first")
        blocks = [
            self._plan[k * self.layout.block :][:POSE_SIZE] for k in range(self.grid.stages + 1)
        ]
        return frozen_array(np.array(blocks))

    def generate(self, folder: str | Path) -> Path:
        """C of one step, seatrial_nmpc.c with its header; it needs only the C library."""
        ca = casadi_module()

        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        generator = ca.CodeGenerator("seatrial_nmpc.c", {"with_header": True})
        generator.add(self.function)
        generator.generate(f"{folder}/")
        return folder / "seatrial_nmpc.c"

    def use(self, library: str | Path) -> None:
        """Use the compiled step: a shared library of the C code of `generate`."""
        ca = casadi_module()

        self._call = ca.external(self.function.name(), str(library))
