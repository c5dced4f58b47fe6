# SPDX-License-Identifier: MIT
"""`seatrial sim`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import add_json, add_ports, guard_lines, lines_of, write_json
from seatrial.simulation.protocol import LINE_KINDS
from seatrial.simulation.server import SimSettings
from seatrial.util.printing import complain


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("models", nargs="+", type=Path, metavar="MODEL", help="model of one boat")
    command.add_argument(
        "--scene", type=Path, metavar="FILE",
        help="walls, current, sensors and starts (default: open water)",
    )  # fmt: skip
    command.add_argument(
        "--current", type=float, nargs=2, metavar=("X", "Y"),
        help="velocity of the water [m/s] (default: the scene's)",
    )  # fmt: skip
    command.add_argument(
        "--seed", type=int, default=0, help="seed of the sensors' noise (default: %(default)s)"
    )
    command.add_argument(
        "--speed", type=float, default=SimSettings.speed, metavar="X",
        help="simulated seconds per second; 0: as fast as possible, up to the stamps of the lines "
        "(default: %(default)g)",
    )  # fmt: skip
    command.add_argument(
        "--rate", type=float, default=SimSettings.rate, metavar="HZ",
        help="rate of the truth [Hz] (default: %(default)g)",
    )  # fmt: skip
    command.add_argument("--duration", type=float, metavar="S", help="duration [s]")
    command.add_argument(
        "--lines", default=",".join(SimSettings.kinds), metavar="LINE_KINDS",
        help=f"kinds of output lines, some of {', '.join(LINE_KINDS)} (default: %(default)s)",
    )  # fmt: skip
    add_ports(command)
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """Lines until the input ends, or the duration is over."""
    from seatrial.boat.physics import axis_physics, negative_latencies
    from seatrial.commands.shared.results import SimResult
    from seatrial.simulation.server import serve
    from seatrial.simulation.world import World

    guard_lines(args, *args.models, args.scene)
    kinds = [kind.strip() for kind in args.lines.split(",") if kind.strip()]
    settings = SimSettings(args.rate, args.speed, args.duration, kinds)
    world = World(args.scene, current=args.current, seed=args.seed)
    for model in args.models:
        added = world.add(model).model
        axis_physics(added)
        for words in negative_latencies(added):
            complain(f"{added.name}: {words}")
    stream = serve(world, lines_of(args), settings, complain)
    names = [boat.name for boat in world.boats]
    found = SimResult(names, args.seed, world.time, stream.lines, stream.mistakes)
    write_json(args, "sim 1", found)
