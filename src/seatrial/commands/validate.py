# SPDX-License-Identifier: MIT
"""`seatrial validate`."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from seatrial.commands.shared import (
    add_command,
    add_horizon,
    add_json,
    add_recordings,
    guard,
    load_model,
    read_all,
)
from seatrial.util.progress import Progress

if TYPE_CHECKING:
    from seatrial.commands.shared import Verbs


def add(verbs: "Verbs") -> None:
    """Its arguments."""
    command = add_command(verbs, "validate", run, "score how well a model predicts recordings")
    command.add_argument("model", type=Path, metavar="MODEL")
    add_recordings(command)
    add_horizon(command, "how far ahead [s] (default: %(default)g)")
    add_json(command, "also write the scores as JSON")
    command.add_argument(
        "--reference", choices=("smoothed", "stencil"), default="smoothed",
        help="velocity to compare with: smoothed, predicted from the model's filter, or the paper's five-point "
        "stencil, predicted from that (default: %(default)s)",
    )  # fmt: skip
    command.add_argument(
        "--against", type=Path, metavar="OTHER", help="another model for a head-to-head comparison"
    )


def run(args: argparse.Namespace, progress: Progress) -> None:
    """Scores, horizons, and another model beside it."""
    from seatrial.boat.model import load
    from seatrial.boat.physics import model_concerns
    from seatrial.evaluation.console import LEGEND, horizons_text, scores_text
    from seatrial.evaluation.head_to_head import head_to_head_text
    from seatrial.evaluation.scores import scores_json
    from seatrial.evaluation.validation import validate
    from seatrial.util.files import dump_json, write_text

    guard(args.json, "{", args.model, args.vehicle, args.against, *args.recordings)
    model = load_model(args)
    other = None if args.against is None else load(args.against)
    recordings = read_all(args, model.vehicle, progress)
    progress.say("validating")
    scores = validate(model, recordings, args.horizon, other=other, reference=args.reference)
    if args.json is not None:
        write_text(args.json, dump_json(scores_json(scores)))
    progress.clear()
    print(f"{scores_text(scores)}\n{LEGEND}\n{horizons_text(scores)}")
    if scores.against is not None:
        print(head_to_head_text(scores.against))
    for doubt in model_concerns(model):
        print(f"  doubt: {doubt}")
