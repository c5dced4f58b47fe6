# SPDX-License-Identifier: MIT
"""How near a carrier with slipping wheels comes to the boat: the whole of the bundled S7, simulated.

python -m benchmarks.mimic              # the table
python -m benchmarks.mimic --write      # into docs/mimic.md
"""

import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import msgspec
import numpy as np

import seatrial
from benchmarks.blocks import fill
from seatrial.frames import Array
from seatrial.mimic import Carrier, Mimic, Motion
from seatrial.mimic.wheels import Ground, SimulatedCarrier
from seatrial.plan import load_plan
from seatrial.simulate import Trial, plant_model, simulate

PAGE = Path(__file__).parents[1] / "docs" / "mimic.md"
DT = 0.02  # [s] of the carrier's velocities
LAG = 0.14  # [s] the ground's lag and delay
SEEDS = (1, 2, 3)
NO_LIMIT = 1e3  # [m]
CASES = {
    "the carrier's own localisation, 5 mm and 10 mrad at 20 Hz, 60 ms late": (
        Ground(), Carrier(lag=LAG),
    ),
    "the same, without the lead": (Ground(), Carrier(lag=0.0)),
    "no way back to the pose": (Ground(), Carrier(lag=LAG, gain=0.0, lost=NO_LIMIT)),
    "an odometry that counts the wheels' turns": (
        Ground(sees_slip=False), Carrier(lag=LAG, lost=NO_LIMIT),
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Run:
    """A carrier's way beside the boat's."""

    carrier: Array  # (n, 3) true
    boat: Array  # (n, 3) true
    motions: list[Motion]

    @property
    def distance(self) -> Array:
        """(n,) [m] of the carrier from where the boat was then."""
        return np.asarray(np.hypot(*(self.carrier - self.boat)[:, :2].T))

    @property
    def off(self) -> tuple[float, float]:
        """RMS of distance [m] and heading [rad]."""
        turn = self.carrier[:, 2] - self.boat[:, 2]
        return float(np.sqrt(np.mean(self.distance**2))), float(np.sqrt(np.mean(turn**2)))


def driven(duration: float | None = None) -> tuple[seatrial.Model, Trial]:
    """The bundled plan's boat and its S7, whole or its first so many seconds."""
    plan, vehicle = load_plan("clean"), seatrial.load_vehicle("mallard-mp")
    entry = plan.trials["S7"]
    entry = msgspec.structs.replace(entry, duration=duration or entry.duration)
    plan = msgspec.structs.replace(plan, trials={"S7": entry})
    return plant_model(plan, vehicle), next(iter(simulate(plan, vehicle)))


def follow(
    model: seatrial.Model, trial: Trial, ground: Ground, carrier: Carrier, seed: int = 1
) -> Run:
    """The carrier starts where the boat does, and hears the trial's commands as the boat did."""
    mimic, robot = Mimic(model, carrier), SimulatedCarrier(ground, DT, seed)
    commands = list(zip(trial.command_stamps * 1e-9, trial.command, strict=True))[::-1]
    mimic.pose(float(commands[-1][0]), robot.eta)
    t = np.arange(0.0, trial.truth_t[-1], DT)
    way, motions = [], []
    for now in t.tolist():
        while commands and commands[-1][0] <= now:
            mimic.command(*commands.pop())
        for stamp, pose in robot.poses():
            mimic.pose(stamp, pose)
        motions.append(mimic.at(now))
        way.append(robot.eta)
        robot.step(motions[-1].velocity)
    truth = np.column_stack([trial.truth[:, :2], np.unwrap(trial.truth[:, 2])])
    boat = np.column_stack([np.interp(t, trial.truth_t, column) for column in truth.T])
    return Run(np.array(way), boat, motions)


def table() -> str:
    """Position and heading over the seeds, case by case."""
    model, trial = driven()
    rows = ["| the carrier's poses | position RMS, cm | largest, cm | heading RMS, mrad |",
            "| --- | ---: | ---: | ---: |"]  # fmt: skip
    for name, (ground, carrier) in CASES.items():
        runs = [follow(model, trial, ground, carrier, seed) for seed in SEEDS]
        position, heading = np.sqrt(np.mean([np.square(run.off) for run in runs], axis=0))
        most = max(run.distance.max() for run in runs)
        rows.append(f"| {name} | {position * 100:.1f} | {most * 100:.1f} | {heading * 1000:.0f} |")
    return "\n".join(rows)


if __name__ == "__main__":
    if "--write" in sys.argv[1:]:
        fill(PAGE, {"follow": partial(str, table())})
    else:
        print(table())
