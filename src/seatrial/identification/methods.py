# SPDX-License-Identifier: MIT
"""From recordings to a model, by one of four methods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import msgspec

from seatrial.boat.findings import Finding, FindingKind, finding_of, of_kinds
from seatrial.boat.model import Model
from seatrial.boat.physics import axis_physics, model_concerns
from seatrial.boat.schema import EQUATION_ERROR
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.console import caution, summary
from seatrial.identification.diagnostics.solution_checks import late_command_findings
from seatrial.identification.estimator import OUTPUT_ERROR, Fit, OutputErrorSettings, fit
from seatrial.identification.likelihood.parameters import EFFECT_KINDS
from seatrial.identification.prior import SPREAD as PRIOR_SPREAD
from seatrial.identification.prior import check_prior, widened, with_prior_findings
from seatrial.identification.problem_setup import free_delays
from seatrial.identification.recording_checks import check_recordings, commands_beyond, explained
from seatrial.identification.regression.equation_error import (
    EquationErrorSettings,
    equation_error,
)
from seatrial.identification.regression.smoother import SMOOTHER, smoother
from seatrial.identification.regression.weak_form import WEAK_FORM, weak_form
from seatrial.identification.selection.command_sampling import sampling_is_open, stated_sampling
from seatrial.identification.selection.terms import missing_term_findings
from seatrial.identification.selection.thruster_layout import contradicted_layout
from seatrial.identification.solution import StartValues
from seatrial.identification.term_choice import TermChoice, choose_terms
from seatrial.inspection.consistency.between_recordings import check_each_recording
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.recording.excitation import excitation, find_roles
from seatrial.recording.faults.course_heading import course_doubt
from seatrial.recording.recording import Recording
from seatrial.recording.sampled_commands import sampling_doubt
from seatrial.recording.undriven import undriven_motion
from seatrial.util.arguments import expect, expect_each
from seatrial.util.blas import one_blas_thread
from seatrial.util.errors import IdentificationError
from seatrial.util.parallel import beside
from seatrial.util.progress import stage

METHODS = (EQUATION_ERROR, OUTPUT_ERROR, WEAK_FORM, SMOOTHER)
DEFAULT_METHOD = OUTPUT_ERROR
LEAST_USABLE = 0.95  # share of usable poses of a recording: with less the user gets a warning

__all__ = [
    "DEFAULT_METHOD",
    "EFFECT_KINDS",
    "METHODS",
    "PRIOR_SPREAD",
    "EquationErrorSettings",
    "caution",
    "check_recordings",
    "identify",
    "summary",
]


def identify(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    method: str = DEFAULT_METHOD,
    roles: Mapping[str, Sequence[str]] | None = None,
    settings: EquationErrorSettings | None = None,
    prior: Model | None = None,
    prior_spread: float = PRIOR_SPREAD,
    effects: Sequence[str] = (),
) -> Model:
    """The vehicle's model from its recordings, checked for plausible physics.

    `method`: one of `METHODS`. output-error uses every recording for all axes. The other methods use for each axis
    the recordings of its role: `roles` names them by surge, sway and yaw; by default those that drive this axis
    most of all, else all that excite it. `settings`: of equation-error; see `EquationErrorSettings`.

    Of output-error alone: `prior`, an older model that a short recording corrects, where its parameters have
    changed by about `prior_spread` (a share above 0, default 0.2); `effects`, further unknowns to estimate: any of
    lever, current, trim, wind, delay. Raises IdentificationError, RecordingError, ModelError (unstable).
    """
    return identify_with_fit(
        recordings, vehicle, method=method, roles=roles, settings=settings,
        prior=prior, prior_spread=prior_spread, effects=effects,
    )[0]  # fmt: skip


@one_blas_thread
def identify_with_fit(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    method: str = DEFAULT_METHOD,
    roles: Mapping[str, Sequence[str]] | None = None,
    settings: EquationErrorSettings | None = None,
    prior: Model | None = None,
    prior_spread: float = PRIOR_SPREAD,
    effects: Sequence[str] = (),
    choice: TermChoice | None = None,
) -> tuple[Model, Fit | None]:
    """`identify`, and the solution that the model came from; None where the method has none.

    `choice`: the vehicle's terms as chosen from these recordings. Without one, terms that are the user's stay, and
    a finding names the most significant missing one.
    """
    # refuse what no model can come from, and options of another method
    expect(vehicle, Vehicle, "vehicle")
    _check_options(method, roles, settings, prior, effects)
    check_recordings(recordings, vehicle)
    # the terms, where the recordings or the prior choose them
    if vehicle.automatic and choice is None:
        choice = choose_terms(recordings, vehicle, prior, effects)
    vehicle = vehicle if choice is None else choice.vehicle
    # consistency of recordings and vehicle file, on another core
    check = beside(partial(check_each_recording, recordings, vehicle))
    # the method
    solution = None
    with stage("", {OUTPUT_ERROR: 0.95, SMOOTHER: 0.7}.get(method, 0.3)):
        if method == OUTPUT_ERROR:
            model, solution = _output_error(
                recordings, vehicle, prior, prior_spread, effects, choice=choice
            )
        else:
            model = _by_regression(method, recordings, vehicle, roles, settings)
            model = model if choice is None else _with_findings(model, choice.findings)
    # is it a boat?
    axis_physics(model)
    # what contradicts the vehicle file; a wrong clock is in the latency alone
    with stage("checking recordings and vehicle file"):
        report = check()
    estimated = {InconsistencyKind.DELAY} if free_delays(vehicle, effects) else set()
    wrong = [one for one in report.findings if one.kind not in estimated]
    others = [one.text for one in wrong if one.kind is not InconsistencyKind.CLOCK]
    spoilt = [*others, *commands_beyond(recordings, vehicle)][:1]
    found = [finding_of(FindingKind.CONTRADICTED, text=text) for text in spoilt]
    # the commands: coefficients that are not the boat's tell nothing of them
    stated = vehicle
    if not spoilt:
        own_terms = prior is None and (choice is None or not choice.automatic)
        asked = method == OUTPUT_ERROR and own_terms
        shown = solution if asked else None
        stated, found = _commands(model, recordings, vehicle, effects, solution=shown)
    model = _with_findings(model, found)
    doubted = [*(finding.text for finding in wrong), *report.angles]
    warnings = _warnings(recordings, stated, model, doubted)
    return replace(model, warnings=warnings), solution


def _commands(
    model: Model,
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    effects: Sequence[str],
    *,
    solution: Fit | None,
) -> tuple[Vehicle, list[Finding]]:
    """The vehicle with what the recordings show of the commands, and the finding: samples of a logger, or late.

    solution: of the likelihood that shows samples; None: it is not used. Under model mismatch it does not tell.
    """
    if solution is not None and not model.findings_of(FindingKind.MODEL_MISMATCH):
        stated, sampling = stated_sampling(
            recordings, vehicle, effects, StartValues.of_solution(solution)
        )
        if sampling:
            return stated, [*sampling]
    # a logger's samples are stamped late, too, by up to their period: the doubt, where there is one, stands for it
    unsure = sampling_is_open(model.vehicle, recordings) and any(map(sampling_doubt, recordings))
    return vehicle, [] if unsure else late_command_findings(model)


def _by_regression(
    method: str,
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    roles: Mapping[str, Sequence[str]] | None,
    settings: EquationErrorSettings | None,
) -> Model:
    """The model of a method that solves for accelerations, not for poses."""
    if method == WEAK_FORM:
        return weak_form(recordings, vehicle, roles=roles)
    if method == SMOOTHER:
        return smoother(recordings, vehicle, roles=roles)
    return equation_error(recordings, vehicle, roles=roles, settings=settings)


def _findings(solution: Fit, choice: TermChoice | None, prior: Model | None) -> tuple[Finding, ...]:
    """A solution's, with those on its terms and on the thrusters of the vehicle file."""
    chosen = () if choice is None else choice.findings
    found = [*chosen, *solution.findings]
    if choice is None or not choice.automatic:
        found += missing_term_findings(solution)
    if prior is None and not of_kinds(chosen, FindingKind.THRUSTER_LAYOUT_SELECTED):
        found += contradicted_layout(solution)
    return tuple(found)


def _check_options(
    method: str,
    roles: Mapping[str, Sequence[str]] | None,
    settings: EquationErrorSettings | None,
    prior: Model | None,
    effects: Sequence[str],
) -> None:
    """Raises IdentificationError for an option that belongs to another method."""
    if prior is not None:
        expect(prior, Model, "prior")
    if settings is not None:
        expect(settings, EquationErrorSettings, "settings")
    expect_each(effects, str, "effects")
    if method not in METHODS:
        raise IdentificationError(f"no method '{method}'; there are {', '.join(METHODS)}")
    if method != EQUATION_ERROR and settings is not None:
        raise IdentificationError(
            f"a setting like Eq. (17) as printed belongs to {EQUATION_ERROR}, not to {method}; "
            f"add --method {EQUATION_ERROR}"
        )
    if prior is not None and method != OUTPUT_ERROR:
        raise IdentificationError(
            f"a prior belongs to {OUTPUT_ERROR}, not to {method}; add --method {OUTPUT_ERROR}"
        )
    if effects and method != OUTPUT_ERROR:
        raise IdentificationError(f"effects belong to {OUTPUT_ERROR}, not to {method}")
    if method == OUTPUT_ERROR and roles:
        raise IdentificationError(
            f"{method} uses every recording for all axes; for roles, --method {EQUATION_ERROR}"
        )


def _warnings(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    model: Model,
    contradictions: Sequence[str],
) -> tuple[str, ...]:
    """What the user checks first: recordings, vehicle file, and numbers that no boat has."""
    silent = [
        f"{name}: nothing is commanded in all of it; were the commands recorded?"
        for name in _silent(recordings, vehicle)
    ]
    undriven = [f"{r.name}: {found.text(r)}" for r in recordings for found in undriven_motion(r)]
    spoilt = [
        f"{r.name}: {100.0 * (1.0 - r.usable):.0f} % of its poses are left out; inspect says why"
        for r in recordings
        if r.usable < LEAST_USABLE
    ]
    is_open = not isinstance(vehicle.file.commands.sampled, bool)
    doubts = [
        (r, [*r.doubts, *course_doubt(r), *(sampling_doubt(r) if is_open else [])])
        for r in recordings
    ]
    doubtful = [f"{r.name}: {doubt}" for r, own in doubts for doubt in own]
    # a wrong vehicle file before poses that are left out: the first is the next step
    return (
        *silent,
        *contradictions,
        *undriven,
        *spoilt,
        *doubtful,
        *commands_beyond(recordings, vehicle),
        *model_concerns(model),
    )


def _output_error(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    prior: Model | None,
    spread: float,
    effects: Sequence[str],
    *,
    choice: TermChoice | None,
) -> tuple[Model, Fit]:
    """By prediction-error estimation, with the findings of solution, prior and choice of terms."""
    begin = None if choice is None else choice.begin
    with explained(recordings, vehicle):
        solution = _maximised(recordings, vehicle, prior, spread, effects, begin=begin)
    solution = replace(solution, findings=_findings(solution, choice, prior))
    model = solution.model()
    if prior is not None:
        model = with_prior_findings(model, prior, spread)
    return model, solution


def _with_findings(model: Model, findings: Sequence[Finding]) -> Model:
    """The model with findings before its own."""
    found = [*findings, *model.estimator.findings]
    return replace(model, estimator=msgspec.structs.replace(model.estimator, findings=found))


def _maximised(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    prior: Model | None,
    spread: float,
    effects: Sequence[str],
    *,
    begin: StartValues | None,
) -> Fit:
    """With a prior, an axis that was never driven keeps the prior's values."""
    settings = OutputErrorSettings(effects=tuple(effects))
    if prior is None:
        find_roles(vehicle, recordings)  # refuses an axis that was never driven, in words
        return fit(recordings, vehicle, settings=settings, begin=begin)
    if len(silent := _silent(recordings, vehicle)) == len(recordings):
        raise IdentificationError(
            f"{', '.join(silent)}: nothing is commanded; drive, and record the commands"
        )
    check_prior(prior, vehicle, lever="lever" in effects)
    return fit(recordings, vehicle, settings=settings, start=prior, prior=widened(prior, spread))


def _silent(recordings: Sequence[Recording], vehicle: Vehicle) -> list[str]:
    """Names of the recordings without any command."""
    return [r.name for r in recordings if not excitation(vehicle, r).rms.any()]
