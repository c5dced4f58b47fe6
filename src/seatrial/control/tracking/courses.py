# SPDX-License-Identifier: MIT
"""Feasible reference courses.

A course is a shape (shapes.py, tracks.py), smooth in a parameter s, and a timetable s(t) that starts and ends at
rest with continuous acceleration. `fitted` finds the shortest duration within thrust and identified speeds.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.control.allocation.steered import steering_of
from seatrial.control.tracking.reference import Reference
from seatrial.control.tracking.shapes import Jet, Shape
from seatrial.control.tuning.linear import LinearBoat, accelerations, linearise, steady_motions
from seatrial.control.tuning.steered import steered_shares
from seatrial.util.errors import ControlError
from seatrial.util.frames import Array

DEMAND_SHARE = 0.6  # of thrust and identified speeds that a course uses; the rest is for feedback
COURSE_SAMPLES = 600  # of a course, at which its demand is computed
LONGEST_COURSE = 1e4  # [s] a longer course is refused


@dataclass(frozen=True)
class Course:
    """A shape and its timetable."""

    shape: Shape
    duration: float  # [s]
    ramp: float = 0.2  # share of each part for acceleration, and the same for deceleration

    def __post_init__(self) -> None:
        if not (self.shape.stops and np.isfinite(length := self.shape.length) and length > 0.0):
            raise ControlError(f"course of length {self.shape.length:g}: expected more than 0")
        if not (np.isfinite(self.duration) and self.duration > 0.0 and 0.0 < self.ramp <= 0.5):
            raise ControlError(
                f"course of {self.duration:g} s with ramps of {self.ramp:g}: expected more than 0 s, and a "
                "share above 0, up to 0.5"
            )

    def at(self, t: float) -> Reference:
        """The reference at t [s]; at rest before the start and after the end."""
        s, rate, change = self.progress(t)
        pose, first, second = self.shape.at(s)
        return Reference(pose, first * rate, second * rate**2 + first * change)

    def progress(self, t: float) -> Jet:
        """s with its first two derivatives to time."""
        part = self.duration / self.shape.stops
        step = self.shape.length / self.shape.stops
        now = min(max(t, 0.0), self.duration)
        k = min(int(now / part), self.shape.stops - 1)
        share, speed, change = timetable((now - k * part) / part, self.ramp)
        return step * (k + share), step * speed / part, step * change / part**2


def timetable(x: float, ramp: float) -> Jet:
    """From 0 to 1 over x from 0 to 1: a smooth start, a steady middle, a smooth end."""
    if x > 0.5:
        share, speed, change = timetable(1.0 - x, ramp)
        return 1.0 - share, speed, -change
    top = 1.0 / (1.0 - ramp)  # speed of the middle
    if x >= ramp:
        return top * (x - 0.5 * ramp), top, 0.0
    z = x / ramp
    height = z**4 * (2.5 - 3.0 * z + z**2)  # integral of the next
    speed = z**3 * (10.0 - 15.0 * z + 6.0 * z**2)
    change = 30.0 * z**2 * (1.0 - z) ** 2
    return top * ramp * height, top * speed, top * change / ramp


def at_speed(shape: Shape, speed: float, ramp: float) -> Course:
    """A shape whose s is the arc length at a speed [m/s], reached and left within `ramp` [s].

    Raises ControlError where one of them is not above 0.
    """
    if not 0.0 < speed < np.inf or not 0.0 < ramp < np.inf:
        raise ControlError(
            f"course at {speed:g} m/s with ramps of {ramp:g} s: expected a speed and ramps above 0"
        )
    duration = shape.length / speed + ramp
    return Course(shape, duration, min(ramp / duration, 0.5))


def fitted(shape: Shape, model: Model, share: float = DEMAND_SHARE) -> Course:
    """The quickest course within `share` of thrust and identified speeds.

    Raises ControlError where the boat can't follow the shape at all.
    """
    boat, most = linearise(model), np.abs(steady_motions(model)).max(axis=0)

    def feasible(duration: float) -> bool:
        return _demand(Course(shape, duration), model, boat, most) <= share

    return Course(shape, _shortest(feasible, model.name))


def _shortest(feasible: Callable[[float], bool], name: str) -> float:
    low, high = 0.0, 1.0
    while not feasible(high):
        low, high = high, 2.0 * high
        if high > LONGEST_COURSE:
            raise ControlError(f"{name}: can't follow this course even in {LONGEST_COURSE:g} s")
    while high - low > 1e-3 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if feasible(middle) else (middle, high)
    return high


def _demand(course: Course, model: Model, boat: LinearBoat, most: Array) -> float:
    """Largest share of commands, thrust and speeds that a course uses."""
    times = np.linspace(0.0, course.duration, COURSE_SAMPLES)
    motions = [course.at(float(t)).body() for t in times]
    nu, nu_dot = (np.array(rows) for rows in zip(*motions, strict=True))
    free = accelerations(model, nu)
    speeds = float((np.abs(nu) / most).max())
    if (steering := steering_of(model)) is not None:
        return max(float(steered_shares(steering, nu, nu_dot - free).max()), speeds)
    commands = ((nu_dot - free) * boat.per_authority) @ boat.mix.T
    size = np.abs(commands).max(axis=1)
    # the allocation's limit: the share of the command that remains when its largest input is 1
    full = commands / np.maximum(size, 1e-12)[:, None]
    _, given = _core.allocate(model.vehicle.chain, np.ascontiguousarray(full))
    return max(float((size / given).max()), speeds)
