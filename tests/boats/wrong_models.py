# SPDX-License-Identifier: MIT
"""A boat seen by sensors of three kinds, and models that are wrong about it."""

from dataclasses import replace

import msgspec
import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.schema import ChainGroup, ProcessEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.simulation.plan import DisturbanceForce, DropOuts, Jumps
from seatrial.simulation.trials import Trial, plant_model, simulate
from tests.boats.plans import planned

SENSORS = {  # rate [Hz], noise of position [m] and heading [rad]
    "GNSS": (5.0, 0.02, 0.01),
    "motion capture": (10.0, 0.002, 0.003),
    "SLAM": (20.0, 0.005, 0.005),
}
FORCE = DisturbanceForce(share=0.04, correlation=2.0)
SURE = ProcessEntry(1e-9, 1e-9, 1e-9, 1e-9, 2.0)  # a model that is sure of itself
DRAG = ("X_u", "X_uu", "Y_v", "Y_vv", "N_r", "N_rr")
THRUST = ("X_F", "Y_F", "N_F")


def driven(
    boat: Vehicle,
    sensor: str,
    force: DisturbanceForce | None = FORCE,
    seconds: float = 200.0,
    correlation: float = 0.0,
) -> tuple[Model, Trial]:
    """The boat as a model, and S7 as the sensor sees it; `correlation` [s] of its errors."""
    rate, position, heading = SENSORS[sensor]
    pose = {
        "rate": rate, "position_noise": position, "heading_noise": heading, "stamp_jitter": 0.0,
        "drop_outs": DropOuts(0.0), "jumps": Jumps(0.0), "noise_correlation": correlation,
    }  # fmt: skip
    plan = planned(
        "paper-like", "S7", seconds=seconds, seed=11, pose=pose, plant={"unmodelled": force},
        joypad={"clock_offset": 0.0},
    )  # fmt: skip
    (trial,) = simulate(plan, boat)
    return plant_model(plan, boat), trial


def scaled(model: Model, **factors: float) -> Model:
    """The same with some coefficients times a factor."""
    values = [value * factors.get(name, 1.0) for name, value in model.values.items()]
    return replace(model, coefficients=np.array(values))


def later(model: Model, seconds: float) -> Model:
    """The same with latency."""
    (group,) = msgspec.to_builtins(model.vehicle.file.chain)
    given = {name: value for name, value in group.items() if value is not None}
    chain = [msgspec.convert(given | {"latency": seconds}, ChainGroup)]
    vehicle = model.vehicle.with_chain(chain)
    size = len(model.coefficients) + len(vehicle.constants.values)
    return replace(
        model,
        vehicle=vehicle,
        constants=vehicle.constants.values,
        covariance=np.zeros((size, size)),
    )


def variants(boat: Model) -> dict[str, Model]:
    """The right model, and wrong ones."""
    return {
        "right": boat,
        "drag": scaled(boat, **dict.fromkeys(DRAG, 1.3)),
        "mass": scaled(boat, **dict.fromkeys((*DRAG, *THRUST), 1 / 1.2)),
        "thrust": scaled(boat, **dict.fromkeys(THRUST, 0.8)),
        "latency": later(boat, 0.2),
    }
