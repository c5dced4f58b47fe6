# SPDX-License-Identifier: MIT
"""`seatrial compare`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import (
    HOW_TO_READ,
    add_exports,
    add_horizon,
    add_json,
    add_recordings,
    check_page,
    horizon_of,
    read_all,
    refuse_options,
    write_json,
)
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.util.printing import say
from seatrial.util.progress import stage

if TYPE_CHECKING:
    from seatrial.recording.recording import Recording


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("a", type=Path, metavar="A", help="model before the change")
    command.add_argument("b", type=Path, metavar="B", help="model after the change")
    add_recordings(command, count="*")
    add_horizon(command, f"how far ahead [s], besides {DEFAULT_HORIZON:g} s")
    add_json(command)
    command.add_argument(
        "-o", "--out", type=Path, metavar="HTML", help="also write one offline HTML file with both models"
    )  # fmt: skip
    add_exports(command)


def run(args: argparse.Namespace) -> None:
    """Two models side by side, on the terminal and as a page."""
    from seatrial.boat.model_file import load
    from seatrial.boat.vehicle import load_vehicle
    from seatrial.evaluation.comparison.compare import COMPARISON_FORMAT, compare, drive_of
    from seatrial.evaluation.comparison.console import comparison_text, next_text

    check_page(args, args.a, args.b, args.vehicle, *args.recordings)
    if not args.recordings:
        refuse_options(args, "recordings; none is given", "vehicle", "horizon", *HOW_TO_READ)
    a, b = load(args.a), load(args.b)
    recordings: list[Recording] = []
    if args.recordings:
        vehicle = None if args.vehicle is None else load_vehicle(args.vehicle)
        a, b = drive_of(a, b, vehicle)
        with stage("reading", 0.3):
            recordings = read_all(args, a.vehicle)
    labels = str(args.a), str(args.b)
    with stage("comparing", None if args.out is None else 0.5):
        found = compare(a, b, recordings, horizon=horizon_of(args), labels=labels)
    write_json(args, COMPARISON_FORMAT, found)
    if args.out is not None:
        from seatrial.report.comparison import write_comparison

        with stage("drawing"):
            write_comparison(
                a, b, recordings, found, args.out,
                horizon=horizon_of(args), figures=args.figures, raster=args.png, tables=args.tables,
            )  # fmt: skip
    say(comparison_text(found))
    if args.out is not None:
        say(f"wrote {args.out}")
    say(f"next: {next_text(found)}")
