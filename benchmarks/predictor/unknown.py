# SPDX-License-Identifier: MIT
"""A current that the filter does not know: how often poses reinitialise it, and its errors."""

from dataclasses import dataclass
from functools import cache

import numpy as np

import seatrial
from benchmarks.predictor.accuracy import SEED, rms
from seatrial.onboard.predictor import Health, Predictor
from seatrial.simulation import PoseReading, PoseSettings, Sensors, Simulator
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from seatrial.util.frames import Array
from tests.boats.drives import SCENES, SETTLED, model

CURRENTS = ((0.0, 0.0), (0.03, 0.02), (0.1, 0.05))  # [m/s]
DELAY = 0.05  # [s] from a pose's stamp to its arrival
TICK, HOLD = 0.02, 1.5  # [s] between commands; that one is held
MOST = 0.6  # of a full command
LASTS, FOUND = 180.0, 60.0  # [s] of the drive; until it should be used to the current


@dataclass(frozen=True)
class Outcome:
    """Tick by tick."""

    t: Array  # (n,) [s]
    pose: Array  # (n, 3) error [m, m, rad]
    velocity: Array  # (n, 3) error [m/s, m/s, rad/s]
    overruled: Array  # (k,) [s] when poses did
    doubted: bool  # whether the model is, at the end


@cache
def outcome(scene: str, current: tuple[float, float]) -> Outcome:
    """Random commands in open water."""
    plan = load_plan("hard")
    sensors = Sensors(pose=PoseSettings.of_plan(plan.pose, DELAY), imu=None, lidar=None)
    plant = plant_model(plan, seatrial.load_vehicle("mallard-mp"))
    boat = Simulator(plant, sensors=sensors, current=current, seed=SEED, radius=0.0)
    predictor, rng = Predictor(model(scene, SEED)), np.random.default_rng(SEED)
    n = round(LASTS / TICK)
    t, pose, velocity, begun = np.zeros(n), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n, bool)
    command = np.zeros(len(plant.vehicle.inputs))
    for i in range(n):
        if i % round(HOLD / TICK) == 0:
            command = rng.uniform(-MOST, MOST, len(command))
        boat.command(command)
        # as its trials were stamped
        predictor.command(boat.time + plan.joypad.clock_offset, command)
        for reading in boat.advance_to((i + 1) * TICK):
            if isinstance(reading, PoseReading):
                predictor.pose(reading.stamp, reading.eta)
        now = predictor.at(boat.time)
        t[i], pose[i], velocity[i] = boat.time, now.pose - boat.eta, now.velocity - boat.nu
        begun[i] = Health.REINITIALISED in now.health
    pose[:, 2] = np.angle(np.exp(1j * pose[:, 2]))
    overruled = t[np.flatnonzero(np.diff(begun.astype(int), prepend=0) == 1)]
    return Outcome(t, pose, velocity, overruled, Health.MODEL_DOUBTED in now.health)


def table() -> str:
    """Markdown."""
    rows = ["| model identified | current, m/s | reinitialised | last at, s | model doubted | "
            f"position error, mm: RMS | largest | after {FOUND:g} s: RMS | u, mm/s | v, mm/s |",
            "| --- | --- | ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: |"]  # fmt: skip
    for scene in SCENES:
        for current in CURRENTS:
            got = outcome(scene, current)
            off = 1e3 * np.hypot(got.pose[:, 0], got.pose[:, 1])
            settled, late = got.t > SETTLED, got.t > FOUND
            times = [
                str(len(got.overruled)),
                f"{got.overruled[-1]:.0f}" if len(got.overruled) else "-",
            ]
            errors = [float(rms(off[settled])), off[settled].max(), float(rms(off[late]))]
            errors += (1e3 * rms(got.velocity[late])[:2]).tolist()
            cells = [scene, f"{np.hypot(*current):.2g}", *times, "yes" if got.doubted else "no"]
            rows.append(f"| {' | '.join(cells + [f'{x:.2g}' for x in errors])} |")
    return "\n".join(rows)
