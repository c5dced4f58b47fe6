# SPDX-License-Identifier: MIT
"""`seatrial select`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import (
    add_horizon,
    add_json,
    add_recordings,
    guard,
    horizon_of,
    read_all,
    recordings_again,
    write_json,
)
from seatrial.commands.shared.workers import add_workers, on_workers
from seatrial.util.printing import say
from seatrial.util.progress import stage


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    add_recordings(command, vehicle=None)
    command.add_argument(
        "--candidates", nargs="+", action="extend", metavar="FILE|TERM",
        help="candidate terms, like 'Y_r * r', or files of them (default: the usual ones)",
    )  # fmt: skip
    add_horizon(
        command, "how far ahead held-out recordings are predicted [s] (default: %(default)g)"
    )
    command.add_argument(
        "-o", "--out", type=Path, metavar="VEHICLE", help="vehicle file with the chosen terms"
    )
    add_workers(command)
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """The table of terms, and the vehicle with the chosen ones."""
    from seatrial.boat.vehicle import load_vehicle
    from seatrial.identification.selection.terms import (
        SELECTION_FORMAT,
        given_candidates,
        select,
        selection_json,
        selection_text,
    )
    from seatrial.util.files import dump_yaml, write_text
    from seatrial.workflow.next_step import after_select

    guard(args.out, "seatrial: vehicle", args.vehicle, *args.recordings, *args.candidates or ())
    guard(args.json, "{", args.vehicle, *args.recordings, *args.candidates or ())
    vehicle = load_vehicle(args.vehicle)
    candidates = None if args.candidates is None else given_candidates(vehicle, args.candidates)
    with stage("reading", 0.05):
        recordings = read_all(args, vehicle)
    with stage("selecting terms"), on_workers(args):
        found = select(
            recordings, vehicle, candidates=candidates, horizon=horizon_of(args),
        )  # fmt: skip
    write_json(args, SELECTION_FORMAT, selection_json(found))
    if args.out is not None:
        write_text(args.out, dump_yaml(found.vehicle.to_mapping()))
    say(selection_text(found))
    if args.out is not None:
        say(f"wrote {args.out}")
    changed = {*found.vehicle.structure.terms} != {*vehicle.structure.terms}
    say(after_select(recordings_again(args), args.out, changed=changed).text)
