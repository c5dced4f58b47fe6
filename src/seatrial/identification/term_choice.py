# SPDX-License-Identifier: MIT
"""The terms of a vehicle with `structure: auto`, and where the search with them starts."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from seatrial.boat.findings import Finding, FindingKind
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.first_search import first_maximum
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.recording_checks import check_recordings, explained
from seatrial.identification.selection.command_sampling import (
    sampled_commands_of,
    sampling_is_open,
)
from seatrial.identification.selection.terms import Selection, choose_structure
from seatrial.identification.selection.terms.candidates import with_usual_terms
from seatrial.identification.selection.thruster_layout import (
    forces_alone,
    select_layout,
    with_layout,
    with_thrusters_of,
)
from seatrial.identification.selection.unnamed_forces import (
    added_forces,
    with_forces_of,
    with_unnamed_forces,
)
from seatrial.identification.solution import StartValues
from seatrial.recording.excitation import find_roles
from seatrial.recording.recording import Recording
from seatrial.util.errors import DivergenceError
from seatrial.util.progress import stage


@dataclass(frozen=True)
class TermChoice:
    """A vehicle with its terms, and why."""

    vehicle: Vehicle
    selection: Selection | None = None  # the reasons; None: a prior's terms, or none can be chosen
    begin: StartValues | None = None  # of the search with these terms
    findings: tuple[Finding, ...] = ()  # on what was chosen beside the terms
    automatic: bool = False  # the recordings were to choose the terms
    diverges: bool = False  # why they could not; otherwise they are too short


def choose_terms(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    prior: Model | None = None,
    effects: Sequence[str] = (),
) -> TermChoice:
    """The terms that the recordings support. Every method estimates those that output-error chooses.

    A prior has terms and thrusters already. Recordings that are too short to choose, or terms that diverge, leave
    those that every boat has, with free added mass: where that has no effect its error says so. `effects` are
    estimated first: terms that are chosen without them stand in for them.
    """
    if prior is not None:
        known = with_forces_of(prior.vehicle, with_thrusters_of(prior.vehicle, vehicle))
        return TermChoice(known.with_terms(prior.structure.terms))
    check_recordings(recordings, vehicle)
    find_roles(vehicle, recordings)  # refuses an axis that was never driven, in words
    named, vehicle = vehicle, with_unnamed_forces(vehicle, recordings)
    at: Point | None = None
    findings = added_forces(named, vehicle)
    if effects or forces_alone(vehicle) or sampling_is_open(vehicle, recordings):
        with stage("effects", 0.4), explained(recordings, vehicle):
            at = first_maximum(recordings, with_usual_terms(vehicle), effects)
            at, vehicle, chosen = choose_input(at, vehicle, effects)
            findings += chosen
    choice = choose_terms_from(at if effects else None, recordings, vehicle)
    return replace(choice, findings=findings)


def choose_input(
    at: Point, vehicle: Vehicle, effects: Sequence[str]
) -> tuple[Point, Vehicle, tuple[Finding, ...]]:
    """The solution and the vehicle with what the recordings show of the commands, and findings on that.

    at: a solution with the terms that every boat has.
    """
    findings: tuple[Finding, ...] = ()
    found = sampled_commands_of(at, with_usual_terms(vehicle), effects)
    if found is not None:
        at, vehicle = found.at, vehicle.with_sampled_commands()
        findings = (found.finding(FindingKind.COMMANDS_SAMPLED),)
    layout = select_layout(at, with_usual_terms(vehicle), effects)
    if layout is not None:
        at, vehicle = layout.at, with_layout(vehicle, layout.layout)
        findings = (*findings, layout.finding)
    return at, vehicle, findings


def choose_terms_from(
    at: Point | None, recordings: Sequence[Recording], vehicle: Vehicle
) -> TermChoice:
    """The same after a solution with the effects, if any, and the terms that every boat has."""
    clean = recordings if at is None else without_effects(at, recordings)
    first = None if at is None else StartValues.of_solution(at)
    usual = TermChoice(with_usual_terms(vehicle), None, first, automatic=True)
    try:
        with explained(recordings, vehicle):
            found = choose_structure(clean, vehicle)
    except DivergenceError:  # terms that stand in for something else, such as a lever arm
        return replace(usual, diverges=True)
    if found is None:
        return usual
    own = StartValues.of_model(found.model)
    known = {} if first is None else first.values
    begin = StartValues({**known, **own.values}, own.noise)
    return TermChoice(found.vehicle, found, begin, automatic=True)


def without_effects(at: Point, recordings: Sequence[Recording]) -> list[Recording]:
    """Recordings for the choice of terms: poses of the origin, without lever arm, delays and current.

    at: a solution of them, or of part of their poses.

    Trim and wind stay: they are forces, which the process noise of the filter includes.
    """
    problem = replace(at.runs.problem, recordings=tuple(recordings))
    return [problem.origin_poses(i, at.theta) for i in range(len(recordings))]
