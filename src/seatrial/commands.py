# SPDX-License-Identifier: MIT
"""What each command does: reads, calls the library function of the same name, prints and writes."""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.frames import Axes
from seatrial.progress import Progress

if TYPE_CHECKING:
    from seatrial.live import Settings
    from seatrial.model import Model
    from seatrial.recording import Recording
    from seatrial.vehicle import Vehicle

AXES_NAMES = tuple(axes.value for axes in Axes)
AXES_QUESTION = """\
No data can tell which way the axes point: when the boat turns to the left, does psi rise (x forward, y to \
port) or fall (y to starboard)?"""
Command = Callable[[argparse.Namespace, Progress], None]


def _guard(out: "Path | None", begins: str, *inputs: object) -> None:
    """Refuse an output that is an input, or a file that is something else."""
    from seatrial.errors import FileError

    given = [Path(str(path)).resolve() for path in inputs if path is not None]
    if out is not None and out.resolve() in given:
        raise FileError(f"{out}: is an input of this command; give another name to write to")
    if out is None or not out.is_file():  # a folder or an odd path is refused where it is written
        return
    try:
        with out.open("rb") as file:
            first = file.read(len(begins)).decode("utf-8", "replace")
    except OSError as error:
        raise FileError(f"{out}: can't be written ({error.strerror})") from None
    if first.lower() != begins.lower():
        raise FileError(
            f"{out}: exists, and is not a file of this kind; give another name, or remove it"
        )


def _read(args: argparse.Namespace, vehicle: "Vehicle", progress: Progress) -> "list[Recording]":
    from seatrial.io import read

    found = []
    for path in progress.over(args.recordings, "reading", len(args.recordings)):
        recording = read(path, vehicle, salvage=args.salvage)
        if args.start is not None or args.end is not None:
            recording = recording.cut(args.start, args.end)
        found.append(recording)
    return found


def _load(args: argparse.Namespace) -> "Model":
    from seatrial.model import load
    from seatrial.vehicle import load_vehicle

    model = load(args.model)
    return model if args.vehicle is None else model.with_vehicle(load_vehicle(args.vehicle))


def demo_command(args: argparse.Namespace, progress: Progress) -> None:
    """Everything on the bundled recordings."""
    from seatrial.demo import demo

    def say(text: str) -> None:
        progress.clear()
        print(text)

    demo(args.out, say, progress.say)


def inspect_command(args: argparse.Namespace, progress: Progress) -> None:
    """Rates, gaps, faults, signs; without a vehicle file the topics or columns."""
    from seatrial.files import dump_json, write_text

    _guard(args.json, "{", args.vehicle, *args.recordings)
    if args.vehicle is None:
        from seatrial.io.look import look

        found = [look(path, salvage=args.salvage) for path in args.recordings]
        text, content = "\n".join(t for t, _ in found), {"recordings": [c for _, c in found]}
    else:
        from seatrial.inspect import inspect, inspection_json
        from seatrial.inspect.text import inspection_text
        from seatrial.vehicle import load_vehicle

        vehicle = load_vehicle(args.vehicle)
        inspection = inspect(_read(args, vehicle, progress), vehicle)
        progress.clear()
        text, content = inspection_text(inspection), inspection_json(inspection)
    if args.json is not None:
        write_text(args.json, dump_json(content))
    print(text)


def init_command(args: argparse.Namespace, progress: Progress) -> None:
    """A vehicle file proposed from a recording; asks where it may."""
    from seatrial.errors import FileError
    from seatrial.files import write_text
    from seatrial.init import Choices, init

    _guard(args.out, "", *args.recordings)
    if args.out.exists() and not args.force:
        raise FileError(
            f"{args.out}: exists already; give another name, or --force to write over it"
        )
    ask = _ask if sys.stdin.isatty() and sys.stdout.isatty() and not args.quiet else None
    axes = args.axes or (_ask(AXES_QUESTION, AXES_NAMES) if ask else AXES_NAMES[0])
    choices = Choices(args.name, axes, args.pose, args.commands, args.parent, args.child)
    progress.say("looking")
    proposal = init(*args.recordings, choices=choices, ask=ask, salvage=args.salvage)
    write_text(args.out, proposal.text)
    progress.clear()
    shown = " ".join(str(path) for path in args.recordings)
    print(proposal.text, end="")
    print(f"wrote {args.out}; next: seatrial inspect {shown} --vehicle {args.out}")


def _ask(question: str, options: Sequence[str]) -> str:
    """Let the user choose by number; enter is the first."""
    print(question)
    for i, option in enumerate(options, 1):
        print(f"  {i}  {option}")
    while True:
        try:
            answer = input(f"1 to {len(options)} [1]: ").strip() or "1"
        except EOFError:
            return options[0]
        if answer.isdecimal() and 1 <= int(answer) <= len(options):
            return options[int(answer) - 1]


def simulate_command(args: argparse.Namespace, progress: Progress) -> None:
    """Trials of a plan, written vehicle by vehicle."""
    from seatrial.io.write import write_setting, write_trial
    from seatrial.model import load
    from seatrial.plan import load_plan, with_seed
    from seatrial.simulate import plant_model, simulate
    from seatrial.vehicle import load_vehicle

    plan = load_plan(args.plan)
    if args.seed is not None:
        plan = with_seed(plan, args.seed)
    given = None if args.model is None else load(args.model)
    for name in plan.vehicles if args.vehicle is None else [args.vehicle]:
        vehicle = load_vehicle(name)
        truth = plant_model(plan, vehicle) if given is None else given.with_vehicle(vehicle)
        print(f"vehicle {write_setting(plan, vehicle, truth, args.out)}")
        for trial in progress.over(simulate(plan, vehicle, given), "simulating", len(plan.trials)):
            print(f"  {write_trial(trial, args.out, args.format)}")


def identify_command(args: argparse.Namespace, progress: Progress) -> None:
    """A model, its summary, and the evidence that was asked for."""
    from seatrial.identify import EquationErrorSettings, identify, summary
    from seatrial.model import load, save
    from seatrial.vehicle import load_vehicle

    _guard(args.out, "seatrial: model", args.vehicle, args.prior, *args.recordings)
    vehicle = load_vehicle(args.vehicle)
    prior = None if args.prior is None else load(args.prior)
    recordings = _read(args, vehicle, progress)
    progress.say("identifying")
    settings = EquationErrorSettings(literal=args.literal)
    roles = _roles(args.role)
    model = identify(
        recordings, vehicle, method=args.method, roles=roles, settings=settings,
        prior=prior, prior_spread=args.prior_spread, effects=args.effect,
    )  # fmt: skip
    told = ""
    if args.minutes or args.profile or args.bootstrap:
        from seatrial.identify.evidence import evidence

        progress.say("weighing the evidence")
        told = evidence(
            model, recordings, vehicle,
            replicates=args.bootstrap, profiled=args.profile, lengths=args.minutes,
        )  # fmt: skip
    save(model, args.out)
    progress.clear()
    print(summary(model))
    print(f"\n{told}\n" if told else "", end="")
    print(f"wrote {args.out}")


def _roles(given: Sequence[str]) -> dict[str, list[str]]:
    from seatrial.errors import RecordingError
    from seatrial.frames import AXES

    roles: dict[str, list[str]] = {}
    for text in given:
        axis, _, names = text.partition("=")
        if axis not in AXES or not names:
            raise RecordingError(f"--role {text}: expected surge=NAME, sway=NAME or yaw=NAME")
        roles.setdefault(axis, []).extend(names.split(","))
    return roles


def validate_command(args: argparse.Namespace, progress: Progress) -> None:
    """Scores, horizons, and another model beside it."""
    from seatrial.against import against_text
    from seatrial.files import dump_json, write_text
    from seatrial.model import load
    from seatrial.sanity import concerns
    from seatrial.validate import LEGEND, horizons_text, scores_json, scores_text, validate

    _guard(args.json, "{", args.model, args.vehicle, args.against, *args.recordings)
    model = _load(args)
    other = None if args.against is None else load(args.against)
    recordings = _read(args, model.vehicle, progress)
    progress.say("validating")
    scores = validate(model, recordings, args.horizon, other=other)
    if args.json is not None:
        write_text(args.json, dump_json(scores_json(scores)))
    progress.clear()
    print(f"{scores_text(scores)}\n{LEGEND}\n{horizons_text(scores)}")
    if scores.against is not None:
        print(against_text(scores.against))
    for doubt in concerns(model):
        print(f"  doubt: {doubt}")


def compare_command(args: argparse.Namespace, progress: Progress) -> None:
    """Two models side by side, on the terminal and as a page."""
    from seatrial.compare import compare, comparison_json, drive_of
    from seatrial.compare.text import comparison_text
    from seatrial.errors import FileError
    from seatrial.files import dump_json, write_text
    from seatrial.model import load
    from seatrial.vehicle import load_vehicle

    inputs = args.a, args.b, args.vehicle, *args.recordings
    _guard(args.json, "{", *inputs)
    _guard(args.out, "<!doctype html", *inputs)
    if args.out is None and (args.figures or args.tables):
        raise FileError("--figures and --tables belong to the HTML file: say where with -o")
    _check_png(args)
    a, b = load(args.a), load(args.b)
    recordings: list[Recording] = []
    if args.recordings:
        vehicle = None if args.vehicle is None else load_vehicle(args.vehicle)
        a, b = drive_of(a, b, vehicle)
        recordings = _read(args, a.vehicle, progress)
    progress.say("comparing")
    labels = str(args.a), str(args.b)
    found = compare(a, b, recordings, horizon=args.horizon, labels=labels)
    if args.json is not None:
        write_text(args.json, dump_json(comparison_json(found)))
    if args.out is not None:
        from seatrial.report.beside import write_comparison

        progress.say("drawing")
        write_comparison(
            a, b, recordings, found, args.out,
            horizon=args.horizon, figures=args.figures, raster=args.png, tables=args.tables,
        )  # fmt: skip
    progress.clear()
    print(comparison_text(found))
    if args.out is not None:
        print(f"wrote {args.out}")


def select_command(args: argparse.Namespace, progress: Progress) -> None:
    """The table of terms, and the vehicle with the chosen ones."""
    from seatrial.files import dump_json, dump_yaml, write_text
    from seatrial.select import given_candidates, select, selection_json, selection_text
    from seatrial.vehicle import load_vehicle

    _guard(args.out, "seatrial: vehicle", args.vehicle, *args.recordings, *args.candidates or ())
    _guard(args.json, "{", args.vehicle, *args.recordings, *args.candidates or ())
    vehicle = load_vehicle(args.vehicle)
    candidates = None if args.candidates is None else given_candidates(vehicle, args.candidates)
    found = select(
        _read(args, vehicle, progress), vehicle,
        candidates=candidates, horizon=args.horizon, say=progress.say,
    )  # fmt: skip
    if args.json is not None:
        write_text(args.json, dump_json(selection_json(found)))
    if args.out is not None:
        write_text(args.out, dump_yaml(found.vehicle.to_mapping()))
    progress.clear()
    print(selection_text(found))
    if args.out is not None:
        print(f"wrote {args.out}")


def predict_command(args: argparse.Namespace, progress: Progress) -> None:
    """Odometry along a recording, or live."""
    from seatrial.errors import LiveError
    from seatrial.live import Settings

    if args.live == bool(args.recordings):
        raise LiveError("give a recording, or --live for lines from standard input or --udp PORT")
    form = args.format or ("csv" if args.out is not None and args.out.suffix == ".csv" else "json")
    settings = Settings(form, args.rate, args.clock)
    if args.live:
        _predict_live(args, settings)
    else:
        _predict_along(args, settings, progress)


def _predict_live(args: argparse.Namespace, settings: "Settings") -> None:
    from seatrial.errors import LiveError
    from seatrial.live import serve
    from seatrial.live.sources import Datagrams, Pipes

    if args.out is not None or args.vehicle is not None:
        raise LiveError("--live writes to standard output or UDP, by the model's own vehicle")
    if args.udp is None and args.to is not None:
        raise LiveError("--to belongs to --udp PORT")

    def complain(words: str) -> None:
        print(f"seatrial: {words}", file=sys.stderr, flush=True)

    source = Pipes() if args.udp is None else Datagrams(args.udp, args.to)
    serve(args.model, source, settings, complain)


def _predict_along(args: argparse.Namespace, settings: "Settings", progress: Progress) -> None:
    from seatrial.errors import LiveError
    from seatrial.files import write_text
    from seatrial.live import Writer, replay

    if args.udp is not None or args.to is not None:
        raise LiveError("--udp and --to belong to --live")
    if len(args.recordings) != 1 or args.out is None:
        raise LiveError("give one recording, and -o FILE for the odometry along it")
    _guard(args.out, "t," if settings.form == "csv" else "{", args.model, *args.recordings)
    model = _load(args)
    (recording,) = _read(args, model.vehicle, progress)
    progress.say("predicting")
    writer = Writer(model.vehicle, settings.form)
    lines = [] if writer.header is None else [writer.header]
    lines += [writer.odometry(out) for out in replay(model, recording, settings.rate)]
    write_text(args.out, "\n".join(lines) + "\n")
    progress.clear()
    print(f"wrote {args.out}")


def report_command(args: argparse.Namespace, progress: Progress) -> None:
    """The page, and its figures and tables beside it."""
    from seatrial.report import write_report

    _guard(args.out, "<!doctype html", args.model, args.vehicle, *args.recordings)
    _check_png(args)
    model = _load(args)
    recordings = _read(args, model.vehicle, progress)
    progress.say("drawing")
    write_report(
        model, recordings, args.out,
        horizon=args.horizon, figures=args.figures, raster=args.png, tables=args.tables,
    )  # fmt: skip
    progress.clear()
    written = [args.out, *(folder for folder in (args.figures, args.tables) if folder is not None)]
    print(f"wrote {', '.join(map(str, written))}")


def _check_png(args: argparse.Namespace) -> None:
    """Before the work of minutes: where to, and whether it can be done."""
    from seatrial.errors import FileError
    from seatrial.report.png import check

    if args.png and args.figures is None:
        raise FileError("--png belongs to the figures: say where with --figures FOLDER")
    if args.png:
        check()
