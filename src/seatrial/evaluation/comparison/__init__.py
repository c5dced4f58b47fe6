# SPDX-License-Identifier: MIT
"""Two models of a boat, before and after: what changed, and whether it matters for prediction."""

from collections.abc import Sequence
from typing import Any

import msgspec

from seatrial.boat.model import Model
from seatrial.boat.schema import NoiseEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.comparison.boats import AxisMeaning, meaning, notes, same_data
from seatrial.evaluation.comparison.parameters import (
    Factor,
    Joint,
    OneSided,
    Pair,
    alone,
    factors,
    joint,
    pairs,
    unlike,
    views,
)
from seatrial.evaluation.comparison.prediction import (
    Ahead,
    about_one_point,
    ahead,
    driven_by,
    same_drive,
    verdict,
)
from seatrial.evaluation.comparison.significance import luck
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.recording.recording import Recording
from seatrial.util.errors import ModelError

COMPARISON_FORMAT = "comparison 1"

__all__ = ["Ahead", "Comparison", "Side", "compare", "comparison_json", "drive_of"]


class Side(msgspec.Struct, frozen=True):
    """One of the two models."""

    label: str  # file
    vehicle: str
    method: str
    recordings: list[str]
    length: float  # [s] of them
    noise: NoiseEntry


class Comparison(msgspec.Struct, frozen=True):
    """What `compare` found; forward-left-up."""

    seatrial: str
    a: Side
    b: Side
    pairs: list[Pair]
    joint: Joint | None  # None: nothing was estimated
    factors: list[Factor]
    only_a: list[OneSided]
    only_b: list[OneSided]
    boat: list[AxisMeaning]
    notes: list[str]
    ahead: list[Ahead] = []
    better: dict[str, dict[str, str | None]] = {}  # by horizon, by u, v, r: "A", "B" or neither
    same_data: bool = False  # both were identified from the same recordings

    @property
    def changed(self) -> list[Pair]:
        """Parameters that differ by more than chance."""
        return [pair for pair in self.pairs if pair.differs]

    @property
    def untested(self) -> list[tuple[OneSided, OneSided]]:
        """Parameters, A's and B's, of which one model's ended at a bound: how well it is known is not."""
        others = {one.name: one for one in self.only_b}
        both = [(one, others[one.name]) for one in self.only_a if one.name in others]
        return [(x, y) for x, y in both if x.at_bound != y.at_bound]


def compare(
    a: Model,
    b: Model,
    recordings: Sequence[Recording] = (),
    *,
    horizon: float = DEFAULT_HORIZON,
    labels: tuple[str, str] = ("A", "B"),
) -> Comparison:
    """Coefficients, constants and what they mean; with recordings, which model predicts better.

    Errors of both are taken for independent; where they are not, a note says so. Predictions are
    `DEFAULT_HORIZON` and `horizon` [s] ahead, of recordings read with `drive_of(a, b)`. Raises
    ModelError where nothing can be compared or a model is unstable, RecordingError where a recording is
    too short.
    """
    odd = unlike(a, b)
    seen = views(a, b)
    found = pairs(a, b, seen, odd)
    if not any(pair.name in a.values for pair in found):
        raise ModelError(
            f"no coefficient in common: {labels[0]} has {', '.join(a.values)}, {labels[1]} has "
            f"{', '.join(b.values)}; compare models of one structure"
        )
    rows: list[Ahead] = []
    better = {}
    if recordings:
        horizons = sorted({DEFAULT_HORIZON, horizon})
        rows = ahead(a, b, recordings, horizons, luck(a, b, seen, found))
        better = {f"{h:g}": verdict([r for r in rows if r.horizon == h]) for h in horizons}
    return Comparison(
        COMPARISON_FORMAT,
        _side(a, labels[0]),
        _side(b, labels[1]),
        found,
        joint(found, seen),
        factors(a, found, seen),
        alone(a, b, odd),
        alone(b, a, odd),
        meaning(a, b),
        notes(a, b, seen),
        rows,
        better,
        same_data(a, b),
    )


def drive_of(a: Model, b: Model, vehicle: Vehicle | None = None) -> tuple[Model, Model]:
    """Both models as the boat that made the recordings: its signals, thrusters and allocation.

    That is `vehicle`, or the models' own where these agree; raises ModelError where they don't. Lever arms
    that differ by what they may be off by become the same.
    """
    if not a.same_origin(b):
        raise ModelError(
            f"the models are of two origins (the poses' point is {a.vehicle.point} of A's, "
            f"{b.vehicle.point} of B's): leave the recordings out, or identify both with one lever arm"
        )
    if vehicle is not None:
        return about_one_point(driven_by(a, vehicle), driven_by(b, vehicle))
    if not same_drive(a.vehicle, b.vehicle):
        raise ModelError(
            "the models' vehicles differ in signals, thrusters or allocation; say with --vehicle how these "
            "recordings were driven"
        )
    return about_one_point(a, b)


def comparison_json(found: Comparison) -> dict[str, Any]:
    """The same for programs."""
    content: dict[str, Any] = msgspec.to_builtins(found)
    return content


def _side(model: Model, label: str) -> Side:
    names = [entry.name for entry in model.recordings]
    length = sum(entry.length for entry in model.recordings)
    return Side(label, model.name, model.estimator.method, names, length, model.noise)
