# SPDX-License-Identifier: MIT
"""`seatrial export`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import add_json, guard, load_model, refuse_options, write_json
from seatrial.util.printing import say

if TYPE_CHECKING:
    from seatrial.export import Hull

NODE_READS_ITS_OWN = (
    "the other formats; the node reads {args.model} and the vehicle in it. Save the model with the other "
    "vehicle, model.with_vehicle(seatrial.load_vehicle('{args.vehicle}')), and export that"
)
HULL = ("mass", "inertia", "size")


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("model", type=Path, metavar="MODEL")
    command.add_argument(
        "--to", required=True, metavar="FORMAT",
        help="c, octave (and MATLAB), fmu, sdf (Gazebo), casadi, ros, latex, json",
    )  # fmt: skip
    command.add_argument("-o", "--out", type=Path, required=True, metavar="PATH")
    command.add_argument(
        "--vehicle",
        metavar="V",
        help="vehicle file for inputs and allocation (default: the model's own)",
    )
    command.add_argument("--mass", type=float, metavar="KG", help="sdf: mass of the boat")
    command.add_argument(
        "--inertia",
        type=float,
        metavar="KGM2",
        help="sdf: moment of inertia about the vertical axis [kg m^2]",
    )
    command.add_argument(
        "--size",
        type=float,
        nargs=3,
        metavar=("L", "W", "H"),
        help="sdf: length, width, height of the hull [m]",
    )
    command.add_argument(
        "--added-mass", type=float, nargs=3, metavar=("X", "Y", "N"),
        help="sdf: added mass in surge and sway [kg] and in yaw [kg m^2], not part of --mass (default: 0 0 0)",
    )  # fmt: skip
    command.add_argument(
        "--ros", type=int, choices=(1, 2), help="ros: version of ROS, 1 or 2 (default: 2)"
    )
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """The file."""
    from seatrial.commands.shared.results import ExportResult
    from seatrial.export import export, format_of
    from seatrial.workflow.next_step import after_export

    chosen = format_of(args.to)
    if args.to != "sdf":
        refuse_options(args, "--to sdf", *HULL, "added_mass")
    if args.to != "ros":
        refuse_options(args, "--to ros", "ros")
    else:
        refuse_options(args, NODE_READS_ITS_OWN.format(args=args), "vehicle")
    guard(args.out, chosen.begins, args.model, args.vehicle)
    guard(args.json, "{", args.model, args.vehicle, args.out)
    model = load_model(args)
    export(model, args.to, args.out, model_path=args.model, hull=_hull(args), ros=args.ros or 2)
    about = chosen.made_here
    say(f"wrote {args.out}: {about}")
    say(after_export(args.out).text)
    found = ExportResult(str(args.model), args.to, about, str(args.out))
    write_json(args, "export 1", found)


def _hull(args: argparse.Namespace) -> "Hull | None":
    """Mass and size, where they are given. Raises ExportError where only some are."""
    from seatrial.export import Hull
    from seatrial.util.errors import ExportError

    given = [name for name in HULL if getattr(args, name) is not None]
    if not given:
        return None
    if len(given) < len(HULL):
        missing = ", ".join(f"--{name}" for name in HULL if name not in given)
        raise ExportError(f"{missing} missing: give mass, inertia and size together")
    return Hull(
        args.mass, args.inertia, tuple(args.size), tuple(args.added_mass or (0.0, 0.0, 0.0))
    )
