# SPDX-License-Identifier: MIT
"""Inputs that are angles: a rudder or a turned thruster turns the boat by the thrust of another input."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial.inspection.consistency.effects import CLEAR_T
from seatrial.inspection.consistency.gains import Run, blocks, gains_of_axis, without_drag
from seatrial.recording.signal import Signal
from seatrial.util.frames import Array

PRODUCT = "product"  # of an angle and a thrust
STEERED = (
    "is it the angle of a rudder or thruster? Then write 'steered' below chain (docs/vehicle.md)"
)


@dataclass(frozen=True)
class SteeringAngle:
    """What an input that looks like an angle turns."""

    thrust: str  # the input that it turns
    t: float  # of the yaw gain of their product, forward-left-up


def steering_angles(
    runs: Sequence[Run], t: Array, *, mirrored: bool = False
) -> dict[str, SteeringAngle]:
    """By input that looks like an angle, the thrust that it turns.

    With the product of the two beside all inputs, the product turns the boat, and more clearly than the angle.
    With thrust both ways the angle alone turns it either way, and has no gain.
    runs: with commands that are 0 at rest; t: (3, n) of their gains.
    """
    names = runs[0].commands.names
    ahead = np.abs(t[0]) >= CLEAR_T
    angles: dict[str, SteeringAngle] = {}
    for k in np.flatnonzero(~ahead).tolist():
        thrusts = np.flatnonzero(ahead).tolist()
        found = {j: _with_product(runs, k, j, mirrored=mirrored) for j in thrusts}
        clear = {j: of for j, (own, of) in found.items() if abs(of) >= max(CLEAR_T, abs(own))}
        if clear:
            j = max(clear, key=lambda j: abs(clear[j]))
            angles[names[k]] = SteeringAngle(names[j], clear[j])
    return angles


def angle_text(thrust: str) -> str:
    """What was found of an input, and how to state it. thrust: the input that it seems to turn."""
    return f"turns the boat only with the thrust of {thrust}: {STEERED}"


def _with_product(
    runs: Sequence[Run], angle: int, thrust: int, *, mirrored: bool
) -> tuple[float, float]:
    """t of the yaw gains of an input and of its product with another one, beside all inputs."""
    products = []
    for run in runs:
        own = run.commands
        product = own.values[:, [angle]] * own.values[:, [thrust]]
        products.append(replace(run, commands=Signal((PRODUCT,), own.stamps, product)))
    wider = [np.dstack([run.inputs, more.inputs]) for run, more in zip(runs, products, strict=True)]
    motion, inputs = without_drag(runs, np.concatenate(wider, axis=1), mirrored=mirrored)
    t = gains_of_axis(motion[:, 2], inputs, blocks(runs)).t
    return float(t[angle]), float(t[-1])
