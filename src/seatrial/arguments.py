# SPDX-License-Identifier: MIT
"""The commands' arguments."""

import argparse
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial import commands
from seatrial.identify import DEFAULT_METHOD, KINDS, METHODS, PRIOR_SPREAD
from seatrial.io.write_bag import FORMATS
from seatrial.live.lines import FORMATS as LINE_FORMATS
from seatrial.live.loop import CLOCKS as LINE_CLOCKS
from seatrial.live.loop import RATE as LINE_RATE
from seatrial.predict import DEFAULT_HORIZON

if TYPE_CHECKING:
    Verbs = argparse._SubParsersAction[argparse.ArgumentParser]


def make_parser() -> argparse.ArgumentParser:
    """Of the program: one parser below it for every command."""
    parser = argparse.ArgumentParser(
        prog="seatrial", description="Dynamic models of small surface vehicles from a recording."
    )
    parser.add_argument("--version", action="version", version=f"seatrial {version('seatrial')}")
    verbs = parser.add_subparsers(required=True, metavar="COMMAND")

    demo = _add(verbs, "demo", commands.demo_command, "everything below on the bundled recordings")
    demo.add_argument(
        "--out", type=Path, default=Path("demo"), help="folder to write to (default: demo)"
    )

    inspect = _add(
        verbs,
        "inspect",
        commands.inspect_command,
        "rates, gaps, faults, clocks, excitation, signs; without --vehicle the topics or columns",
    )
    _recordings(inspect, vehicle_required=False)
    _json(inspect)

    init = _add(
        verbs,
        "init",
        commands.init_command,
        "a vehicle file to start from, proposed from a recording",
    )
    init.add_argument("recordings", nargs="+", type=Path, metavar="RECORDING")
    init.add_argument("-o", "--out", type=Path, required=True, metavar="VEHICLE")
    init.add_argument("--name", help="the boat's name (default: the recording's)")
    init.add_argument(
        "--axes",
        choices=commands.AXES_NAMES,
        help=f"of the recording (default: {commands.AXES_NAMES[0]})",
    )
    init.add_argument("--pose", metavar="TOPIC", help="topic of the poses")
    init.add_argument("--commands", metavar="TOPIC", help="topic of the commands")
    init.add_argument(
        "--parent", metavar="FRAME", help="the world's frame, where poses come from tf"
    )
    init.add_argument("--child", metavar="FRAME", help="the boat's frame, where poses come from tf")
    _salvage(init)
    init.add_argument("--force", action="store_true", help="write over an existing file")

    simulate = _add(
        verbs, "simulate", commands.simulate_command, "recordings like the paper's S1-S7"
    )
    simulate.add_argument("--plan", default="paper-like", help="a file, or paper-like, hard, clean")
    simulate.add_argument("--vehicle", help="vehicle file instead of the plan's vehicles")
    simulate.add_argument("--model", type=Path, help="model file instead of the plan's plant")
    simulate.add_argument("--seed", type=int, help="instead of the plan's")
    simulate.add_argument(
        "--format", choices=("csv", *FORMATS), default="csv",
        help="csv: a folder of tables a trial; or a bag a trial (default: csv)",
    )  # fmt: skip
    simulate.add_argument("-o", "--out", type=Path, required=True, metavar="DIR")

    _add_identify(verbs)
    _add_scored(verbs)
    _add_compare(verbs)
    _add_select(verbs)
    _add_predict(verbs)
    return parser


def _add_identify(verbs: "Verbs") -> None:
    identify = _add(verbs, "identify", commands.identify_command, "a model from recordings")
    _recordings(identify, vehicle_required=True)
    identify.add_argument("-o", "--out", type=Path, required=True, metavar="MODEL")
    identify.add_argument(
        "--method", choices=METHODS, default=DEFAULT_METHOD,
        help="equation-error is the paper's least squares; output-error, on the raw poses, finds the thrusters' "
        "latency, lag and dead zone, too (default: %(default)s)",
    )  # fmt: skip
    identify.add_argument(
        "--role", action="append", default=[], metavar="AXIS=NAME[,NAME]",
        help="recordings that identify surge, sway or yaw (default: found from the excitation)",
    )  # fmt: skip
    identify.add_argument(
        "--effect", action="append", default=[], choices=KINDS,
        help="also seek this: the sensor's lever arm, or each recording's current, trim or wind",
    )  # fmt: skip
    identify.add_argument(
        "--minutes", action="store_true", help="accuracy against the length that was driven"
    )
    identify.add_argument(
        "--profile", nargs="+", action="extend", default=[], metavar="NAME",
        help="intervals of these by profile likelihood",
    )  # fmt: skip
    identify.add_argument(
        "--bootstrap", type=int, default=0, metavar="N",
        help="intervals from N refits to blocks drawn anew (200 are usual)",
    )  # fmt: skip
    identify.add_argument(
        "--literal",
        action="store_true",
        help="Eq. (17) as printed, surge acceleration one step late",
    )
    identify.add_argument(
        "--prior", type=Path, metavar="OLD",
        help="model of this boat from before its payload changed: then a short recording will do",
    )  # fmt: skip
    identify.add_argument(
        "--prior-spread", type=float, default=PRIOR_SPREAD, metavar="SHARE",
        help="by how much its parameters may have changed (default: %(default)g)",
    )  # fmt: skip


def _add_scored(verbs: "Verbs") -> None:
    for name, run, text in (
        ("validate", commands.validate_command, "how well a model predicts recordings"),
        ("report", commands.report_command, "one offline HTML file with the evidence"),
    ):
        command = _add(verbs, name, run, text)
        command.add_argument("model", type=Path, metavar="MODEL")
        _recordings(command, vehicle_required=False)
        _horizon(command, "how far ahead [s] (default: %(default)g)")
        if name == "validate":
            _json(command, "also write scores.json")
            command.add_argument(
                "--against",
                type=Path,
                metavar="OTHER",
                help="another model, beside it in a 2 x 2 table",
            )
        else:
            command.add_argument("-o", "--out", type=Path, required=True, metavar="HTML")
            _exports(command)


def _add_compare(verbs: "Verbs") -> None:
    compare = _add(
        verbs,
        "compare",
        commands.compare_command,
        "which of a boat's numbers changed; does it matter",
    )
    compare.add_argument("a", type=Path, metavar="A", help="model from before")
    compare.add_argument("b", type=Path, metavar="B", help="model from after")
    _recordings(compare, vehicle_required=False, count="*")
    _horizon(compare, f"how far ahead [s], besides {DEFAULT_HORIZON:g} s")
    _json(compare)
    compare.add_argument(
        "-o", "--out", type=Path, metavar="HTML", help="also one offline HTML file with both"
    )
    _exports(compare)


def _add_select(verbs: "Verbs") -> None:
    select = _add(
        verbs, "select", commands.select_command, "which terms recordings ask for, and which repeat"
    )
    _recordings(select, vehicle_required=True)
    select.add_argument(
        "--candidates", nargs="+", action="extend", metavar="FILE|TERM",
        help="terms that may come in, like 'Y_r * r', or files of them (default: a list of usual ones)",
    )  # fmt: skip
    _horizon(select, "how far ahead held-out recordings are predicted [s] (default: %(default)g)")
    select.add_argument("-o", "--out", type=Path, metavar="VEHICLE", help="with the chosen terms")
    _json(select)


def _add_predict(verbs: "Verbs") -> None:
    predict = _add(
        verbs, "predict", commands.predict_command,
        "velocity and odometry as on board: along a recording, or live from lines",
    )  # fmt: skip
    predict.add_argument("model", type=Path, metavar="MODEL")
    _recordings(predict, vehicle_required=False, count="*")
    predict.add_argument(
        "-o", "--out", type=Path, metavar="FILE", help="odometry along the recording"
    )
    predict.add_argument(
        "--live", action="store_true", help="lines from standard input, or --udp, until it ends"
    )
    predict.add_argument(
        "--udp", type=int, metavar="PORT", help="live: listen there on loopback instead"
    )
    predict.add_argument(
        "--to", type=int, metavar="PORT", help="live: answer there (default: to whoever wrote last)"
    )
    predict.add_argument(
        "--format", choices=LINE_FORMATS, help="of the lines (default: json; of a .csv file: csv)"
    )
    predict.add_argument(
        "--rate",
        type=float,
        default=LINE_RATE,
        metavar="HZ",
        help="of the odometry (default: %(default)g)",
    )
    predict.add_argument(
        "--clock", choices=LINE_CLOCKS, default=LINE_CLOCKS[0],
        help="live: odometry is due by the stamps of the input, or by this machine's clock (default: %(default)s)",
    )  # fmt: skip


def _add(
    verbs: "Verbs",
    name: str,
    run: commands.Command,
    text: str,
) -> argparse.ArgumentParser:
    command = verbs.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    command.add_argument("-q", "--quiet", action="store_true", help="no progress")
    command.set_defaults(run=run)
    return command


def _recordings(
    command: argparse.ArgumentParser, *, vehicle_required: bool, count: str = "+"
) -> None:
    command.add_argument("recordings", nargs=count, type=Path, metavar="RECORDING")
    text = "vehicle file" + (
        ""
        if vehicle_required
        else " for signals and allocation (default: the model's own); terms and chain stay the model's"
    )
    command.add_argument("--vehicle", required=vehicle_required, metavar="V", help=text)
    command.add_argument(
        "--start", type=float, metavar="S", help="use each recording from here [s]"
    )
    _salvage(command)
    command.add_argument("--end", type=float, metavar="S", help="use each recording up to here [s]")


def _horizon(command: argparse.ArgumentParser, text: str) -> None:
    command.add_argument("--horizon", type=float, default=DEFAULT_HORIZON, metavar="S", help=text)


def _json(command: argparse.ArgumentParser, text: str = "also write it for programs") -> None:
    command.add_argument("--json", type=Path, metavar="FILE", help=text)


def _salvage(command: argparse.ArgumentParser) -> None:
    text = "read what is left of a damaged bag"
    command.add_argument("--salvage", action="store_true", help=text)


def _exports(command: argparse.ArgumentParser) -> None:
    command.add_argument("--figures", type=Path, metavar="FOLDER", help="every plot as SVG")
    command.add_argument(
        "--png", action="store_true", help="the figures as PNG, too (pip install 'seatrial[png]')"
    )
    command.add_argument(
        "--tables", type=Path, metavar="FOLDER", help="every table as CSV and LaTeX"
    )
