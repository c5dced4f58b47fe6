# SPDX-License-Identifier: MIT
"""`auto`: vehicle file, inspection, model, validation on what was held out, report."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from seatrial.boat.findings import Finding
from seatrial.boat.model import Model, load, save
from seatrial.boat.vehicle import Vehicle, load_vehicle
from seatrial.evaluation.assessment import assess
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.evaluation.scores import Scores, load_scores, scores_json
from seatrial.evaluation.validation import scores_of, validate
from seatrial.guide.answers import (
    AT_ORIGIN,
    assumptions,
    choices_of,
    effect_answered,
    proposed,
)
from seatrial.guide.held_out import HELD_OUT_SUFFIX, hold_out, place_of
from seatrial.guide.steps import Say, Steps, Task, digest_of
from seatrial.identification.guided import identify_guided
from seatrial.identification.selection.significance import least_length
from seatrial.inspection.console import inspection_text
from seatrial.inspection.overview import Inspection, inspect
from seatrial.inspection.proposal.sources import Choices
from seatrial.io import read
from seatrial.io.reader import recording_name
from seatrial.recording.recording import Recording
from seatrial.recording.undriven import undriven_motion
from seatrial.report.evidence.advice import wants_more_data
from seatrial.report.evidence.model_evidence import evidence_of
from seatrial.report.evidence.verdict import USE_WITHIN_ENVELOPE, following, predicted
from seatrial.report.model_report import write_evidence
from seatrial.util.errors import FileError, RecordingError, VehicleError
from seatrial.util.files import dump_json, write_text
from seatrial.util.format import joined
from seatrial.util.progress import over, stage
from seatrial.util.questions import Questions
from seatrial.workflow.next_step import NextStep, asked_for, command, identify_line


@dataclass(frozen=True)
class Guide:
    """What a guided path ended with."""

    folder: Path
    model: Model
    scores: Scores
    assumed: tuple[str, ...]
    next: NextStep
    inspection: Inspection

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / "report.html"


def auto(
    logs: Sequence[str | Path],
    folder: str | Path,
    *,
    test: str | Path | None = None,
    choices: Choices | None = None,
    ask: Questions | None = None,
    say: Say = lambda _: None,
    salvage: bool = False,
    effects: Sequence[str] = (),
) -> Guide:
    """From logs to a model that is validated on what was held out, and its report, in one folder.

    `test`: the log of `logs` that tests the model; default: the last quarter of each. `ask`: who answers what no
    log can tell; without, it is assumed and stated. `effects`: those to begin with, as of `identify`. A path that
    was stopped goes on where it was, and a vehicle file in the folder is used as it is: it has the answers. Raises
    as `init`, `identify` and `validate`.
    """
    paths = tuple(Path(log) for log in logs)
    if not paths:
        raise RecordingError("no log given; pass at least one")
    if Path(folder).is_file():
        raise FileError(f"{folder}: is a file; give a folder to write to")
    if test is not None:
        place_of(str(test), paths)
    here = Task(paths, Path(folder), ask, say, salvage, Steps(Path(folder)), tuple(effects))
    # 1. the vehicle file: proposed once, then the user's
    with stage("vehicle file", 0.1):
        proposed_now = _vehicle_file(here, choices or Choices())
        vehicle = load_vehicle(here.file("vehicle.yaml"))
    # 2. the recordings, and consistency of the vehicle file with them
    with stage("reading", 0.1), _of_this_boat(here, proposed_now=proposed_now):
        recordings = [read(path, vehicle, salvage=salvage) for path in over(here.logs)]
    with stage("inspecting", 0.05):
        inspection = _inspect(here, recordings, vehicle)
        recordings = [_while_driven(here, recording) for recording in recordings]
    # 3. the model, from all but what is held out
    training, held_out = hold_out(here, recordings, vehicle, test)
    made_from = digest_of(
        [source.sha256 for r in recordings for source in r.sources],
        here.file("vehicle.yaml").read_text("utf-8"),
        [(r.name, r.offset, r.duration) for r in training],
        *here.effects,
    )
    with stage("identifying", 0.55):
        model = _model(here, training, vehicle, made_from)
    whole = _identify_whole(here, model, held_out)
    if whole is not None:
        here.assumed.append(
            f"what tests the model is not used to identify it. A model of all the data: {whole}"
        )
    # 4. scores on what was held out, 5. the report on all of it
    with stage("validating", 0.1):
        tested = _as_model_reads(here, model, vehicle, held_out)
        scores = _scores(here, model, tested or training, made_from)
    with stage("report"):
        seen = _as_model_reads(here, model, vehicle, training)
        step = _report(here, model, [*tested, *seen], whole)
    return Guide(here.folder, model, scores, tuple(here.assumed), step, inspection)


@contextmanager
def _of_this_boat(here: Task, *, proposed_now: bool) -> Iterator[None]:
    """Refuses logs that a vehicle file that was there does not describe: the folder may be another boat's."""
    try:
        yield
    except (RecordingError, VehicleError) as error:
        if proposed_now:
            raise
        logs = joined([str(log) for log in here.logs])
        raise RecordingError(
            f"{here.folder} has a vehicle file that does not describe {logs}: {error}. "
            "If it is another boat's folder, give another one with -o; else change the file, or remove it"
        ) from error


def _vehicle_file(here: Task, choices: Choices) -> bool:
    """Propose it, unless there is one; whether it was proposed."""
    path = here.file("vehicle.yaml")
    if path.exists():
        unused = (
            "; options on the boat are not used: change the file"
            if replace(choices, name=None) != Choices()
            else ""
        )
        here.say(f"vehicle   {path}, as it is{unused}")
        here.assumed += _other_logs(here)
        return False
    if here.file("model.yaml").exists():
        raise FileError(
            f"{here.folder}: has a model but no vehicle.yaml; give another folder, or remove it"
        )
    chosen = choices_of(here.logs[0], choices, here.ask)
    proposal, chosen = proposed(here.logs, chosen, here.ask, salvage=here.salvage)
    here.assumed += assumptions(here.logs[0], proposal, chosen, here.ask)
    write_text(path, proposal.text)
    inputs = joined([*proposal.drive.inputs])
    axes = joined(
        [force["axis"] for force in proposal.drive.forces.values()] or ["surge, sway, yaw"]
    )
    here.say(f"vehicle   {inputs} drive {axes}  -> {path}")
    return True


def _other_logs(here: Task) -> list[str]:
    """What is assumed where the folder has a model of other recordings, none of them given."""
    path = here.file("model.yaml")
    before = [entry.name for entry in load(path).recordings] if path.exists() else []
    if not before or set(before) & {recording_name(log) for log in here.logs}:
        return []
    return [
        f"these logs are of the boat in {here.file('vehicle.yaml')}, whose model was of {joined(before)} and "
        "is replaced (-o for another boat)"
    ]


def _while_driven(here: Task, recording: Recording) -> Recording:
    """Without a beginning or an end in which the boat is carried, towed or adrift."""
    start, end = None, None
    for found in undriven_motion(recording):
        which = "first" if found.first else "last"
        here.assumed.append(
            f"the {which} {found.end - found.start:.0f} s of {recording.name} are left out: the boat moves "
            f"{found.moved:.0f} m there without a command (carried, towed or adrift)"
        )
        start, end = (found.end, end) if found.first else (start, found.start)
    return recording if start is end is None else recording.cut(start, end)


def _inspect(here: Task, recordings: Sequence[Recording], vehicle: Vehicle) -> Inspection:
    """State what is wrong with recordings and vehicle file; the model has it as a doubt."""
    found = inspect(recordings, vehicle)
    write_text(here.file("inspect.txt"), inspection_text(found) + "\n")
    length = sum(r.duration for r in recordings)
    usable = sum(r.usable * r.duration for r in recordings) / length
    wrong = [*found.vehicle.remarks, *(finding.text for finding in found.signs.findings)]
    verdict = wrong[0] if wrong else "units, signs and order are consistent"
    share = f"{100.0 * usable:.1f} % of the poses usable"
    here.say(f"inspect   {length:.0f} s, {share}; {verdict}  -> {here.file('inspect.txt')}")
    return found


def _model(here: Task, training: Sequence[Recording], vehicle: Vehicle, made_from: str) -> Model:
    """Identify, with the effects that the model lacks; or the model that is there."""
    path = here.file("model.yaml")
    if here.steps.done("model", made_from, [path]):
        here.say(f"identify  done before  -> {path}")
        return load(path)
    accepted: list[str] = []

    def confirm(kind: str, finding: Finding) -> bool:
        answer = here.ask is None or effect_answered(finding, here.ask)
        accepted.extend([kind] if answer else [])
        return answer

    found = identify_guided(training, vehicle, effects=here.effects, confirm=confirm)
    save(found.model, path)
    here.steps.note("model", made_from, [path])
    terms = f"{len(found.model.values)} coefficients"
    if found.chosen is not None:
        terms += ", terms chosen by the recordings"
    elif vehicle.automatic:
        least = least_length(training, len(found.solution.problem.free))
        terms += (
            ", those that every boat has: the recordings are too short to choose terms "
            f"({least:.0f} s or more, beside what tests the model)"
        )
    with_them = f"; with {joined(found.effects)}" if found.effects else ""
    if here.ask is None:
        here.assumed += [
            f"{effect} is estimated with the model, as the log shows it" for effect in found.effects
        ]
    dropped = [kind for kind in accepted if kind not in found.effects]
    without = f"; without {joined(dropped)}, which the other parts explain" if dropped else ""
    here.say(f"identify  {terms}{with_them}{without}  -> {path}")
    _lever_stated_wrong(here, found.model, vehicle)
    return found.model


def _identify_whole(here: Task, model: Model, held_out: Sequence[Recording]) -> str | None:
    """The command that identifies from the last quarters, too; None where none is held out."""
    if not any(one.name.endswith(HELD_OUT_SUFFIX) for one in held_out):
        return None
    whole = here.file("model-of-all.yaml")
    return identify_line(here.logs, here.file("vehicle.yaml"), whole, *_effect_options(model))


def _effect_options(model: Model) -> list[str]:
    """Options of `identify` with the model's effects."""
    effects = str(model.estimator.settings.get("effects") or "").split(", ")
    return [word for effect in effects if effect for word in ("--effect", effect)]


def _lever_stated_wrong(here: Task, model: Model, vehicle: Vehicle) -> None:
    """State that the lever arm is the log's: the user's, or the origin, does not stand."""
    if model.vehicle.lever == vehicle.lever:
        return
    here.assumed[:] = [one for one in here.assumed if one != AT_ORIGIN]
    if vehicle.stated_lever is not None and any(vehicle.lever):
        here.assumed.append(
            f"the lever arm stated, {vehicle.point}, does not fit the log; it shows {model.vehicle.point}"
        )


def _as_model_reads(
    here: Task, model: Model, vehicle: Vehicle, recordings: Sequence[Recording]
) -> list[Recording]:
    """The recordings as the model's vehicle reads them: with the lever arm and delays that were estimated."""
    if (model.vehicle.lever, model.vehicle.delays) == (vehicle.lever, vehicle.delays):
        return [*recordings]
    names = {recording_name(path): path for path in here.logs}
    found = []
    for one in recordings:
        name = one.name.removesuffix(HELD_OUT_SUFFIX)
        again = read(names[name], model.vehicle, salvage=here.salvage)
        part = again.cut(one.offset or None, one.offset + one.duration + 0.5 * one.period)
        found.append(replace(part, name=one.name))
    return found


def _scores(here: Task, model: Model, tested: Sequence[Recording], made_from: str) -> Scores:
    """Validate; or the scores that are there."""
    path = here.file("scores.json")
    if here.steps.done("scores", made_from, [path]):
        return load_scores(path)
    scores = validate(model, tested)
    write_text(path, dump_json(scores_json(scores)))
    here.steps.note("scores", made_from, [path])
    return scores


def _report(
    here: Task, model: Model, recordings: Sequence[Recording], whole: str | None
) -> NextStep:
    """The page; and what to do next. whole: the command that identifies from what is held out, too."""
    found = assess(model, recordings, DEFAULT_HORIZON)
    evidence = evidence_of(model, found, scores_of(model, found, DEFAULT_HORIZON))
    write_evidence(evidence, here.file("report.html"))
    here.say(f"validate  {predicted(evidence)}  -> {here.file('scores.json')}")
    here.say(f"report    -> {here.file('report.html')}")
    # what `auto` estimated stays, and so does its model
    vehicle, further = here.file("vehicle.yaml"), here.file("model-2.yaml")
    wanted = asked_for(model, here.logs, vehicle, further, _effect_options(model))
    if wanted is not None:
        return wanted
    step = following(evidence)
    if step.endswith(USE_WITHIN_ENVELOPE):
        out = here.file("odometry.csv")
        use = command("predict", here.file("model.yaml"), here.logs[0], "-o", out)
        return NextStep(use, "velocity and odometry as on board; other uses: docs/uses.md")
    wish = step.removeprefix("Next: ")
    # what is held out may have the driving that the model lacks
    if whole is not None and wants_more_data(evidence):
        return NextStep(
            whole, f"this model lacks the last quarter of each log. If that is not enough: {wish}"
        )
    return NextStep(wish)
