# SPDX-License-Identifier: MIT
"""What several commands have in common: reading, guarding files, arguments."""

import argparse
import os
import re
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seatrial.util.printing import STANDARD_OUTPUT, put

if TYPE_CHECKING:
    from collections.abc import Mapping

    import msgspec

    from seatrial.boat.model import Model
    from seatrial.boat.vehicle import Vehicle
    from seatrial.inspection.proposal.sources import Choices
    from seatrial.onboard.live.endpoints import Datagrams, Pipes
    from seatrial.recording.recording import Recording

JSON_HELP = "also write the result as JSON; -: to standard output, in place of the text"
OTHER_VEHICLE = "vehicle file for signals and allocation (default: the model's); its terms and chain are not used"

HOW_TO_READ = ("start", "end", "without", "salvage")  # options of `add_recordings` beside --vehicle


def refuse_options(args: argparse.Namespace, owner: str, *names: str) -> None:
    """Refuse options that this use of a command would ignore, as they belong to `owner`. Raises SeatrialError."""
    from seatrial.util.errors import SeatrialError
    from seatrial.util.format import joined

    values = [(name, getattr(args, name)) for name in names]
    given = [name for name, value in values if value not in (None, []) and value is not False]
    if given:
        options = joined([f"--{name.replace('_', '-')}" for name in given])
        raise SeatrialError(f"{options} belong{'s' * (len(given) == 1)} to {owner}")


def guard(out: Path | None, begins: str, *inputs: object) -> None:
    """Refuse an output that is an input, or a file that is something else."""
    from seatrial.util.errors import FileError
    from seatrial.util.files import writable

    if str(out) == STANDARD_OUTPUT:
        return
    given = [Path(str(path)).resolve() for path in inputs if path is not None]
    if out is not None and out.resolve() in given:
        raise FileError(f"{out}: is an input of this command; give another name to write to")
    if out is None or not out.is_file():  # a folder or an odd path is refused where it is written
        return
    with writable(out), out.open("rb") as file:
        first = file.read(len(begins)).decode("utf-8", "replace")
    if first.lower() != begins.lower():
        raise FileError(
            f"{out}: exists, and is not a file of this kind; give another name, or remove it"
        )


def read_all(args: argparse.Namespace, vehicle: "Vehicle") -> "list[Recording]":
    """All recordings of a command, cut as it says."""
    from seatrial.io import read_each

    unwanted = [_stretch(text) for text in args.without]
    found = read_each(args.recordings, vehicle, salvage=args.salvage)
    for name, start, end in unwanted:
        i = _called(name, found, args.recordings)
        found[i] = found[i].without(start, end)
    if args.start is None and args.end is None:
        return found
    return [recording.cut(args.start, args.end) for recording in found]


def recordings_again(args: argparse.Namespace) -> list[str]:
    """The recordings of a command, and how it reads them, as words of a further command line.

    All options of `add_recordings` but --vehicle; of `init`, which has only some of them, those.
    """
    given = vars(args)
    words = [str(path) for path in args.recordings]
    for name in ("start", "end"):
        words += [] if given.get(name) is None else [f"--{name}", f"{given[name]:.15g}"]
    words += [word for text in given.get("without", ()) for word in ("--without", text)]
    return [*words, "--salvage"] if args.salvage else words


def _called(name: str, recordings: "list[Recording]", paths: list[Path]) -> int:
    """Which recording is meant, by its name or by its path."""
    from seatrial.util.errors import RecordingError

    own = [i for i, path in enumerate(paths) if path == Path(name)]
    names = [recording.name for recording in recordings]
    # also where it is one of several with this name, which folders tell apart
    own = own or [i for i, one in enumerate(names) if one == name or one.endswith(f"/{name}")]
    if len(own) == 1:
        return own[0]
    if own:
        raise RecordingError(
            f"--without {name}: {len(own)} recordings are called so; give its path"
        )
    known = ", ".join(sorted({*names}))
    raise RecordingError(f"--without {name}: there is no such recording; {known}")


def _stretch(text: str) -> tuple[str, float, float]:
    """NAME, FROM and TO [s] of a stretch to leave out."""
    from seatrial.util.errors import RecordingError

    found = re.fullmatch(r"(.+)=([\d.]*)-([\d.]*)", text)
    with suppress(ValueError):
        if found is not None:
            return found[1], float(found[2] or 0.0), float(found[3] or "inf")
    raise RecordingError(
        f"--without {text}: expected NAME=FROM-TO, a recording and seconds from its start, such as S2=83-97"
    )


def load_model(args: argparse.Namespace) -> "Model":
    """The model, with another vehicle where one is given."""
    from seatrial.boat.model_file import load
    from seatrial.boat.vehicle import load_vehicle

    model = load(args.model)
    return model if args.vehicle is None else model.with_vehicle(load_vehicle(args.vehicle))


def check_png(args: argparse.Namespace) -> None:
    """Before the work of minutes: where to, and whether it can be done."""
    from seatrial.report.figures.png import check
    from seatrial.util.errors import FileError

    if args.png and args.figures is None:
        raise FileError("--png belongs to the figures: say where with --figures FOLDER")
    if args.png:
        check()


def check_page(args: argparse.Namespace, *inputs: object) -> None:
    """Guard JSON and page of a command whose page is optional: figures and tables belong to it."""
    from seatrial.util.errors import FileError

    guard(args.json, "{", *inputs)
    guard(args.out, "<!doctype html", *inputs)
    if args.out is None and (args.figures or args.tables):
        raise FileError("--figures and --tables belong to the HTML file: say where with -o")
    check_png(args)


def choices_of(args: argparse.Namespace, name: str | None) -> "Choices":
    """What the options that `init` and `auto` share choose: topics, and where things are."""
    from seatrial.inspection.proposal.sources import Choices, thrusters_of

    return Choices(
        name=name, pose=args.pose, commands=args.commands,
        lever=None if args.lever is None else (args.lever[0], args.lever[1]),
        thrusters=() if args.thrusters is None else thrusters_of(args.thrusters),
    )  # fmt: skip


def add_ports(
    command: argparse.ArgumentParser,
    udp: str = "read lines from this port on loopback instead of standard input",
    to: str = "port to answer to (default: the last sender)",
) -> None:
    """Those of lines over UDP, which `lines_of` reads."""
    command.add_argument("--udp", type=int, metavar="PORT", help=udp)
    command.add_argument("--to", type=int, metavar="PORT", help=to)


def lines_of(args: argparse.Namespace) -> "Pipes | Datagrams":
    """Where the lines come from, and where the answers go. Raises SeatrialError."""
    from seatrial.onboard.live.endpoints import Datagrams, Pipes

    if args.udp is None:
        refuse_options(args, "--udp PORT", "to")
        return Pipes()
    return Datagrams(args.udp, args.to)


def add_recordings(
    command: argparse.ArgumentParser, *, vehicle: str | None = OTHER_VEHICLE, count: str = "+"
) -> None:
    """Recordings, and how they are read. `vehicle`: what --vehicle is; None: it must be given."""
    # with a default, argparse does not list it among the required ones where it may be left out
    command.add_argument("recordings", nargs=count, default=[], type=Path, metavar="RECORDING")
    command.add_argument(
        "--vehicle", required=vehicle is None, metavar="V", help=vehicle or "vehicle file"
    )
    command.add_argument(
        "--start", type=float, metavar="S", help="use each recording from this time on [s]"
    )
    command.add_argument(
        "--end", type=float, metavar="S", help="use each recording up to this time [s]"
    )
    command.add_argument(
        "--without", action="append", default=[], metavar="NAME=FROM-TO",
        help="exclude an interval [s] of a recording, where something else moved the boat; either end may be "
        "omitted; repeatable",
    )  # fmt: skip
    add_salvage(command)


def add_horizon(command: argparse.ArgumentParser, text: str) -> None:
    """--horizon, which `horizon_of` reads."""
    from seatrial.evaluation.prediction import DEFAULT_HORIZON

    command.add_argument(
        "--horizon", type=float, metavar="S", help=text % {"default": DEFAULT_HORIZON}
    )


def horizon_of(args: argparse.Namespace) -> float:
    """The horizon that is given, or the usual one [s]."""
    from seatrial.evaluation.prediction import DEFAULT_HORIZON

    return DEFAULT_HORIZON if args.horizon is None else float(args.horizon)


def add_json(command: argparse.ArgumentParser) -> None:
    """--json. The command calls `guard(args.json, "{", ...)` before its work and `write_json` after it."""
    command.add_argument("--json", type=Path, metavar="FILE", help=JSON_HELP)


def to_programs(args: argparse.Namespace) -> bool:
    """Whether standard output is for JSON alone: then it has no questions."""
    return str(args.json) == STANDARD_OUTPUT


def write_json(
    args: argparse.Namespace, kind: str, content: "Mapping[str, Any] | msgspec.Struct"
) -> None:
    """The result for programs, where --json asks for it; tools/json_page.py lists the fields.

    `kind`: its kind and version, such as `inspection 1`, for content that does not state it. Infinity and NaN,
    which JSON does not have, become null.
    """
    if args.json is None:
        return
    import msgspec

    from seatrial.util.files import builtin, dump_json, finite_or_none, write_text

    plain = finite_or_none(msgspec.to_builtins(content, enc_hook=builtin))
    plain = {"seatrial": kind} | plain
    if to_programs(args):
        put(dump_json(plain, ascii_only=True))
    else:
        write_text(args.json, dump_json(plain))


def guard_lines(args: argparse.Namespace, *inputs: object) -> None:
    """The same for a command that answers in lines: on standard output both would mix."""
    from seatrial.util.errors import LiveError

    if to_programs(args) and args.udp is None:
        raise LiveError("--json -: the lines are on standard output; give a file, or --udp PORT")
    guard(args.json, "{", *inputs)


def add_places(command: argparse.ArgumentParser) -> None:
    """--lever and --thrusters."""
    command.add_argument(
        "--lever", nargs=2, type=float, metavar=("X", "Y"),
        help="the measured point from the boat's origin (middle of the thrusters; of two astern the centre of "
        "mass) [m]: ahead, and to port; in forward-right-down axes, as of an autopilot's log, to starboard",
    )  # fmt: skip
    command.add_argument(
        "--thrusters", metavar="PLACES",
        help="'X Y DEG; X Y DEG; ...': position [m] and direction of thrust [deg] of each, in the commands' order",
    )  # fmt: skip


def add_salvage(command: argparse.ArgumentParser) -> None:
    """--salvage."""
    text = "read what is left of a damaged bag"
    command.add_argument("--salvage", action="store_true", help=text)


def add_exports(command: argparse.ArgumentParser) -> None:
    """Figures and tables beside a page."""
    command.add_argument("--figures", type=Path, metavar="FOLDER", help="every plot as SVG")
    command.add_argument(
        "--png",
        action="store_true",
        help="also write the figures as PNG (pip install 'seatrial[png]')",
    )
    command.add_argument(
        "--tables", type=Path, metavar="FOLDER", help="every table as CSV and LaTeX"
    )


def open_page(args: argparse.Namespace, uri: str) -> None:
    """Open a page in the browser, unless --no-browser, or where the user is at no desktop."""
    if not args.no_browser and _has_browser():
        import webbrowser

        webbrowser.open(uri)


def _has_browser() -> bool:
    """Whether the user is at a desktop."""
    if sys.stdout is None or not sys.stdout.isatty():
        return False
    return sys.platform in ("darwin", "win32") or any(
        map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY"))
    )
