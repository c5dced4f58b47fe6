# SPDX-License-Identifier: MIT
"""Scores as values, and their file: what `validate` writes and `report` reads."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

import msgspec
import numpy as np

from seatrial.boat.findings import Finding
from seatrial.boat.model import Model
from seatrial.boat.older_files.notes import with_findings
from seatrial.evaluation.head_to_head import HeadToHead
from seatrial.evaluation.reference import Reference
from seatrial.evaluation.residuals import Correlation
from seatrial.util.above import above, text_by
from seatrial.util.files import convert, expect_format, finite_or_none, read_json

if TYPE_CHECKING:
    from seatrial.util.above import Figure

SCORES_FORMAT = "scores 6"
WITHOUT_ODOMETRY = "scores 5"  # no predictions with the disturbance
WITHOUT_REFERENCE = "scores 4"  # all of it relative to the stencil's velocities
# without pooled scores and fingerprint, and with sentences in place of findings
WITH_SENTENCES = "scores 3"
GOOD_RATIO = 0.8  # RMS over constant velocity's: above it an axis is predicted hardly better
OFF = 2.0  # standard errors by which coefficients may be off without a finding
# the same of pose noise, relative: by the median fourth difference of some 3000 poses
POSE_NOISE_ERROR = 0.05
NOT_FINITE = {"ratio": math.inf, "kurtosis": math.nan}  # of a boat that never moves
# what predictions start from: the stencil's velocity; the model's own causal filter's; the same with the filter's
# disturbance, which continues and decays: what odometry on board predicts without poses
Start = Literal["stencil", "filter", "odometry"]
Interval = tuple[float, float]


# keys of scores files that are other than the attributes
FILE_KEYS = {"expected_rms": "foreseen", "parameter_rms": "unsure"}


class AxisScore(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False, rename=FILE_KEYS
):
    """One velocity on one recording. RMS values in m/s, m/s, rad/s for u, v, r.

    rms: of the predicted velocity; with a smoothed reference its uncertainty is part of it
    stays_constant: RMS of "velocity stays constant" at the same instants
    ratio: rms / stays_constant: below 1 the model predicts better than that
    floor: what a perfect model would score, because of pose noise; at least the reference's
        standard error
    expected_rms: by the model itself: noise floor, process noise, parameter errors; None without
        process noise
    parameter_rms: its part by parameter errors
    excess: sqrt(rms^2 - floor^2), 0 where the score is at its floor
    bias: mean of measured minus predicted
    kurtosis: 3 for a normal distribution
    rms_interval: 95 % by bootstrap over blocks of time; None where the recording has too few of
        them
    stays_constant_interval: the same of `stays_constant`
    ratio_interval: the same of `ratio`
    excess_interval: the same of `excess`
    reference: RMS standard error of a smoothed reference
    """

    rms: float
    stays_constant: float
    ratio: float
    floor: float
    expected_rms: float | None
    parameter_rms: float | None
    excess: float
    bias: float
    kurtosis: float
    rms_interval: Interval | None
    stays_constant_interval: Interval | None
    ratio_interval: Interval | None
    excess_interval: Interval | None
    reference: float | None = None

    @property
    def at_floor(self) -> bool:
        """Whether pose noise alone may have made this score."""
        return self._within(self.resolved(self.floor))

    def resolved(self, error: float) -> float:
        """RMS of an error against the reference, whose own standard error adds to it."""
        return float(np.hypot(error, self.reference or 0.0))

    @property
    def as_expected(self) -> bool:
        """Whether the error may be no more than the model expects of itself."""
        return self.at_most is not None and self._within(self.at_most)

    def _within(self, most: float) -> bool:
        """Whether the error, or the low end of its interval, is at most that."""
        return self.rms <= most or (self.rms_interval is not None and self.rms_interval[0] <= most)

    @property
    def at_most(self) -> float | None:
        """The expected error where coefficients and pose noise are off by two of their standard errors.

        They are off once for all predictions, so that no interval of the error knows of it.
        """
        if self.expected_rms is None:
            return None
        if self.parameter_rms is None:
            return self.resolved(self.expected_rms)
        more = (OFF**2 - 1.0) * self.parameter_rms**2 + (
            (1.0 + POSE_NOISE_ERROR) ** 2 - 1.0
        ) * self.floor**2
        return self.resolved(float(np.sqrt(self.expected_rms**2 + more)))


class HorizonScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """One recording at one horizon, from one kind of start.

    horizon: [s] the chosen one
    steps: poses
    start: what predictions start from
    predictions: number of them
    scores: by u, v, r
    """

    horizon: float
    steps: int
    start: Start
    predictions: int
    scores: dict[str, AxisScore]


class PooledScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """Several recordings together at one horizon, from one kind of start.

    horizon: [s]
    steps: poses, the fewest
    start: what predictions start from
    recordings: number of them
    predictions: number of them
    scores: by u, v, r
    """

    horizon: float
    steps: int
    start: Start
    recordings: int
    predictions: int
    scores: dict[str, AxisScore]


class RecordingScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """All three velocities on one recording.

    recording: its name
    length: [s]
    predictions: number of them
    usable: share of its poses that are not left out as faulty
    seen: the model was identified from it, or from a part of it
    excited: the axis that dominates it, if one does: Table III's pairing
    scores: by u, v, r; at the chosen horizon
    horizons: scores at further horizons, from each kind of start
    correlations: of the filter's residuals with the forces
    findings: disturbances, errors beyond the expected, what could not be had
    reference: what predictions are compared with: smoothed velocities, predicted from the filter's,
        or the stencil's
    """

    recording: str
    length: float
    predictions: int
    usable: float
    seen: bool
    excited: str | None
    scores: dict[str, AxisScore]
    horizons: list[HorizonScore] = []
    correlations: list[Correlation] = []
    findings: list[Finding] = []
    reference: Reference = "stencil"


class Scores(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """Scores of `validate`.

    seatrial: kind and version of the content
    model: its name
    method: that identified it
    horizon: [s]
    recordings: one for each recording
    against: another model, where one was given
    pooled: recordings that judge the model, together: see `judged`
    fingerprint: of the model's numbers
    reference: the chosen one; a recording without a filter has the stencil's
    """

    seatrial: str
    model: str
    method: str
    horizon: float
    recordings: list[RecordingScore]
    against: HeadToHead | None = None
    pooled: list[PooledScore] = []
    fingerprint: str = ""
    reference: Reference = "stencil"

    def plot(self, figure: Figure | None = None) -> Figure:
        """Error over horizon of each velocity, with Matplotlib, beside what it must be compared with.

        That is the noise floor, the error that the model expects, and the error of constant velocity. Draws on
        `figure` where one is given. Raises SeatrialError where Matplotlib is not installed.
        """
        drawn: Figure = above("display.scores_plot", "plot_scores")(self, figure)
        return drawn

    __str__ = text_by("evaluation.console", "validation_text")
    _repr_html_ = text_by("display.tables", "scores_html")


class Scored(Protocol):
    """What was scored so far ahead: `HorizonScore`, or several recordings together."""

    @property
    def horizon(self) -> float:
        """How far [s]."""

    @property
    def steps(self) -> int:
        """How far in poses; of several recordings the fewest."""

    @property
    def start(self) -> Start:
        """What predictions start from."""

    @property
    def predictions(self) -> int:
        """How many."""

    @property
    def scores(self) -> Mapping[str, AxisScore]:
        """By u, v, r."""


def main_start(rows: Sequence[Scored]) -> Start:
    """The start whose errors count: the filter's beside a smoothed reference, else the stencil's."""
    smoothed = any(s.reference is not None for row in rows for s in row.scores.values())
    return "filter" if smoothed else "stencil"


def fingerprint(model: Model) -> str:
    """Digest of a model's numbers: scores are of this model and of no other."""
    numbers = np.concatenate([model.coefficients, model.constants, model.covariance.ravel()])
    return hashlib.sha256(numbers.tobytes()).hexdigest()


def scores_json(scores: Scores) -> dict[str, object]:
    """The content of `scores.json`."""
    content: dict[str, object] = finite_or_none(msgspec.to_builtins(scores))
    return content


def load_scores(path: Path) -> Scores:
    """Scores from their file. Raises FileError."""
    earlier = (WITHOUT_ODOMETRY, WITHOUT_REFERENCE, WITH_SENTENCES)
    content = expect_format(read_json(path), SCORES_FORMAT, path, earlier=earlier)
    if content["seatrial"] == WITH_SENTENCES:
        content = {**content, "recordings": _with_findings(content.get("recordings"), path)}
    rows = _objects(content.get("recordings"))
    for scored in [*rows, *_objects(content.get("pooled"))]:
        _restore(scored)
    for scored in (one for row in rows for one in _objects(row.get("horizons"))):
        _restore(scored)
    return convert(content, Scores, path, finite=False)


def _with_findings(rows: object, path: Path) -> object:
    """Recordings of an earlier file with findings in place of their sentences."""
    if not isinstance(rows, list):
        return rows
    return [with_findings(row, f"{path}: recordings[{i}]") for i, row in enumerate(rows)]


def _objects(value: object) -> list[dict[str, Any]]:
    """The mappings of a list; whatever else it is, `convert` names."""
    return [one for one in value if isinstance(one, dict)] if isinstance(value, list) else []


def _restore(scored: dict[str, Any]) -> None:
    """Null, which JSON has in place of infinity and NaN, as the number that it was."""
    scores = scored.get("scores")
    for axis in _objects(list(scores.values()) if isinstance(scores, dict) else None):
        for name, value in NOT_FINITE.items():
            axis[name] = value if axis.get(name, 0.0) is None else axis.get(name)
