# SPDX-License-Identifier: MIT
"""`seatrial tune`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import add_json, guard, write_json
from seatrial.control import ALLOCATIONS, CONTROLLER_RATE, KNOB, VEHICLE
from seatrial.util.printing import say
from seatrial.util.progress import stage


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("model", type=Path, metavar="MODEL")
    command.add_argument(
        "--knob", type=float, default=KNOB, metavar="S",
        help="closed-loop time constant [s]: smaller is quicker, larger is gentler (default: %(default)g)",
    )  # fmt: skip
    command.add_argument(
        "--action", choices=("pid", "pd"), default="pid", help="with or without integral (default: pid)"
    )  # fmt: skip
    command.add_argument(
        "--rate", type=float, default=CONTROLLER_RATE, metavar="HZ",
        help="rate of the controller [Hz] (default: %(default)g)",
    )  # fmt: skip
    command.add_argument(
        "--delay", type=float, default=0.0, metavar="S",
        help="further delay in the loop, such as a network's [s] (default: 0)",
    )  # fmt: skip
    command.add_argument(
        "--allocation", choices=ALLOCATIONS, default=VEHICLE,
        help="the boat's own, or a scheme of `seatrial allocate` for thrusters that are commanded one by "
        "one (default: %(default)s)",
    )  # fmt: skip
    command.add_argument(
        "-o", "--out", type=Path, metavar="GAINS", help="gains file for the controller"
    )
    command.add_argument("--ros", type=Path, metavar="FILE", help="gains as ROS 1 parameters")
    command.add_argument("--ros2", type=Path, metavar="FILE", help="gains as ROS 2 parameters")
    command.add_argument(
        "--report", type=Path, metavar="HTML", help="step responses and Bode plots"
    )
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """Gains and margins, shown and written."""
    from seatrial.boat.model_file import load
    from seatrial.control import save_gains, save_ros, tune, tuning_text
    from seatrial.control.gains_file import GAINS_FORMAT, gains_of
    from seatrial.workflow.next_step import after_tune

    ros = "seatrial_tracking:"
    begins = ("seatrial: gains", ros, ros, "<!doctype html")
    outs = (args.out, args.ros, args.ros2, args.report)
    for i, (out, begin) in enumerate(zip(outs, begins, strict=True)):
        guard(out, begin, args.model, *outs[:i])
    guard(args.json, "{", args.model, *outs)
    model = load(args.model)
    with stage("margins over the model's covariance", None if args.report is None else 0.5):
        found = tune(
            model, args.knob, action=args.action, rate=args.rate, extra=args.delay, allocation=args.allocation
        )  # fmt: skip
    if args.report is not None:
        from seatrial.control.tuning.page import tuning_report
        from seatrial.util.files import write_text

        with stage("drawing"):
            write_text(args.report, tuning_report(found))
    if args.out is not None:
        save_gains(found, args.out)
    if args.ros is not None:
        save_ros(found, args.ros)
    if args.ros2 is not None:
        save_ros(found, args.ros2, ros2=True)
    write_json(args, GAINS_FORMAT, gains_of(found))
    say(tuning_text(found))
    for out in outs:
        if out is not None:
            say(f"wrote {out}")
    say(after_tune(args.model, args.out).text)
