# SPDX-License-Identifier: MIT
"""The whole workflow on the bundled recordings and on simulated trials."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import resources
from pathlib import Path

from seatrial.boat.findings import finding_text
from seatrial.boat.model import Model
from seatrial.boat.model_file import save
from seatrial.boat.physics import model_concerns, physics_line
from seatrial.boat.vehicle import Vehicle, load_vehicle
from seatrial.evaluation.assessment import HORIZONS, Assessment, assess
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.evaluation.scores import Scores, scores_json
from seatrial.evaluation.validation import scores_of
from seatrial.identification.methods import DEFAULT_METHOD, identify
from seatrial.inspection.console import inspection_text
from seatrial.inspection.overview import inspect
from seatrial.inspection.proposal.propose import init
from seatrial.inspection.proposal.sources import Choices
from seatrial.io import read
from seatrial.io.trial_files import write_setting, write_trial
from seatrial.recording.recording import Recording
from seatrial.report.evidence.model_evidence import evidence_of
from seatrial.report.model_report import write_evidence
from seatrial.simulation.plan import PlanFile, load_plan
from seatrial.simulation.trials import SUFFIX, plant_model, simulate
from seatrial.util.errors import FileError
from seatrial.util.files import dump_json, write_text
from seatrial.util.format import table
from seatrial.util.frames import ERROR_UNITS, SYMBOLS
from seatrial.util.parallel import beside, spread
from seatrial.util.progress import over, stage

PAPER = "equation-error"
DEMO_METHODS = (PAPER, DEFAULT_METHOD)
TRAINED_ON = ("CSE1_data_random_run1", "CSE1_data_random_run3")
TESTED_ON = "CSE1_data_run1"
SHIP_SHARE = 0.8  # of the time that all takes
SHIPS = (  # vehicle file, method, label
    ("vehicle.yaml", PAPER, "the paper's method"),
    ("vehicle.yaml", DEFAULT_METHOD, DEFAULT_METHOD),
    ("pair.yaml", DEFAULT_METHOD, "propellers as pairs"),
)
PAIRING = {"S4": "u", "S5": "v", "S6": "r"}  # Table III
TABLE_III = {
    "-MP": {"S4": "2.3", "S5": "3.5", "S6": "0.10"},
    "-AF": {"S4": "1.8", "S5": "2.2", "S6": "0.07"},
}
DEMO_LEGEND = """\
  constant: RMS error of a constant velocity; in brackets: error over that;
  floor: noise floor, the error of a perfect model from pose noise;
  velocities by the five-point stencil, as in the paper; seatrial validate and report have smoothed ones"""
Say = Callable[[str], None]


def demo(out: Path, say: Say) -> None:
    """Identify, validate and report: a real model ship, then the paper's trials. `say` gets lines for the user."""
    with stage("model ship", SHIP_SHARE):
        reported = _ship(out / "cse1", say)
    with stage("simulated trials"):
        _trials(out / "mallard", say)
    reported()
    say(DEMO_LEGEND)


def bundled_data() -> Path:
    """The folder of the bundled recordings."""
    installed = Path(str(resources.files("seatrial"))) / "data"
    for folder in (installed, Path(__file__).resolve().parents[2] / "data"):
        if (folder / "cse1").is_dir():
            return folder
    raise FileError(f"{installed}: the bundled recordings are missing; install seatrial again")


def _ship(out: Path, say: Say) -> Callable[[], None]:
    """C/S Enterprise I: identified on two runs, tested on the third. What is returned ends its report."""
    data = bundled_data() / "cse1"
    say("Real recordings: C/S Enterprise I, a model ship, identified on two runs, tested on run1")
    bags = [data / "mcap" / f"{name}.mcap" for name in (*TRAINED_ON, TESTED_ON)]
    vehicles = {file: load_vehicle(data / file) for file, _, _ in SHIPS}
    with stage("reading", 0.03):
        runs = {file: [read(bag, v) for bag in bags] for file, v in vehicles.items()}
    _inspect(runs["vehicle.yaml"], vehicles["vehicle.yaml"], out, say)
    proposed = beside(partial(_init, bags[:-1], out))

    def identified(ship: tuple[str, str, str]) -> _Identified:
        file, method, _ = ship
        vehicle, (*trained, tested) = vehicles[file], runs[file]
        with stage("identifying", 0.7):
            model = identify(trained, vehicle, method=method)
        unseen = _assessed(model, [tested], method)
        name = vehicle.name if method == DEFAULT_METHOD else f"{vehicle.name}-{method}"
        one = _Identified(model, unseen, _scores(model, unseen), out / name)
        _store(one.folder, model, one.scores)
        return one

    with stage("identifying", 0.85):
        found = spread(identified, SHIPS, "identification")
    say(proposed())
    say(_scores_table({label: one.scores for (*_, label), one in zip(SHIPS, found, strict=True)}))
    # the last one is shown
    shown, (*trained, _) = found[-1], runs[SHIPS[-1][0]]

    def report() -> None:
        _report(
            shown.folder,
            shown.model,
            [*shown.unseen, *_assessed(shown.model, trained, DEFAULT_METHOD)],
        )

    reported = beside(report)
    (row,) = shown.scores.recordings
    say(f"  {row.predictions} predictions, {100 * row.usable:.1f} % of the poses used")
    _show_model(shown.model, shown.folder, say)
    return reported


@dataclass(frozen=True)
class _Identified:
    """A model, and how it predicts the recording that it has not seen."""

    model: Model
    unseen: list[Assessment]
    scores: Scores
    folder: Path


def _inspect(runs: Sequence[Recording], vehicle: Vehicle, out: Path, say: Say) -> None:
    with stage("inspect", 0.03):
        found = inspect(runs, vehicle)
    write_text(out / "inspect.txt", inspection_text(found) + "\n")
    findings = [finding.text for finding in found.signs.findings]
    for sentence in findings or ["consistent with the vehicle file's units, signs and order"]:
        say(f" inspect: {sentence}  -> {out / 'inspect.txt'}")


def _init(bags: Sequence[Path], out: Path) -> str:
    """`init` on the bags; a text for the user."""
    proposal = init(*bags, choices=Choices(name="cse1", axes="forward-right-down"))
    write_text(out / "proposed.yaml", proposal.text)
    return f" init: vehicle file proposed from the bags alone  -> {out / 'proposed.yaml'}\n"


def _trials(out: Path, say: Say) -> None:
    """S1-S7 for both allocations: identified on S1-S3, tested on S4-S7 (Tables II and III)."""
    plan = load_plan("paper-like")
    say(f"Simulated trials: the paper's S1-S7, plan '{plan.name}'")
    for texts in spread(partial(_boat, plan, out), plan.vehicles, "boat"):
        for text in texts:
            say(text)


def _boat(plan: PlanFile, out: Path, name: str) -> list[str]:
    """The trials of one allocation, their models and reports; texts for the user."""
    vehicle = load_vehicle(name)
    suffix = SUFFIX[vehicle.scheme]
    written = write_setting(plan, vehicle, plant_model(plan, vehicle), out)
    with stage("simulating", 0.2):
        trials = over(simulate(plan, vehicle), total=len(plan.trials))
        folders = [write_trial(trial, out) for trial in trials]
    known = load_vehicle(written)
    recordings = [read(folder, known) for folder in folders]
    models: dict[str, Model] = {}
    found: dict[str, Scores] = {}
    for method in DEMO_METHODS:
        with stage(method, 0.3):
            models[method] = identify(recordings[:3], known, method=method)
            assessed = _assessed(models[method], recordings[3:], method)
            found[method] = _scores(models[method], assessed)
    save(models[PAPER], out / f"{PAPER}{suffix}.yaml")
    best = out / f"result{suffix}"
    _store(best, models[method], found[method])
    _report(best, models[method], assessed)
    texts = [
        f" allocation{suffix.replace('-', ' ')}",
        _coefficients_table(models, plan.plant.coefficients),
        _scores_table(found, TABLE_III[suffix]),
    ]
    _show_model(models[DEFAULT_METHOD], best, texts.append)
    return texts


def _scores_table(found: Mapping[str, Scores], boat: Mapping[str, str] | None = None) -> str:
    """RMS errors of several models, and their ratios to constant velocity.

    `boat`: the paper's Table III by trial. Of the trials in its pairing only that velocity is shown.
    """
    head = ["RMS error 1 s ahead", "constant", "floor", *found]
    rows = []
    for several in zip(*(scores.recordings for scores in found.values()), strict=True):
        one, trial = several[0], several[0].recording.partition("-")[0]
        for symbol in PAIRING.get(trial, "".join(one.scores)):
            unit, size = ERROR_UNITS[SYMBOLS.index(symbol)]
            own = [row.scores[symbol] for row in several]
            cells = [f"{size * s.rms:.3f} ({s.ratio:.2f})" for s in own]
            fixed = f"{size * own[-1].stays_constant:.3f}", f"{size * own[-1].floor:.3f}"
            paper = [] if boat is None else [boat.get(trial, "")]
            rows.append([f"{one.recording} {symbol}, {unit}", *fixed, *cells, *paper])
    return table([*head, *([] if boat is None else ["the paper's boat"])], rows)


def _coefficients_table(models: Mapping[str, Model], truth: Mapping[str, float]) -> str:
    """Identified coefficients, and the plant's."""
    values = {"true": truth, **{name: m.values for name, m in models.items()}}
    names = list(next(iter(models.values())).values)
    rows = [[label, *(f"{own[n]:.2f}" for n in names)] for label, own in values.items()]
    return table(["", *names], rows)


def _assessed(model: Model, recordings: Sequence[Recording], method: str) -> list[Assessment]:
    """Predictions for the scores and, of the default method, at all horizons for the report."""
    others = HORIZONS if method == DEFAULT_METHOD else ()
    with stage("validating", 0.5):
        return assess(model, recordings, DEFAULT_HORIZON, "stencil", others)


def _scores(model: Model, assessed: Sequence[Assessment]) -> Scores:
    """Scores of recordings that can be predicted."""
    for one in assessed:
        if one.failure is not None:
            raise one.failure
    return scores_of(model, assessed, DEFAULT_HORIZON, reference="stencil")


def _store(out: Path, model: Model, scores: Scores) -> None:
    save(model, out / "model.yaml")
    write_text(out / "scores.json", dump_json(scores_json(scores)))


def _report(out: Path, model: Model, assessed: Sequence[Assessment]) -> None:
    with stage("report"):
        every = scores_of(model, assessed, DEFAULT_HORIZON, reference="stencil")
        write_evidence(evidence_of(model, assessed, every), out / "report.html")


def _show_model(model: Model, out: Path, say: Say) -> None:
    """Findings, concerns and physics of a model."""
    findings = map(finding_text, model.estimator.findings)
    for sentence in [*findings, *(f"doubt: {concern}" for concern in model_concerns(model))]:
        say(f"  {sentence}")
    say(f"  {physics_line(model)}")
    say(f"  -> {out / 'report.html'}\n")
