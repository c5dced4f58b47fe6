# SPDX-License-Identifier: MIT
"""One run: course, boat, SLAM and pilot in closed loop."""

from dataclasses import dataclass

import numpy as np

from benchmarks.studies.tracking.pilots import Pilot
from benchmarks.studies.tracking.scenes import Conditions, sensors
from seatrial.boat.model import Model
from seatrial.control import Course
from seatrial.simulation import PoseReading, Simulator
from seatrial.util.frames import Array

RATE = 50.0  # [Hz] of the controller
SETTLING = 8.0  # [s] at the start, standing still, not counted: filters find out where they are
FAR = 1.0  # [m] off: lost, the run ends


@dataclass(frozen=True)
class Outcome:
    """One run, call by call of the pilot."""

    t: Array  # (n,) [s] of the course
    error: Array  # (n, 3) true pose less the reference [m, m, rad], earth-fixed
    command: Array  # (n, inputs)
    lost: bool

    @property
    def position(self) -> float:
        """RMS distance [m] from the reference."""
        return float(np.sqrt((self.error[:, :2] ** 2).sum(axis=1).mean()))

    @property
    def heading(self) -> float:
        """RMS [rad]."""
        return float(np.sqrt((self.error[:, 2] ** 2).mean()))

    @property
    def worst(self) -> float:
        """Largest distance [m]."""
        return float(np.hypot(*self.error[:, :2].T).max())

    @property
    def unrest(self) -> float:
        """RMS change of the commands from call to call: noise that reaches the thrusters."""
        return float(np.sqrt((np.diff(self.command, axis=0) ** 2).mean()))


def run(plant: Model, pilot: Pilot, course: Course, conditions: Conditions, seed: int) -> Outcome:
    """The course once, after `SETTLING` at its start."""
    boat = Simulator(
        plant, sensors=sensors(conditions), current=conditions.current, seed=seed, start=course.at(0.0).eta,
        radius=0.0,
    )  # fmt: skip
    calls = round((SETTLING + course.duration) * RATE)
    t = np.arange(calls) / RATE - SETTLING
    error, command = np.zeros((calls, 3)), np.zeros((calls, len(plant.vehicle.inputs)))
    late = Late(course)
    for i in range(calls):
        error[i] = boat.eta - course.at(t[i]).eta
        if np.hypot(*error[i, :2]) > FAR:
            return _counted(t[: i + 1], error[: i + 1], command[: i + 1], lost=True)
        if boat.pose() is not None:
            command[i] = pilot.command(boat.time, late)
        boat.command(command[i])
        for reading in boat.advance_to((i + 1) / RATE):
            if isinstance(reading, PoseReading):
                pilot.pose(reading.stamp, reading.eta.copy())
    return _counted(t, error, command, lost=False)


class Late(Course):
    """The course by the simulator's clock."""

    def __init__(self, course: Course) -> None:
        super().__init__(course.shape, course.duration, course.ramp)

    def progress(self, t: float) -> tuple[float, float, float]:
        """`SETTLING` later."""
        return super().progress(t - SETTLING)


def _counted(t: Array, error: Array, command: Array, *, lost: bool) -> Outcome:
    error[:, 2] = np.angle(np.exp(1j * error[:, 2]))
    shown = t >= min(0.0, t[-1])
    return Outcome(t[shown], error[shown], command[shown], lost)
