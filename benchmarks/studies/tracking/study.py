# SPDX-License-Identifier: MIT
"""What is run, and what comes out."""

from collections.abc import Callable
from functools import cache, partial

import numpy as np

from benchmarks.harness.still import Still
from benchmarks.studies.tracking.hand import by_hand
from benchmarks.studies.tracking.loop import Outcome, run
from benchmarks.studies.tracking.pilots import ByHand, Differences, Filtered, Pilot, Tuned
from benchmarks.studies.tracking.scenes import CONDITIONS, Conditions, course, identified, truth
from seatrial.boat.model import Model
from seatrial.control import KNOB, Course, Tuning, tune
from seatrial.control.mpc import by_thrusters
from seatrial.control.tuning.design import Action

SEEDS = (1, 2, 3)
KNOBS = (0.35, 0.5, 1.0, 2.0, 4.0)  # [s]
CURRENTS = ((0.0, 0.0), (0.015, 0.0))  # [m/s] against a boat that keeps still
FOLLOWING = ("sign-pattern", "null-space")  # allocators that are tried on the courses
STANDING = ("moore-penrose", *FOLLOWING)  # and keeping still
EASY = "paper-like"  # conditions of the allocators and of keeping still
WATCH = 180.0  # [s] it keeps still; the last half counts


@cache
def tuned(scheme: str, plan: str, knob: float = KNOB, action: Action = "pid") -> Tuning:
    """By the identified model."""
    return tune(identified(scheme, plan), knob, action=action)


def hand(scheme: str, conditions: str, odometry: bool) -> Pilot:
    """With the gains found in still water."""
    plan = CONDITIONS[conditions].plan
    source = Filtered(identified(scheme, plan)) if odometry else Differences()
    return ByHand(by_hand(scheme, plan, odometry), source)


PILOTS: dict[str, Callable[[str, str], Pilot]] = {
    "PD by hand": lambda s, c: hand(s, c, False),
    "PD by hand, our odometry": lambda s, c: hand(s, c, True),
    "tuned PID": lambda s, c: Tuned(tuned(s, CONDITIONS[c].plan), feed_forward=False),
    "tuned PID, feed-forward": lambda s, c: Tuned(tuned(s, CONDITIONS[c].plan)),
}


@cache
def outcomes(scheme: str, conditions: str, shape: str, pilot: str) -> tuple[Outcome, ...]:
    """One a seed."""
    return tuple(
        run(truth(scheme), PILOTS[pilot](scheme, conditions), course(shape), CONDITIONS[conditions], seed)
        for seed in SEEDS
    )  # fmt: skip


def at_knob(scheme: str, conditions: str, knob: float) -> tuple[Outcome, ...]:
    """The figure of eight with another knob."""
    given = CONDITIONS[conditions]
    return tuple(
        run(truth(scheme), Tuned(tuned(scheme, given.plan, knob)), course("eight"), given, seed)
        for seed in SEEDS
    )


@cache
def allocated(allocation: str, action: Action = "pid") -> Tuning:
    """MP's boat with its thrusters commanded one by one, by an allocator."""
    return tune(by_thrusters(identified("MP", EASY)), KNOB, action=action, allocation=allocation)


@cache
def by_allocator(allocation: str, shape: str) -> tuple[Outcome, ...]:
    """One a seed, with feed-forward."""
    pilot, plant = partial(Tuned, allocated(allocation)), by_thrusters(truth("MP"))
    return tuple(run(plant, pilot(), course(shape), CONDITIONS[EASY], seed) for seed in SEEDS)


def keeping_still(
    plant: Model, tuning: Tuning, current: tuple[float, float]
) -> tuple[float, float]:
    """How far [m] the boat swings along its own axis from end to end, and its mean offset [m]."""
    found = run(plant, Tuned(tuning), Course(Still(), WATCH), Conditions(EASY, current), SEEDS[0])
    late = found.error[found.t > 0.5 * WATCH, :2]
    return float(np.ptp(late[:, 0])), float(np.hypot(*late.mean(axis=0)))
