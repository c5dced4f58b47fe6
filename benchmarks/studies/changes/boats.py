# SPDX-License-Identifier: MIT
"""The paper's boat with a payload, a weak thruster or a low battery, and its drives."""

from collections.abc import Callable
from dataclasses import dataclass

from seatrial.boat.model import Model
from seatrial.boat.schema import ChainGroup
from seatrial.evaluation.comparison.cause_candidates import BATTERY, MASS, OFF_CENTRE, ONE_THRUSTER
from seatrial.identification.estimator import output_error
from seatrial.simulation.plan import DisturbanceForce, PlanFile
from seatrial.simulation.trials import Trial
from tests.boats.plans import planned
from tests.boats.scenes import FORCE, TRAINING, driven, pushed, vehicle_of

FIRST, AFTER = 3001, 6001  # seeds of S1 to S3, and of S7
DRIVE = "S7"
SECONDS = 140.0  # of S7
MORE, WEAK, LOW = 1.2, 0.6, 0.85  # of the mass, one thruster, the thrust of all
WEAK_THRUSTER = "F_2"
SHIFT = 0.17  # [rad/m] of N_ud: a sixth of the mass 5 cm aside, for a radius of gyration of 0.22 m


@dataclass(frozen=True)
class Change:
    """A change of the boat, what a detector may call it, and its size."""

    of: Callable[[PlanFile], PlanFile]
    causes: tuple[str, ...]
    size: float  # [-]
    what: str
    further: bool = False  # of fewer seeds


def heavier(plan: PlanFile, shift: float = 0.0) -> PlanFile:
    """A fifth more mass and inertia, off centre by `shift` of N_ud."""
    values = {name: value / MORE for name, value in plan.plant.coefficients.items()}
    values["N_ud"] += shift
    return planned(plan, coefficients=values)


def weaker(plan: PlanFile, share: float) -> PlanFile:
    """Less thrust of all thrusters."""
    values = {
        n: v * (share if n.endswith("_F") else 1.0) for n, v in plan.plant.coefficients.items()
    }
    return planned(plan, coefficients=values)


def damaged(plan: PlanFile) -> PlanFile:
    """Less thrust of one thruster."""
    mean = (3.0 + WEAK) / 4.0
    names = [f"F_{i}" for i in range(1, 5)]
    gains = {name: (WEAK if name == WEAK_THRUSTER else 1.0) / mean for name in names}
    chain = [*plan.plant.chain, ChainGroup(name="weak", gains=gains)]
    return planned(weaker(plan, mean), plant={"chain": chain})


CHANGES = {
    "+20 % mass": Change(heavier, (MASS,), MORE - 1.0, "mass"),
    "+20 % mass, 5 cm aside": Change(
        lambda plan: heavier(plan, SHIFT), (MASS, OFF_CENTRE), MORE - 1.0, "mass"
    ),
    "one thruster of four at 60 %": Change(damaged, (ONE_THRUSTER,), WEAK - 1.0, WEAK_THRUSTER),
    "thrust of all at 85 %": Change(
        lambda plan: weaker(plan, LOW), (BATTERY,), LOW - 1.0, "thrust", further=True
    ),
}


def identified(seed: int) -> Model:
    """A model of S1 to S3, with a disturbance force of 4 % of full thrust."""
    trials = driven(pushed("hard", FORCE), vehicle_of("MP"), FIRST + seed, TRAINING)
    return output_error([trial.recording for trial in trials.values()], vehicle_of("MP"))


def unseen(
    change: Callable[[PlanFile], PlanFile] | None,
    seed: int,
    force: DisturbanceForce = FORCE,
    seconds: float = SECONDS,
) -> Trial:
    """The first seconds of S7 with the changed boat; None: the same boat."""
    plan = pushed("hard", force)
    plan = plan if change is None else change(plan)
    short = planned(plan, DRIVE, seconds=seconds)
    return driven(short, vehicle_of("MP"), AFTER + seed)[DRIVE]
