# SPDX-License-Identifier: MIT
"""The boat, its models, the courses and the conditions."""

from dataclasses import dataclass
from functools import cache

import seatrial
from seatrial.boat.model import Model
from seatrial.control import Circle, Course, Eight, Square, fitted
from seatrial.simulation import PoseSettings, Sensors
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model
from tests.boats.scenes import TRAINING, driven, pushed

SCHEMES = {"AF": "mallard-af", "MP": "mallard-mp"}
SLAM_DELAY = 0.05  # [s] from a pose's stamp to its arrival
SHAPES = {"circle": Circle(0.7), "eight": Eight(1.1, 0.45), "square": Square(1.2)}


@dataclass(frozen=True)
class Conditions:
    """What disturbs the boat and its poses."""

    plan: str  # whose SLAM it has; the model is identified with the same
    current: tuple[float, float] = (0.0, 0.0)  # [m/s] of the water


CONDITIONS = {
    "paper-like": Conditions("paper-like"),
    "hard": Conditions("hard"),
    "paper-like, current": Conditions("paper-like", (0.03, 0.02)),
}


@cache
def truth(scheme: str) -> Model:
    """The plan's plant: Table II with dead zone and lag."""
    return plant_model(load_plan("paper-like"), seatrial.load_vehicle(SCHEMES[scheme]))


@cache
def identified(scheme: str, plan: str) -> Model:
    """The model from the plan's S1 to S3, with an unmodelled force.

    Without one the model would state so little process noise that the predictor rejects poses in a current.
    """
    vehicle = seatrial.load_vehicle(SCHEMES[scheme])
    trials = driven(pushed(plan), vehicle, names=TRAINING)
    return seatrial.identify([t.recording for t in trials.values()], vehicle)


@cache
def course(shape: str) -> Course:
    """The same for both schemes: as quick as always-forward, the weaker one, allows."""
    return fitted(SHAPES[shape], truth("AF"))


def sensors(conditions: Conditions) -> Sensors:
    """Its SLAM."""
    plan = load_plan(conditions.plan)
    return Sensors(pose=PoseSettings.of_plan(plan.pose, SLAM_DELAY), imu=None, lidar=None)
