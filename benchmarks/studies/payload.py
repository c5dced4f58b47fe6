# SPDX-License-Identifier: MIT
"""A payload on board: what compare reports, and what a prior saves. The table of docs/compare.md.

    python -m benchmarks.studies.payload --seeds 20
    python -m benchmarks.studies.payload --seeds 20 --pushed

The plan's boat; a fifth more mass and inertia, off centre (every coefficient divided by 1.2, N_ud
0.1 rad/m larger). Three trials before, three after; then a minute of S7 with and without the old
model as prior. With --pushed an unmodelled force acts on the boat (4 % of full thrust, 2 s).
"""

import sys
from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np

import seatrial
from benchmarks.harness import command
from benchmarks.harness.markdown import table
from benchmarks.studies.changes.boats import MORE, heavier
from seatrial.boat.model import Model
from seatrial.evaluation.comparison.compare import compare
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.identification.prior import widened
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import PlanFile, load_plan
from seatrial.util.errors import SeatrialError
from tests.boats.scenes import TRAINING, UNSEEN, driven, pushed

OFFSET = 0.1  # [rad/m] of N_ud
FIRST, AFTER = 3001, 4001  # seeds
MINUTE = (20.0, 80.0)  # [s] of S7
PIECES = 31  # blocks of a minute, for an estimate without a prior
VEHICLE = seatrial.load_vehicle("mallard-mp")
Row = list[str]


def loaded(plan: PlanFile) -> PlanFile:
    """The same boat with its payload."""
    return heavier(plan, OFFSET)


def recordings(plan: PlanFile, names: Sequence[str], seed: int) -> list[Recording]:
    """Some of the plan's trials."""
    return [trial.recording for trial in driven(plan, VEHICLE, seed, names).values()]


def alarms(models: Sequence[Model]) -> Iterable[Row]:
    """False alarms: the same boat twice, every pair of models."""
    found = [compare(a, b) for a, b in combinations(models, 2)]
    marked = np.mean([bool(c.changed) for c in found])
    joint = np.mean([c.joint is not None and c.joint.p < 0.05 for c in found])
    yield [f"same boat twice ({len(found)} pairs): some parameter marked", f"{100 * marked:.1f} %"]
    yield ["same boat twice: joint test below 5 %", f"{100 * joint:.1f} %"]


def changes(
    before: Sequence[Model], after: Sequence[Model], unseen: Sequence[Recording]
) -> Iterable[Row]:
    """Before and after the payload: parameters marked, factors, and which model predicts better."""
    three = zip(before, after, unseen, strict=True)
    found = [compare(a, b, [recording]) for a, b, recording in three]
    for name in (pair.name for pair in found[0].pairs):
        marked = np.mean([any(pair.name == name for pair in c.changed) for c in found])
        yield [f"with payload: {name} marked", f"{100 * marked:.0f} %"]
    scale = np.array([[axis.factor for axis in c.factors] for c in found])
    of = zip(scale.mean(axis=0), scale.std(axis=0), strict=True)
    yield [
        f"factor of surge, sway, yaw; {1 / MORE:.4f} is right",
        ", ".join(f"{m:.4f} ± {s:.4f}" for m, s in of),
    ]
    better = np.mean([[x == "B" for x in c.better["1"].values()] for c in found], axis=0)
    yield [
        "new model found better on S7 1 s ahead, each axis",
        ", ".join(f"{100 * share:.0f} %" for share in better),
    ]


def minute(before: Sequence[Model], plan: PlanFile, unseen: Sequence[Recording]) -> Iterable[Row]:
    """RMS errors after a minute, with the old model as prior over those without."""
    names, truth = list(plan.plant.coefficients), loaded(plan).plant.coefficients
    block = OutputErrorSettings(block=(MINUTE[1] - MINUTE[0]) / PIECES)
    ratio, stated, refused = [], [], 0
    for old, recording in zip(before, unseen, strict=True):
        short = [recording.cut(*MINUTE)]
        new = output_error(short, VEHICLE, start=old, prior=widened(old))
        try:
            alone = output_error(short, VEHICLE, start=old, settings=block)
        except SeatrialError:
            refused += 1
            continue
        off = np.array([[m.values[n] - truth[n] for n in names] for m in (new, alone)])
        ratio.append(off)
        stated.append(off[0] / [new.standard_errors[n] for n in names])
    rms = np.sqrt(np.mean(np.square(ratio), axis=0))
    spread = np.sqrt(np.mean(np.square(stated), axis=0))
    yield ["a minute of S7: refused without a prior", f"{refused} of {len(before)}"]
    for name, (prior, alone), z in zip(names, rms.T, spread, strict=True):
        shown = f"{prior / alone:.2f} ({prior:.5f} / {alone:.5f}); {z:.2f}"
        yield [
            f"a minute of S7, {name}: RMS error with the prior over that without; over stated",
            shown,
        ]


def main(arguments: Sequence[str]) -> None:
    """Run and print."""
    parser = command.parser("studies.payload", __doc__)
    parser.add_argument("--plan", default="hard")
    parser.add_argument("--seeds", type=int, default=20, help=f"from {FIRST} and {AFTER} on")
    parser.add_argument("--pushed", action="store_true", help="with an unmodelled force")
    given = parser.parse_args(arguments)
    plan = pushed(given.plan) if given.pushed else load_plan(given.plan)
    before, after, unseen = [], [], []
    for seed in range(given.seeds):
        try:
            old = output_error(recordings(plan, TRAINING, FIRST + seed), VEHICLE)
            new = output_error(recordings(loaded(plan), TRAINING, AFTER + seed), VEHICLE)
        except SeatrialError as error:
            print(f"seed {seed}: {error}", file=sys.stderr)
            continue
        before.append(old)
        after.append(new)
        unseen += recordings(loaded(plan), [UNSEEN], AFTER + seed)
    rows = [*alarms(before), *changes(before, after, unseen), *minute(before, plan, unseen)]
    print(table(["", given.plan + (", pushed" if given.pushed else "")], rows))


if __name__ == "__main__":
    main(sys.argv[1:])
