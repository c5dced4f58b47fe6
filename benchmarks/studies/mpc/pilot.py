# SPDX-License-Identifier: MIT
"""Model predictive control as a pilot of `benchmarks.studies.tracking`: poses as they arrive in, commands out."""

import time

import numpy as np

import seatrial
from benchmarks.studies.tracking.pilots import Pilot
from seatrial.control import Course, Reference
from seatrial.control.mpc import Nmpc
from seatrial.util.frames import Array

PERIOD = 0.1  # [s] from one programme to the next


class Predictive(Pilot):
    """`Nmpc` on the predictor's motion; between programmes the commands hold."""

    def __init__(self, controller: Nmpc) -> None:
        self.controller = controller
        self.controller.forget()
        self.predictor = seatrial.Predictor(controller.model)
        self.due = -np.inf
        self.held = np.zeros(len(controller.model.vehicle.inputs))
        self.took: list[float] = []  # [s] each programme

    def pose(self, stamp: float, eta: Array) -> None:
        """To the predictor."""
        self.predictor.pose(stamp, eta)

    def wanted(self, acts: float, course: Course, eta: Array) -> list[Reference]:
        """References over the horizon from `acts` [s] on; eta (3,): the boat's pose then."""
        del eta
        return [course.at(acts + ahead) for ahead in self.controller.grid.times.tolist()]

    def command(self, t: float, course: Course) -> Array:
        """A new programme every PERIOD."""
        if t < self.due - 1e-9:
            return self.held
        self.due = t + PERIOD
        acts = t + self.controller.latency
        found = self.predictor.at(acts)
        wanted = self.wanted(acts, course, found.pose)
        rows = np.array([np.concatenate([one.eta, one.body()[0]]) for one in wanted])
        begin = time.perf_counter()
        self.held = self.controller.command(t, found.pose, found.velocity, rows, found.disturbance)
        self.took.append(time.perf_counter() - begin)
        self.predictor.command(t, self.held)
        return self.held
