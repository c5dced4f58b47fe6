# SPDX-License-Identifier: MIT
"""Drives that a live session identifies, and their rows in order of time."""

from collections.abc import Iterator

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.schema import EnvelopeEntry, Integration, NoiseEntry
from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.simulation.plan import DisturbanceForce
from seatrial.simulation.trials import DisturbedPlant
from seatrial.util.frames import Array, body_velocity
from tests.boats.hulls import MIDDLE, STEP, driven

CHAIN: list[dict[str, object]] = [{"latency": 0.06, "lag": 0.15}]
PUSH = DisturbanceForce(share=0.06, correlation=2.0)
GUSTS = DisturbanceForce(share=0.05, correlation=2.0, earth_fixed=True)
WIND = (0.012, -0.008)  # [m/s^2] steady, earth-fixed
WHITE = 2e-3  # [m, rad] of the poses
TWIN_TRUTH = {
    "X_vr": 1.2, "X_u": -0.25, "X_uu": -1.0, "X_F": 0.5, "Y_ur": -0.6, "Y_v": -0.4, "Y_vv": -2.0,
    "N_r": -0.8, "N_rr": -0.5, "N_F": 1.5,
}  # fmt: skip
TICK = 0.02  # [s] of the sticks

Row = tuple[int, str, Array]


def holonomic(
    seconds: float, *, seed: int, rate: float = 20.0, push: DisturbanceForce | None = PUSH
) -> tuple[Vehicle, Recording]:
    """A boat of four thrusters, pushed, driven by pulses of every axis."""
    vehicle, (recording,) = driven(
        MIDDLE, CHAIN, seed=seed, push=push, white=WHITE, rate=rate, seconds=seconds, drives=1
    )
    return vehicle, recording


def twin(chain: list[dict[str, object]] | None = None) -> Vehicle:
    """A boat of two thrusters astern."""
    names = ("t", "x", "y", "psi", "left", "right")
    column = {name: {"column": name} for name in names}
    content = {
        "seatrial": "vehicle 1", "name": "twin", "axes": "forward-left-up", "chain": chain or [],
        "pose": {"stamp": column["t"], "x": column["x"], "y": column["y"], "psi": column["psi"]},
        "commands": {"stamp": column["t"], "inputs": {n: column[n] for n in ("left", "right")}},
        "forces": {
            "F_u": {"axis": "surge", "of": {"left": 0.5, "right": 0.5}},
            "F_r": {"axis": "yaw", "of": {"left": -0.5, "right": 0.5}},
        },
        "structure": {
            "surge": ["X_vr * v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
            "sway": ["Y_ur * u * r", "Y_v * v", "Y_vv * |v| * v"],
            "yaw": ["N_r * r", "N_rr * |r| * r", "N_F * F_r"],
        },
    }  # fmt: skip
    return vehicle_from(content, "twin")


def twin_in_wind(seconds: float, *, seed: int, rate: float = 20.0) -> tuple[Vehicle, Recording]:
    """A boat of two thrusters that drifts in steady wind with gusts."""
    true = twin(CHAIN)
    theta = np.array([TWIN_TRUTH[n] for n in true.structure.coefficients])
    size = len(theta) + len(true.constants.names)
    boat = Model(
        true, theta, np.zeros((size, size)), true.constants.values,
        Integration("runge-kutta", STEP), NoiseEntry(0.0, 0.0), EnvelopeEntry({}, {}),
    )  # fmt: skip
    rng = np.random.default_rng(seed)
    commands = _pulses(rng, seconds)
    plant = DisturbedPlant(boat, GUSTS, np.random.default_rng([seed, 1]))
    states = np.zeros((len(commands), 6))
    for i, row in enumerate(commands):
        plant.advance_to(i * TICK)
        state = states[i] = plant.state
        state[3:5] += TICK * body_velocity(state[2:3], np.array([[*WIND, 0.0]]))[0, :2]
        plant.state = state
        plant.command(i * TICK, np.ascontiguousarray(row))
    at = np.round(np.arange(0.1, seconds - 0.1, 1.0 / rate) / TICK).astype(int)
    eta = states[at, :3] + WHITE * rng.normal(size=(len(at), 3))
    stamps = np.round(1e9 * TICK * np.arange(len(commands))).astype(np.int64)
    return twin(), make_recording("twin", stamps[at], eta, Signal(true.inputs, stamps, commands))


def _pulses(rng: np.random.Generator, seconds: float) -> Array:
    """Commands (n, 2) at every tick: pulses of both thrusters, alike or not, with pauses."""
    out = np.zeros((round(seconds / TICK), 2))
    t = 1.0
    while t < seconds - 1.0:
        hold = rng.uniform(0.5, 3.0)
        common, turn = rng.uniform(-1.0, 1.0, 2) * (0.7, 0.5)
        out[round(t / TICK) : round((t + hold) / TICK)] = [common - turn, common + turn]
        t += hold + rng.uniform(0.0, 1.5)
    return np.clip(out, -1.0, 1.0)


def rows(recording: Recording, *, until: float = np.inf) -> Iterator[Row]:
    """Commands and poses up to a time [s], in order of their stamps."""
    commands = recording.commands
    found: list[Row] = [
        (int(s), "command", v) for s, v in zip(commands.stamps, commands.values, strict=True)
    ]
    found += [(int(s), "pose", v) for s, v in zip(recording.stamps, recording.raw, strict=True)]
    end = recording.origin + 1e9 * until
    yield from sorted((r for r in found if r[0] <= end), key=lambda r: (r[0], r[1]))
