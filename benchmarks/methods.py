# SPDX-License-Identifier: MIT
"""Gate: every method on the same simulated trials: what it finds of the boat, how it predicts, how long it takes.

    python -m benchmarks.methods
    python -m benchmarks.methods --pushed          # by a force of 4 % of full thrust that no model knows
    python -m benchmarks.methods --seeds 8 --presets hard
    python -m benchmarks.methods --write           # into docs/choose.md

Trained on S1-S3, tested on S7 one second ahead, from the true velocities against the true ones.
Under always-forward allocation the truth of a force coefficient is the gain past the dead zone's
edge. Times are of the CPU, of one thread after the other.
"""

import sys
import time
from collections.abc import Iterable, Sequence
from functools import cache

import numpy as np

import seatrial
from benchmarks.harness import command
from benchmarks.harness.page import refill
from benchmarks.studies.changes.boats import weaker
from seatrial.boat.vehicle import load_vehicle
from seatrial.evaluation.prediction import predict
from seatrial.identification.methods import METHODS
from seatrial.simulation.plan import PlanFile, load_plan
from seatrial.simulation.trials import Trial, plant_model
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Array
from tests.boats.scenes import TRAINING, UNSEEN, driven
from tests.boats.scenes import pushed as with_force

FIRST = 2001  # seed
WEAK = "N_ud"  # weakly excited in the paper's trials: listed apart


@cache
def trials(
    preset: str, name: str, seed: int, *, pushed: bool = False
) -> tuple[tuple[Trial, ...], Trial]:
    """Those to train on, and the one to test on; the same for every method."""
    plan = with_force(preset) if pushed else preset
    *known, unseen = driven(plan, load_vehicle(name), seed, (*TRAINING, UNSEEN)).values()
    return tuple(known), unseen


def errors(values: dict[str, float], plan: PlanFile, gain: float) -> dict[str, float]:
    """Relative errors by coefficient; a force's truth is the gain past the dead zone's edge."""
    truth = weaker(plan, gain).plant.coefficients
    return {name: values[name] / truth[name] - 1.0 for name in truth}


def rows(presets: Iterable[str], seeds: int, *, pushed: bool) -> Iterable[str]:
    """One line of the table for every preset, allocation and method."""
    for preset in presets:
        for name in ("mallard-mp", "mallard-af"):
            for method in METHODS:
                yield row(preset, name, method, seeds, pushed=pushed)


def row(preset: str, name: str, method: str, seeds: int, *, pushed: bool = False) -> str:
    """One line of the table."""
    vehicle = load_vehicle(name)
    off: list[dict[str, float]] = []
    ahead: list[Array] = []
    spent: list[float] = []
    failed = 0
    for seed in range(FIRST, FIRST + seeds):
        plan = load_plan(preset)
        known, unseen = trials(preset, name, seed, pushed=pushed)
        begin = time.process_time()
        try:
            model = seatrial.identify([t.recording for t in known], vehicle, method=method)
            spent.append(time.process_time() - begin)
            found = predict(model, unseen.recording, 1.0, velocities=unseen.true_motion)
        except SeatrialError:
            failed += 1
            continue
        edges = any(n.startswith("edge") for n in model.vehicle.constants.names)
        plant = plant_model(plan, vehicle)
        constants = dict(zip(plant.vehicle.constants.names, plant.constants.tolist(), strict=True))
        edge = constants.get("edge_forward", 0.0)
        gain = 1.0 if edges or name.endswith("mp") else 1.0 / (1.0 - edge)
        off.append(errors(model.values, plan, gain))
        ahead.append(np.sqrt(np.mean(found.errors**2, axis=0)))
    head = f"| {preset}{', pushed' if pushed else ''} | {name[-2:].upper()} | {method} |"
    if not off:
        return f"{head} no model | | | | | {failed} |"
    table = {n: 100 * np.sqrt(np.mean([o[n] ** 2 for o in off])) for n in off[0]}
    worst = max((n for n in table if n != WEAK), key=lambda n: table[n])
    u, v, r = np.sqrt(np.mean(np.square(ahead), axis=0)) * (100.0, 100.0, 1.0)
    return (
        f"{head} {_two(np.median([table[n] for n in table if n != WEAK]))} | "
        f"{_two(table[worst])} ({worst}) | {_two(table[WEAK])} | {_two(u)}, {_two(v)}, {_two(r)} | "
        f"{np.median(spent):.2g} | {failed} |"
    )


def _two(value: float) -> str:
    """Two digits, without powers of ten."""
    return f"{float(f'{value:.2g}'):.10g}"


def main(arguments: Sequence[str]) -> None:
    """Print the table."""
    parser = command.parser("methods", __doc__)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--presets", nargs="+", default=["paper-like", "hard"])
    parser.add_argument("--pushed", action="store_true", help="by an unmodelled force")
    parser.add_argument("--write", action="store_true", help="into docs/choose.md, too")
    given = parser.parse_args(arguments)
    lines = [
        "| preset | allocation | method | RMS error of coefficients, %: median | worst | N_ud | "
        "S7, 1 s ahead: u, v (cm/s), r (rad/s) | CPU, s | failed |",
        "| --- | --- | --- | ---: | --- | ---: | --- | ---: | ---: |",
    ]
    print("\n".join(lines))
    for line in rows(given.presets, given.seeds, pushed=given.pushed):
        print(line, flush=True)
        lines.append(line)
    if given.write:
        name = "methods-pushed" if given.pushed else "methods"
        refill(command.DOCS / "choose.md", {name: "\n".join(lines)})


if __name__ == "__main__":
    main(sys.argv[1:])
