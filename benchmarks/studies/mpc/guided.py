# SPDX-License-Identifier: MIT
"""A boat without sway thrust: the guidance benchmark's boat, courses, weather and GNSS."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.studies.guidance.boat import SETTLING, WINDY, identified, truth
from benchmarks.studies.guidance.study import SEEDS, Outcome, course, run, tuned
from benchmarks.studies.mpc.pilot import Predictive
from seatrial.control import Course, Reference, WaitingReference
from seatrial.control.mpc import Nmpc
from seatrial.util.frames import Array


class PredictivePath(Predictive):
    """`Nmpc` as a pilot of `benchmarks.studies.guidance`; the reference waits for the boat."""

    def __init__(self, controller: Nmpc, reach: float) -> None:
        super().__init__(controller)
        self.reach = reach  # [m]
        self._reference: WaitingReference | None = None

    def wanted(self, acts: float, course: Course, eta: Array) -> list[Reference]:
        """As of `Predictive`, on the course that starts after SETTLING."""
        if self._reference is None:
            self._reference = WaitingReference(course, self.reach)
        self._reference.at(acts - SETTLING, eta)
        return [self._reference.later(ahead) for ahead in self.controller.grid.times.tolist()]


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
    guidance = tuned().guidance
    assert guidance is not None
    pilot = PredictivePath(controller(), guidance.radius)
    found = run(truth(left), pilot, course(shape, speed), WINDY, SEEDS[0])
    return Followed(found, controller().unsolved, np.array(pilot.took[1:]))
