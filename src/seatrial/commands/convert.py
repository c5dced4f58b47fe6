# SPDX-License-Identifier: MIT
"""`seatrial convert`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import add_json, add_salvage, guard, write_json
from seatrial.util.printing import say


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("recording", type=Path, metavar="RECORDING")
    command.add_argument(
        "--vehicle",
        metavar="VEHICLE",
        help="vehicle file, whose signals are written (default: none; all topics of an autopilot's log)",
    )
    command.add_argument(
        "-o",
        "--out",
        type=Path,
        required=True,
        metavar="OUT",
        help="a new folder for tables, or a file name ending in .mcap, .bag or .db3",
    )
    add_salvage(command)
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """A recording as tables or as a bag."""
    from seatrial.boat.vehicle import load_vehicle
    from seatrial.commands.shared.results import ConvertResult
    from seatrial.io.convert import convert
    from seatrial.workflow.next_step import after_convert

    guard(args.out, "", args.recording, args.vehicle)
    guard(args.json, "{", args.recording, args.vehicle, args.out)
    vehicle = None if args.vehicle is None else load_vehicle(args.vehicle)
    written = convert(args.recording, args.out, vehicle, salvage=args.salvage)
    for path in written:
        say(f"wrote {path}")
    recording = args.out if args.out.is_dir() else written[0]
    step = after_convert(recording, None if vehicle is None else written[-1])
    say(step.text)
    paths = [str(path) for path in written]
    write_json(args, "convert 1", ConvertResult(str(args.recording), paths, step.do))
