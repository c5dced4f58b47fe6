# SPDX-License-Identifier: MIT
"""`seatrial identify`."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import (
    add_json,
    add_recordings,
    guard,
    read_all,
    recordings_again,
    refuse_options,
    write_json,
)
from seatrial.commands.shared.workers import add_workers, on_workers
from seatrial.identification.methods import DEFAULT_METHOD, EFFECT_KINDS, METHODS, PRIOR_SPREAD
from seatrial.util.printing import say
from seatrial.util.progress import stage

if TYPE_CHECKING:
    from seatrial.boat.model import Model
    from seatrial.boat.vehicle import Vehicle
    from seatrial.identification.solution import Fit
    from seatrial.identification.term_choice import TermChoice
    from seatrial.recording.recording import Recording

TOO_SHORT = (
    "structure: auto: {length:.0f} s are too short to choose terms. The model has drag, thrust and free added "
    "mass of every axis. Record {least:.0f} s or more, 20 s for each parameter, or write the terms in the vehicle "
    "file"
)
TOO_MANY = (
    "structure: auto: the recordings ask for more terms than {length:.0f} s tell apart, 20 s for each parameter. "
    "The model has drag, thrust and free added mass of every axis. Do first what the findings advise: terms can "
    "stand in for an effect such as a lever arm; else record longer"
)
DIVERGE = (
    "structure: auto: models with chosen terms diverge. The model has drag, thrust and free added mass of every "
    "axis. Do first what the findings advise: terms can stand in for an effect such as a lever arm"
)


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    add_recordings(command, vehicle=None)
    command.add_argument("-o", "--out", type=Path, required=True, metavar="MODEL")
    add_json(command)
    _add_method(command)
    command.add_argument(
        "-v", "--verbose", action="store_true",
        help="all findings and the table of tested terms; without it the three findings that matter most",
    )  # fmt: skip
    _add_accuracy(command)
    add_workers(command)
    command.add_argument(
        "--literal",
        action="store_true",
        help="equation-error: Eq. (17) as printed, with the surge acceleration one step late",
    )
    _add_prior(command)


def _add_method(command: argparse.ArgumentParser) -> None:
    """How to identify, and what to estimate."""
    command.add_argument(
        "--method", choices=METHODS, default=DEFAULT_METHOD,
        help="output-error: prediction-error estimation on the raw poses, with the thrusters' latency, lag and "
        "dead zone; equation-error: the paper's least squares (default: %(default)s)",
    )  # fmt: skip
    command.add_argument(
        "--structure", choices=["auto"],
        help="auto: the recordings choose the terms, whatever the vehicle file has (default: the vehicle file's)",
    )  # fmt: skip
    command.add_argument(
        "--role", action="append", default=[], metavar="AXIS=NAME[,NAME]",
        help="recordings that identify surge, sway or yaw (default: found from the excitation)",
    )  # fmt: skip
    command.add_argument(
        "--effect", action="append", default=[], choices=EFFECT_KINDS,
        help="estimate this effect, too: the sensor's lever arm, the delay of its position against the heading, "
        "or each recording's current, trim or wind",
    )  # fmt: skip


def _add_accuracy(command: argparse.ArgumentParser) -> None:
    """Tables beside the model."""
    command.add_argument(
        "--minutes", action="store_true", help="standard errors against record length"
    )
    command.add_argument(
        "--profile", nargs="+", action="extend", default=[], metavar="NAME",
        help="confidence intervals of these parameters by profile likelihood",
    )  # fmt: skip
    command.add_argument(
        "--bootstrap", type=int, default=0, metavar="N",
        help="confidence intervals by a block bootstrap of N refits (200 are usual)",
    )  # fmt: skip


def _add_prior(command: argparse.ArgumentParser) -> None:
    """An older model."""
    command.add_argument(
        "--prior", type=Path, metavar="OLD",
        help="model of this boat before its payload changed, as a prior: a short recording is then enough",
    )  # fmt: skip
    command.add_argument(
        "--prior-spread", type=float, metavar="SHARE",
        help=f"share by which parameters of the prior may have changed (default: {PRIOR_SPREAD:g})",
    )  # fmt: skip


def run(args: argparse.Namespace) -> None:
    """A model, its summary, and the tables on request."""
    from seatrial.boat.model_file import load
    from seatrial.boat.vehicle import load_vehicle

    guard(args.out, "seatrial: model", args.vehicle, args.prior, *args.recordings)
    guard(args.json, "{", args.vehicle, args.prior, *args.recordings, args.out)
    if args.prior is None:
        refuse_options(args, "--prior OLD; no prior is given", "prior_spread")
    vehicle = load_vehicle(args.vehicle)
    vehicle = vehicle if args.structure is None else vehicle.with_automatic_structure()
    prior = None if args.prior is None else load(args.prior)
    with stage("reading", 0.1):
        recordings = read_all(args, vehicle)
    with on_workers(args):
        _identify(args, recordings, vehicle, prior)


def _identify(
    args: argparse.Namespace,
    recordings: "list[Recording]",
    vehicle: "Vehicle",
    prior: "Model | None",
) -> None:
    """What the recordings tell: the model's file, and the texts."""
    from seatrial.boat.model_file import save
    from seatrial.commands.shared.results import identified
    from seatrial.identification.methods import EquationErrorSettings, identify_with_fit, summary
    from seatrial.inspection.overview import inspect
    from seatrial.workflow.next_step import after_identify

    reasons, choice = _terms(args, recordings, vehicle, prior)
    settings = EquationErrorSettings(literal=True) if args.literal else None
    roles = _roles(args.role)
    tables = bool(args.minutes or args.profile or args.bootstrap)
    with stage("identifying", 0.4 if tables else None):
        model, solution = identify_with_fit(
            recordings, vehicle, method=args.method, roles=roles, settings=settings,
            prior=prior, effects=args.effect, choice=choice,
            prior_spread=PRIOR_SPREAD if args.prior_spread is None else args.prior_spread,
        )  # fmt: skip
    save(model, args.out)
    if reasons:
        say(f"{reasons}\n")
    say(summary(model, brief=not args.verbose))
    if tables:
        _say_accuracy(args, solution)
    say(f"wrote {args.out}")
    again = recordings_again(args)
    step = after_identify(
        model, again, args.vehicle, args.out, _same_options(args),
        automatic=vehicle.automatic, look=lambda: inspect(recordings, vehicle),
    )  # fmt: skip
    say(step.text)
    write_json(args, "identify 1", identified(model, args.out, step.text))


def _terms(
    args: argparse.Namespace,
    recordings: "list[Recording]",
    vehicle: "Vehicle",
    prior: "Model | None",
) -> "tuple[str, TermChoice | None]":
    """The terms of a vehicle with `structure: auto`, and why, in words."""
    from seatrial.identification.selection.significance import (
        enough_blocks,
        least_length,
        usable_time,
    )
    from seatrial.identification.selection.terms import chosen_terms_text, selection_text
    from seatrial.identification.selection.terms.select_terms import estimated_parameters
    from seatrial.identification.term_choice import choose_terms

    if not vehicle.automatic:
        return "", None
    with stage("choosing terms", 0.6):
        choice = choose_terms(recordings, vehicle, prior, args.effect)
    found = choice.selection
    if found is not None:
        return selection_text(found) if args.verbose else chosen_terms_text(found), choice
    if prior is not None:
        return "", choice
    if choice.diverges:
        return DIVERGE, choice
    fitted = estimated_parameters(choice.vehicle, recordings)
    least, length = least_length(recordings, fitted), usable_time(recordings)
    text = TOO_MANY if enough_blocks(recordings, fitted) else TOO_SHORT
    return text.format(length=length, least=least), choice


def _same_options(args: argparse.Namespace) -> list[str]:
    """The options of this identification that a further one of the same recordings keeps."""
    repeated = (("--effect", args.effect), ("--role", args.role))
    kept = [word for option, values in repeated for value in values for word in (option, value)]
    for option, value in (
        ("--structure", args.structure),
        ("--method", args.method if args.method != DEFAULT_METHOD else None),
        ("--prior", args.prior),
        ("--prior-spread", args.prior_spread),
    ):
        kept += [] if value is None else [option, str(value)]
    return [*kept, "--literal"] if args.literal else kept


def _roles(given: Sequence[str]) -> dict[str, list[str]]:
    from seatrial.util.errors import RecordingError
    from seatrial.util.frames import AXES

    roles: dict[str, list[str]] = {}
    for text in given:
        axis, _, names = text.partition("=")
        if axis not in AXES or not names:
            raise RecordingError(f"--role {text}: expected surge=NAME, sway=NAME or yaw=NAME")
        roles.setdefault(axis, []).extend(names.split(","))
    return roles


def _say_accuracy(args: argparse.Namespace, solution: "Fit | None") -> None:
    """Confidence intervals and record lengths, as asked for."""
    from seatrial.identification.on_request import accuracy_tables

    with stage("computing confidence intervals"):
        shown = accuracy_tables(
            solution, replicates=args.bootstrap, profiled=args.profile, lengths=args.minutes,
        )  # fmt: skip
    say(f"\n{shown}\n")
