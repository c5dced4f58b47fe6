# SPDX-License-Identifier: MIT
"""Worst margins of the loop over draws of the model's covariance."""

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace

import numpy as np

from seatrial.boat.model import Model
from seatrial.control.tuning.guidance import Guidance
from seatrial.control.tuning.linear import LinearBoat, redrawn
from seatrial.control.tuning.loops import Feedback, Margins, frequencies, margins
from seatrial.control.tuning.rules import Gains
from seatrial.util.frames import Array
from seatrial.util.progress import over
from seatrial.util.statistics import root_of

MARGIN_DRAWS = 200
MARGIN_SEED = 1
DRAW_FREQUENCIES = 200  # of the loop of each draw


def drawn(model: Model, draws: int = MARGIN_DRAWS, seed: int = MARGIN_SEED) -> Iterator[Model]:
    """The model with coefficients and constants drawn from its covariance; deterministic by seed."""
    rng = np.random.default_rng(seed)
    n = len(model.coefficients)
    root = root_of(model.covariance)
    for _ in range(draws):
        off = root @ rng.normal(size=len(root))
        yield replace(
            model, coefficients=model.coefficients + off[:n], constants=_timing_only(model, off[n:])
        )


def _timing_only(model: Model, off: Array) -> Array:
    """Constants of the chain; those of the static curve are not drawn, their steepest slope is used."""
    timing = [
        name.partition(".")[0] in ("latency", "lag", "gain")
        for name in model.vehicle.constants.names
    ]
    return np.asarray(model.constants + np.where(timing, off, 0.0))


def worst_of(
    boats: Sequence[LinearBoat],
    gains: Sequence[Gains],
    knob: float,
    hold: float,
    strength: float,
    *,
    guidance: Guidance | None = None,
) -> Margins:
    """Margins (boats, ...) of each boat, the worst of its motions."""
    longest = float(boats[0].actuators.delay.max()) + hold
    slow = 0.0 if guidance is None else guidance.time
    omega = frequencies(knob, longest, DRAW_FREQUENCIES, slow)
    feedback = Feedback(gains, boats[0].speeds, omega, hold, guidance)
    found = [margins(boat, feedback, strength).worst() for boat in over(boats)]
    return Margins(*(np.array([getattr(m, f.name) for m in found]) for f in fields(Margins)))


def draws_of(
    boat: LinearBoat, model: Model, draws: int = MARGIN_DRAWS, seed: int = MARGIN_SEED
) -> list[LinearBoat]:
    """The boat itself, then each draw of its model under the same axis commands.

    No draws where the covariance is zero.
    """
    if not model.covariance.any():
        return [boat]
    return [boat, *(redrawn(boat, one) for one in drawn(model, draws, seed))]
