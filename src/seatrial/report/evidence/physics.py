# SPDX-License-Identifier: MIT
"""Physics that a model implies, with the uncertainty of its coefficients."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import AxisPhysics, axis_physics
from seatrial.boat.schema import Integration
from seatrial.util.errors import ModelError
from seatrial.util.frames import Array
from seatrial.util.parallel import spread
from seatrial.util.statistics import root_of

PHYSICS_DRAWS = 60  # of the coefficients
PHYSICS_SEED = 20
COARSE_STEP = 1 / 12  # [s] of the integration; enough for intervals
MOST_UNSTABLE = 0.5  # share of unstable draws from which on no interval is given


@dataclass(frozen=True)
class Spread:
    """One axis with 95 % intervals; None where there are none."""

    axis: int
    found: AxisPhysics
    top_speed: tuple[float, float] | None  # [m/s] or [rad/s]
    rise_time: tuple[float, float] | None  # [s]
    coast: tuple[float, float] | None  # [m] or [rad]


@dataclass(frozen=True)
class Physics:
    """All driven axes, or why there are none."""

    axes: tuple[Spread, ...]
    unstable: str  # why the model is unstable; empty: it is stable
    unstable_share: float  # of the draws


def physics(model: Model) -> Physics:
    """Top speeds, rise times and stopping distances, with intervals from draws of the coefficients."""
    try:
        found = axis_physics(model)
    except ModelError as error:
        return Physics((), str(error), 0.0)
    drawn = _drawn(model)
    stable = [one for one in drawn if one is not None]
    unstable = 1.0 - len(stable) / len(drawn) if drawn else 0.0
    kept = stable if drawn and unstable < MOST_UNSTABLE else []
    return Physics(
        tuple(_spread(place, one, kept) for place, one in enumerate(found)), "", unstable
    )


def _spread(place: int, found: AxisPhysics, drawn: Sequence[Sequence[AxisPhysics]]) -> Spread:
    def interval(name: str) -> tuple[float, float] | None:
        if not drawn:
            return None
        low, high = np.quantile([getattr(one[place], name) for one in drawn], [0.025, 0.975])
        return float(low), float(high)

    return Spread(
        found.axis, found, interval("top_speed"), interval("rise_time"), interval("coast")
    )


def _drawn(model: Model) -> list[list[AxisPhysics] | None]:
    """`axis_physics` of coefficients drawn from their covariance; None where they are unstable."""
    n = len(model.coefficients)
    root = root_of(model.covariance[:n, :n])
    if not root.any():
        return []
    normal = np.random.default_rng(PHYSICS_SEED).normal(size=(PHYSICS_DRAWS, n))
    own = model.integration
    step = max(own.step, COARSE_STEP) if own.scheme == "runge-kutta" else own.step
    model = replace(model, integration=Integration(own.scheme, step))

    def one(draw: Array) -> list[AxisPhysics] | None:
        try:
            return axis_physics(replace(model, coefficients=draw))
        except ModelError:
            return None

    return spread(one, model.coefficients + normal @ root.T)
