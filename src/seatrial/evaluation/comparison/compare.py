# SPDX-License-Identifier: MIT
"""`compare`: which parameters of two models differ, and whether that affects prediction."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from seatrial.boat.model import Model
from seatrial.boat.schema import NoiseEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.comparison.boats import AxisMeaning, axis_meanings, notes, same_data
from seatrial.evaluation.comparison.causes import Cause, causes
from seatrial.evaluation.comparison.comparability import not_comparable
from seatrial.evaluation.comparison.parameters import (
    Factor,
    Joint,
    OneSided,
    Pair,
    factors,
    joint,
    pairs,
    unmatched,
    views,
)
from seatrial.evaluation.comparison.prediction import (
    PredictionRow,
    predict_both,
    same_drive,
    verdict,
    with_common_lever,
    with_signals,
)
from seatrial.evaluation.comparison.significance import same_boat_errors
from seatrial.evaluation.prediction import DEFAULT_HORIZON
from seatrial.recording.recording import Recording
from seatrial.util.above import text_by
from seatrial.util.arguments import expect, expect_each
from seatrial.util.blas import one_blas_thread
from seatrial.util.errors import ModelError

COMPARISON_FORMAT = "comparison 1"


class Side(msgspec.Struct, frozen=True):
    """One of the two models.

    label: its file, or as given
    vehicle: name of its vehicle
    method: that identified it
    recordings: names of those that it was identified from
    length: [s] of them
    noise: of poses and motion
    """

    label: str
    vehicle: str
    method: str
    recordings: list[str]
    length: float
    noise: NoiseEntry


class Comparison(msgspec.Struct, frozen=True):
    """Result of `compare`; forward-left-up.

    seatrial: version that made it
    a: the first model
    b: the second
    pairs: parameters that both have
    joint: test of all differences; None: nothing was estimated
    factors: common factors of the coefficients of an axis
    only_a: parameters that B does not have
    only_b: parameters that A does not have
    boat: response of each axis to the same command
    notes: what restricts the comparison, in words
    ahead: predictions, where recordings were given
    better: by horizon, by u, v, r: "A", "B" or None, neither
    same_data: whether both were identified from the same recordings
    causes: the most probable first; none of the same recordings
    """

    seatrial: str
    a: Side
    b: Side
    pairs: list[Pair]
    joint: Joint | None
    factors: list[Factor]
    only_a: list[OneSided]
    only_b: list[OneSided]
    boat: list[AxisMeaning]
    notes: list[str]
    ahead: list[PredictionRow] = []
    better: dict[str, dict[str, str | None]] = {}
    same_data: bool = False
    causes: list[Cause] = []

    __str__ = text_by("evaluation.comparison.console", "comparison_text")

    @property
    def changed(self) -> list[Pair]:
        """Parameters that differ significantly."""
        return [pair for pair in self.pairs if pair.differs]

    @property
    def untested(self) -> list[tuple[OneSided, OneSided]]:
        """Parameters of A and B of which one is at a bound, so its uncertainty is unknown."""
        others = {one.name: one for one in self.only_b}
        both = [(one, others[one.name]) for one in self.only_a if one.name in others]
        return [(x, y) for x, y in both if x.at_bound != y.at_bound]


@one_blas_thread
def compare(
    a: Model,
    b: Model,
    recordings: Sequence[Recording] = (),
    *,
    horizon: float = DEFAULT_HORIZON,
    labels: tuple[str, str] = ("A", "B"),
) -> Comparison:
    """Differences of parameters and physics; with recordings, which model predicts better.

    Errors of the two are assumed independent; a note states where they are not. Predictions are
    `DEFAULT_HORIZON` and `horizon` [s] ahead, of recordings read with `drive_of(a, b)`. Raises
    ModelError where no coefficient is comparable or a model is unstable, RecordingError for a recording
    that is too short.
    """
    expect(a, Model, "a")
    expect(b, Model, "b")
    expect_each(recordings, Recording, "recordings")
    # 1. Parameters that both models have, in comparable terms; Wald tests with Holm's correction.
    odd = not_comparable(a, b)
    seen = views(a, b)
    found = pairs(a, b, seen, odd)
    _refuse_nothing_in_common(a, b, found, labels)
    # 2. Predictions from shared starts: RMS errors, their difference, its significance.
    rows: list[PredictionRow] = []
    better = {}
    if recordings:
        horizons = sorted({DEFAULT_HORIZON, horizon})
        rows = predict_both(a, b, recordings, horizons, same_boat_errors(a, b, seen, found))
        better = {f"{h:g}": verdict([r for r in rows if r.horizon == h]) for h in horizons}
    # 3. Parameters without a counterpart, common factors, causes, physics, and reservations.
    same = same_data(a, b)
    return Comparison(
        COMPARISON_FORMAT, _side(a, labels[0]), _side(b, labels[1]), found, joint(found, seen),
        factors(a, b, found, seen), unmatched(a, b, odd), unmatched(b, a, odd), axis_meanings(a, b),
        notes(a, b, seen), rows, better, same, [] if same else causes(a, b, found, seen),
    )  # fmt: skip


def _refuse_nothing_in_common(
    a: Model, b: Model, found: Sequence[Pair], labels: tuple[str, str]
) -> None:
    """Raise ModelError where no coefficient is in both."""
    if not any(pair.name in a.values for pair in found):
        raise ModelError(
            f"no coefficient in common: {labels[0]} has {', '.join(a.values)}, {labels[1]} has "
            f"{', '.join(b.values)}; compare models of one structure"
        )


def drive_of(a: Model, b: Model, vehicle: Vehicle | None = None) -> tuple[Model, Model]:
    """Both models with the signals, thrusters and allocation of the recordings.

    These are `vehicle`'s, or the models' own where they agree; raises ModelError where they do not.
    Lever arms that differ within their errors become the same.
    """
    if not a.same_origin(b):
        raise ModelError(
            f"the models are of two origins (the measured point is {a.vehicle.point} of A's, "
            f"{b.vehicle.point} of B's): compare without recordings, or identify both with one lever arm"
        )
    if vehicle is not None:
        return with_common_lever(with_signals(a, vehicle), with_signals(b, vehicle))
    if not same_drive(a.vehicle, b.vehicle):
        raise ModelError(
            "the models' vehicles differ in signals, thrusters or allocation; give the vehicle file of "
            "these recordings with --vehicle"
        )
    return with_common_lever(a, b)


def _side(model: Model, label: str) -> Side:
    names = [entry.name for entry in model.recordings]
    length = sum(entry.length for entry in model.recordings)
    return Side(label, model.name, model.estimator.method, names, length, model.noise)
