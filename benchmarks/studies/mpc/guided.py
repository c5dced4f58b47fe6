# SPDX-License-Identifier: MIT
"""A boat without sway thrust: the guidance benchmark's boat, courses, weather and GNSS."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.studies.guidance.boat import SETTLING, WINDY, identified, truth
from benchmarks.studies.guidance.study import SEEDS, Outcome, course, run
from benchmarks.studies.mpc.pilot import Predictive
from seatrial.control import Course, Reference
from seatrial.control.mpc import Nmpc
from seatrial.util.frames import Array


@dataclass(frozen=True)
class Delayed:
    """A course that begins after the boat has settled."""

    course: Course

    def at(self, t: float) -> Reference:
        """The reference at t [s] of the run."""
        return self.course.at(t - SETTLING)


class PredictivePath(Predictive):
    """`Nmpc` as a pilot of `benchmarks.studies.guidance`."""

    def command(self, t: float, course: Course) -> Array:
        """On the course that starts after SETTLING."""
        return super().command(t, Delayed(course))


@cache
def controller() -> Nmpc:
    """By the identified model."""
    return Nmpc(identified())


@dataclass(frozen=True)
class Followed:
    """One run."""

    outcome: Outcome
    unsolved: int  # programmes
    took: Array  # [s] each command


@cache
def followed(shape: str, speed: float, left: float = 1.0) -> Followed:
    """In wind and current. left: gain of the left thruster, which the model is not told."""
    pilot = PredictivePath(controller())
    found = run(truth(left), pilot, course(shape, speed), WINDY, SEEDS[0])
    return Followed(found, controller().unsolved, np.array(pilot.took[1:]))
