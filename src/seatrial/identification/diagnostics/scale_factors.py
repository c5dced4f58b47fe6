# SPDX-License-Identifier: MIT
"""Factors on an axis' thrust, on its drag, or on both, that one model for all of it does not have.

Each is tested by its score at the solution, where it is 1: no search is needed for that. What blocks of time
scatter about is chance.
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

WORTH = 20.0  # fall of -2 log likelihood from which on factors are worth a word
SHARP = (
    0.05  # standard error of a factor, by the information, above which the data say nothing of it
)
LEAST = 0.03  # between factors: less is nothing to speak of
ZONES = ("edge_forward", "edge_reverse", "pair_dead_zone")


@dataclass(frozen=True)
class WithFactors:
    """Passes as they were if some factors were free, too."""

    information: Array  # (p + k, p + k)
    scores: Array  # (blocks, p + k)


@dataclass(frozen=True)
class Change:
    """A factor that is not the same everywhere."""

    axis: int
    what: str  # of QUANTITIES
    less: str  # where it is least: a recording, or its beginning or end
    more: str
    ratio: float  # of these two
    test: ScoreTest

    @property
    def manifest(self) -> bool:
        """Whether it is beyond chance, and worth a word."""
        return self.test.likely and self.test.gain >= WORTH and self.ratio <= 1.0 - LEAST


Tested = Callable[[int, str, Array], Change | None]  # of an axis, what changes, and its weights


def changes(at: Point, tested: Tested) -> list[Change]:
    """What is manifest, by axis: one cause for all axes, the one that explains most."""
    by_cause: dict[str, list[Change]] = {what: [] for what in QUANTITIES}
    for axis in range(3):
        for what, weights in _ways(at, axis):
            found = tested(axis, what, weights)
            if found is not None and found.manifest:
                by_cause[what].append(found)
    return max(by_cause.values(), key=lambda found: sum(change.test.gain for change in found))


def dead_zone_of(at: Point, what: str) -> str:
    """Whether thrust changes without a dead zone that could explain it, as findings have it."""
    lacks = what == "thrust" and not _zoned(at.runs.problem.vehicle)
    return "not modelled" if lacks else "modelled"


def _zoned(vehicle: Vehicle) -> bool:
    """Whether the thrusters have a dead zone, known or sought."""
    kinds = {name.partition(".")[0] for name in vehicle.constants.names}
    return bool(kinds & set(ZONES)) or any(group.table for group in vehicle.file.chain)


def _ways(at: Point, axis: int) -> Iterator[tuple[str, Array]]:
    """What changes, and how the free parameters (p,) would with a factor on it: as much as they are."""
    problem = at.runs.problem
    thrust, drag = thrust_and_drag(problem.vehicle.structure, axis)
    free = np.array(problem.free)
    for what, names in (("thrust", thrust), ("drag", drag), ("thrust and drag", thrust | drag)):
        own = np.array([problem.names[i] in names for i in free])
        weights = np.where(own, at.theta[free], 0.0)
        if weights.any():
            yield what, weights


def thrust_and_drag(structure: Structure, axis: int) -> tuple[set[str], set[str]]:
    """Coefficients of an axis' terms with a force, and of its drag.

    Drag is what is of velocities alone, but for terms of masses: a payload that weighs on all axes alike changes
    no Coriolis term.
    """
    forces = {force.name for force in structure.forces}
    thrust: set[str] = set()
    drag: set[str] = set()
    for term in structure.terms:
        if term.axis == axis and term.coefficient is not None and not term.of_masses:
            (thrust if forces & set(term.factors) else drag).add(term.coefficient)
    return thrust, drag
