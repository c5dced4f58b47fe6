# SPDX-License-Identifier: MIT
"""The two boats of the study, step by step: the paper's in its pool, and two thrusters in wind and current."""

from typing import Protocol

import numpy as np

from benchmarks.studies.guidance import boat as twin
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.poolside.area import Area, rectangle
from seatrial.simulation.plan import OperatorEntry, Pool
from seatrial.simulation.trials import DisturbedPlant, plant_model
from seatrial.util.frames import Array
from tests.boats.scenes import FORCE, pushed, true_parameters, vehicle_of

Poses = list[tuple[float, Array]]  # stamp [s], pose (3,)


class Water(Protocol):
    """A boat in its water, with its truth."""

    name: str
    vehicle: Vehicle  # as the estimator gets it
    pool: Pool
    area: Area
    radius: float  # [m] of the boat
    operator: OperatorEntry
    tick: float  # [s]
    period: float  # [s] of the poses
    offset: float  # [s] by which stamps of commands are later than those of poses
    sway: bool  # whether the sticks drive it

    @property
    def state(self) -> Array:
        """True pose and velocity (6,)."""

    def inputs(self, sticks: Array) -> Array:
        """The vehicle's inputs for sticks F_u, F_v, F_r."""

    def step(self, command: Array) -> Poses:
        """By a tick, with this command; poses that arrive."""

    def truth(self, names: tuple[str, ...]) -> Array:
        """True values of parameters."""


class PaperPool:
    """The paper's boat by the plan "hard", with a disturbance force of 4 % of full thrust."""

    name, radius, tick, period, sway = "paper's pool", 0.3, 1 / 30, 1 / 15, True

    def __init__(self, seed: int) -> None:
        self.plan = pushed("hard", FORCE)
        self.vehicle, self.pool = vehicle_of("MP"), self.plan.pool
        self.area = rectangle(self.pool.length, self.pool.width)
        self.operator, self.offset = self.plan.operator, self.plan.joypad.clock_offset
        rng = np.random.default_rng([seed, 1])
        self._plant = DisturbedPlant(plant_model(self.plan, self.vehicle), FORCE, rng)
        self._rng, self._ticks = np.random.default_rng([seed, 2]), 0
        noise = self.plan.pose
        self._noise = np.array([noise.position_noise, noise.position_noise, noise.heading_noise])

    @property
    def state(self) -> Array:
        """As of `Water`."""
        return np.array(self._plant.state)

    def inputs(self, sticks: Array) -> Array:
        """As of `Water`."""
        return np.clip(sticks, -1.0, 1.0)

    def step(self, command: Array) -> Poses:
        """As of `Water`."""
        self._plant.command(self._ticks * self.tick, np.ascontiguousarray(command))
        self._ticks += 1
        self._plant.advance_to(self._ticks * self.tick)
        if self._ticks % 2:
            return []
        return [(self._ticks * self.tick, self.state[:3] + self._noise * self._rng.normal(size=3))]

    def truth(self, names: tuple[str, ...]) -> Array:
        """As of `Water`."""
        return true_parameters(self.plan, names)


class TwinInWind:
    """Two thrusters, wind with gusts; GNSS of 2 cm and 0.01 rad."""

    name, radius, tick, period, sway = (
        "two thrusters in wind", 0.8, twin.TICK, twin.GNSS_PERIOD, False,
    )  # fmt: skip

    def __init__(self, seed: int) -> None:
        chain: dict[str, object] = {
            "latency": "estimate", "lag": "estimate",
            "dead_zone": {"forward": "estimate", "reverse": "estimate"},
        }  # fmt: skip
        self.vehicle, self.pool = twin.vehicle((chain,)), Pool(length=30.0, width=24.0, margin=3.0)
        self.area, self.offset = rectangle(self.pool.length, self.pool.width), 0.0
        self.operator = pushed("hard", FORCE).operator
        self._true: Model = twin.truth()
        self._sea = twin.Sea(
            self._true, twin.Weather((0.0, 0.0), (0.0, 0.0), 1.5), seed, np.zeros(3)
        )

    @property
    def state(self) -> Array:
        """As of `Water`."""
        return np.array(self._sea.state)

    def inputs(self, sticks: Array) -> Array:
        """As of `Water`."""
        both = np.array([sticks[0] - sticks[2], sticks[0] + sticks[2]])
        return both / max(1.0, float(np.abs(both).max()))

    def step(self, command: Array) -> Poses:
        """As of `Water`."""
        self._sea.command(command)
        return self._sea.advance()

    def truth(self, names: tuple[str, ...]) -> Array:
        """As of `Water`."""
        zones = {"edge_forward": 0.05, "edge_reverse": 0.05, "latency": 0.06, "lag": 0.2}
        gain = 1.0 if any(n.startswith("edge") for n in names) else 1.0 / (1.0 - 0.05)
        known = {n: v * (gain if n.endswith("_F") else 1.0) for n, v in self._true.values.items()}
        return np.array([known[n] if n in known else zones[n.partition(".")[0]] for n in names])
