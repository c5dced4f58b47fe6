# SPDX-License-Identifier: MIT
"""Inputs that are angles: a rudder or a turned thruster turns the boat by the thrust of another input."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial.inspection.consistency.effects import CLEAR_T
from seatrial.inspection.consistency.gains import (
    Runs,
    blocks,
    gains_of_axis,
    unexplained_share,
    without_drag,
)
from seatrial.recording.signal import Signal
from seatrial.util.frames import Array

PRODUCT = "product"  # of an angle and a thrust
STEERED = (
    "is it the angle of a rudder or thruster? Then write 'steered' below chain (docs/vehicle.md)"
)
IN_FLOW = "is it a rudder in the flow? Then write its force's terms times |u| * u (docs/vehicle.md)"


@dataclass(frozen=True)
class SteeringAngle:
    """What an input that looks like an angle turns."""

    thrust: str  # the input that it turns
    # of the yaw gain of their product, forward-left-up; in the flow: of its product with |u| u
    t: float
    flow: bool = False  # with |u| u in place of the thrust less is left unexplained


def steering_angles(runs: Runs, t: Array, *, mirrored: bool = False) -> dict[str, SteeringAngle]:
    """By input that looks like an angle, the thrust that it turns.

    With the product of the two, or of the angle and |u| u, beside all inputs, the product turns the boat, and more
    clearly than the angle. With thrust both ways the angle alone turns it either way, and has no gain.
    runs: with commands that are 0 at rest; t: (3, n) of their gains.
    """
    names = runs[0].commands.names
    ahead = np.flatnonzero(np.abs(t[0]) >= CLEAR_T).tolist()
    angles: dict[str, SteeringAngle] = {}
    for k in sorted(set(range(len(names))) - set(ahead)):
        found = {j: _with_product(runs, k, _of_thrust(runs, k, j), mirrored) for j in ahead}
        if not found:
            break
        j = max(found, key=lambda j: found[j].clear * abs(found[j].t))
        flow = _with_product(runs, k, _of_flow(runs, k, mirrored=mirrored), mirrored)
        if flow.clear and flow.left < min(one.left for one in found.values()):
            angles[names[k]] = SteeringAngle(names[j], flow.t, flow=True)
        elif found[j].clear:
            angles[names[k]] = SteeringAngle(names[j], found[j].t)
    return angles


def angle_text(found: SteeringAngle) -> str:
    """What was found of an input, and how to state it."""
    if found.flow:
        return f"turns the boat only at speed: {IN_FLOW}"
    return f"turns the boat only with the thrust of {found.thrust}: {STEERED}"


@dataclass(frozen=True)
class _Product:
    """Yaw by an input and by its product with another quantity, beside all inputs."""

    own: float  # t of the input
    t: float  # of the product
    left: float  # sum of the squared yaw accelerations that are left

    @property
    def clear(self) -> bool:
        return abs(self.t) >= max(CLEAR_T, abs(self.own))


def _of_thrust(runs: Runs, angle: int, thrust: int) -> list[Array]:
    """The product of two inputs in each run, averaged as inputs are: (DELAYS, m, 1)."""
    products = []
    for run in runs:
        own = run.commands
        product = own.values[:, [angle]] * own.values[:, [thrust]]
        products.append(replace(run, commands=Signal((PRODUCT,), own.stamps, product)).inputs)
    return products


def _of_flow(runs: Runs, angle: int, *, mirrored: bool) -> list[Array]:
    """The product of an input and |u| u in each run: (DELAYS, m, 1)."""
    products = []
    for run in runs:
        own = run.smooth
        velocity = own.velocity.conj() if mirrored else own.velocity
        u = (velocity * np.exp(-1j * own.psi)).real
        products.append(run.inputs[:, :, [angle]] * (np.abs(u) * u)[None, :, None])
    return products


def _with_product(runs: Runs, angle: int, products: Sequence[Array], mirrored: bool) -> _Product:
    """What the products (DELAYS, m, 1) of an input explain of the yaw beside all inputs."""
    wider = [np.dstack([run.inputs, more]) for run, more in zip(runs, products, strict=True)]
    motion, inputs = without_drag(runs, np.concatenate(wider, axis=1), mirrored=mirrored)
    t = gains_of_axis(motion[:, 2], inputs, blocks(runs)).t
    left = unexplained_share(motion, inputs)[:, 2].min() * float(np.sum(motion[:, 2] ** 2))
    return _Product(float(t[angle]), float(t[-1]), float(left))
