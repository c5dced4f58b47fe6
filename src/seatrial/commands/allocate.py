# SPDX-License-Identifier: MIT
"""`seatrial allocate`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import (
    HOW_TO_READ,
    add_exports,
    add_json,
    add_recordings,
    check_page,
    read_all,
    refuse_options,
    write_json,
)
from seatrial.control.allocation import PRIORITY, AllocatorScheme
from seatrial.util.printing import say
from seatrial.util.progress import stage

if TYPE_CHECKING:
    from seatrial.boat.model import Model
    from seatrial.boat.vehicle import Vehicle


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument(
        "boat", type=Path, metavar="MODEL|VEHICLE", help="model or vehicle file, or mallard-af"
    )
    add_recordings(command, count="*")
    command.add_argument(
        "--scheme", choices=[s.value for s in AllocatorScheme],
        help=f"allocation scheme (default: {AllocatorScheme.AUTO.value})",
    )  # fmt: skip
    command.add_argument(
        "--priority", metavar="AXES",
        help="order in which axes keep their thrust at the limits; + scales axes alike "
        f"(default: '{PRIORITY}')",
    )  # fmt: skip
    command.add_argument(
        "--margin", type=float, metavar="C",
        help="distance of idle thrust from the dead zone's edge [command units] (default: up to F_os, or 0.04)",
    )  # fmt: skip
    command.add_argument(
        "--wrench", nargs=3, type=float, metavar=("F_u", "F_v", "F_r"),
        help="print the thruster commands for this wrench, forward-left-up; refused if out of reach",
    )  # fmt: skip
    add_json(command)
    command.add_argument(
        "-o", "--out", type=Path, metavar="HTML", help="also one offline HTML file"
    )
    add_exports(command)


def run(args: argparse.Namespace) -> None:
    """The schemes on the terminal and as a page; the commands for one wrench."""
    from seatrial.control.allocation import (
        allocation_json,
        allocation_text,
        compare_schemes,
        load_boat,
        wrench_text,
    )
    from seatrial.workflow.next_step import NextStep, after_allocate, command

    check_page(args, args.boat, args.vehicle, *args.recordings)
    if not args.recordings:
        refuse_options(args, "recordings; none is given", *HOW_TO_READ)
    boat, vehicle = load_boat(args.boat, args.vehicle)
    if steered := _steered(args, boat):
        say(steered)
        say(NextStep(command("tune", args.boat, "-o", "gains.yaml")).text)
        return
    with stage("reading", 0.3):
        recordings = read_all(args, vehicle)
    with stage("allocating", None if args.out is None else 0.5):
        found = compare_schemes(
            boat,
            recordings,
            scheme=args.scheme or AllocatorScheme.AUTO.value,
            priority=args.priority or PRIORITY,
            margin=args.margin,
        )
    text = allocation_text(found) if args.wrench is None else wrench_text(found, args.wrench)
    write_json(args, "allocation 1", allocation_json(found))
    if args.out is not None:
        from seatrial.control.allocation.page import write_allocation

        with stage("drawing"):
            write_allocation(
                found, args.out, figures=args.figures, raster=args.png, tables=args.tables
            )
    say(text)
    if args.out is not None:
        say(f"wrote {args.out}")
    if args.wrench is None:
        say(after_allocate().text)


def _steered(args: argparse.Namespace, boat: "Model | Vehicle") -> str | None:
    """The authority of a model's thrust and angle; None: it has no angle. Raises SeatrialError."""
    from seatrial.boat.model import Model
    from seatrial.control.allocation.steered import steered_text, steering_of
    from seatrial.control.tuning.linear import steady_motions
    from seatrial.util.errors import AllocationError

    steering = steering_of(boat) if isinstance(boat, Model) else None
    if steering is None or not isinstance(boat, Model):
        return None
    owner = f"thrusters in fixed directions; {args.boat} has a thrust and its angle, which have one allocation"
    if args.recordings:
        raise AllocationError(f"recordings belong to {owner}")
    refuse_options(args, owner, "vehicle", "scheme", "priority", "margin", "wrench", "json", "out")
    return steered_text(boat, steering, float(steady_motions(boat)[:, 0].max()))
