# SPDX-License-Identifier: MIT
"""`seatrial validate`."""

import argparse
from pathlib import Path

from seatrial.commands.shared import (
    add_horizon,
    add_json,
    add_recordings,
    guard,
    horizon_of,
    load_model,
    read_all,
    recordings_again,
    write_json,
)
from seatrial.util.printing import say
from seatrial.util.progress import stage


def add(command: argparse.ArgumentParser) -> None:
    """Its arguments."""
    command.add_argument("model", type=Path, metavar="MODEL")
    add_recordings(command)
    add_horizon(command, "how far ahead [s] (default: %(default)g)")
    add_json(command)
    command.add_argument(
        "--reference", choices=("smoothed", "stencil"), default="smoothed",
        help="velocity to compare with: smoothed, predicted from the model's filter, or the paper's five-point "
        "stencil, predicted from that (default: %(default)s)",
    )  # fmt: skip
    command.add_argument(
        "--against", type=Path, metavar="OTHER", help="another model for a head-to-head comparison"
    )


def run(args: argparse.Namespace) -> None:
    """Scores, horizons, and another model beside it."""
    from seatrial.boat.findings import FindingKind
    from seatrial.boat.model_file import load
    from seatrial.boat.physics import model_concerns
    from seatrial.evaluation.scores import SCORES_FORMAT, scores_json
    from seatrial.evaluation.validation import validate
    from seatrial.inspection.consistency.between_recordings import contradictions
    from seatrial.recording.undriven import undriven_motion
    from seatrial.workflow.next_step import after_validate

    guard(args.json, "{", args.model, args.vehicle, args.against, *args.recordings)
    model = load_model(args)
    other = None if args.against is None else load(args.against)
    with stage("reading", 0.4):
        recordings = read_all(args, model.vehicle)
    with stage("validating"):
        scores = validate(
            model, recordings, horizon_of(args), other=other, reference=args.reference
        )
    write_json(args, SCORES_FORMAT, scores_json(scores))
    say(str(scores))
    wrong = contradictions(recordings, model.vehicle)
    found = [(recording, one) for recording in recordings for one in undriven_motion(recording)]
    moves = [f"{recording.name}: {one.text(recording)}" for recording, one in found]
    for doubt in dict.fromkeys([*wrong, *moves, *model_concerns(model)]):
        say(f"  doubt: {doubt}")
    options = [] if args.vehicle is None else ["--vehicle", args.vehicle]
    options += [] if args.horizon is None else ["--horizon", f"{args.horizon:.15g}"]
    undriven = [one.span(recording) for recording, one in found]
    again = recordings_again(args)
    step = after_validate(
        args.model, scores, again, options, wrong,
        undriven=undriven, contradicted=model.findings_of(FindingKind.CONTRADICTED),
    )  # fmt: skip
    say(step.text)
