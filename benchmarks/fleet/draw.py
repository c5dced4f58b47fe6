# SPDX-License-Identifier: MIT
"""What is drawn at random for each boat."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import DisturbanceForce
from tests.boats.hulls import CORNERS, CROSS, TUG, Hull, driven

LENGTH = (0.3, 2.0)  # [m]
DISPLACED = (10.0, 30.0)  # [kg] of a boat of one metre; with the length's cube
# mass across over that along; inertia over a rod's
ADDED_ACROSS, ADDED_YAW = ((1.1, 1.8), (0.8, 2.0))
THRUST = (0.025, 0.25)  # [m/s^2] of one thruster, over the mass
FROUDE = (0.3, 1.2)  # full speed [m/s] over the root of the length [m]
SIDEWAYS, TURNING = (0.4, 0.9), (0.8, 2.0)  # full speed across over that ahead, of the ends over it
LINEAR = (0.1, 0.6)  # share of the drag at full speed
LATENCY, LAG = (0.0, 0.25), (0.03, 0.35)  # [s]
EDGE, UNEQUAL = (0.02, 0.12), (0.8, 1.2)  # dead zone; reverse edge over forward edge
REVERSE, POWER = (0.6, 1.0), (1.0, 2.0)
PUSHES, LASTS = (0.01, 0.05), (0.5, 4.0)  # share of full thrust, [s]
WHITE = (5e-4, 2e-2)  # [m, rad]
LASTING, MEMORY = (0.5, 2.0), (0.1, 1.0)  # times the white errors, [s]
RATES = (4.0, 8.0, 12.0, 20.0, 30.0)  # [Hz]
SECONDS = (90.0, 150.0, 200.0)
DRIVES = 3
PLACED = 0.7  # [m] the hull that `CORNERS`, `CROSS`, `TUG` are drawn for
Range = tuple[float, float]
Places = list[tuple[float, float, float]]


@dataclass(frozen=True)
class Drawn:
    """A boat, its drives, and how it is seen."""

    seed: int
    hull: Hull
    chain: dict[str, object]
    push: DisturbanceForce | None
    white: float  # [m, rad]
    lasting: Range | None  # [m, rad], [s]
    rate: float  # [Hz]
    seconds: float

    @property
    def truth(self) -> dict[str, float]:
        """What coefficients and constants should be, by name."""
        zone = self.chain["dead_zone"]
        assert isinstance(zone, dict)
        edges = {"edge_forward": zone["forward"], "edge_reverse": zone["reverse"]}
        rest = {k: v for k, v in self.chain.items() if isinstance(v, float)}
        return {"reverse_ratio": 1.0, "power": 1.0, **self.hull.coefficients, **edges, **rest}

    def trials(self) -> tuple[Vehicle, list[Recording]]:
        """Its vehicle file, of which the chain is not known, and what was recorded."""
        return driven(
            self.hull, self.chain, seed=self.seed, push=self.push, white=self.white, lasting=self.lasting,
            rate=self.rate, seconds=self.seconds, drives=DRIVES,
        )  # fmt: skip


def draw(seed: int) -> Drawn:
    """One boat."""
    rng = np.random.default_rng([77, seed])

    def uniform(span: Range) -> float:
        return float(rng.uniform(*span))

    def any_size(span: Range) -> float:
        return float(np.exp(rng.uniform(*np.log(span))))

    length = any_size(LENGTH)
    hull = _hull(length, [CORNERS, CROSS, TUG][rng.integers(3)], uniform)
    edge = uniform(EDGE)
    chain: dict[str, object] = {
        "latency": uniform(LATENCY),
        "lag": uniform(LAG),
        "dead_zone": {"forward": edge, "reverse": edge * uniform(UNEQUAL)},
    }
    for stage, span in (("reverse_ratio", REVERSE), ("power", POWER)):
        if rng.random() < 0.4:
            chain[stage] = uniform(span)
    push = None
    if rng.random() < 0.5:
        push = DisturbanceForce(
            uniform(PUSHES), uniform(LASTS), earth_fixed=bool(rng.random() < 0.5)
        )
    white = any_size(WHITE)
    lasting = (white * uniform(LASTING), uniform(MEMORY)) if rng.random() < 0.3 else None
    rate, seconds = float(rng.choice(RATES)), float(rng.choice(SECONDS))
    return Drawn(seed, hull, chain, push, white, lasting, rate, seconds)


def _hull(length: float, places: Places, uniform: Callable[[Range], float]) -> Hull:
    """A hull whose drag is its thrust at full speed."""
    mass = length**3 * uniform(DISPLACED)
    masses = (mass, mass * uniform(ADDED_ACROSS), mass * length**2 / 12.0 * uniform(ADDED_YAW))
    placed = [(x * length / PLACED, y * length / PLACED, angle) for x, y, angle in places]
    nothing = (0.0, 0.0, 0.0)
    hull = Hull(placed, mass * uniform(THRUST), masses, nothing, nothing)
    full = uniform(FROUDE) * np.sqrt(length)
    speeds = np.array([full, full * uniform(SIDEWAYS), full / length * uniform(TURNING)])
    linear = np.array([uniform(LINEAR) for _ in range(3)])
    most = hull.full_thrust
    first, second = linear * most / speeds, (1.0 - linear) * most / speeds**2
    return replace(hull, linear=tuple(first.tolist()), quadratic=tuple(second.tolist()))
