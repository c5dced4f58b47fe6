# SPDX-License-Identifier: MIT
"""Boats whose coefficients are given, how commands move them, and recordings of that."""

from collections.abc import Mapping

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.schema import EnvelopeEntry, Integration, NoiseEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.simulation.trials import DisturbedPlant
from seatrial.util.frames import Array, body_velocity


def given_model(vehicle: Vehicle, values: Mapping[str, float], step: float = 1 / 240) -> Model:
    """A model without errors and noise, with the vehicle's own chain; step: [s]."""
    theta = np.array([values[name] for name in vehicle.structure.coefficients])
    none = np.zeros((len(theta) + len(vehicle.constants.names),) * 2)
    return Model(
        vehicle, theta, none, vehicle.constants.values, Integration("runge-kutta", step),
        NoiseEntry(0.0, 0.0), EnvelopeEntry({}, {}),
    )  # fmt: skip


def traced(model: Model, begin: Array, values: Array) -> _core.ThrustTrace:
    """Thrust by commands (m, inputs) from `begin` (m,) [s] on, without known signals."""
    none = np.zeros(0), np.zeros((0, 0))
    return _core.ThrustTrace(model.vehicle.chain, model.constants, begin, values, *none)


def states_at(
    model: Model, t: Array, begin: Array, values: Array, start: Array | None = None
) -> Array:
    """States (n, 6) at t (n,) [s] under commands as of `traced`; from rest at the origin unless `start` is given."""
    begun = np.zeros(6) if start is None else start
    return np.asarray(_core.simulate(model.boat, traced(model, begin, values), begun, t)[0])


def ticked(
    plant: DisturbedPlant, commands: Array, tick: float, wind: tuple[float, float] = (0.0, 0.0)
) -> Array:
    """States (n, 6) at every tick [s], before its command; wind: [m/s^2] steady and earth-fixed."""
    states = np.zeros((len(commands), 6))
    for i, row in enumerate(commands):
        plant.advance_to(i * tick)
        states[i] = plant.state
        if any(wind):
            state = plant.state
            state[3:5] += tick * body_velocity(state[2:3], np.array([[*wind, 0.0]]))[0, :2]
            plant.state = state
        plant.command(i * tick, np.ascontiguousarray(row))
    return states


def given_motion(vehicle: Vehicle, t: Array, eta: Array) -> Recording:
    """A recording of poses (n, 3) at t (n,) [s], without commands."""
    return recorded("given", vehicle, (t, eta), (t[:1], np.zeros((1, len(vehicle.inputs)))))


def recorded(
    name: str, vehicle: Vehicle, poses: tuple[Array, Array], commands: tuple[Array, Array]
) -> Recording:
    """A recording; poses and commands: stamps (n,) [s] and rows."""
    (t, eta), (begin, values) = poses, commands
    stamps, since = (np.round(1e9 * s).astype(np.int64) for s in (t, begin))
    return make_recording(name, stamps, eta, Signal(vehicle.inputs, since, values))
