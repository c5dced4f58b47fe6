# SPDX-License-Identifier: MIT
"""The whole line on the bundled recordings and on simulated trials."""

from collections.abc import Callable
from importlib import resources
from pathlib import Path

from seatrial.errors import FileError
from seatrial.files import dump_json, write_text
from seatrial.identify import identify
from seatrial.init import Choices, init
from seatrial.inspect import inspect
from seatrial.inspect.text import inspection_text
from seatrial.io import read
from seatrial.io.write import write_setting, write_trial
from seatrial.model import Model, save
from seatrial.plan import load_plan
from seatrial.recording import Recording
from seatrial.report import write_report
from seatrial.sanity import concerns, sanity_line
from seatrial.simulate import SUFFIX, plant_model, simulate
from seatrial.validate import LEGEND, Scores, scores_json, scores_text, validate
from seatrial.vehicle import Vehicle, load_vehicle

TRAINED_ON = ("CSE1_data_random_run1", "CSE1_data_random_run3")
TESTED_ON = "CSE1_data_run1"
TABLE_III = {
    "-MP": "S4 u 2.3 cm/s, S5 v 3.5 cm/s, S6 r 0.10 rad/s",
    "-AF": "S4 u 1.8 cm/s, S5 v 2.2 cm/s, S6 r 0.07 rad/s",
}
Say = Callable[[str], None]


def demo(out: Path, say: Say, note: Say) -> None:
    """Identify, validate and report: a real model ship, then the paper's trials.

    `say` gets lines for the user, `note` what is being done.
    """
    _ship(out / "cse1", say, note)
    _trials(out / "mallard", say, note)
    say(LEGEND)


def bundled_data() -> Path:
    """Where the recordings that come with seatrial are."""
    installed = Path(str(resources.files("seatrial"))) / "data"
    for folder in (installed, Path(__file__).resolve().parents[2] / "data"):
        if (folder / "cse1").is_dir():
            return folder
    raise FileError(f"{installed}: the bundled recordings are missing; install seatrial again")


def _ship(out: Path, say: Say, note: Say) -> None:
    """C/S Enterprise I: identified on two runs, tested on the third."""
    data = bundled_data() / "cse1"
    say("Real recordings: C/S Enterprise I, a model ship, identified on two runs, tested on run1")
    bags = {n: data / "mcap" / f"{n}.mcap" for n in (*TRAINED_ON, TESTED_ON)}
    _look(bags, load_vehicle(data / "vehicle.yaml"), out, say, note)
    for file, label in (
        ("vehicle.yaml", "the paper's structure"),
        ("coupled.yaml", "with coupled terms and delay"),
    ):
        note(f"CSE1, {label}")
        vehicle = load_vehicle(data / file)
        runs = {name: read(bag, vehicle) for name, bag in bags.items()}
        model = identify([runs[n] for n in TRAINED_ON], vehicle)
        scores = validate(model, [runs[TESTED_ON]])
        say(f" {label}: {scores_text(scores)}")
        _store(
            out / vehicle.name,
            model,
            scores,
            [runs[TESTED_ON], *(runs[n] for n in TRAINED_ON)],
            say,
        )


def _look(bags: dict[str, Path], vehicle: Vehicle, out: Path, say: Say, note: Say) -> None:
    """What `inspect` and `init` make of the bags."""
    note("CSE1, inspect")
    found = inspect([read(bag, vehicle) for bag in bags.values()], vehicle)
    write_text(out / "inspect.txt", inspection_text(found) + "\n")
    wrong = [finding.text for finding in found.signs.findings]
    for sentence in wrong or ["nothing against the vehicle file's units, signs and order"]:
        say(f" inspect: {sentence}  -> {out / 'inspect.txt'}")
    note("CSE1, init")
    proposal = init(
        *(bags[n] for n in TRAINED_ON), choices=Choices(name="cse1", axes="forward-right-down")
    )
    write_text(out / "proposed.yaml", proposal.text)
    say(f" init: what the bags alone say of the ship  -> {out / 'proposed.yaml'}\n")


def _trials(out: Path, say: Say, note: Say) -> None:
    """S1-S7 for both allocations: identified on S1-S3, tested on S4-S7 (Tables II and III)."""
    plan = load_plan("paper-like")
    say(f"Simulated trials: the paper's S1-S7, plan '{plan.name}'")
    models: dict[str, Model] = {}
    for name in plan.vehicles:
        vehicle = load_vehicle(name)
        suffix = SUFFIX[vehicle.scheme]
        written = write_setting(plan, vehicle, plant_model(plan, vehicle), out)
        folders = []
        for trial in simulate(plan, vehicle):
            note(f"simulating {trial.name}")
            folders.append(write_trial(trial, out))
        note(f"identifying {vehicle.name}{suffix}")
        recordings = _read_all(folders, load_vehicle(written))
        models[suffix] = identify(recordings[:3], load_vehicle(written))
        scores = validate(models[suffix], recordings[3:])
        say(f" allocation{suffix.replace('-', ' ')}: {scores_text(scores)}")
        say(_beside_truth(models[suffix], plan.plant.coefficients))
        say(f"  the paper's boat (Table III): {TABLE_III[suffix]}")
        _store(out / f"result{suffix}", models[suffix], scores, recordings[3:], say)


def _beside_truth(model: Model, truth: dict[str, float]) -> str:
    """Coefficients found, the plant's in brackets: pose noise biases the paper's method."""
    cells = [f"{name} {value:.2f} ({truth[name]:.2f})" for name, value in model.values.items()]
    return "  found (true): " + ", ".join(cells)


def _read_all(folders: list[Path], vehicle: Vehicle) -> list[Recording]:
    return [read(folder, vehicle) for folder in folders]


def _store(out: Path, model: Model, scores: Scores, recordings: list[Recording], say: Say) -> None:
    save(model, out / "model.yaml")
    write_text(out / "scores.json", dump_json(scores_json(scores)))
    write_report(model, recordings, out / "report.html")
    for doubt in concerns(model):
        say(f"  doubt: {doubt}")
    say(f"  {sanity_line(model)}")
    say(f"  -> {out / 'report.html'}\n")
