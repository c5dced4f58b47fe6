# SPDX-License-Identifier: MIT
"""The layout of the thrusters behind commands that are generalised forces, where the vehicle file states none.

A dead zone is the thrusters': how it acts on the forces depends on their layout and on the allocation. Without
them force and drag coefficients take its place. So usual layouts are candidates. Directions of thrust alone
matter: each row of T is divided by its norm, so that the force coefficients carry distances and angles.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from seatrial.boat.allocation import Scheme
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.noise_parameters import present
from seatrial.boat.schema import AllocationEntry, ThrusterEntry
from seatrial.boat.vehicle import WRENCH, Vehicle
from seatrial.identification.first_search import first_maximum
from seatrial.identification.likelihood.filter_runs import filter_along
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import Outcome, search
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.likelihood.whiteness import without_process_noise
from seatrial.identification.pose_rate import near_with_fewer_poses
from seatrial.identification.selection.actuator_selection import moved_to, wider_problem
from seatrial.identification.selection.actuator_stages import (
    has_curve,
    stage_candidates,
    with_estimated_stages,
)
from seatrial.identification.selection.held import held_test
from seatrial.identification.solution import Fit, OutputErrorSettings, StartValues
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array

LEAST_LAYOUT_GAIN = 100.0  # fall of -2 log L: a layout changes what every command does
USUAL_LIMIT = 1.0  # of a thruster's command, in the units of the inputs

X_AHEAD = [(1.0, 1.0, -45.0), (1.0, -1.0, 45.0), (-1.0, 1.0, 45.0), (-1.0, -1.0, -45.0)]
X_FACING = [(1.0, 1.0, 135.0), (1.0, -1.0, -135.0), (-1.0, 1.0, 45.0), (-1.0, -1.0, -45.0)]
TWO_AHEAD = [(0.0, 1.0, 0.0), (0.0, -1.0, 0.0)]
BOW_ARM = 1.5  # of a bow thruster, over half the distance between two astern
LAYOUTS: Mapping[str, tuple[Scheme, Sequence[tuple[float, float, float]]]] = {
    # x [m], y [m], direction of thrust [deg] of each thruster
    "four in an X, all ahead": (Scheme.MP, X_AHEAD),
    "four in an X, bow pair astern": (Scheme.MP, X_FACING),  # MallARD's
    "four in an X, always forward": (Scheme.AF, X_FACING),
    "two ahead and one across": (Scheme.MP, [*TWO_AHEAD, (0.0, 0.0, 90.0)]),
    "two ahead and one across the bow": (Scheme.MP, [*TWO_AHEAD, (BOW_ARM, 0.0, 90.0)]),
    "two ahead and two across": (Scheme.MP, [*TWO_AHEAD, (1.0, 0.0, 90.0), (-1.0, 0.0, 90.0)]),
    "three in a star": (
        Scheme.MP,
        [(1.0, 0.0, 90.0), (-0.5, 0.866, 210.0), (-0.5, -0.866, 330.0)],
    ),
}


@dataclass(frozen=True)
class LayoutChoice:
    """A layout that the recordings ask for: its name, the solution with it, and the finding."""

    layout: str
    at: Point
    finding: Finding


def select_layout(
    at: Point, vehicle: Vehicle, effects: Sequence[str] = (), least: float = -np.inf
) -> LayoutChoice | None:
    """The layout that explains the recordings best, if one does much better than none; `at`: without one.

    `least`: fall of -2 log L that its score test must promise. None as well where the vehicle file states
    thrusters or a curve.
    """
    if not forces_alone(vehicle):
        return None
    settings = OutputErrorSettings(effects=tuple(effects))
    # the score test of each layout with the curve of its thrusters
    found = {name: _tested(at, with_layout(vehicle, name), settings) for name in LAYOUTS}
    layout = max(found, key=lambda name: found[name].gain)
    # the best one is fitted with the whole thrust curve: its gain depends on the curve
    best = found[layout]
    if best.gain < least:
        return None
    curved, outcome = _searched(best.whole, best.theta, at.noise)
    gain = at.runs.cost - curved.runs.cost
    if outcome is not Outcome.CONVERGED or gain < LEAST_LAYOUT_GAIN:
        return None
    there, outcome = _searched(best.problem, moved_to(curved, best.problem, {}), curved.noise)
    if outcome is not Outcome.CONVERGED:
        return None
    finding = finding_of(FindingKind.THRUSTER_LAYOUT_SELECTED, layout=layout, gain=gain)
    return LayoutChoice(layout, there, finding)


def contradicted_layout(found: Fit) -> list[Finding]:
    """A usual layout that explains the recordings much better than the thrusters of the vehicle file.

    None where no process noise shows that anything is wrong, and where the file states none.
    """
    problem, effects = found.problem, found.settings.effects
    allocated = problem.vehicle.file.thrusters and set(problem.vehicle.inputs) == set(WRENCH)
    if not allocated or found.horizon or without_process_noise(found.point):
        return []
    vehicle = without_thrusters(problem.vehicle)
    start = StartValues.of_model(found.model())
    try:
        at = first_maximum(problem.recordings, vehicle, effects, start=start)
    except IdentificationError:  # the stated thrusters have a solution, forces alone have none
        return []
    # a layout that promises no more than the stated one is not searched
    own = _tested(at, _without_chain(problem.vehicle), OutputErrorSettings(effects=effects))
    best = select_layout(at, vehicle, effects, own.gain + LEAST_LAYOUT_GAIN)
    gain = 0.0 if best is None else near_with_fewer_poses(found.point).runs.cost - best.at.runs.cost
    if best is None or gain < LEAST_LAYOUT_GAIN:
        return []
    kind = FindingKind.THRUSTER_LAYOUT_CONTRADICTED
    return [finding_of(kind, layout=best.layout, gain=gain)]


@dataclass(frozen=True)
class _Tested:
    """A layout before its search."""

    gain: float  # fall of -2 log L, by a score test
    problem: Problem  # with a dead zone
    whole: Problem  # with the whole curve
    theta: Array  # of `whole`, without a dead zone


def _tested(at: Point, vehicle: Vehicle, settings: OutputErrorSettings) -> _Tested:
    before = at.runs.problem
    zoned, _ = with_estimated_stages(vehicle, before.recordings)
    more = [e.probe for e in stage_candidates(vehicle, zoned) if not e.origin]
    problem, whole = (
        wider_problem(before, v, vehicle, settings) for v in (zoned, next(iter(more), zoned))
    )
    theta = moved_to(at, whole, {})
    theta[[i for i, name in enumerate(whole.names) if name.startswith("edge_")]] = 0.0
    runs = filter_along(whole, theta, at.noise, repeatable=False)
    gain = held_test(runs, before, whole).gain + at.runs.cost - runs.cost
    return _Tested(gain, problem, whole, theta)


def _searched(problem: Problem, theta: Array, noise: Array) -> tuple[Point, Outcome]:
    return search(
        problem, theta, noise, hold=False, least=noise_floor(problem, 0.0), free=present(noise)
    )


def forces_alone(vehicle: Vehicle) -> bool:
    """Whether the inputs are the three generalised forces, and the file has neither thrusters nor a curve."""
    known = vehicle.file.thrusters or vehicle.file.forces or has_curve(vehicle)
    return set(vehicle.inputs) == set(WRENCH) and not known


def with_thrusters_of(known: Vehicle, vehicle: Vehicle) -> Vehicle:
    """The vehicle with the thrusters of a known one of the same inputs, where its own file states none."""
    if not (forces_alone(vehicle) and set(known.inputs) == set(vehicle.inputs)):
        return vehicle
    thrusters, allocation = known.file.thrusters, known.file.allocation
    file = msgspec.structs.replace(vehicle.file, thrusters=thrusters, allocation=allocation)
    return replace(vehicle, file=file)


def without_thrusters(vehicle: Vehicle) -> Vehicle:
    """The vehicle with forces alone, as a file that states no thrusters and nothing of their chain."""
    allocation = AllocationEntry(limit=vehicle.file.allocation.limit)
    bare = _without_chain(vehicle)
    return replace(
        bare, file=msgspec.structs.replace(bare.file, thrusters={}, allocation=allocation)
    )


def _without_chain(vehicle: Vehicle) -> Vehicle:
    return replace(vehicle, file=msgspec.structs.replace(vehicle.file, chain=[]))


def with_layout(vehicle: Vehicle, layout: str) -> Vehicle:
    """The vehicle with the thrusters of a layout, T_1, T_2, ..., and its allocation."""
    scheme, places = LAYOUTS[layout]
    thrusters = {
        f"T_{i}": ThrusterEntry(x=x, y=y, angle_deg=angle)
        for i, (x, y, angle) in enumerate(places, 1)
    }
    allocation = AllocationEntry(
        scheme=scheme.value, limit=vehicle.file.allocation.limit or USUAL_LIMIT
    )
    file = msgspec.structs.replace(vehicle.file, thrusters=thrusters, allocation=allocation)
    return replace(vehicle, file=file)
