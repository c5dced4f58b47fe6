# SPDX-License-Identifier: MIT
"""Boats of other proportions than the paper's, driven by pulses of a joypad, pushed, and seen by a SLAM."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import DisturbanceForce
from seatrial.simulation.trials import DisturbedPlant
from seatrial.util.frames import Array
from tests.boats.motions import given_model, recorded, ticked
from tests.boats.vehicles import by_columns

FREE = {  # added mass of its own along and across
    "surge": ["X_vr * v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
    "sway": ["Y_ur * u * r", "Y_v * v", "Y_vv * |v| * v", "Y_F * F_v"],
    "yaw": ["N_uv * u * v", "N_r * r", "N_rr * |r| * r", "N_F * F_r"],
}
CORNERS = [(0.3, 0.2, -45.0), (0.3, -0.2, 45.0), (-0.3, 0.2, 45.0), (-0.3, -0.2, -45.0)]
CROSS = [
    (0.0, 0.15, 0.0),
    (0.0, -0.15, 0.0),
    (0.2, 0.0, 90.0),
    (-0.2, 0.0, 90.0),
]  # x, y [m], angle [deg]
STEP = 1 / 240  # [s]
TICK = 0.02  # [s] of the joypad


@dataclass(frozen=True)
class Hull:
    """A boat in SI units."""

    places: list[tuple[float, float, float]]
    thrust: float  # [N] of each thruster
    mass: tuple[float, float, float]  # [kg, kg, kg m^2] with added mass
    linear: tuple[float, float, float]  # [N s/m, N s/m, N m s]
    quadratic: tuple[float, float, float]

    @property
    def full_thrust(self) -> Array:
        """(3,) [N, N, N m] of a wrench of 1 in each axis, as pseudo-inverse allocation has it."""
        x, y, angle = np.array(self.places).T
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        return np.asarray(self.thrust * np.linalg.norm([c, s, x * s - y * c], axis=1))

    @property
    def coefficients(self) -> dict[str, float]:
        """Of `FREE`, by Newton's second law."""
        m, n, i = self.mass
        drag = [-np.array(d) / self.mass for d in (self.linear, self.quadratic)]
        force = self.full_thrust / self.mass
        return {
            "X_vr": n / m, "X_u": drag[0][0], "X_uu": drag[1][0], "X_F": force[0],
            "Y_ur": -m / n, "Y_v": drag[0][1], "Y_vv": drag[1][1], "Y_F": force[1],
            "N_uv": (m - n) / i, "N_r": drag[0][2], "N_rr": drag[1][2], "N_F": force[2],
        }  # fmt: skip

    def vehicle(self, chain: list[dict[str, object]]) -> Vehicle:
        """Its vehicle file, driven through the usual allocation."""
        places = enumerate(self.places, 1)
        return by_columns(
            "boat", ("F_u", "F_v", "F_r"), FREE, chain=chain,
            thrusters={f"t{k}": {"x": x, "y": y, "angle_deg": a} for k, (x, y, a) in places},
            allocation={"scheme": "moore-penrose", "limit": 1.0},
        )  # fmt: skip


SMALL = Hull(CROSS, 2.0, (4.0, 5.5, 0.06), (1.5, 3.0, 0.05), (6.0, 14.0, 0.03))  # quick in yaw
TUG = [(-0.35, 0.2, 0.0), (-0.35, -0.2, 0.0), (0.35, 0.0, 90.0)]  # the third is its bow thruster
NEAR = [(0.12, 0.08, -45.0), (0.12, -0.08, 45.0), (-0.12, 0.08, 45.0), (-0.12, -0.08, -45.0)]
LIGHT = Hull(NEAR, 1.0, (0.6, 0.9, 0.006), (1.0, 1.5, 0.02), (2.0, 4.0, 0.02))  # a toy of 0.5 kg
MIDDLE = Hull(CORNERS, 8.0, (11.0, 15.0, 0.6), (4.0, 6.0, 0.35), (18.0, 30.0, 0.4))
BOWED = Hull(TUG, 8.0, (11.0, 15.0, 0.6), (4.0, 6.0, 0.35), (18.0, 30.0, 0.4))


def sticks(rng: np.random.Generator, seconds: float) -> Array:
    """F_u, F_v, F_r (n, 3) at every tick: pulses of one axis or all, pauses between."""
    out = np.zeros((round(seconds / TICK), 3))
    t = 2.0
    while t < seconds - 2.0:
        hold = rng.uniform(0.5, 3.0)
        pulse = rng.uniform(-1.0, 1.0, 3) * rng.uniform(0.4, 1.0)
        if rng.random() > 0.3:
            pulse = np.zeros(3)
            pulse[rng.integers(3)] = rng.choice([-1.0, 1.0]) * rng.uniform(0.15, 1.0)
        out[round(t / TICK) : round(min(t + hold, seconds - 2.0) / TICK)] = pulse
        t += hold + (rng.uniform(0.0, 2.0) if rng.random() < 0.7 else 0.0)
    return out


def one_after_another(rng: np.random.Generator, seconds: float) -> Array:
    """The same with pulses of surge, then of sway, then of yaw, at last a few of all at once."""
    out = sticks(rng, seconds)
    count = round(seconds / TICK)
    free = count - round(20.0 / TICK)
    size = np.abs(out[:free]).max(axis=1) * np.sign(out[:free].sum(axis=1))
    out[:free] = 0.0
    out[np.arange(free), 3 * np.arange(free) // free] = size
    turns = np.arange(count - free) * TICK
    out[free:] = 0.6 * np.sin(2.0 * np.pi * turns[:, None] / np.array([6.0, 9.0, 5.0]))
    return out


def driven(
    hull: Hull,
    chain: dict[str, object] | list[dict[str, object]],
    *,
    seed: int,
    push: DisturbanceForce | None = None,
    white: float,
    lasting: tuple[float, float] | None = None,
    rate: float = 12.0,
    seconds: float = 120.0,
    drives: int = 2,
    late: tuple[float, float] = (0.0, 0.0),
    wind: tuple[float, float] = (0.0, 0.0),
    pattern: Callable[[np.random.Generator, float], Array] | None = None,
) -> tuple[Vehicle, list[Recording]]:
    """Its vehicle without a chain, and recordings; `white` [m, rad], `lasting`: size [m, rad] and memory [s].

    pattern: the commands, by default `sticks`; late: [s] by which positions and headings are older than their
    stamps, whole ticks; wind: [m/s^2] steady and earth-fixed, beside the push.
    """
    true = hull.vehicle([chain] if isinstance(chain, dict) else chain)
    boat, found = given_model(true, hull.coefficients, STEP), []
    for k in range(drives):
        rng = np.random.default_rng([seed, k])
        command = (pattern or sticks)(rng, seconds)
        plant = DisturbedPlant(boat, push, np.random.default_rng([seed, k, 1]))
        plant.state = np.array([0.0, 0.0, rng.uniform(-3.0, 3.0), 0.0, 0.0, 0.0])
        states = ticked(plant, command, TICK, wind)
        t = np.arange(0.1, seconds - 0.1, 1.0 / rate)
        at = np.round(t / TICK).astype(int)
        seen = [np.maximum(at - round(delay / TICK), 0) for delay in late]
        eta = np.column_stack([states[seen[0], :2], states[seen[1], 2]])
        eta += white * rng.normal(size=(len(at), 3))
        if lasting is not None:
            size, memory = lasting
            stays = np.exp(-TICK / memory)
            error = np.zeros((len(command), 3))
            error[0] = rng.normal(size=3)
            for i in range(1, len(command)):
                error[i] = stays * error[i - 1] + np.sqrt(1.0 - stays**2) * rng.normal(size=3)
            eta = eta + size * error[at]
        ticks = TICK * np.arange(len(command))
        found.append(recorded(f"r{k + 1}", true, (ticks[at], eta), (ticks, command)))
    return hull.vehicle([]), found
