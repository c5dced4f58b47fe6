# SPDX-License-Identifier: MIT
"""Gate: what each branch of the estimator is for: every figure with that branch off, beside the figure with all.

    python -m benchmarks.ablation run    # goes on where it was stopped
    python -m benchmarks.ablation run --branches "fit horizon,noise structures" --groups ship
    python -m benchmarks.ablation tables
    python -m benchmarks.ablation write    # into its page in docs/

A branch that moves no figure has no place in the estimator. Figures: full filter passes and CPU seconds; of
simulated boats (still, pushed, with correlated pose errors, drawn at random, with a lever arm) errors in standard
errors, RMS, and coverage of 95 % intervals; of the real ship the error one second ahead on the run left out, over
that of a velocity that stays constant; the same with `structure: auto`.
"""

import argparse
import contextlib
import sys
import time
from collections.abc import Iterator, Sequence
from typing import Any
from unittest.mock import patch

import numpy as np

import seatrial
from benchmarks import cse1
from benchmarks.fleet.draw import draw
from benchmarks.fleet.work import in_errors
from benchmarks.guided import moved
from benchmarks.harness import command, store
from benchmarks.harness.markdown import table
from benchmarks.harness.page import refill
from benchmarks.harness.store import Record
from seatrial import _core
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.diagnostics.unmodelled_effects import Unmodelled
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.identification.likelihood import noise_structures
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.likelihood.optimiser import Damping
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Array
from seatrial.util.statistics import NORMAL_95
from tests.boats.drives import CORRELATED, RUNS, SCENES, SHIP, trials
from tests.boats.scenes import TRAINING, load_plan, scenes, true_parameters, vehicle_of

ALL = "everything on"
FIRST = 1001  # seed
STILL = ("paper-like MP", "hard AF")
PUSHED = ("hard MP pushed",)
PAGE = command.DOCS / "decisions" / "0014-what-each-branch-is-for.md"
IDENTIFICATION = "seatrial.identification"
LIKELIHOOD = f"{IDENTIFICATION}.likelihood"
ESTIMATOR = f"{IDENTIFICATION}.estimator"
SELECTION = f"{IDENTIFICATION}.selection.actuator_selection"
ERRORS = f"{IDENTIFICATION}.uncertainty.estimation_errors"


def _same(at: Point, *_: object) -> Point:
    return at


def _none(*_: object, **__: object) -> list[Any]:
    return []


def _nothing(*_: object) -> None:
    return None


def _unchanged(_: Point, covariance: Array) -> Array:
    return covariance


def _never(*_: object) -> bool:
    return False


class _GrowingDamping(Damping):
    """Damping that grows without regard to how far a trial failed (Nielsen's)."""

    def after_none(self, ratio: float) -> None:
        """After a trial without a fall."""
        del ratio
        self.value, self.growth = self.growth * max(self.value, 1e-3), 2.0 * self.growth


def _with_process_noise_only(*args: Any, poses_only: bool) -> list[Any]:  # noqa: ANN401
    return [] if poses_only else noise_structures.screened(*args, poses_only=False)


def _no_addition(_: Point, __: int, inside: Array, *___: object) -> Array:
    return np.zeros((len(inside),) * 2)


EQUAL_STRUCTURES = tuple(s for s in noise_structures.STRUCTURES if not s.unequal)

# what stands in a branch's place where it is off
BRANCHES: dict[str, dict[str, Any]] = {
    ALL: {},
    "noise structures": {f"{LIKELIHOOD}.fit_horizon.screened": _none},
    "pose errors alone": {f"{LIKELIHOOD}.fit_horizon.screened": _with_process_noise_only},
    "frame of the disturbance": {
        f"{LIKELIHOOD}.noise_structures.in_likelier_frame": _same,
        f"{LIKELIHOOD}.fit_horizon.in_likelier_frame": _same,
    },
    "longer memory of pose errors": {f"{LIKELIHOOD}.noise_structures.with_longer_memory": _same},
    "unequal surge and sway": {
        f"{ESTIMATOR}.with_unequal_axes": _same,
        f"{LIKELIHOOD}.noise_structures.STRUCTURES": EQUAL_STRUCTURES,
    },
    "fewer noise sources": {f"{LIKELIHOOD}.noise_structures.simplified": _same},
    "fit horizon": {f"{LIKELIHOOD}.fit_horizon._best_predicting": _nothing},
    "longer fit horizon": {f"{LIKELIHOOD}.fit_horizon.FIT_HORIZONS": (0.8,)},
    "much process noise far off": {f"{LIKELIHOOD}.optimiser.far_from_poses": _never},
    "damping by a failed trial": {f"{LIKELIHOOD}.optimiser.Damping": _GrowingDamping},
    "noise halfway after a failure": {
        f"{LIKELIHOOD}.optimiser._halfway": lambda _, __, least: least
    },
    "fewer poses in searches": {f"{IDENTIFICATION}.pose_rate.SEARCH_RATE": np.inf},
    "actuator stages": {f"{ESTIMATOR}.select_stages": lambda at, *_: (at, [])},
    "stages by a fit": {f"{SELECTION}._by_fit": lambda *_: (None, None)},
    "dead-zone profile": {f"{ERRORS}.with_dead_zone_profile": _unchanged},
    "lags by their squares": {f"{ERRORS}.with_lag_by_square": _unchanged},
    "profile at a bound": {
        f"{IDENTIFICATION}.uncertainty.covariance.one_sided_profile": _no_addition
    },
    "diagnostics": {
        f"{ESTIMATOR}.unmodelled_effect": lambda *_: Unmodelled(()),
        f"{ESTIMATOR}.change_findings": _none,
        f"{ESTIMATOR}.disturbance_findings": _none,
    },
}


def work(branch: str, group: str, name: str, seed: int) -> Record:
    """One identification with a branch off: full passes over all recordings, CPU seconds, errors."""
    record: Record = {"branch": branch, "group": group}
    with contextlib.ExitStack() as off:
        for target, other in BRANCHES[branch].items():
            off.enter_context(patch(target, other))
        poses = off.enter_context(_counted())
        begin = time.process_time()
        try:
            found, whole = DATA[group](name, seed)
        except SeatrialError as error:
            return record | {"failed": str(error)}
        seconds = time.process_time() - begin
    return record | {"passes": sum(poses) / whole, "seconds": seconds, "off": found}


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
    errors = in_errors(model, dict(zip(model.parameters, truth.tolist(), strict=True)))
    return [*errors.values()], sum(len(r.t) for r in recordings)


def _drawn(effect: str, seed: int) -> tuple[list[float], int]:
    """A boat of the fleet gate, or the same with a lever arm."""
    boat = draw(seed)
    vehicle, recordings = boat.trials()
    if effect:
        length = float(np.hypot(*np.ptp([place[:2] for place in boat.hull.places], axis=0)))
        recordings = [moved(r, effect, length, seed) for r in recordings]
    settings = OutputErrorSettings(effects=(effect,) if effect else ())
    model = output_error(recordings, vehicle, settings=settings)
    return [*in_errors(model, boat.truth).values()], sum(len(r.t) for r in recordings)


def _ship(left_out: str, _: int) -> tuple[list[float], int]:
    """The real ship, one run left out."""
    return _left_out(seatrial.load_vehicle(SHIP / "vehicle.yaml"), left_out)


def _by_itself(left_out: str, _: int) -> tuple[list[float], int]:
    """The same, the terms chosen by the recordings; of all runs only the passes are of interest."""
    vehicle = seatrial.load_vehicle(SHIP / "vehicle.yaml")
    return _left_out(vehicle.with_automatic_structure(), left_out)


def _left_out(vehicle: Vehicle, left_out: str) -> tuple[list[float], int]:
    """Errors one second ahead on the ship's run that is left out, if any, over those of a constant velocity."""
    runs = {n: seatrial.read(SHIP / "csv" / f"CSE1_data_{n}.csv", vehicle) for n in RUNS}
    tested = runs.pop(left_out, None)
    model = seatrial.identify(list(runs.values()), vehicle)
    found: list[float] = []
    if tested is not None:
        truth = cse1.reference(tested)
        found = cse1.ratios(model, tested, truth, truth, 1.0).tolist()
    return found, sum(len(r.t) for r in runs.values())


DATA = {
    "still": _recovered,
    "pushed": _recovered,
    "correlated": _recovered,
    "fleet": _drawn,
    "lever": _drawn,
    "ship": _ship,
    "auto": _by_itself,
}
OF_SHIP = ("ship", "auto")


def jobs(given: argparse.Namespace) -> list[tuple[str, str, str, int]]:
    """Branch, group, name and seed of every identification."""
    seeds, boats = range(FIRST, FIRST + given.seeds), range(1, given.boats + 1)
    correlated = tuple(CORRELATED[n] for n in SCENES)
    runs = {
        "still": [(n, s) for n in STILL for s in seeds],
        "pushed": [(n, s) for n in PUSHED for s in seeds],
        "correlated": [(n, s) for n in correlated for s in seeds],
        "fleet": [("", s) for s in boats],
        "lever": [("lever", s) for s in boats],
        "ship": [(n, 0) for n in RUNS],
        "auto": [(n, 0) for n in (*RUNS, "")],
    }
    return [
        (branch, group, *run)
        for branch in (given.branches or list(BRANCHES))
        for group in (given.groups or list(DATA))
        for run in runs[group]
    ]


def summary(records: Sequence[Record]) -> str:
    """One line for each branch: its figures on what was identified with it off, with everything on in brackets."""
    head = ["off", "passes", "CPU", "refused"]
    head += [f"{g}: {'u / v / r' if g in OF_SHIP else 'RMS, covered'}" for g in DATA]
    known = {(r["branch"], *r["job"][1:]): r for r in records}
    rows = []
    for branch in BRANCHES:
        jobs_done = [job for b, *job in known if b == branch and (ALL, *job) in known]
        if not jobs_done:
            continue
        own, every = ([known[(b, *job)] for job in jobs_done] for b in (branch, ALL))
        cells = [_ratio(own, every, "passes"), _ratio(own, every, "seconds")]
        for with_it, without in zip(_figures(every), _figures(own), strict=True):
            same = "same" if with_it else ""
            cells.append(
                without
                if branch == ALL
                else same
                if with_it == without
                else f"{without} ({with_it})"
            )
        rows.append([branch, *cells])
    return table(head, rows)


def passes_line(records: Sequence[Record]) -> str:
    """Full passes of an identification with everything on, by group."""
    whole = [r for r in records if r["branch"] == ALL and "passes" in r]
    found = {g: [r["passes"] for r in whole if r["group"] == g] for g in DATA}
    means = [f"{group} {np.mean(own):.0f}" for group, own in found.items() if own]
    return f"full passes of an identification, mean: {', '.join(means)}"


def _ratio(own: Sequence[Record], every: Sequence[Record], what: str) -> str:
    """Of sums over what was identified by both."""
    both = [(a[what], b[what]) for a, b in zip(own, every, strict=True) if what in a and what in b]
    off, on = np.array(both).reshape(-1, 2).sum(axis=0)
    return f"{off / on:.2f}"


def _figures(own: Sequence[Record]) -> list[str]:
    """Refusals, then the figures of each group; empty: nothing of it was identified."""
    done = [r for r in own if "failed" not in r]
    cells = [str(len(own) - len(done))]
    for group in DATA:
        there = [r["off"] for r in done if r["group"] == group]
        off = np.array([z for each in there for z in each])
        if not len(off):
            cells.append("")
        elif group in OF_SHIP:
            cells.append(" / ".join(f"{x:.3f}" for x in off.reshape(-1, 3).mean(axis=0)))
        else:
            inside = 100.0 * np.mean(np.abs(off) < NORMAL_95)
            cells.append(f"{np.sqrt(np.mean(off**2)):.3f}, {inside:.1f} %")
    return cells


def _listed(text: str) -> list[str]:
    return text.split(",")


def main(arguments: Sequence[str]) -> None:
    """Run, print the table, or write it."""
    parser = command.parser("ablation", __doc__)
    parser.add_argument("verb", choices=("run", "tables", "write"))
    command.with_results(parser, "build/ablation.jsonl")
    command.with_seeds(parser, 4, FIRST)
    parser.add_argument("--boats", type=int, default=12, help="of the fleet")
    parser.add_argument("--branches", type=_listed, help=f"of {', '.join(BRANCHES)}; default all")
    parser.add_argument("--groups", type=_listed, help=f"of {', '.join(DATA)}; default all")
    given = parser.parse_args(arguments)
    present = store.code("ablation")
    if given.verb == "run":
        store.run(given.results, jobs(given), work, present, given.workers)
        return
    records = store.chosen(store.read(given.results), present, any_code=given.any_code)
    text = summary(records)
    print(text)
    print(passes_line(records))
    if given.verb == "write":
        refill(PAGE, {"ablation": text})


if __name__ == "__main__":
    main(sys.argv[1:])
