# SPDX-License-Identifier: MIT
"""The boat, the weather, its GNSS; and the model that is identified from two drives in that weather."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

import seatrial
from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array, body_velocity
from tests.boats.motions import given_model, recorded
from tests.boats.vehicles import TWIN, TWO_ASTERN, by_columns

MASS = (32.0, 46.0, 8.0)  # [kg, kg, kg m^2] with added mass
THRUST, ARM = 30.0, 0.35  # [N] of each thruster, [m] to the left and the right
LINEAR = (8.0, 30.0, 9.0)  # [N s/m, N s/m, N m s]
QUADRATIC = (12.0, 70.0, 8.0)
# [kg/m, kg, kg m] of the skegs at speed: sway, against the Munk moment, yaw
LIFT = (35.0, 9.0, 8.0)
CHAIN = {"latency": 0.06, "lag": 0.2, "dead_zone": {"forward": 0.05, "reverse": 0.05}}
TICK = 0.04  # [s] of the controller, and of the weather
GNSS_PERIOD, GNSS_DELAY = 0.12, 0.2  # [s]; delay: from the stamp to the arrival
GNSS_NOISE = np.array([0.02, 0.02, 0.01])  # [m, m, rad]
SETTLING = 6.0  # [s] at a course's start, standing still, not counted
DRIVE = 240.0  # [s] of each drive that the model is identified from


@dataclass(frozen=True)
class Weather:
    """Current, and wind as a force on the hull; both earth-fixed."""

    current: tuple[float, float] = (0.0, 0.0)  # [m/s]
    wind: tuple[float, float] = (0.0, 0.0)  # [N] mean
    gust: float = 0.0  # [N] standard deviation in x and in y
    gust_time: float = 5.0  # [s]


CALM = Weather()
WINDY = Weather((0.06, -0.08), (-2.0, 3.0), 1.5)


def vehicle(chain: tuple[dict[str, object], ...] = ()) -> Vehicle:
    """Two thrusters astern, commanded one by one."""
    structure = {
        "surge": TWIN["surge"],
        "sway": ["Y_ur * u * r", "Y_v * v", "Y_uv * |u| * v", "Y_vv * |v| * v"],
        "yaw": ["N_uv * u * v", "N_r * r", "N_ur * |u| * r", "N_rr * |r| * r", "N_F * F_r"],
    }
    return by_columns("twin", ("left", "right"), structure, forces=TWO_ASTERN, chain=list(chain))


@cache
def truth(left: float = 1.0) -> Model:
    """The plant; `left`: gain of the left thruster, 0.7 for one that has lost 30 %."""
    # a vehicle's gains have a mean of 1, the coefficients contain the rest
    mean = 0.5 * (left + 1.0)
    gains = {"gains": {"left": left / mean, "right": 1.0 / mean}}
    own = vehicle(({**CHAIN},) if left == 1.0 else ({**CHAIN}, gains))
    m, n, i = MASS
    linear, quadratic = (-np.array(d) / MASS for d in (LINEAR, QUADRATIC))
    values = {
        "X_vr": n / m, "X_u": linear[0], "X_uu": quadratic[0], "X_F": 2.0 * THRUST * mean / m,
        "Y_ur": -m / n, "Y_v": linear[1], "Y_vv": quadratic[1],
        "Y_uv": -LIFT[0] / n, "N_uv": (m - n + LIFT[1]) / i, "N_ur": -LIFT[2] / i,
        "N_r": linear[2], "N_rr": quadratic[2], "N_F": 2.0 * THRUST * mean * ARM / i,
    }  # fmt: skip
    return given_model(own, values, 1 / 200)


class Sea:
    """The plant in the weather, step by step, with its GNSS."""

    def __init__(self, plant: Model, weather: Weather, seed: int, start: Array) -> None:
        self.weather, self.rng = weather, np.random.default_rng(seed)
        self._core = _core.Plant(plant.boat, plant.vehicle.chain, plant.constants)
        self._core.state = np.concatenate([start, np.zeros(3)])
        self._gust = weather.gust * self.rng.normal(size=2)
        self._tick = 0
        self._on_the_way: list[tuple[float, Array]] = []

    @property
    def time(self) -> float:
        """[s]."""
        return self._tick * TICK

    @property
    def eta(self) -> Array:
        """True pose (3,)."""
        return np.array(self._core.state[:3])

    @property
    def state(self) -> Array:
        """True pose and velocity (6,)."""
        return np.array(self._core.state)

    def command(self, values: Array) -> None:
        """To both thrusters, from now on."""
        self._core.command(self.time, np.ascontiguousarray(values))

    def advance(self) -> list[tuple[float, Array]]:
        """By a tick; the poses that arrive, with their stamps [s]."""
        self._core.advance_to((self._tick + 1) * TICK)
        self._tick += 1
        w, state = self.weather, np.array(self._core.state)
        state[:2] += TICK * np.array(w.current)
        decay = np.exp(-TICK / w.gust_time)
        self._gust = decay * self._gust + np.sqrt(1.0 - decay**2) * w.gust * self.rng.normal(size=2)
        force = np.append(np.array(w.wind) + self._gust, 0.0)
        state[3:5] += TICK * body_velocity(state[2:3], force[None])[0, :2] / MASS[:2]
        self._core.state = state
        if self._tick % round(GNSS_PERIOD / TICK) == 0:
            self._on_the_way.append((self.time, state[:3] + GNSS_NOISE * self.rng.normal(size=3)))
        due = [pose for pose in self._on_the_way if pose[0] + GNSS_DELAY <= self.time + 1e-9]
        self._on_the_way = self._on_the_way[len(due) :]
        return due


def drive(weather: Weather, seed: int) -> Recording:
    """Pulses of both thrusters, as from a joypad."""
    rng, own = np.random.default_rng([seed, 1]), vehicle()
    sea = Sea(truth(), weather, seed, np.zeros(3))
    commands, poses = np.zeros((round(DRIVE / TICK), 2)), []
    at = round(1.0 / TICK)
    while at < len(commands) - round(1.0 / TICK):
        hold = int(rng.uniform(0.6, 4.0) / TICK)
        forward, turn = rng.uniform(-0.6, 1.0), rng.uniform(-0.6, 0.6) * (rng.random() < 0.7)
        commands[at : at + hold] = np.clip([forward - turn, forward + turn], -1.0, 1.0)
        at += hold + int(rng.choice([0.0, rng.uniform(0.0, 1.5)]) / TICK)
    commands[-round(1.0 / TICK) :] = 0.0
    for row in commands:
        sea.command(row)
        poses += sea.advance()
    t, eta = np.array([p[0] for p in poses]), np.array([p[1] for p in poses])
    ticks = TICK * np.arange(len(commands))
    return recorded(f"drive {seed}", own, (t, eta), (ticks, commands))


@cache
def identified() -> Model:
    """From two drives in wind and current, which the model is not told."""
    chain: dict[str, object] = {
        "latency": "estimate", "lag": "estimate",
        "dead_zone": {"forward": "estimate", "reverse": "estimate"},
    }  # fmt: skip
    own = vehicle((chain,))
    drives = [drive(replace(WINDY, wind=(2.0, -2.0)), seed) for seed in (11, 12)]
    return seatrial.identify(drives, own)
