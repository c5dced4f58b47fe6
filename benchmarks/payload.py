# SPDX-License-Identifier: MIT
"""A payload comes on board: what compare says of it, and what a prior saves.

    python benchmarks/payload.py --seeds 20

The plan's boat; a fifth more mass and inertia, off centre (every coefficient divided by 1.2, N_ud
0.1 rad/m larger). Three trials before, three after; then a minute of S7 with and without the old
model as prior. With --pushed an unmodelled force acts on the boat (4 % of full thrust, 2 s).
"""

import argparse
import os
import sys
from collections.abc import Sequence
from itertools import combinations

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before NumPy

import msgspec
import numpy as np

import seatrial
from seatrial.boat.model import Model
from seatrial.evaluation.comparison.parameters import factors, joint, pairs, views
from seatrial.evaluation.comparison.prediction import predict_both, verdict
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.identification.prior import widened
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import PlanFile, Unmodelled, load_plan, with_seed
from seatrial.simulation.trials import simulate
from seatrial.util.errors import SeatrialError

MORE = 1.2  # times mass and inertia
OFFSET = 0.1  # [rad/m] of N_ud
TRAINING = ("S1", "S2", "S3")
UNSEEN = "S7"
FIRST, AFTER = 3001, 4001  # seeds
MINUTE = (20.0, 80.0)  # [s] of S7
PIECES = 31  # blocks of a minute, for an estimate without a prior
VEHICLE = seatrial.load_vehicle("mallard-mp")


def loaded(plan: PlanFile) -> PlanFile:
    """The same boat with its payload."""
    values = {name: value / MORE for name, value in plan.plant.coefficients.items()}
    values["N_ud"] += OFFSET
    plant = msgspec.structs.replace(plan.plant, coefficients=values)
    return msgspec.structs.replace(plan, plant=plant)


def recordings(plan: PlanFile, names: Sequence[str], seed: int) -> list[Recording]:
    """Some of the plan's trials."""
    plan = with_seed(plan, seed)
    trials = {name: plan.trials[name] for name in names}
    return [t.recording for t in simulate(msgspec.structs.replace(plan, trials=trials), VEHICLE)]


def alarms(models: Sequence[Model]) -> str:
    """The same boat twice, every pair of models: how often a difference is seen."""
    found = []
    for a, b in combinations(models, 2):
        seen = views(a, b)
        rows = pairs(a, b, seen, {})
        test = joint(rows, seen)
        axes = factors(a, rows, seen)
        found.append([
            any(row.differs for row in rows), test is not None and test.p < 0.05,
            np.mean([abs(axis.z) > 1.96 for axis in axes]),
        ])  # fmt: skip
    share = 100.0 * np.mean(found, axis=0)
    return (
        f"  same boat, {len(found)} pairs of {len(models)} models: a parameter differs in {share[0]:.1f} %, "
        f"the joint test below 5 % in {share[1]:.1f} %, an axis' factor away from 1 in {share[2]:.1f} %"
    )


def changes(before: Sequence[Model], after: Sequence[Model]) -> str:
    """Before and after the payload: what is found changed."""
    names: dict[str, int] = {}
    scale = []
    for a, b in zip(before, after, strict=True):
        seen = views(a, b)
        rows = pairs(a, b, seen, {})
        for row in rows:
            names[row.name] = names.get(row.name, 0) + row.differs
        scale.append([axis.factor for axis in factors(a, rows, seen)])
    listed = ", ".join(f"{name} {100 * n / len(before):.0f}" for name, n in names.items())
    mean, spread = np.mean(scale, axis=0), np.std(scale, axis=0)
    axes = ", ".join(f"{m:.4f} ± {s:.4f}" for m, s in zip(mean, spread, strict=True))
    return (
        f"  with payload, found changed in % of {len(before)}: {listed}\n"
        f"  factor of surge, sway, yaw (1 / {MORE:g} = {1 / MORE:.4f}): {axes}"
    )


def predictions(
    before: Sequence[Model], after: Sequence[Model], unseen: Sequence[Recording]
) -> str:
    """S7 of the loaded boat, 1 s ahead: how often the new model is found better."""
    better, rms = [], []
    for a, b, recording in zip(before, after, unseen, strict=True):
        rows = predict_both(a, b, [recording], [1.0])
        better.append([letter == "B" for letter in verdict(rows).values()])
        rms.append([[one.a, one.b] for one in rows[-1].axes.values()])
    share, mean = 100.0 * np.mean(better, axis=0), np.mean(rms, axis=0)
    said = ", ".join(
        f"{axis} {s:.0f} % ({k * old:.3g} to {k * new:.3g} {unit})"
        for axis, s, (old, new), k, unit in zip(
            ("surge", "sway", "yaw"),
            share,
            mean,
            (100, 100, 1),
            ("cm/s", "cm/s", "rad/s"),
            strict=True,
        )
    )
    return f"  predicts S7 1 s ahead better, by more than chance: {said}"


def minute(before: Sequence[Model], plan: PlanFile, unseen: Sequence[Recording]) -> str:
    """RMS errors after a minute, with the old model as prior and without; and of the old model."""
    truth = np.array(list(loaded(plan).plant.coefficients.values()))
    names = list(plan.plant.coefficients)
    found: dict[str, list[np.ndarray]] = {"old": [], "alone": [], "prior": [], "z": []}
    failed = 0
    for old, recording in zip(before, unseen, strict=True):
        short = [recording.cut(*MINUTE)]
        block = OutputErrorSettings(block=(MINUTE[1] - MINUTE[0]) / PIECES)
        new = output_error(short, VEHICLE, start=old, prior=widened(old))
        try:
            alone = output_error(short, VEHICLE, start=old, settings=block)
        except SeatrialError:
            failed += 1
            continue
        for key, model in (("old", old), ("alone", alone), ("prior", new)):
            found[key].append(np.array([model.values[n] for n in names]) - truth)
        error = np.array([new.standard_errors[n] for n in names])
        found["z"].append(found["prior"][-1] / error)
    rms = {key: np.sqrt(np.mean(np.square(rows), axis=0)) for key, rows in found.items()}
    lines = [
        f"  a minute of S7, RMS error; without a prior no solution in {failed} of {len(before)}",
        f"    {'':<6} {'truth':>8} {'old model':>10} {'alone':>10} {'with prior':>10} {'ratio':>6}   "
        "error / stated",
    ]
    for i, name in enumerate(names):
        old, alone, new = (rms[key][i] for key in ("old", "alone", "prior"))
        lines.append(
            f"    {name:<6} {truth[i]:8.4f} {old:10.5f} {alone:10.5f} {new:10.5f} {new / alone:6.2f}   "
            f"{rms['z'][i]:.2f}"
        )
    return "\n".join(lines)


def main(arguments: Sequence[str]) -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plan", default="hard")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--pushed", action="store_true", help="with an unmodelled force")
    given = parser.parse_args(arguments)
    plan = load_plan(given.plan)
    if given.pushed:
        plant = msgspec.structs.replace(plan.plant, unmodelled=Unmodelled(0.04, 2.0))
        plan = msgspec.structs.replace(plan, plant=plant)
    before, after, unseen = [], [], []
    for seed in range(given.seeds):
        try:
            old = output_error(recordings(plan, TRAINING, FIRST + seed), VEHICLE)
            new = output_error(recordings(loaded(plan), TRAINING, AFTER + seed), VEHICLE)
        except SeatrialError as error:
            print(f"  seed {seed}: {error}")
            continue
        before.append(old)
        after.append(new)
        unseen += recordings(loaded(plan), [UNSEEN], AFTER + seed)
    print(f"{given.plan}{', pushed' if given.pushed else ''}, seeds {FIRST} and {AFTER} on")
    print(alarms(before))
    print(changes(before, after))
    print(predictions(before, after, unseen))
    print(minute(before, plan, unseen))


if __name__ == "__main__":
    main(sys.argv[1:])
