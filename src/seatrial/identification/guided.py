# SPDX-License-Identifier: MIT
"""Identification that follows its own findings: the effects that the model lacks are estimated, too."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from seatrial.boat.finding_kinds import UNMODELLED_EFFECTS
from seatrial.boat.findings import Finding, of_kinds
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.diagnostics.unmodelled_effects import (
    differs_from_zero,
    effect_places,
    unmodelled_effect,
)
from seatrial.identification.first_search import first_maximum, first_problem
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.parameters import EFFECT_KINDS
from seatrial.identification.methods import identify_with_fit
from seatrial.identification.recording_checks import check_recordings
from seatrial.identification.selection.actuator_selection import select_stages
from seatrial.identification.selection.terms.candidates import with_usual_terms
from seatrial.identification.selection.unnamed_forces import added_forces, with_unnamed_forces
from seatrial.identification.solution import Fit, OutputErrorSettings, StartValues
from seatrial.identification.term_choice import (
    TermChoice,
    choose_input,
    choose_terms_from,
)
from seatrial.identification.uncertainty.covariance import sandwich_covariance
from seatrial.recording.excitation import find_roles
from seatrial.recording.recording import Recording
from seatrial.util.progress import stage

MOST_EFFECTS = 3  # a boat that needs more of them is described by none

Confirm = Callable[[str, Finding], bool]


@dataclass(frozen=True)
class Guided:
    """A model, and what was decided on the way to it."""

    model: Model
    solution: Fit
    choice: TermChoice  # terms that the recordings chose
    followed: tuple[Finding, ...]  # findings whose effects are estimated now
    effects: tuple[str, ...]


def identify_guided(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    effects: Sequence[str] = (),
    confirm: Confirm = lambda _kind, _finding: True,
) -> Guided:
    """`identify` with the effects that the recordings show, at most `MOST_EFFECTS`; effects first, then terms.

    Terms that are chosen without an effect stand in for it. So effects are found with the terms that every boat
    has. With `structure: auto` terms are then chosen from recordings without the effects. `effects`: those to
    begin with. `confirm`: whether a found effect (kind, finding) is estimated. An effect with which there is no
    solution is left out. Raises as `identify`.
    """
    check_recordings(recordings, vehicle)
    find_roles(vehicle, recordings)  # refuses an axis that was never driven, in words
    # the effects, with the terms that every boat has
    with stage("effects", 0.4):
        known = _known_effects(recordings, vehicle, tuple(effects), confirm)
    # the terms, and all of it together
    found = _whole(recordings, known)
    # an effect that only the whole model shows: a stated lever arm that is slightly wrong
    for _ in range(MOST_EFFECTS - len(known.kinds)):
        named = _unmodelled(found)
        if named is None or not confirm(*named):
            break
        with stage(f"with {named[0]}"):
            known = known.with_effect(recordings, *named)
            found = _whole(recordings, known)
    return found


def check_length(recordings: Sequence[Recording], vehicle: Vehicle) -> None:
    """Raises IdentificationError where recordings are too short for the terms that come first."""
    first_problem(recordings, _with_first_terms(vehicle))


@dataclass(frozen=True)
class _Known:
    """What is known before terms are chosen."""

    at: Point  # solution with the effects and the terms that every boat has
    vehicle: Vehicle  # with what the recordings show of the commands
    chosen: tuple[Finding, ...]  # findings on that
    kinds: tuple[str, ...]  # effects
    followed: tuple[Finding, ...]  # findings that named them

    def with_effect(self, recordings: Sequence[Recording], kind: str, finding: Finding) -> "_Known":
        """With one more effect."""
        kinds = (*self.kinds, kind)
        at = first_maximum(recordings, _with_first_terms(self.vehicle), kinds)
        return replace(self, at=at, kinds=kinds, followed=(*self.followed, finding))


def _with_first_terms(vehicle: Vehicle) -> Vehicle:
    """The vehicle with its own terms; where they are chosen, with those that every boat has."""
    return with_usual_terms(vehicle) if vehicle.automatic else vehicle


def _known_effects(
    recordings: Sequence[Recording], own: Vehicle, effects: tuple[str, ...], confirm: Confirm
) -> _Known:
    """Effects that the recordings show, and what the commands do where the file leaves it open."""
    vehicle = with_unnamed_forces(own, recordings) if own.automatic else own
    chosen = added_forces(own, vehicle)
    at = first_maximum(recordings, _with_first_terms(vehicle), effects)
    # the commands first: otherwise a dead zone looks like an effect
    if vehicle.automatic:
        at, vehicle, shown = choose_input(at, vehicle, effects)
        chosen += shown
    at, kinds, followed = _with_effects(at, effects, confirm)
    at, kinds, followed = _without_needless(at, _with_first_terms(vehicle), kinds, followed)
    return _Known(at, vehicle, chosen, kinds, followed)


def _whole(recordings: Sequence[Recording], known: _Known) -> Guided:
    """Terms from poses without the effects, where the recordings choose them; then all of it together."""
    vehicle, kinds = known.vehicle, known.kinds
    if vehicle.automatic:
        with stage("choosing terms", 0.4):
            choice = choose_terms_from(known.at if kinds else None, recordings, vehicle)
    else:
        choice = TermChoice(vehicle, None, StartValues.of_solution(known.at))
    choice = replace(choice, findings=known.chosen)
    with stage("identifying"):
        model, solution = identify_with_fit(recordings, vehicle, effects=kinds, choice=choice)
    assert solution is not None  # output-error has one
    return Guided(model, solution, choice, known.followed, kinds)


def _unmodelled(found: Guided) -> tuple[str, Finding] | None:
    """An effect that the model lacks: its kind, as of `effects`, and its finding."""
    for kind, finding_kind in UNMODELLED_EFFECTS.items():
        for finding in of_kinds(found.model.estimator.findings, finding_kind):
            if kind not in found.effects:
                return kind, finding
    return None


def _with_effects(
    at: Point, kinds: tuple[str, ...], confirm: Confirm
) -> tuple[Point, tuple[str, ...], tuple[Finding, ...]]:
    """The solution with the effects that it lacks, one after another, the one with the largest gain first."""
    followed: tuple[Finding, ...] = ()
    while len(kinds) < MOST_EFFECTS:
        found = unmodelled_effect(at, 0.0, sandwich_covariance(at))
        if found.at is None or found.kind not in EFFECT_KINDS or not found.findings:
            break
        if not confirm(found.kind, found.findings[0]):
            break
        at = found.at
        kinds, followed = (*kinds, found.kind), (*followed, found.findings[0])
    return at, kinds, followed


def _without_needless(
    at: Point, vehicle: Vehicle, kinds: tuple[str, ...], followed: tuple[Finding, ...]
) -> tuple[Point, tuple[str, ...], tuple[Finding, ...]]:
    """Without the followed effects that stood for a stage of the actuator chain: with it they are zero."""
    if not followed:
        return at, kinds, followed
    at, _ = select_stages(at, vehicle, OutputErrorSettings(effects=kinds), 0.0)
    given = kinds[: len(kinds) - len(followed)]
    needed = [
        (kind, finding)
        for kind, finding in zip(kinds[len(given) :], followed, strict=True)
        if differs_from_zero(at, effect_places(at.runs.problem, kind))
    ]
    return at, (*given, *(k for k, _ in needed)), tuple(f for _, f in needed)
