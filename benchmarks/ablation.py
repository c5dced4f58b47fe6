# SPDX-License-Identifier: MIT
"""Gate: what each branch of the estimator is for: every figure with that branch off, beside the figure with all.

    python -m benchmarks.ablation --seeds 8 --boats 20
    python -m benchmarks.ablation --branches "fit horizon,noise structures" --no-ship

A branch that moves no figure has no place in the estimator. Figures: full filter passes and CPU seconds; of
simulated boats (still, pushed, with correlated pose errors, drawn at random) errors in standard errors, RMS, and
coverage of 95 % intervals; of the real ship the error one second ahead on the run left out, over that of a
velocity that stays constant.
"""

import argparse
import contextlib
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numpy as np

import seatrial
from benchmarks import cse1
from benchmarks.fleet.work import identified
from benchmarks.harness import command
from benchmarks.harness.markdown import table
from benchmarks.harness.workers import gathered
from seatrial import _core
from seatrial.identification.estimator import output_error
from seatrial.identification.likelihood.optimiser import Point
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Array
from seatrial.util.statistics import NORMAL_95
from tests.boats.drives import CORRELATED, RUNS, SCENES, SHIP, trials
from tests.boats.scenes import TRAINING, load_plan, scenes, true_parameters, vehicle_of

ALL = "everything on"
FIRST = 1001  # seed
STILL = ("paper-like MP", "hard AF")
PUSHED = ("hard MP pushed",)
LIKELIHOOD = "seatrial.identification.likelihood"
ESTIMATOR = "seatrial.identification.estimator"
SELECTION = "seatrial.identification.selection.actuator_selection"


def _same(at: Point, *_: object) -> Point:
    return at


def _none(*_: object, **__: object) -> list[Any]:
    return []


def _nothing(*_: object) -> None:
    return None


def _unchanged(_: Point, covariance: Array) -> Array:
    return covariance


# what stands in a branch's place where it is off
BRANCHES: dict[str, dict[str, Callable[..., Any]]] = {
    ALL: {},
    "noise structures": {f"{LIKELIHOOD}.fit_horizon.screened": _none},
    "frame of the disturbance": {
        f"{LIKELIHOOD}.noise_structures.in_likelier_frame": _same,
        f"{LIKELIHOOD}.fit_horizon.in_likelier_frame": _same,
    },
    "longer memory of pose errors": {f"{LIKELIHOOD}.noise_structures.with_longer_memory": _same},
    "fewer noise sources": {f"{LIKELIHOOD}.noise_structures.simplified": _same},
    "fit horizon": {f"{LIKELIHOOD}.fit_horizon._best_predicting": _nothing},
    "actuator stages": {f"{ESTIMATOR}.select_stages": lambda at, *_: (at, [])},
    "stages by a fit": {f"{SELECTION}._by_fit": lambda *_: (None, None)},
    "dead-zone profile": {f"{ESTIMATOR}.with_dead_zone_profile": _unchanged},
    "lags by their squares": {f"{ESTIMATOR}.with_lag_by_square": _unchanged},
}


@dataclass(frozen=True)
class Row:
    """Figures of one identification."""

    group: str
    passes: float  # full, over all recordings
    seconds: float  # of CPU
    off: tuple[float, ...]  # errors in standard errors; of the ship, its three ratios
    refused: bool = False


def work(branch: str, group: str, name: str, seed: int) -> Row:
    """One identification with a branch off."""
    with contextlib.ExitStack() as off:
        for target, other in BRANCHES[branch].items():
            off.enter_context(patch(target, other))
        poses = off.enter_context(_counted())
        begin = time.process_time()
        try:
            found, whole = DATA[group](name, seed)
        except SeatrialError:
            return Row(group, 0.0, 0.0, (), refused=True)
        return Row(group, sum(poses) / whole, time.process_time() - begin, tuple(found))


@contextlib.contextmanager
def _counted() -> Iterator[list[int]]:
    """Poses of all full passes inside."""
    poses: list[int] = []
    plain = _core.innovations

    def counting(*args: Any, **options: Any) -> _core.FilterRun:  # noqa: ANN401
        run = plain(*args, **options)
        poses.append(len(run.weight))
        return run

    with patch.object(_core, "innovations", counting):
        yield poses


def _recovered(name: str, seed: int) -> tuple[list[float], int]:
    """A scene of the recovery gate, or one with correlated pose errors."""
    if name in scenes():
        scene = scenes()[name]
        made, plan = scene.trials(seed), scene.plan
        vehicle = vehicle_of(scene.allocations[0])
        recordings = [trial.recording for trial in made.values()]
    else:
        drives, plan = trials(name, seed, TRAINING), load_plan("hard")
        vehicle = drives[TRAINING[0]].vehicle
        recordings = [drives[each].recording for each in TRAINING]
    model = output_error(recordings, vehicle)
    truth = true_parameters(plan, model.parameters)
    errors = np.array([model.standard_errors[n] for n in model.parameters])
    values = np.concatenate([model.coefficients, model.constants])
    known = errors > 0.0
    return ((values - truth)[known] / errors[known]).tolist(), sum(len(r.t) for r in recordings)


def _drawn(_: str, seed: int) -> tuple[list[float], int]:
    """A boat of the fleet gate."""
    row = identified(seed)
    if row.refused:
        raise SeatrialError(row.refused)
    return list(row.off.values()), 1


def _ship(left_out: str, _: int) -> tuple[list[float], int]:
    """The real ship, one run left out."""
    vehicle = seatrial.load_vehicle(SHIP / "vehicle.yaml")
    runs = {n: seatrial.read(SHIP / "csv" / f"CSE1_data_{n}.csv", vehicle) for n in RUNS}
    others = [run for name, run in runs.items() if name != left_out]
    model = output_error(others, vehicle)
    truth = cse1.reference(runs[left_out])
    found = cse1.ratios(model, runs[left_out], truth, truth, 1.0)
    return found.tolist(), sum(len(r.t) for r in others)


DATA = {
    "still": _recovered,
    "pushed": _recovered,
    "correlated": _recovered,
    "fleet": _drawn,
    "ship": _ship,
}


def jobs(given: argparse.Namespace) -> list[tuple[str, str, str, int]]:
    """Branch, group, name and seed of every identification."""
    branches = given.branches.split(",") if given.branches else list(BRANCHES)
    groups = {"still": STILL, "pushed": PUSHED, "correlated": tuple(CORRELATED[n] for n in SCENES)}
    seeds = range(FIRST, FIRST + given.seeds)
    found = []
    for branch in dict.fromkeys([ALL, *branches]):
        found += [
            (branch, g, name, s) for g, names in groups.items() for name in names for s in seeds
        ]
        found += [(branch, "fleet", "", s) for s in range(1, given.boats + 1)]
        found += [] if given.no_ship else [(branch, "ship", name, 0) for name in RUNS]
    return found


def summary(done: Sequence[tuple[str, Row]]) -> str:
    """One line for each branch."""
    head = ["off", "CPU s", "refused"]
    head += [f"{g}: RMS, covered" for g in DATA if g != "ship"] + ["ship: passes, u / v / r"]
    rows = []
    for branch in dict.fromkeys(branch for branch, _ in done):
        own = [row for name, row in done if name == branch]
        cells = [branch, f"{sum(r.seconds for r in own):.0f}", str(sum(r.refused for r in own))]
        for group in DATA:
            there = [r for r in own if r.group == group and not r.refused]
            off = np.array([z for r in there for z in r.off])
            if not len(off):
                cells.append("")
            elif group == "ship":
                ratios = " / ".join(f"{x:.2f}" for x in off.reshape(len(there), 3).mean(axis=0))
                cells.append(f"{np.mean([r.passes for r in there]):.0f}, {ratios}")
            else:
                inside = 100.0 * np.mean(np.abs(off) < NORMAL_95)
                cells.append(f"{np.sqrt(np.mean(off**2)):.2f}, {inside:.1f} %")
        rows.append(cells)
    return table(head, rows)


def main(arguments: Sequence[str]) -> None:
    """Run all, print the table."""
    parser = command.parser("ablation", __doc__)
    parser.add_argument("--seeds", type=int, default=4, help=f"of each scene, from {FIRST} on")
    parser.add_argument("--boats", type=int, default=12, help="of the fleet")
    parser.add_argument("--branches", help=f"with commas, of {', '.join(BRANCHES)}; default all")
    parser.add_argument("--no-ship", action="store_true", help="without the real ship")
    command.with_workers(parser)
    given = parser.parse_args(arguments)
    wanted = jobs(given)
    rows = gathered(work, wanted, given.workers)
    print(summary([(job[0], row) for job, row in zip(wanted, rows, strict=True)]))


if __name__ == "__main__":
    main(sys.argv[1:])
