# SPDX-License-Identifier: MIT
"""`seatrial report`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import (
    add_exports,
    add_horizon,
    add_json,
    add_recordings,
    check_png,
    guard,
    horizon_of,
    load_model,
    read_all,
    refuse_options,
    write_json,
)
from seatrial.util.printing import say
from seatrial.util.progress import stage


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("model", type=Path, metavar="MODEL")
    add_recordings(command)
    add_horizon(command, "how far ahead [s] (default: %(default)g)")
    command.add_argument(
        "--scores", type=Path, metavar="FILE",
        help="use the scores that validate --json wrote for this model and these recordings",
    )  # fmt: skip
    command.add_argument("-o", "--out", type=Path, required=True, metavar="HTML")
    add_exports(command)
    add_json(command)


def run(args: argparse.Namespace) -> None:
    """The page, and its figures and tables beside it."""
    from seatrial.commands.shared.results import ReportResult
    from seatrial.evaluation.scores import load_scores
    from seatrial.report.evidence.model_evidence import collect
    from seatrial.report.evidence.verdict import following
    from seatrial.report.model_report import write_evidence

    guard(args.out, "<!doctype html", args.model, args.vehicle, args.scores, *args.recordings)
    guard(args.json, "{", args.model, args.vehicle, args.scores, *args.recordings, args.out)
    check_png(args)
    if args.scores is not None:
        refuse_options(
            args, "scores that are computed here; those of --scores have their own", "horizon"
        )
    model = load_model(args)
    scores = None if args.scores is None else load_scores(args.scores)
    with stage("reading", 0.3):
        recordings = read_all(args, model.vehicle)
    with stage("report"):
        evidence = collect(model, recordings, horizon_of(args), scores)
        write_evidence(
            evidence, args.out, figures=args.figures, raster=args.png, tables=args.tables
        )
    written = [args.out, *(folder for folder in (args.figures, args.tables) if folder is not None)]
    paths = [str(path) for path in args.recordings]
    found = ReportResult(str(args.model), paths, [str(path) for path in written])
    write_json(args, "report 1", found)
    say(f"wrote {', '.join(map(str, written))}")
    say(f"next: {following(evidence).removeprefix('Next: ')}")
