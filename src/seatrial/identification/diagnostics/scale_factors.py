# SPDX-License-Identifier: MIT
"""Scale factors on an axis' thrust, on its drag, or on both: score tests at the solution, where each is 1.

No further fit is needed. The scatter of the scores over blocks of time is the measure of chance.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from seatrial.boat.finding_kinds import QUANTITIES
from seatrial.boat.structure import Structure
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.likelihood.optimiser import Point
from seatrial.identification.selection.score_test import ScoreTest
from seatrial.util.frames import Array

LEAST_FACTOR_GAIN = 20.0  # expected fall of -2 log L: less is not reported
LARGEST_FACTOR_ERROR = (
    0.05  # standard error, by the information, above which it is not identifiable
)
LEAST_FACTOR_CHANGE = 0.03  # relative difference: less is not reported
DEAD_ZONE_CONSTANTS = ("edge_forward", "edge_reverse", "pair_dead_zone")


@dataclass(frozen=True)
class WithScaleFactors:
    """Information and scores with k scale factors as further parameters."""

    information: Array  # (p + k, p + k)
    scores: Array  # (blocks, p + k)


@dataclass(frozen=True)
class FactorChange:
    """A scale factor that differs between recordings, or drifts."""

    axis: int
    quantity: str  # of QUANTITIES
    less: str  # where it is least: a recording, or its beginning or end
    more: str
    ratio: float  # of the least to the largest factor
    test: ScoreTest

    @property
    def manifest(self) -> bool:
        """Whether it is significant, and large enough to be reported."""
        return (
            self.test.likely
            and self.test.gain >= LEAST_FACTOR_GAIN
            and self.ratio <= 1.0 - LEAST_FACTOR_CHANGE
        )


# of an axis, a quantity, and the weights (p,) by which a factor on it moves the free parameters
FactorTest = Callable[[int, str, Array], FactorChange | None]


def manifest_changes(at: Point, tested: FactorTest) -> list[FactorChange]:
    """Significant changes by axis, of one quantity: the one with the largest expected fall of -2 log L."""
    by_quantity: dict[str, list[FactorChange]] = {quantity: [] for quantity in QUANTITIES}
    for axis in range(3):
        for quantity, weights in _scaled_parameters(at, axis):
            found = tested(axis, quantity, weights)
            if found is not None and found.manifest:
                by_quantity[quantity].append(found)
    return max(by_quantity.values(), key=lambda found: sum(change.test.gain for change in found))


def dead_zone_of(at: Point, quantity: str) -> str:
    """Whether thrust changes in a model without a dead zone, which could explain it, in a finding's words."""
    lacks = quantity == "thrust" and not _has_dead_zone(at.runs.problem.vehicle)
    return "not modelled" if lacks else "modelled"


def _has_dead_zone(vehicle: Vehicle) -> bool:
    """Whether the thrusters have a dead zone, stated or estimated."""
    kinds = {name.partition(".")[0] for name in vehicle.constants.names}
    return bool(kinds & set(DEAD_ZONE_CONSTANTS)) or any(
        group.table for group in vehicle.file.chain
    )


def _scaled_parameters(at: Point, axis: int) -> Iterator[tuple[str, Array]]:
    """Each quantity, and the derivative (p,) of the free parameters by a factor on it: their own values."""
    problem = at.runs.problem
    thrust, drag = thrust_and_drag(problem.vehicle.structure, axis)
    free = np.array(problem.free)
    for quantity, names in (("thrust", thrust), ("drag", drag), ("thrust and drag", thrust | drag)):
        own = np.array([problem.names[i] in names for i in free])
        weights = np.where(own, at.theta[free], 0.0)
        if weights.any():
            yield quantity, weights


def thrust_and_drag(structure: Structure, axis: int) -> tuple[set[str], set[str]]:
    """Coefficients of an axis' terms with a force, and of its drag.

    Drag is all terms of velocities alone, without those of masses: a payload that acts on all axes alike changes
    no Coriolis term.
    """
    forces = {force.name for force in structure.forces}
    thrust: set[str] = set()
    drag: set[str] = set()
    for term in structure.terms:
        if term.axis == axis and term.coefficient is not None and not term.of_masses:
            (thrust if forces & set(term.factors) else drag).add(term.coefficient)
    return thrust, drag
