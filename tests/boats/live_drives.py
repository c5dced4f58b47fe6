# SPDX-License-Identifier: MIT
"""Drives that a live session identifies, and their rows in order of time."""

from collections.abc import Iterator

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import DisturbanceForce
from seatrial.simulation.trials import DisturbedPlant
from seatrial.util.frames import Array
from tests.boats.hulls import MIDDLE, STEP, driven
from tests.boats.motions import given_model, recorded, ticked
from tests.boats.vehicles import TWIN, TWIN_TRUTH, TWO_ASTERN, by_columns

CHAIN: list[dict[str, object]] = [{"latency": 0.06, "lag": 0.15}]
PUSH = DisturbanceForce(share=0.06, correlation=2.0)
GUSTS = DisturbanceForce(share=0.05, correlation=2.0, earth_fixed=True)
WIND = (0.012, -0.008)  # [m/s^2] steady, earth-fixed
WHITE = 2e-3  # [m, rad] of the poses
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
    return by_columns("twin", ("left", "right"), TWIN, forces=TWO_ASTERN, chain=chain or [])


def twin_in_wind(seconds: float, *, seed: int, rate: float = 20.0) -> tuple[Vehicle, Recording]:
    """A boat of two thrusters that drifts in steady wind with gusts."""
    true = twin(CHAIN)
    boat = given_model(true, TWIN_TRUTH, STEP)
    rng = np.random.default_rng(seed)
    commands = _pulses(rng, seconds)
    plant = DisturbedPlant(boat, GUSTS, np.random.default_rng([seed, 1]))
    states = ticked(plant, commands, TICK, WIND)
    at = np.round(np.arange(0.1, seconds - 0.1, 1.0 / rate) / TICK).astype(int)
    eta = states[at, :3] + WHITE * rng.normal(size=(len(at), 3))
    ticks = TICK * np.arange(len(commands))
    return twin(), recorded("twin", true, (ticks[at], eta), (ticks, commands))


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
