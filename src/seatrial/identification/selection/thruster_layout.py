# SPDX-License-Identifier: MIT
"""The layout of the thrusters behind commands that are generalised forces, where the vehicle file states none.

A dead zone is the thrusters': how it acts on the forces depends on their layout and on the allocation. Without
them force and drag coefficients take its place. So usual layouts are candidates. Directions of thrust alone
matter: each row of T is divided by its norm, so that the force coefficients carry distances and angles.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import msgspec

from seatrial.boat.allocation import Scheme
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.noise_parameters import present
from seatrial.boat.schema import AllocationEntry, ThrusterEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.likelihood.fit_horizon import noise_floor
from seatrial.identification.likelihood.optimiser import Outcome, Point, search
from seatrial.identification.likelihood.problem import Problem
from seatrial.identification.selection.actuator_selection import moved_to, wider_problem
from seatrial.identification.selection.actuator_stages import has_curve, with_estimated_stages
from seatrial.identification.selection.held import held_test
from seatrial.identification.solution import OutputErrorSettings
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

    def given_to(self, vehicle: Vehicle) -> Vehicle:
        """The vehicle with this layout."""
        return with_layout(vehicle, self.layout)


def select_layout(at: Point, vehicle: Vehicle, effects: Sequence[str] = ()) -> LayoutChoice | None:
    """The layout that explains the recordings best, if one does much better than none; `at`: without one.

    None as well where the vehicle file states thrusters or a curve.
    """
    before = at.runs.problem
    if not forces_alone(vehicle):
        return None
    # a filter run without a dead zone, and what its score test promises, ranks the layouts
    settings = OutputErrorSettings(effects=tuple(effects))
    found = {}
    for name in LAYOUTS:
        with_it = with_layout(vehicle, name)
        whole, _ = with_estimated_stages(with_it, before.recordings)
        problem = wider_problem(before, whole, with_it, settings)
        theta = _without_dead_zone(moved_to(at, problem, {}), problem)
        runs = problem.run_filter(theta, at.noise, repeatable=False)
        found[name] = (
            held_test(runs, before, problem).gain + at.runs.cost - runs.cost,
            problem,
            theta,
        )
    # the best of them is estimated
    layout = max(found, key=lambda name: found[name][0])
    _, problem, theta = found[layout]
    there, outcome = search(
        problem, theta, at.noise, hold=False, least=noise_floor(problem, 0.0), free=present(at.noise)
    )  # fmt: skip
    gain = at.runs.cost - there.runs.cost
    if outcome is not Outcome.CONVERGED or gain < LEAST_LAYOUT_GAIN:
        return None
    return LayoutChoice(
        layout, there, finding_of(FindingKind.THRUSTER_LAYOUT_SELECTED, layout=layout, gain=gain)
    )


def forces_alone(vehicle: Vehicle) -> bool:
    """Whether the file has generalised forces as inputs, and neither thrusters nor a curve."""
    return not (vehicle.file.thrusters or vehicle.file.forces or has_curve(vehicle))


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


def _without_dead_zone(theta: Array, problem: Problem) -> Array:
    edges = [i for i, name in enumerate(problem.names) if name.startswith("edge_")]
    theta[edges] = 0.0
    return theta
