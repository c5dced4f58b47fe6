# SPDX-License-Identifier: MIT
"""Identification that follows its own findings: the effects that the model lacks are estimated, too."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from seatrial.boat.finding_kinds import UNMODELLED_EFFECTS
from seatrial.boat.findings import Finding, of_kinds
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.methods import identify_with_fit, with_chosen_terms
from seatrial.identification.selection.terms import Selection
from seatrial.identification.solution import Fit
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError
from seatrial.util.progress import stage

MOST_EFFECTS = 3  # a boat that needs more of them is described by none
FIRST_SHARE = 0.5  # of the time, for the model without further effects

Confirm = Callable[[str, Finding], bool]


@dataclass(frozen=True)
class Guided:
    """A model, and what was decided on the way to it."""

    model: Model
    solution: Fit
    chosen: Selection | None  # terms that the recordings chose; None: given, or too short to choose
    followed: tuple[Finding, ...]  # findings whose effects are estimated now
    effects: tuple[str, ...]


def identify_guided(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    effects: Sequence[str] = (),
    confirm: Confirm = lambda _kind, _finding: True,
) -> Guided:
    """`identify`, and again with each unmodelled effect that it finds, at most `MOST_EFFECTS` of them.

    `effects`: those to begin with. `confirm`: whether a found effect (kind, finding) is estimated. With
    `structure: auto` terms are chosen again after each effect, from recordings without it. An effect with which
    there is no solution is left out. Raises as `identify`.
    """
    with stage("", FIRST_SHARE):
        found = _identified(recordings, vehicle, tuple(effects))
    for _ in range(MOST_EFFECTS - len(effects)):
        # the unmodelled effect, where there is one
        named = _unmodelled(found.model)
        if named is None or named[0] in found.effects or not confirm(*named):
            break
        kind, finding = named
        # with it; the terms are chosen without its influence on the poses
        with stage(f"with {kind}"):
            try:
                further = _identified(
                    recordings, vehicle, (*found.effects, kind),
                    choose_from=_without_effect(found, recordings, kind),
                )  # fmt: skip
            except IdentificationError:
                break
        found = replace(further, followed=(*found.followed, finding))
    return found


def _unmodelled(model: Model) -> tuple[str, Finding] | None:
    """The effect that the model lacks: its kind, as of `effects`, and its finding."""
    for kind, finding_kind in UNMODELLED_EFFECTS.items():
        for finding in of_kinds(model.estimator.findings, finding_kind):
            return kind, finding
    return None


def _without_effect(
    found: Guided, recordings: Sequence[Recording], kind: str
) -> Sequence[Recording]:
    """Recordings for the choice of terms: poses of the origin, without lever arm, delays and current.

    Trim and wind stay: they are forces, which the process noise of the filter includes.
    """
    if found.chosen is None:  # no terms are chosen
        return recordings
    with stage("", 0.3):
        _, solution = identify_with_fit(
            recordings, found.chosen.vehicle, effects=(*found.effects, kind), chosen=found.chosen
        )
    assert solution is not None  # output-error has one
    problem, theta = solution.problem, solution.theta
    return [problem.origin_poses(i, theta) for i in range(len(recordings))]


def _identified(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    effects: tuple[str, ...],
    choose_from: Sequence[Recording] | None = None,
) -> Guided:
    """One identification; `choose_from`: recordings that choose the terms, if they are others."""
    chosen = None
    if vehicle.automatic:
        with stage("choosing terms", 0.6):
            vehicle, chosen = with_chosen_terms(choose_from or recordings, vehicle)
    with stage("identifying"):
        model, solution = identify_with_fit(recordings, vehicle, effects=effects, chosen=chosen)
    assert solution is not None  # output-error has one
    return Guided(model, solution, chosen, (), effects)
