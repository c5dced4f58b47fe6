# SPDX-License-Identifier: MIT
"""What to do next after a command, derived from what it found."""

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from seatrial.boat.finding_kinds import ASK_FOR_ACTION, UNMODELLED_EFFECTS
from seatrial.boat.findings import Finding, FindingKind, advice_of, most_important, sentence_of
from seatrial.boat.model import Model
from seatrial.evaluation.scores import GOOD_RATIO, RecordingScore, Scores
from seatrial.identification.uncertainty.identifiability import identifiability
from seatrial.identification.uncertainty.parameter_verdict import ParameterVerdict
from seatrial.inspection.advice import USABLE_POSES
from seatrial.inspection.overview import Inspection
from seatrial.recording.excitation import EXCITED, beyond_full
from seatrial.util.format import joined, percent
from seatrial.util.frames import AXES, SYMBOLS

IDENTIFY_FROM = 3  # trials: the paper's S1-S3
MOST_NAMED = 3  # parameters in one line
EFFECT_OF = {kind: effect for effect, kind in UNMODELLED_EFFECTS.items()}
UNDRIVEN = "the boat moves there without a command"
WEAKER = "an input has another effect there"
LOOK_AT_RECORDINGS = (  # findings that `inspect` may explain
    FindingKind.OUTLIERS,
    FindingKind.NOT_PREDICTABLE,
    FindingKind.NO_SIGNIFICANT_COEFFICIENT,
    FindingKind.NO_BETTER_THAN_CONSTANT,
)

Paths = Sequence[str | Path]
Recordings = Paths  # and the options with which they are read, as words of a command line


@dataclass(frozen=True)
class NextStep:
    """A command or a manoeuvre, and why."""

    do: str
    why: str = ""

    @property
    def text(self) -> str:
        """One line, of which a command can be pasted whole: a shell takes the reason as a comment."""
        if not self.why:
            return f"next: {self.do}"
        return f"next: {self.do}  " + (
            f"# {self.why}" if self.do.startswith("seatrial ") else f"({self.why})"
        )


def after_inspect(found: Inspection, recordings: Recordings, vehicle: str | Path) -> NextStep:
    """Correct the vehicle file, or record what is missing, or identify without what belongs to no model."""
    # what the vehicle file has wrong
    uses = [use for view in found.recordings for use in view.inputs]
    beyond = [text for use in uses for text in beyond_full(use.name, use.least, use.most)]
    wrong = [f.text for f in found.signs.findings if f.leave_out is None]
    for remark in (*found.vehicle.remarks, *beyond, *wrong):
        return NextStep(f"correct {vehicle}", remark)
    # what a recording lacks
    driven = {a.axis for view in found.recordings for a in view.axes if a.rms >= EXCITED}
    missing = [axis for axis in _forced(found) if axis not in driven]
    if missing:
        return NextStep(f"record more with pulses of {joined(missing)}", "no recording excites it")
    # what is left out of them, and what the model lacks with it
    weaker = [f.leave_out.span for f in found.signs.findings if f.leave_out is not None]
    without = _left_out([*found.undriven, *weaker])
    poor = [view for view in found.recordings if view.usable < USABLE_POSES]
    why = UNDRIVEN if found.undriven else WEAKER if weaker else ""
    if poor:
        share = percent(1.0 - poor[0].usable)
        why = f"{share} of the poses of {poor[0].name} are unusable: look at its faults first"
    return NextStep(identify_line([*recordings, *without], vehicle), why)


def _left_out(spans: Sequence[str]) -> list[str]:
    """Intervals NAME=FROM-TO as options."""
    return [word for span in spans for word in ("--without", span)]


def _forced(found: Inspection) -> list[str]:
    axes = {force.axis for force in found.vehicle.forces}
    return [name for i, name in enumerate(AXES) if i in axes]


def identify_line(
    recordings: Recordings, vehicle: str | Path, model: str | Path = "model.yaml", *options: str
) -> str:
    """The command line of `identify`."""
    return command("identify", *recordings, "--vehicle", vehicle, "-o", model, *options)


def command(*words: str | Path) -> str:
    """A command line that a shell reads back."""
    return "seatrial " + " ".join(shlex.quote(str(word)) for word in words)


def after_identify(
    model: Model,
    recordings: Recordings = ("RECORDINGS",),
    vehicle: str | Path = "VEHICLE",
    out: str | Path = "model.yaml",
    options: Sequence[str] = (),
    *,
    automatic: bool = False,
    look: Callable[[], Inspection] | None = None,
) -> NextStep:
    """The most important finding that asks for an action, or validation.

    `options`: those that `identify` had, which it has again; automatic, look: as of `asked_for`.
    """
    asked = asked_for(model, recordings, vehicle, out, options, automatic=automatic, look=look)
    if asked is not None:
        return asked
    # what is not known well
    loose = [
        f for f in identifiability(model).findings
        if f.verdict in (ParameterVerdict.WEAK, ParameterVerdict.LOST)
    ]  # fmt: skip
    step = command("validate", out, "TEST_RECORDING")
    if loose:
        loose.sort(key=lambda f: -f.relative)
        names = ", ".join(f"{f.name} {percent(f.relative)}" for f in loose[:MOST_NAMED])
        return NextStep(step, f"standard errors are large: {names}; the report says what to drive")
    return NextStep(step, "a recording that the model has not seen")


def asked_for(
    model: Model,
    recordings: Recordings,
    vehicle: str | Path,
    out: str | Path,
    options: Sequence[str] = (),
    *,
    automatic: bool = False,
    look: Callable[[], Inspection] | None = None,
) -> NextStep | None:
    """What the model's doubts and findings ask for; None: nothing.

    automatic: the recordings chose the terms; look: the inspection of these recordings, without which it is taken
    to find something.
    """
    found = [f for f in most_important(model.estimator.findings) if f.kind in ASK_FOR_ACTION]
    found = [f for f in found if not (automatic and f.kind is FindingKind.MODEL_MISMATCH)]
    puzzling = [*model.warnings, *(f for f in found if f.kind in LOOK_AT_RECORDINGS)]
    if puzzling and look is not None and _only_identifies(look(), recordings, vehicle):
        # inspect would send back to identify
        found = [f for f in found if f.kind not in LOOK_AT_RECORDINGS]
    elif model.warnings:
        # doubts on recordings and vehicle file come first: they may spoil all else
        return NextStep(command("inspect", *recordings, "--vehicle", vehicle), model.warnings[0])
    return _remedy(found[0], recordings, vehicle, out, options) if found else None


def _only_identifies(found: Inspection, recordings: Recordings, vehicle: str | Path) -> bool:
    """Whether an inspection has nothing to correct and nothing to leave out."""
    return after_inspect(found, recordings, vehicle).do == identify_line(recordings, vehicle)


def _remedy(
    finding: Finding,
    recordings: Recordings,
    vehicle: str | Path,
    out: str | Path,
    options: Sequence[str],
) -> NextStep:
    """The command that a finding asks for; its advice, where it is no command."""
    why = sentence_of(finding)
    kind = finding.kind
    if kind in EFFECT_OF:
        more = (*options, "--effect", EFFECT_OF[kind])
        return NextStep(identify_line(recordings, vehicle, out, *more), why)
    if kind is FindingKind.MISSING_TERM:
        more = (*options, "--structure", "auto")
        return NextStep(identify_line(recordings, vehicle, out, *more), why)
    if kind is FindingKind.MODEL_MISMATCH:
        chosen = Path(vehicle).with_name(f"{Path(vehicle).stem}-chosen.yaml")
        return NextStep(command("select", *recordings, "--vehicle", vehicle, "-o", chosen), why)
    if kind is FindingKind.DISTURBED_INTERVAL:
        span = f"{finding.number('start'):.10g}-{finding.number('end'):.10g}"
        more = (*options, "--without", f"{finding.part('recording')}={span}")
        return NextStep(
            identify_line(recordings, vehicle, out, *more), f"{why}, if you know its cause"
        )
    if kind in LOOK_AT_RECORDINGS:
        return NextStep(command("inspect", *recordings, "--vehicle", vehicle), why)
    return NextStep(advice_of(finding), why)


def after_select(
    recordings: Recordings, out: str | Path | None, *, changed: bool = True
) -> NextStep:
    """Write the chosen terms, or identify with them; changed: they are not those of the vehicle file."""
    if not changed:
        return NextStep(
            command("validate", "model.yaml", "TEST_RECORDING"), "the vehicle file has these terms"
        )
    if out is not None:
        return NextStep(identify_line(recordings, out))
    return NextStep("give -o VEHICLE, for a vehicle file with the chosen terms")


def after_simulate(trials: Paths, vehicle: str | Path) -> NextStep:
    """Identify from the first trials; the others test the model."""
    return NextStep(identify_line(trials[:IDENTIFY_FROM], vehicle))


def after_convert(recording: str | Path, vehicle: str | Path | None) -> NextStep:
    """Look at it, or propose the vehicle file."""
    if vehicle is None:
        return NextStep(command("init", recording, "-o", "vehicle.yaml"))
    return NextStep(command("inspect", recording, "--vehicle", vehicle))


def after_tune(model: str | Path, gains: str | Path | None) -> NextStep:
    """Write the gains, or try them on the simulated boat."""
    if gains is None:
        return NextStep("give -o GAINS, for the gains as a file")
    return NextStep(
        command("sim", model), "try the gains on the simulated boat before the real one"
    )


def after_predict(model: str | Path) -> NextStep:
    """The same on board."""
    return NextStep(
        command("predict", model, "--live"), "the same on board; ROS nodes: docs/ros.md"
    )


def after_export(out: str | Path) -> NextStep:
    """Where to read on."""
    return NextStep(f"use {out}", "how to call it: docs/export.md")


def after_allocate() -> NextStep:
    """The scheme is the boat's."""
    return NextStep(
        "write the scheme at allocation: in the vehicle file, and use it in the boat's software"
    )


def fleet_of(folder: Path) -> NextStep:
    """After simulating many boats."""
    return NextStep(command("fleet", folder), "all boats: one table and one report")


def after_validate(
    model: str | Path,
    scores: Scores,
    recordings: Recordings,
    options: Sequence[str] = (),
    wrong: Sequence[str] = (),
    *,
    undriven: Sequence[str] = (),
    contradicted: Sequence[Finding] = (),
) -> NextStep:
    """What the scores ask for, or the report.

    `options`: those of `validate` that `report` has, too. `wrong`: what contradicts the vehicle file. `undriven`:
    what moves without commands, as of `Inspection`. `contradicted`: findings of the model.
    """
    if contradicted:
        return NextStep(advice_of(contradicted[0]), sentence_of(contradicted[0]))
    if wrong:
        return NextStep(
            "correct the recordings, or give their own vehicle file by --vehicle", wrong[0]
        )
    if undriven:
        driven = [*recordings, *_left_out(undriven)]
        return NextStep(command("validate", model, *driven, *options), UNDRIVEN)
    return _after_scores(model, scores, recordings, options)


def _after_scores(
    model: str | Path, scores: Scores, recordings: Recordings, options: Sequence[str]
) -> NextStep:
    """What the scores of recordings that belong to the vehicle file ask for."""
    report = command("report", model, *recordings, *options, "-o", "report.html")
    rows = scores.recordings
    unseen = [row for row in rows if not row.seen]
    if not unseen:
        return NextStep(
            command("validate", model, "TEST_RECORDING", *options),
            "the model was identified from these: they do not test it",
        )
    poor = [(row, axes) for row in unseen if (axes := _poor(row))]
    if poor:
        row, axes = poor[0]
        return NextStep(
            report,
            f"{row.recording}: {joined(axes)} hardly better than a constant velocity; the report says what "
            "to drive",
        )
    for row in unseen:
        for finding in row.findings:
            if finding.kind is FindingKind.EXCEEDS_EXPECTED_ERROR:
                return NextStep(report, sentence_of(finding))
    return NextStep(report)


def _poor(row: RecordingScore) -> list[str]:
    """Axes in which the model hardly predicts better than a constant velocity."""
    return [
        AXES[i] for i, symbol in enumerate(SYMBOLS)
        if row.scores[symbol].ratio > GOOD_RATIO and not row.scores[symbol].at_floor
    ]  # fmt: skip
