# SPDX-License-Identifier: MIT
"""`seatrial mimic`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import add_json, add_ports, guard_lines, lines_of, write_json
from seatrial.onboard.live.line_loop import CLOCKS, RATE
from seatrial.onboard.live.protocol import LINE_FORMATS
from seatrial.util.printing import complain

# the defaults are the core's
LIMITS = {
    "speed": ("M/S", "largest speed of the carrier, in any direction (default: 0.8)"),
    "yaw-rate": ("RAD/S", "largest yaw rate of the carrier (default: 2)"),
    "acceleration": ("M/S2", "largest acceleration of the carrier (default: 1.5)"),
    "yaw-acceleration": ("RAD/S2", "largest yaw acceleration of the carrier (default: 6)"),
    "lag": (
        "S",
        "delay plus time constant of the carrier, by which the velocity leads (default: 0.1)",
    ),
    "gain": ("1/S", "feedback gain on the pose error to the virtual boat (default: 2)"),
    "lost": ("M", "distance from the virtual boat at which the carrier stops (default: 0.5)"),
}


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("model", type=Path, metavar="MODEL")
    for name, (unit, text) in LIMITS.items():
        command.add_argument(f"--{name}", type=float, metavar=unit, help=text)
    add_ports(command)
    command.add_argument(
        "--format", choices=LINE_FORMATS, default=LINE_FORMATS[0],
        help="format of the input lines; output is JSON (default: %(default)s)",
    )  # fmt: skip
    command.add_argument(
        "--rate",
        type=float,
        default=RATE,
        metavar="HZ",
        help="rate of the velocity [Hz] (default: %(default)g)",
    )
    command.add_argument(
        "--clock", choices=CLOCKS, default=CLOCKS[0],
        help="clock that paces the output: stamps of the input, or this machine's (default: %(default)s)",
    )  # fmt: skip
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """Lines until the input ends."""
    from seatrial.boat.physics import axis_physics
    from seatrial.commands.shared.results import MimicResult
    from seatrial.onboard.live import Settings
    from seatrial.simulation.mimic import Carrier, Mimic
    from seatrial.simulation.mimic.server import MimicStream

    guard_lines(args, args.model)
    names = [name.replace("-", "_") for name in LIMITS]
    carrier = Carrier(**{name: getattr(args, name) for name in names})
    settings = Settings(args.format, args.rate, args.clock)
    mimic = Mimic(args.model, carrier)
    axis_physics(mimic.model)
    stream = MimicStream(mimic, settings, complain)
    stream.serve(lines_of(args))
    write_json(args, "mimic 1", MimicResult(str(args.model), stream.lines, stream.mistakes))
