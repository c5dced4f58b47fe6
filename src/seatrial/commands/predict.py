# SPDX-License-Identifier: MIT
"""`seatrial predict`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import (
    HOW_TO_READ,
    add_json,
    add_ports,
    add_recordings,
    guard,
    lines_of,
    load_model,
    read_all,
    refuse_options,
    write_json,
)
from seatrial.onboard.live.line_loop import CLOCKS as LINE_CLOCKS
from seatrial.onboard.live.line_loop import RATE as LINE_RATE
from seatrial.onboard.live.protocol import LINE_FORMATS
from seatrial.onboard.live.server import ADAPT
from seatrial.util.printing import complain, say
from seatrial.util.progress import over, stage

if TYPE_CHECKING:
    from seatrial.onboard.live import Adaptation, Settings


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("model", type=Path, metavar="MODEL")
    add_recordings(command, count="*")
    command.add_argument(
        "-o", "--out", type=Path, metavar="FILE", help="file for the odometry along the recording"
    )
    _add_stream(command)
    command.add_argument(
        "--format",
        choices=LINE_FORMATS,
        help="format of the lines (default: json; for a .csv file: csv)",
    )
    command.add_argument(
        "--rate",
        type=float,
        default=LINE_RATE,
        metavar="HZ",
        help="rate of the odometry [Hz] (default: %(default)g)",
    )
    command.add_argument(
        "--clock", choices=LINE_CLOCKS,
        help="live: clock that paces the output: stamps of the input, or this machine's "
        f"(default: {LINE_CLOCKS[0]})",
    )  # fmt: skip
    command.add_argument(
        "--adapt", choices=ADAPT,
        help="live: a change of the boat (payload, a thruster, the battery) is reported, and the model adapted on "
        "the line 'adapt' (ask) or at once (auto); off: no test (default: ask, where the model allows the test)",
    )  # fmt: skip
    command.add_argument(
        "--adapted", type=Path, metavar="FILE", help="live: file for the adapted model"
    )
    add_json(command)


def _add_stream(command: argparse.ArgumentParser) -> None:
    """Where live lines come from and go to."""
    command.add_argument(
        "--live",
        action="store_true",
        help="read lines from standard input, or --udp, until the stream ends",
    )
    add_ports(
        command,
        "live: read lines from this port on loopback",
        "live: port to answer to (default: the last sender)",
    )


def run(args: argparse.Namespace) -> None:
    """Odometry along a recording, or live."""
    from seatrial.onboard.live import Settings
    from seatrial.util.errors import LiveError

    if args.live == bool(args.recordings):
        raise LiveError("give a recording, or --live for lines from standard input or --udp PORT")
    form = args.format or ("csv" if args.out is not None and args.out.suffix == ".csv" else "json")
    settings = Settings(form, args.rate, args.clock or LINE_CLOCKS[0])
    if args.live:
        _predict_live(args, settings)
    else:
        _predict_along(args, settings)


def _predict_live(args: argparse.Namespace, settings: "Settings") -> None:
    from seatrial.onboard.live import serve
    from seatrial.util.errors import LiveError

    if args.json is not None:
        raise LiveError("--json belongs to a recording; with --live the lines themselves are JSON")
    if args.out is not None or args.vehicle is not None:
        raise LiveError("--live writes to standard output or UDP, by the model's own vehicle")
    refuse_options(args, "recordings; --live reads lines", *HOW_TO_READ)
    adaptation = _adaptation(args)
    serve(args.model, lines_of(args), settings, complain, adaptation)


def _adaptation(args: argparse.Namespace) -> "Adaptation | None":
    """What happens on a change of the boat; None: no test, by wish or as the model allows none."""
    from seatrial.boat.model import Model
    from seatrial.boat.model_file import load, save
    from seatrial.onboard.live import Adaptation
    from seatrial.util.errors import FileError, LiveError, ModelError

    if args.adapt == "off":
        if args.adapted is not None:
            raise LiveError("--adapted is the file of an adapted model; --adapt off adapts none")
        return None
    from seatrial.monitoring.change_detector import ChangeDetector

    if args.adapted is not None:
        guard(args.adapted, "seatrial: model", args.model)
        if args.adapted.is_dir():  # known now, not when the boat has changed
            raise FileError(f"{args.adapted}: is a folder; give a file name")

    def keep(model: Model) -> None:
        if args.adapted is not None:
            save(model, args.adapted)

    try:
        return Adaptation(ChangeDetector(load(args.model)), args.adapt == "auto", keep)
    except ModelError:
        if args.adapt is not None or args.adapted is not None:
            raise
        return None


def _predict_along(args: argparse.Namespace, settings: "Settings") -> None:
    from seatrial.commands.shared.results import PredictResult
    from seatrial.onboard.live import Writer, replay
    from seatrial.util.errors import LiveError
    from seatrial.util.files import write_text
    from seatrial.workflow.next_step import after_predict

    refuse_options(args, "--live", "udp", "to", "clock", "adapt", "adapted")
    if len(args.recordings) != 1 or args.out is None:
        raise LiveError("give one recording, and -o FILE for the odometry along it")
    model = load_model(args)
    writer = Writer(model.vehicle, settings.form)
    guard(args.out, writer.header or "{", args.model, *args.recordings)
    guard(args.json, "{", args.model, *args.recordings, args.out)
    with stage("reading", 0.5):
        (recording,) = read_all(args, model.vehicle)
    lines = [] if writer.header is None else [writer.header]
    count = round(recording.duration * settings.rate)
    with stage("predicting"):
        outs = over(replay(model, recording, settings.rate), total=count)
        lines += [writer.odometry(out) for out in outs]
    write_text(args.out, "\n".join(lines) + "\n")
    say(f"wrote {args.out}")
    say(after_predict(args.model).text)
    estimates = len(lines) - (writer.header is not None)
    found = PredictResult(
        str(args.model), recording.name, recording.duration, settings.rate, estimates, str(args.out)
    )
    write_json(args, "predict 1", found)
