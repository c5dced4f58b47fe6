# SPDX-License-Identifier: MIT
"""Three drivers: by the advice, by the paper's S1 to S3, and at random; all turn back before the walls."""

from abc import ABC, abstractmethod

import numpy as np

from benchmarks.studies.poolside.waters import Water
from seatrial.boat.model import Model
from seatrial.poolside.advisor import Advisor
from seatrial.poolside.coverage import Coverage
from seatrial.poolside.needs import Need
from seatrial.poolside.state import ManoeuvreState
from seatrial.simulation.pilots import PulseOperator
from seatrial.util.frames import Array, body_velocity

PROTOCOL = 200.0  # [s] of each trial
REACTION = 0.3  # [s] from the page to the sticks
STICK_ERROR = 0.075  # of a stick's size, standard deviation
BACK = 0.4  # of the free half-length, within which a boat that turned back may go on


class Driver(ABC):
    """Gives commands; away from the walls where the boat would not stop before them."""

    def __init__(self, water: Water, seed: int) -> None:
        self.water, self.rng = water, np.random.default_rng([seed, 3])
        self.half = np.array([water.pool.length, water.pool.width]) / 2 - water.pool.margin
        self.returning = False

    @abstractmethod
    def drive(self, t: float, x: Array) -> Array:
        """Commands (inputs,) at t [s] in state x (6,)."""

    def look(self, t: float, x: Array) -> Array:
        """The same within the walls."""
        return self.to_middle(x) if self._turns_back(x) else self.drive(t, x)

    def to_middle(self, x: Array) -> Array:
        """Sticks towards the middle: sideways where the boat can, else bow first."""
        place = body_velocity(x[2:3], np.array([[-x[0], -x[1], 0.0]]))[0]
        if self.water.sway:
            sticks = np.array([2.0 * place[0] - 2.0 * x[3], 2.0 * place[1] - 2.0 * x[4], -x[5]])
            return self.water.inputs(np.clip(sticks, -1.0, 1.0))
        turn = float(np.arctan2(place[1], place[0]))
        return self.water.inputs(
            np.array(
                [0.6 if abs(turn) < 0.8 else 0.0, 0.0, np.clip(0.5 * turn - 0.4 * x[5], -0.6, 0.6)]
            )
        )

    def _turns_back(self, x: Array) -> bool:
        velocity = body_velocity(-x[2:3], np.array([[x[3], x[4], 0.0]]))[0, :2]
        operator = self.water.operator
        braked = velocity * np.abs(velocity) / (2 * operator.braking)
        stop = x[:2] + velocity * operator.look_ahead + braked
        outside = bool(((np.abs(stop) > self.half) & (stop * velocity >= 0)).any())
        inside = bool((np.abs(x[:2]) < BACK * self.half).all())
        self.returning = outside or (self.returning and not inside)
        return self.returning


class Protocol(Driver):
    """S1, S2, S3 in turn: pulses in one axis, by the paper-like plan's operator."""

    def __init__(self, water: Water, seed: int) -> None:
        super().__init__(water, seed)
        axes = (0, 1, 2) if water.sway else (0, 2)
        self.pilots = [PulseOperator(a, water.operator, water.pool, self.rng) for a in axes]
        self.length = PROTOCOL * len(axes)

    def drive(self, t: float, x: Array) -> Array:
        """As of `Driver`."""
        pilot = self.pilots[min(int(t // PROTOCOL), len(self.pilots) - 1)]
        return self.water.inputs(np.clip(pilot.drive(t, x), -1.0, 1.0))


class AtRandom(Driver):
    """Pulses of a random axis, size, side and length."""

    def __init__(self, water: Water, seed: int) -> None:
        super().__init__(water, seed)
        self.until, self.sticks = 0.0, np.zeros(3)

    def drive(self, t: float, x: Array) -> Array:
        """As of `Driver`."""
        if t >= self.until:
            entry, pausing = self.water.operator, bool(self.sticks.any())
            low, high = entry.pause if pausing else entry.pulse
            self.until, self.sticks = t + self.rng.uniform(low, high), np.zeros(3)
            if not pausing:
                axis = int(self.rng.choice([0, 1, 2] if self.water.sway else [0, 2]))
                self.sticks[axis] = self.rng.uniform(0.2, 1.0) * self.rng.choice([-1.0, 1.0])
        return self.water.inputs(self.sticks)


class Guided(Driver):
    """Drives what the advisor proposes: late, and with sticks that are not quite right."""

    def __init__(self, water: Water, seed: int) -> None:
        super().__init__(water, seed)
        self.advisor = Advisor(water.vehicle, water.area, period=water.period, radius=water.radius)
        self.coverage = Coverage(water.vehicle)
        self.model: Model | None = None
        self.needs: list[Need] = []
        self.trust = 1.0
        self.now: ManoeuvreState | None = None
        self.begun = 0.0
        self.sizes = np.ones(0)

    def look(self, t: float, x: Array) -> Array:
        """As of `Driver`; a manoeuvre that the walls end is over."""
        if self._turns_back(x):
            self.now = None
            return self.to_middle(x)
        return self.drive(t, x)

    def drive(self, t: float, x: Array) -> Array:
        """As of `Driver`."""
        if self.now is None or t >= self.begun + self.now.seconds:
            driven, trust = self.coverage.driven, self.trust
            found = self.advisor.advise(self.model, x, self.needs, driven=driven, trust=trust)
            self.now, self.begun = found[0], t + REACTION
            rows = len(self.now.commands)
            self.sizes = 1.0 + STICK_ERROR * self.rng.normal(
                size=(rows, len(self.water.vehicle.inputs))
            )
        one = self.now
        if not one.commands:
            return self.to_middle(x)
        row = int(np.searchsorted(one.t, t - self.begun, side="right")) - 1
        if row < 0:
            return np.zeros(len(self.water.vehicle.inputs))
        return np.clip(np.array(one.commands[row]) * self.sizes[row], -1.0, 1.0)
