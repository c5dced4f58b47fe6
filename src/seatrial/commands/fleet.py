# SPDX-License-Identifier: MIT
"""`seatrial fleet`."""

import argparse
from contextlib import nullcontext
from pathlib import Path

from seatrial.commands.shared import add_json, guard, write_json
from seatrial.commands.shared.workers import add_workers, workers_of
from seatrial.util.printing import complain, say


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument(
        "boats", type=Path, metavar="FOLDER|CONFIG",
        help="a folder with one folder a boat (vehicle.yaml and recordings), or a fleet's file",
    )  # fmt: skip
    command.add_argument(
        "-o", "--out", type=Path, metavar="DIR", help="folder to write to (default: NAME-fleet)"
    )
    command.add_argument(
        "--last-time", type=Path, metavar="DIR",
        help="results of an earlier run: each boat is compared with its model there",
    )  # fmt: skip
    add_workers(command, default="local")
    command.add_argument("-v", "--verbose", action="store_true", help="reasons in full")
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """All boats; the table."""
    from seatrial.fleet.console import fleet_text
    from seatrial.fleet.fleet import fleet
    from seatrial.fleet.fleet_file import load_fleet
    from seatrial.util.errors import FleetError

    guard(args.json, "{", args.boats)
    boats = load_fleet(args.boats, args.last_time)
    out = args.out or Path(f"{args.boats.resolve().name.partition('.')[0]}-fleet")
    if args.boats.is_dir() and out.resolve().is_relative_to(args.boats.resolve()):
        raise FleetError(f"{out}: is inside the folder of the boats; give another one with -o")
    if args.last_time is not None and out.resolve() == args.last_time.resolve():
        raise FleetError(f"{out}: has the results of last time; give another folder with -o")
    guard(out / "fleet.json", "{")
    guard(out / "fleet.html", "<!doctype html")
    try:
        with workers_of(args) or nullcontext() as farm:
            found = fleet(boats, out, farm)
    except KeyboardInterrupt:
        complain("stopped; the same command goes on where it was")
        raise
    say(fleet_text(found.result, verbose=args.verbose))
    say(f"report  -> {found.report}")
    write_json(args, "fleet-result 1", found.result)
