# SPDX-License-Identifier: MIT
"""The last steps of a guided path: scores on what was held out, the report, and what to do next."""

from collections.abc import Callable, Sequence

from seatrial.boat.model import Model
from seatrial.evaluation.assessment import assess
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.evaluation.scores import Scores, load_scores, scores_json
from seatrial.evaluation.validation import scores_of, validate
from seatrial.guide.model import effect_options
from seatrial.guide.steps import Task, digest_of
from seatrial.inspection.overview import Inspection
from seatrial.recording.recording import Recording
from seatrial.report.evidence.advice import wants_more_data
from seatrial.report.evidence.model_evidence import Evidence, evidence_of
from seatrial.report.evidence.verdict import following, predicted, wished
from seatrial.report.model_report import write_evidence
from seatrial.util.files import dump_json, sha256, write_text
from seatrial.workflow.fitness import Level, Use
from seatrial.workflow.next_step import NextStep, asked_for, command


def scores_on(here: Task, model: Model, tested: Sequence[Recording], made_from: str) -> Scores:
    """Validate; or the scores that are there."""
    path = here.file("scores.json")
    # of what the model is made from, its answers may differ
    own = digest_of(made_from, sha256(here.file("model.yaml")))
    if here.steps.done("scores", own, [path]):
        return load_scores(path)
    scores = validate(model, tested)
    write_text(path, dump_json(scores_json(scores)))
    here.steps.note("scores", own, [path])
    return scores


def report(
    here: Task,
    model: Model,
    recordings: Sequence[Recording],
    training: Sequence[Recording],
    whole: str | None,
    *,
    automatic: bool,
    look: Callable[[], Inspection],
) -> NextStep:
    """The page of all recordings; and what to do next.

    training: recordings that the model came from. whole: the command that identifies from what is held out, too;
    automatic, look: as of `asked_for`.
    """
    found = assess(model, recordings, DEFAULT_HORIZON)
    evidence = evidence_of(model, found, scores_of(model, found, DEFAULT_HORIZON))
    write_evidence(evidence, here.file("report.html"))
    here.say(f"validate  {predicted(evidence)}  -> {here.file('scores.json')}")
    here.say(f"report    -> {here.file('report.html')}")
    # what `auto` estimated stays, and so does its model; what tests it stays out of the next one
    logs = here.again(*(here.log_of[one.sources] for one in training))
    vehicle, further = here.file("vehicle.yaml"), here.file("model-2.yaml")
    wanted = asked_for(
        model, logs, vehicle, further, effect_options(model), automatic=automatic, look=look
    )
    if wanted is not None:
        return wanted
    return after_report(here, evidence, whole)


def after_report(here: Task, evidence: Evidence, whole: str | None) -> NextStep:
    """What no finding's command does: odometry where the model is fit for it, else what the evidence asks for."""
    odometry = next(one for one in evidence.fitness if one.use is Use.ODOMETRY)
    if not wished(evidence) and odometry.level is not Level.NOT_FIT:
        out = here.file("odometry.csv")
        use = command("predict", here.file("model.yaml"), *here.again(here.logs[0]), "-o", out)
        return NextStep(use, "velocity and odometry as on board; other uses: docs/uses.md")
    wish = following(evidence).removeprefix("Next: ")
    # what is held out may have the driving that the model lacks
    if whole is not None and wants_more_data(evidence):
        return NextStep(
            whole, f"this model lacks the last quarter of each log. If that is not enough: {wish}"
        )
    return NextStep(wish)
