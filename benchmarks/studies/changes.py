# SPDX-License-Identifier: MIT
"""Changes of a running boat: noticed, named, sized; false alarms without one. The table of docs/changes.md.

    python -m benchmarks.studies.changes --seeds 20
    python -m benchmarks.studies.changes --seeds 20 --write    # into the page

The paper's boat in its pool, with an unmodelled force of 4 % of full thrust; a model of S1 to S3, then S7 with the
changed boat. False alarms: S7 with the same boat, and with gusts of 12 %.
"""

import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import msgspec
import numpy as np

from benchmarks.harness import command
from benchmarks.harness.markdown import table
from benchmarks.harness.page import refill
from seatrial.boat.model import Model
from seatrial.boat.schema import ChainGroup
from seatrial.evaluation.comparison.cause_candidates import BATTERY, MASS, OFF_CENTRE, ONE_THRUSTER
from seatrial.identification.estimator import output_error
from seatrial.monitoring.change_detector import ChangeDetector
from seatrial.onboard.boat_change import BoatChange, ChangeState
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import DisturbanceForce, PlanFile
from tests.boats.scenes import FORCE, TRAINING, driven, pushed, vehicle_of

PAGE = Path(__file__).resolve().parents[2] / "docs" / "changes.md"
FIRST, AFTER = 3001, 6001  # seeds
MORE, WEAK, LOW = 1.2, 0.6, 0.85  # of the mass, one thruster, the thrust of all
SHIFT = 0.17  # [rad/m] of N_ud: a sixth of the mass 5 cm aside, for a radius of gyration of 0.22 m
SOON = 30.0  # [s]
GUSTS = DisturbanceForce(share=0.12, correlation=2.0)
NANO = 1e9
NOTICED = (
    "change", "noticed after (median)", f"within {SOON:.0f} s", "confirmed", "named rightly",
    "size in its 95 % interval",
)  # fmt: skip
ALARMS = "the same boat", "driven", "noticed", "confirmed", "CPU, of one core"
Row = list[str]


def heavier(plan: PlanFile, shift: float = 0.0) -> PlanFile:
    """A fifth more mass and inertia, off centre by `shift` of N_ud."""
    values = {name: value / MORE for name, value in plan.plant.coefficients.items()}
    values["N_ud"] += shift
    return _with(plan, values, [*plan.plant.chain])


def weaker(plan: PlanFile, share: float) -> PlanFile:
    """Less thrust of all thrusters."""
    values = {
        n: v * (share if n.endswith("_F") else 1.0) for n, v in plan.plant.coefficients.items()
    }
    return _with(plan, values, [*plan.plant.chain])


def damaged(plan: PlanFile) -> PlanFile:
    """Less thrust of one thruster."""
    mean = (3.0 + WEAK) / 4.0
    gains = {f"F_{i}": (WEAK if i == 2 else 1.0) / mean for i in range(1, 5)}
    other = weaker(plan, mean)
    chain = [*plan.plant.chain, ChainGroup(name="weak", gains=gains)]
    return _with(plan, dict(other.plant.coefficients), chain)


def _with(plan: PlanFile, values: dict[str, float], chain: list[ChainGroup]) -> PlanFile:
    plant = msgspec.structs.replace(plan.plant, coefficients=values, chain=chain)
    return msgspec.structs.replace(plan, plant=plant)


CHANGES: dict[str, tuple[Callable[[PlanFile], PlanFile], set[str], float]] = {
    "+20 % mass": (heavier, {MASS}, MORE - 1.0),
    "+20 % mass, 5 cm aside": (lambda p: heavier(p, SHIFT), {MASS, OFF_CENTRE}, MORE - 1.0),
    "one thruster of four at 60 %": (damaged, {ONE_THRUSTER}, WEAK - 1.0),
    "thrust of all at 85 %": (lambda p: weaker(p, LOW), {BATTERY}, LOW - 1.0),
}


def identified(seed: int) -> Model:
    """A model of S1 to S3."""
    trials = driven(pushed("hard", FORCE), vehicle_of("MP"), FIRST + seed, TRAINING)
    return output_error([trial.recording for trial in trials.values()], vehicle_of("MP"))


def unseen(plan: PlanFile, seed: int) -> Recording:
    """S7 of a plan."""
    return driven(plan, vehicle_of("MP"), AFTER + seed, ["S7"])["S7"].recording


def findings(model: Model, recording: Recording) -> list[BoatChange]:
    """What a detector reports along a recording, until a change is confirmed."""
    detector, signal = ChangeDetector(model), recording.commands
    rows = [(int(t), "command", v) for t, v in zip(signal.stamps, signal.values, strict=True)]
    rows += [(int(t), "pose", v) for t, v in zip(recording.stamps, recording.raw, strict=True)]
    found: list[BoatChange] = []
    for stamp, kind, values in sorted(rows, key=lambda row: row[:2]):
        detector.use(kind, stamp, values)
        change = detector.look() if kind == "pose" else None
        found += [] if change is None else [change]
        if change is not None and change.state is ChangeState.CONFIRMED:
            break
    return found


def changed(name: str, models: Sequence[Model]) -> Row:
    """One row of the table: a change of the boat, in every seed."""
    make, right, size = CHANGES[name]
    plan = make(pushed("hard", FORCE))
    seconds, named, errors, missed = [], 0, [], 0
    for seed, model in enumerate(models):
        recording = unseen(plan, seed)
        found = findings(model, recording)
        last = found[-1] if found and found[-1].state is ChangeState.CONFIRMED else None
        noticed = [c for c in found if c.state is ChangeState.NOTICED]
        seconds.append((noticed[0].stamp - recording.origin) / NANO if noticed else np.inf)
        missed += last is None
        if last is not None and last.cause in right:
            named += 1
            assert last.size is not None
            assert last.error is not None
            errors.append((last.size - size) / last.error)
    n = len(models)
    soon = np.mean(np.array(seconds) <= SOON)
    inside = np.mean(np.abs(errors) < 1.96) if errors else np.nan
    return [
        name, f"{np.median(seconds):.0f} s", f"{100 * soon:.0f} %", f"{100 * (n - missed) / n:.0f} %",
        f"{100 * named / n:.0f} %", f"{100 * inside:.0f} %",
    ]  # fmt: skip


def unchanged(name: str, force: DisturbanceForce, models: Sequence[Model]) -> Row:
    """False alarms, and what the tests cost."""
    hours = cost = 0.0
    noticed = confirmed = 0
    for seed, model in enumerate(models):
        recording = unseen(pushed("hard", force), seed)
        begin = time.process_time()
        found = findings(model, recording)
        cost += time.process_time() - begin
        hours += recording.duration / 3600.0
        noticed += sum(c.state is ChangeState.NOTICED for c in found)
        confirmed += sum(c.state is ChangeState.CONFIRMED for c in found)
    share = 100.0 * cost / (3600.0 * hours)
    return [name, f"{hours:.1f} h", str(noticed), str(confirmed), f"{share:.1f} %"]


def main(arguments: Sequence[str]) -> None:
    """Run, print, and write into the page on request."""
    parser = command.parser("studies.changes", __doc__)
    parser.add_argument("--seeds", type=int, default=20, help=f"from {FIRST} and {AFTER} on")
    parser.add_argument("--write", action="store_true", help="into the page")
    given = parser.parse_args(arguments)
    models = [identified(seed) for seed in range(given.seeds)]
    first = table(NOTICED, [changed(name, models) for name in CHANGES])
    forces = {"disturbance force of 4 % of full thrust": FORCE, "of 12 %": GUSTS}
    second = table(ALARMS, [unchanged(name, force, models) for name, force in forces.items()])
    print(first, second, sep="\n\n")
    if given.write:
        refill(PAGE, {"changes": first, "alarms": second})


if __name__ == "__main__":
    main(sys.argv[1:])
