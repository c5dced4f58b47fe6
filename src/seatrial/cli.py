# SPDX-License-Identifier: MIT
"""The command line. No logic: every command is the library function of the same name."""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.errors import SeatrialError
from seatrial.frames import Axes
from seatrial.identify import DEFAULT_METHOD, KINDS, METHODS, PRIOR_SPREAD
from seatrial.io.write_bag import FORMATS
from seatrial.predict import DEFAULT_HORIZON
from seatrial.progress import Progress

if TYPE_CHECKING:
    from seatrial.model import Model
    from seatrial.recording import Recording
    from seatrial.vehicle import Vehicle

DONE, MISTAKE = 0, 1
AXES_NAMES = tuple(axes.value for axes in Axes)
AXES_QUESTION = """\
No data can tell which way the axes point: when the boat turns to the left, does psi rise (x forward, y to \
port) or fall (y to starboard)?"""
Command = Callable[[argparse.Namespace, Progress], None]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command. Returns 0 done, 1 a mistake of the user's; usage errors exit with 2."""
    args = _parser().parse_args(arguments)
    progress = Progress(quiet=args.quiet)
    run: Command = args.run
    try:
        run(args, progress)
    except SeatrialError as error:
        progress.clear()
        print(f"seatrial: {' '.join(str(error).split())}", file=sys.stderr)
        return MISTAKE
    except KeyboardInterrupt:
        progress.clear()
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    progress.clear()
    return DONE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="seatrial", description="Dynamic models of small surface vehicles from a recording."
    )
    parser.add_argument("--version", action="version", version=f"seatrial {version('seatrial')}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    demo = _add(commands, "demo", _demo, "everything below on the bundled recordings")
    demo.add_argument(
        "--out", type=Path, default=Path("demo"), help="folder to write to (default: demo)"
    )

    inspect = _add(
        commands,
        "inspect",
        _inspect,
        "rates, gaps, faults, clocks, excitation, signs; without --vehicle the topics or columns",
    )
    _recordings(inspect, vehicle_required=False)
    inspect.add_argument("--json", type=Path, metavar="FILE", help="also write it for programs")

    init = _add(commands, "init", _init, "a vehicle file to start from, proposed from a recording")
    init.add_argument("recordings", nargs="+", type=Path, metavar="RECORDING")
    init.add_argument("-o", "--out", type=Path, required=True, metavar="VEHICLE")
    init.add_argument("--name", help="the boat's name (default: the recording's)")
    init.add_argument(
        "--axes", choices=AXES_NAMES, help=f"of the recording (default: {AXES_NAMES[0]})"
    )
    init.add_argument("--pose", metavar="TOPIC", help="topic of the poses")
    init.add_argument("--commands", metavar="TOPIC", help="topic of the commands")
    init.add_argument(
        "--parent", metavar="FRAME", help="the world's frame, where poses come from tf"
    )
    init.add_argument("--child", metavar="FRAME", help="the boat's frame, where poses come from tf")
    init.add_argument("--salvage", action="store_true", help="read what is left of a damaged bag")
    init.add_argument("--force", action="store_true", help="write over an existing file")

    simulate = _add(commands, "simulate", _simulate, "recordings like the paper's S1-S7")
    simulate.add_argument("--plan", default="paper-like", help="a file, or paper-like, hard, clean")
    simulate.add_argument("--vehicle", help="vehicle file instead of the plan's vehicles")
    simulate.add_argument("--model", type=Path, help="model file instead of the plan's plant")
    simulate.add_argument("--seed", type=int, help="instead of the plan's")
    simulate.add_argument(
        "--format", choices=("csv", *FORMATS), default="csv",
        help="csv: a folder of tables a trial; or a bag a trial (default: csv)",
    )  # fmt: skip
    simulate.add_argument("-o", "--out", type=Path, required=True, metavar="DIR")

    identify = _add(commands, "identify", _identify, "a model from recordings")
    _recordings(identify, vehicle_required=True)
    identify.add_argument("-o", "--out", type=Path, required=True, metavar="MODEL")
    identify.add_argument(
        "--method", choices=METHODS, default=DEFAULT_METHOD,
        help="equation-error is the paper's least squares; output-error, on the raw poses, finds the thrusters' "
        "latency, lag and dead zone, too (default: %(default)s)",
    )  # fmt: skip
    identify.add_argument(
        "--role", action="append", default=[], metavar="AXIS=NAME[,NAME]",
        help="recordings that identify surge, sway or yaw (default: found from the excitation)",
    )  # fmt: skip
    identify.add_argument(
        "--effect", action="append", default=[], choices=KINDS,
        help="also seek this: the sensor's lever arm, or each recording's current, trim or wind",
    )  # fmt: skip
    identify.add_argument(
        "--minutes", action="store_true", help="accuracy against the length that was driven"
    )
    identify.add_argument(
        "--profile", nargs="+", action="extend", default=[], metavar="NAME",
        help="intervals of these by profile likelihood",
    )  # fmt: skip
    identify.add_argument(
        "--bootstrap", type=int, default=0, metavar="N",
        help="intervals from N refits to blocks drawn anew (200 are usual)",
    )  # fmt: skip
    identify.add_argument(
        "--literal",
        action="store_true",
        help="Eq. (17) as printed, surge acceleration one step late",
    )
    identify.add_argument(
        "--prior", type=Path, metavar="OLD",
        help="model of this boat from before its payload changed: then a short recording will do",
    )  # fmt: skip
    identify.add_argument(
        "--prior-spread", type=float, default=PRIOR_SPREAD, metavar="SHARE",
        help="by how much its parameters may have changed (default: %(default)g)",
    )  # fmt: skip

    for name, run, text in (
        ("validate", _validate, "how well a model predicts recordings"),
        ("report", _report, "one offline HTML file with the evidence"),
    ):
        command = _add(commands, name, run, text)
        command.add_argument("model", type=Path, metavar="MODEL")
        _recordings(command, vehicle_required=False)
        command.add_argument(
            "--horizon",
            type=float,
            default=DEFAULT_HORIZON,
            metavar="S",
            help="how far ahead [s] (default: %(default)g)",
        )
        if name == "validate":
            command.add_argument("--json", type=Path, metavar="FILE", help="also write scores.json")
            command.add_argument(
                "--against",
                type=Path,
                metavar="OTHER",
                help="another model, beside it in a 2 x 2 table",
            )
        else:
            command.add_argument("-o", "--out", type=Path, required=True, metavar="HTML")
            _exports(command)

    _add_compare(commands)
    _add_select(commands)
    return parser


def _exports(command: argparse.ArgumentParser) -> None:
    command.add_argument("--figures", type=Path, metavar="FOLDER", help="every plot as SVG")
    command.add_argument(
        "--tables", type=Path, metavar="FOLDER", help="every table as CSV and LaTeX"
    )


def _add_compare(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    compare = _add(
        commands, "compare", _compare, "which of a boat's numbers changed; does it matter"
    )
    compare.add_argument("a", type=Path, metavar="A", help="model from before")
    compare.add_argument("b", type=Path, metavar="B", help="model from after")
    _recordings(compare, vehicle_required=False, count="*")
    compare.add_argument(
        "--horizon",
        type=float,
        default=DEFAULT_HORIZON,
        metavar="S",
        help=f"how far ahead [s], besides {DEFAULT_HORIZON:g} s",
    )
    compare.add_argument("--json", type=Path, metavar="FILE", help="also write it for programs")
    compare.add_argument(
        "-o", "--out", type=Path, metavar="HTML", help="also one offline HTML file with both"
    )
    _exports(compare)


def _add_select(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    select = _add(commands, "select", _select, "which terms recordings ask for, and which repeat")
    _recordings(select, vehicle_required=True)
    select.add_argument(
        "--candidates", nargs="+", action="extend", metavar="FILE|TERM",
        help="terms that may come in, like 'Y_r * r', or files of them (default: a list of usual ones)",
    )  # fmt: skip
    select.add_argument(
        "--horizon", type=float, default=DEFAULT_HORIZON, metavar="S",
        help="how far ahead held-out recordings are predicted [s] (default: %(default)g)",
    )  # fmt: skip
    select.add_argument("-o", "--out", type=Path, metavar="VEHICLE", help="with the chosen terms")
    select.add_argument("--json", type=Path, metavar="FILE", help="also write it for programs")


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


def _add(
    commands: "argparse._SubParsersAction[argparse.ArgumentParser]",
    name: str,
    run: Command,
    text: str,
) -> argparse.ArgumentParser:
    command = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    command.add_argument("-q", "--quiet", action="store_true", help="no progress")
    command.set_defaults(run=run)
    return command


def _recordings(
    command: argparse.ArgumentParser, *, vehicle_required: bool, count: str = "+"
) -> None:
    command.add_argument("recordings", nargs=count, type=Path, metavar="RECORDING")
    text = "vehicle file" + (
        ""
        if vehicle_required
        else " for signals and allocation (default: the model's own); terms and chain stay the model's"
    )
    command.add_argument("--vehicle", required=vehicle_required, metavar="V", help=text)
    command.add_argument(
        "--start", type=float, metavar="S", help="use each recording from here [s]"
    )
    command.add_argument(
        "--salvage", action="store_true", help="read what is left of a damaged bag"
    )
    command.add_argument("--end", type=float, metavar="S", help="use each recording up to here [s]")


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


def _demo(args: argparse.Namespace, progress: Progress) -> None:
    from seatrial.demo import demo

    def say(text: str) -> None:
        progress.clear()
        print(text)

    demo(args.out, say, progress.say)


def _inspect(args: argparse.Namespace, progress: Progress) -> None:
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


def _init(args: argparse.Namespace, progress: Progress) -> None:
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


def _simulate(args: argparse.Namespace, progress: Progress) -> None:
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


def _identify(args: argparse.Namespace, progress: Progress) -> None:
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


def _validate(args: argparse.Namespace, progress: Progress) -> None:
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


def _compare(args: argparse.Namespace, progress: Progress) -> None:
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
            horizon=args.horizon, figures=args.figures, tables=args.tables,
        )  # fmt: skip
    progress.clear()
    print(comparison_text(found))
    if args.out is not None:
        print(f"wrote {args.out}")


def _select(args: argparse.Namespace, progress: Progress) -> None:
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


def _report(args: argparse.Namespace, progress: Progress) -> None:
    from seatrial.report import write_report

    _guard(args.out, "<!doctype html", args.model, args.vehicle, *args.recordings)
    model = _load(args)
    recordings = _read(args, model.vehicle, progress)
    progress.say("drawing")
    write_report(
        model, recordings, args.out,
        horizon=args.horizon, figures=args.figures, tables=args.tables,
    )  # fmt: skip
    progress.clear()
    written = [args.out, *(folder for folder in (args.figures, args.tables) if folder is not None)]
    print(f"wrote {', '.join(map(str, written))}")


if __name__ == "__main__":
    sys.exit(main())
