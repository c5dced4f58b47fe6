# SPDX-License-Identifier: MIT
"""Oracle: what the test for a change reports of the unchanged model ship, a model with mismatch.

    make demo
    python -m benchmarks.studies.changes.mismatch --model demo/cse1/cse1/model.yaml

The finding of the mismatch is taken out of the model, which is of two runs; the first run was left out. Scatter of
the scores: by the model's covariance (sandwich) over that of white innovations, median over windows of 40 s.
"""

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np

import seatrial
from benchmarks.harness import command
from benchmarks.harness.markdown import table
from benchmarks.studies.changes.work import findings
from seatrial.boat.findings import FindingKind
from seatrial.boat.model import Model
from seatrial.evaluation.comparison.cause_candidates import CAUSES
from seatrial.monitoring.change_space import change_space
from seatrial.monitoring.window_likelihood import windows
from seatrial.onboard.boat_change import ChangeState
from seatrial.recording.recording import Recording
from tests.boats.drives import RUNS, SHIP

WINDOW = 40.0  # [s]
HEAD = "run", "driven", "noticed", "confirmed", "changes that it confirmed", "scatter of the scores"


def without_refusal(model: Model) -> Model:
    """The model without its finding of a mismatch."""
    kept = [f for f in model.estimator.findings if f.kind is not FindingKind.MODEL_MISMATCH]
    return replace(model, estimator=msgspec.structs.replace(model.estimator, findings=kept))


def scatter(model: Model, recording: Recording) -> float:
    """Median over windows of tr(C H) / p times the ratio of lengths; C: sandwich, H: a window's information."""
    space = change_space(model)
    known = int(np.sum(np.diag(space.wider.covariance) > 0.0))
    length = sum(entry.length for entry in model.recordings)
    found = []
    for start in np.arange(0.0, recording.duration - WINDOW, WINDOW):
        window = windows(model, recording.cut(start, start + WINDOW))[0]
        quadratic = window.quadratic(space.wider, space.theta)
        if quadratic is not None:
            both = float(np.sum(space.wider.covariance * quadratic.information))
            found.append(both * length / WINDOW / known)
    return float(np.median(found))


def row(name: str, model: Model, recording: Recording) -> list[str]:
    """What is found along a run."""
    found = findings(model, recording, to_the_end=True)
    sure = [change for change in found if change.state is ChangeState.CONFIRMED]
    sizes = [
        c.cause if c.size is None else f"{c.what} {100 * c.size:+.0f} %"
        for c in sorted(sure, key=lambda c: CAUSES.index(c.cause))
    ]
    noticed = sum(change.state is ChangeState.NOTICED for change in found)
    return [
        name, f"{recording.duration:.0f} s", str(noticed), str(len(sure)), ", ".join(sizes),
        f"{scatter(model, recording):.0f}",
    ]  # fmt: skip


def main(arguments: Sequence[str]) -> None:
    """Print the table."""
    parser = command.parser("studies.changes.mismatch", __doc__)
    parser.add_argument("--model", type=Path, required=True, help="of random_run1 and random_run3")
    parser.add_argument("--runs", nargs="*", default=RUNS, choices=RUNS)
    given = parser.parse_args(arguments)
    vehicle = seatrial.load_vehicle(SHIP / "vehicle.yaml")
    model = without_refusal(seatrial.load(given.model))
    paths = {name: SHIP / "csv" / f"CSE1_data_{name}.csv" for name in given.runs}
    rows = [row(name, model, seatrial.read(path, vehicle)) for name, path in paths.items()]
    print(table(HEAD, rows))


if __name__ == "__main__":
    main(sys.argv[1:])
