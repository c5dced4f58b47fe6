# SPDX-License-Identifier: MIT
"""A carrier with slipping wheels that follows the boat along the bundled S7, simulated."""

from dataclasses import dataclass

import numpy as np

import seatrial
from seatrial.simulation.mimic import Carrier, Mimic, Motion
from seatrial.simulation.trials import Trial, plant_model, simulate
from seatrial.util.frames import Array
from tests.boats.mecanum import Ground, SimulatedCarrier
from tests.boats.plans import planned

DT = 0.02  # [s] of the carrier's velocities


@dataclass(frozen=True)
class Run:
    """Paths of a carrier and of the boat."""

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
    plan, vehicle = planned("clean", "S7", seconds=duration), seatrial.load_vehicle("mallard-mp")
    return plant_model(plan, vehicle), next(iter(simulate(plan, vehicle)))


def follow(
    model: seatrial.Model, trial: Trial, ground: Ground, carrier: Carrier, seed: int = 1
) -> Run:
    """The carrier starts where the boat does, and gets the trial's commands when the boat did."""
    mimic, robot = Mimic(model, carrier), SimulatedCarrier(ground, DT, seed)
    commands = list(zip(trial.command_stamps * 1e-9, trial.command, strict=True))[::-1]
    mimic.pose(float(commands[-1][0]), robot.eta)
    t = np.arange(0.0, trial.truth_t[-1], DT)
    path, motions = [], []
    for now in t.tolist():
        while commands and commands[-1][0] <= now:
            mimic.command(*commands.pop())
        for stamp, pose in robot.poses():
            mimic.pose(stamp, pose)
        motions.append(mimic.at(now))
        path.append(robot.eta)
        robot.step(motions[-1].velocity)
    truth = np.column_stack([trial.truth[:, :2], np.unwrap(trial.truth[:, 2])])
    boat = np.column_stack([np.interp(t, trial.truth_t, column) for column in truth.T])
    return Run(np.array(path), boat, motions)
