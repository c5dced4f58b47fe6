# SPDX-License-Identifier: MIT
"""Boats of any geometry for the tests of thrust allocation, and their thrusts by the vehicle file's words."""

from dataclasses import dataclass

import msgspec
import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

import seatrial
from seatrial.boat.schema import AllocationEntry, ChainGroup, DeadZone, ThrusterEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.control.allocation import AllocatorScheme, effectiveness
from seatrial.util.errors import VehicleError

SCHEMES = [s.value for s in AllocatorScheme]
MALLARD = seatrial.load_vehicle("mallard-mp")


def boat(
    places: list[tuple[float, float, float]],
    chain: list[ChainGroup] | None = None,
    limit: float = 1.0,
    F_os: float = 0.0,
) -> Vehicle:
    """MallARD's file with other thrusters: x, y [m], angle [deg]."""
    return Vehicle(
        msgspec.structs.replace(
            MALLARD.file,
            thrusters={f"T_{i}": ThrusterEntry(*place) for i, place in enumerate(places)},
            chain=[] if chain is None else chain,
            allocation=AllocationEntry("moore-penrose", F_os, limit),
        ),
        "boat",
    )


@st.composite
def boats(draw, least: int = 4) -> Vehicle:
    """Three to eight thrusters anywhere; unequal, unsymmetric, with a curve of their own each."""
    n = draw(st.integers(least, 8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    angles = rng.uniform(-180, 180, n)
    if draw(st.booleans()):  # thrusters in line, as on real boats
        angles = 45.0 * np.round(angles / 45.0)
    places = list(zip(rng.uniform(-1, 1, n), rng.uniform(-0.5, 0.5, n), angles, strict=True))
    gains = rng.uniform(0.7, 1.3, n)
    gains /= gains.mean() if n <= 6 else gains  # the chain has room for 32 constants
    chain = [
        ChainGroup(
            name=f"g{k}",
            actuators=[f"T_{k}"],
            dead_zone=DeadZone(*rng.uniform(0.02, 0.15, 2)),
            reverse_ratio=rng.uniform(0.6, 1.0),
            power=rng.choice([1.0, 1.5, 2.0]),
            gains=None,
        )
        for k in range(n)
    ]
    if n <= 6:
        chain.append(ChainGroup(gains={f"T_{k}": g for k, g in enumerate(gains)}))
    try:
        found = boat(places, chain)
        T = effectiveness(found).T
    except VehicleError:
        assume(False)
        raise
    assume(np.linalg.svd(T, compute_uv=False)[2] > 0.05)
    return found


@dataclass(frozen=True)
class Thrusts:
    """Bounds of thrusts (n,), and the function from commands to them, out of the vehicle file."""

    vehicle: Vehicle

    def of(self, commands: np.ndarray) -> np.ndarray:
        """Thrusts of commands (n,): the chain's formula, written again."""
        found = np.zeros(len(commands))
        groups = self.vehicle.file.chain
        for k, c in enumerate(commands):
            g = groups[k]
            edge = g.dead_zone.forward if c >= 0 else g.dead_zone.reverse
            past = max(0.0, (abs(c) - edge) / (1 - edge))
            full = 1.0 if c >= 0 else -g.reverse_ratio
            gain = (groups[-1].gains or {}).get(f"T_{k}", 1.0)
            found[k] = gain * full * past**g.power
        return found

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        n = len(self.vehicle.actuators)
        return self.of(-np.ones(n)), self.of(np.ones(n))


def wrenches(seed: int, T: np.ndarray, bounds, share: float, m: int = 5) -> np.ndarray:
    """Wrenches (m, 3) of random thrusts: within reach for share <= 1."""
    rng = np.random.default_rng(seed)
    low, high = bounds
    thrusts = share * rng.uniform(low, high, (m, len(low)))
    return thrusts @ T.T
