# SPDX-License-Identifier: MIT
"""`seatrial inspect`."""

import argparse

from seatrial.commands.shared import (
    add_json,
    add_recordings,
    guard,
    read_all,
    recordings_again,
    write_json,
)
from seatrial.util.printing import say
from seatrial.util.progress import over, stage


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    add_recordings(command, vehicle="vehicle file (default: none; topics or columns only)")
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """Rates, gaps, faults, signs; without a vehicle file the topics or columns."""
    from seatrial.util.errors import VehicleError
    from seatrial.workflow.next_step import NextStep, after_inspect, command

    guard(args.json, "{", args.vehicle, *args.recordings)
    again = recordings_again(args)
    if args.vehicle is None:
        if args.without or args.start is not None or args.end is not None:
            raise VehicleError(
                "--start, --end and --without cut by the recordings' poses: say with --vehicle which they are"
            )
        from seatrial.io.look import look

        found = [look(path, salvage=args.salvage) for path in over(args.recordings, "reading")]
        text, content = "\n".join(t for t, _ in found), {"recordings": [c for _, c in found]}
        kind = "contents 1"
        init = command("init", *again, "-o", "vehicle.yaml")
        step = NextStep(init, "a vehicle file to start from")
    else:
        from seatrial.boat.vehicle import load_vehicle
        from seatrial.inspection.console import inspection_text
        from seatrial.inspection.overview import inspect, inspection_json

        vehicle = load_vehicle(args.vehicle)
        with stage("reading", 0.6):
            recordings = read_all(args, vehicle)
        with stage("checking"):
            inspection = inspect(recordings, vehicle)
        text, content = inspection_text(inspection), inspection_json(inspection)
        kind, step = "inspection 1", after_inspect(inspection, again, args.vehicle)
    write_json(args, kind, content)
    say(text)
    say(step.text)
