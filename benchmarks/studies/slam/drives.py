# SPDX-License-Identifier: MIT
"""Drives round the pool, gentle and aggressive, with their truth at any time."""

from dataclasses import dataclass

import msgspec
import numpy as np

import seatrial
from benchmarks.studies.slam.scene import POOL, pool_scene
from benchmarks.studies.slam.se2 import turned
from seatrial.boat.vehicle import WRENCH
from seatrial.simulation.pilots import Operator
from seatrial.simulation.plan import DisturbanceForce, OperatorEntry, Pool, load_plan, with_seed
from seatrial.simulation.trials import DisturbedPlant, plant_model
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array, body_velocity
from tests.boats.drives import LASTS, SCENES

PUSHED = "hard, pushed"  # the preset that models are identified from
STICKS = {"gentle": (0.3, 0.4), "aggressive": (0.7, 1.0)}  # share of full, sizes of pulses
DURATION = 80.0  # [s]
TRUTH_RATE = 200.0  # [Hz]; between, straight lines
COURSE = (4.6, 1.5)  # [m] semi-axes of the ellipse that is followed, around the posts
AHEAD = 0.25  # [rad] on the ellipse, of the point steered for
BACK = 0.25  # share of pulses that turn the way round
CLEAR = 0.3  # [m] between the boat's origin and any surface


class CircuitOperator(Operator):
    """Pulses along an ellipse, one way round or the other, while pulses of yaw turn the boat."""

    def __init__(self, entry: OperatorEntry, pool: Pool, rng: np.random.Generator) -> None:
        super().__init__(entry, pool, rng)
        self.way = float(rng.choice([-1.0, 1.0]))
        self.travel = self.turn = 0.0
        self.until = np.zeros(2)  # [s] end of the pulse of travel, and of yaw or its pause

    def start(self) -> Array:
        """Pose (3,) of the beginning: on the ellipse, with any heading."""
        phase = self.rng.uniform(-np.pi, np.pi)
        x, y = COURSE[0] * np.cos(phase), COURSE[1] * np.sin(phase)
        return np.array([x, y, self.rng.uniform(-np.pi, np.pi)])

    def drive(self, t: float, x: Array) -> Array:
        """Towards the point ahead, with the yaw of the moment."""
        if t >= self.until[0]:
            self.until[0] = t + self.rng.uniform(*self.entry.pulse)
            self.travel = self.rng.uniform(*self.entry.amplitude["surge"])
            self.way *= -1.0 if self.rng.random() < BACK else 1.0
        if t >= self.until[1]:
            resting = self.turn == 0.0
            self.until[1] = t + self.rng.uniform(
                *(self.entry.pulse if resting else self.entry.pause)
            )
            side = self.rng.choice([-1.0, 1.0])
            self.turn = side * self.rng.uniform(*self.entry.amplitude["yaw"]) if resting else 0.0
        phase = np.arctan2(x[1] / COURSE[1], x[0] / COURSE[0]) + self.way * AHEAD
        goal = np.array([COURSE[0] * np.cos(phase), COURSE[1] * np.sin(phase)])
        way = np.append((goal - x[:2]) / np.linalg.norm(goal - x[:2]), 0.0)
        sticks = self.travel * body_velocity(x[2:3], way[None])[0]
        sticks[2] = self.turn
        return np.asarray(sticks)


@dataclass(frozen=True)
class Drive:
    """What the joypad sends, and where the boat is."""

    driving: str
    seed: int
    command_sent: Array  # (m,) [s] true time
    command_t: Array  # (m,) [s] by the joypad's clock
    command: Array  # (m, inputs)
    truth_t: Array  # (n,) [s]
    truth: Array  # (n, 6) x, y, psi (unwrapped), u, v, r

    def poses(self, t: Array) -> Array:
        """True poses (k, 3)."""
        columns = [np.interp(t, self.truth_t, self.truth[:, i]) for i in range(3)]
        columns[2] = turned(columns[2])
        return np.column_stack(columns)


def drive(driving: str, seed: int) -> Drive:
    """The boat of the preset, pushed, in the pool with posts.

    Raises ModelError where it comes too near to a surface.
    """
    plan = with_seed(load_plan("hard"), seed)
    vehicle = seatrial.load_vehicle("mallard-mp")
    model = plant_model(plan, vehicle)
    rng = np.random.default_rng([seed, list(STICKS).index(driving)])
    sizes = dict.fromkeys(plan.operator.amplitude, STICKS[driving])
    entry = msgspec.structs.replace(plan.operator, amplitude=sizes)
    operator = CircuitOperator(entry, POOL, rng)
    plant = DisturbedPlant(model, DisturbanceForce(SCENES[PUSHED], LASTS), rng)
    plant.state = np.concatenate([operator.start(), np.zeros(3)])
    order = [WRENCH.index(name) for name in vehicle.inputs]

    # in ticks of the truth: looks and commands are whole numbers of them
    each = round(plan.operator.reaction * TRUTH_RATE)
    t = np.arange(round(DURATION * TRUTH_RATE) + 1) / TRUTH_RATE
    truth, sticks = np.zeros((len(t), 6)), np.zeros((len(t), 3))
    for i, now in enumerate(t.tolist()):
        plant.advance_to(now)
        truth[i] = plant.state
        if i % each == 0:
            held = operator.look(now, truth[i])[order]
            plant.command(now, np.ascontiguousarray(held))
        sticks[i] = held
    nearest = float(pool_scene().distance(truth[:, :2]).min())
    if nearest < CLEAR:
        raise ModelError(
            f"{driving}, seed {seed}: the boat comes within {nearest:.2f} m of a surface; "
            f"expected {CLEAR} m; take another seed or a smaller course"
        )
    sent = slice(None, None, round(TRUTH_RATE / plan.joypad.rate))
    truth[:, 2] = np.unwrap(truth[:, 2])
    return Drive(driving, seed, t[sent], t[sent] + plan.joypad.clock_offset, sticks[sent], t, truth)
