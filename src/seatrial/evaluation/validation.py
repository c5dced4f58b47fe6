# SPDX-License-Identifier: MIT
"""How far a model can be trusted: scores on recordings, each beside what they must be compared with."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any, Literal, Protocol

import msgspec
import numpy as np
from numpy.typing import NDArray

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import loosened
from seatrial.boat.physics import sanity
from seatrial.evaluation.disturbed_intervals import stretches, stretches_found
from seatrial.evaluation.filtering import Causal, believed_noise, causal
from seatrial.evaluation.head_to_head import Against, against
from seatrial.evaluation.prediction import DEFAULT_HORIZON, Lookahead, Prediction, predict
from seatrial.evaluation.residuals import Correlation, residuals
from seatrial.recording.excitation import excitation
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import SLOW
from seatrial.util.block_bootstrap import block_length, block_sums, ratio_interval
from seatrial.util.errors import ModelError, RecordingError
from seatrial.util.frames import AXES, SYMBOLS, Array
from seatrial.util.statistics import kurtosis

SCORES_FORMAT = "scores 4"
HORIZONS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # [s]
STARTS = 8  # in a horizon: closer ones make predictions that are nearly the same
BUMPED = 2.0  # times the errors elsewhere, of a stretch that is worth a word
BEYOND = 1.25  # times what the model foresees of itself, from which on that is worth a word
OFF = 2.0  # standard errors of coefficients that are nothing to speak of
NOISIER = 0.05  # as many of pose noise, by the median fourth difference of some 3000 poses
WIDER = 1.5  # times its interval, as all horizons are looked at: 2.9 standard errors
SHARED = 2  # poses ahead to which the filter has used poses that the reference uses, too
SOON = 0.5  # [s] until then a boat that has changed hardly shows it, but poses show how they err
Start = Literal["stencil", "filter"]
Interval = tuple[float, float]


class AxisScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """One velocity on one recording. RMS values in m/s or rad/s."""

    rms: float  # of measured minus predicted
    stays_constant: float  # RMS of "velocity stays constant" at the same instants
    ratio: float  # rms / stays_constant: below 1 the model is worth having
    floor: float  # what a perfect model would score, because of pose noise
    # what the model says of itself: floor, the force that it leaves out, uncertain coefficients
    foreseen: float | None
    unsure: float | None  # the part of it that these coefficients make
    excess: float  # sqrt(rms^2 - floor^2), 0 where the score is at its floor
    bias: float  # mean of measured minus predicted
    kurtosis: float  # 3 for a normal distribution
    # 95 % by bootstrap over blocks of time; None where the recording has too few of them
    rms_interval: Interval | None
    stays_constant_interval: Interval | None
    ratio_interval: Interval | None
    excess_interval: Interval | None

    @property
    def at_floor(self) -> bool:
        """Whether pose noise alone may have made this score."""
        return self.rms <= self.floor or (
            self.rms_interval is not None and self.rms_interval[0] <= self.floor
        )

    @property
    def as_foreseen(self) -> bool:
        """Whether it may be no more than the model says of itself."""
        most = self.at_most
        return most is not None and (
            self.rms <= most or (self.rms_interval is not None and self.rms_interval[0] <= most)
        )

    @property
    def at_most(self) -> float | None:
        """What is foreseen where coefficients and pose noise are off by two of their standard errors.

        They are off once for all predictions, so that no interval of the error knows of it.
        """
        if self.foreseen is None or self.unsure is None:
            return self.foreseen
        more = (OFF**2 - 1.0) * self.unsure**2 + ((1.0 + NOISIER) ** 2 - 1.0) * self.floor**2
        return float(np.sqrt(self.foreseen**2 + more))


class HorizonScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """One recording at one horizon, from one kind of start."""

    horizon: float  # [s] that was asked for
    steps: int  # poses
    start: Start  # of the predictions: the stencil's velocity, or the model's own causal filter's
    predictions: int
    scores: dict[str, AxisScore]  # by u, v, r


class RecordingScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """All three velocities on one recording."""

    recording: str
    length: float  # [s]
    predictions: int
    usable: float  # share of its poses that are not left out as faulty
    seen: bool  # the model was identified from it, or from a part of it
    excited: str | None  # the axis that dominates it, if one does: Table III's pairing
    scores: dict[str, AxisScore]  # by u, v, r; at the horizon that was asked for
    horizons: list[HorizonScore] = []
    correlations: list[Correlation] = []  # of the filter's residuals with the forces
    findings: list[Finding] = []  # disturbances, errors beyond the expected, what could not be had


class Scores(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """What `validate` found."""

    seatrial: str
    model: str
    method: str
    horizon: float  # [s]
    recordings: list[RecordingScore]
    against: Against | None = None  # another model, where one was given


def validate(
    model: Model,
    recordings: Sequence[Recording],
    horizon: float = DEFAULT_HORIZON,
    *,
    other: Model | None = None,
) -> Scores:
    """Scores of the model on every recording, `horizon` [s] ahead, and at all `HORIZONS`.

    With an `other` model also the table of `against`. Refuses an unstable model, and one that runs
    away within `horizon`.
    """
    sanity(model)
    found = [score(model, r, predict(model, r, horizon)) for r in recordings]
    more = further(model, recordings, horizon)
    found = [msgspec.structs.replace(s, **m) for s, m in zip(found, more, strict=True)]
    beside = None if other is None else against(model, other, recordings, horizon)
    return Scores(SCORES_FORMAT, model.name, model.estimator.method, horizon, found, beside)


def score(model: Model, recording: Recording, prediction: Prediction) -> RecordingScore:
    """Scores of one prediction."""
    dominant = excitation(model.vehicle, recording).dominant
    return RecordingScore(
        recording.name,
        recording.duration,
        len(prediction.t),
        recording.usable,
        seen(model, recording),
        None if dominant is None else AXES[dominant],
        axis_scores(prediction),
    )


def axis_scores(prediction: Prediction) -> dict[str, AxisScore]:
    """Scores of one prediction by u, v, r, with their intervals."""
    errors, index = prediction.errors, prediction.index
    squares = np.column_stack([errors, prediction.measured - prediction.start]) ** 2
    intervals = _intervals(squares, index, prediction.steps)
    return {
        symbol: _axis_score(prediction, axis, intervals[axis])
        for axis, symbol in enumerate(SYMBOLS)
    }


def _intervals(squares: Array, index: NDArray[np.int64], steps: int) -> list[list[Interval | None]]:
    """Of RMS, of that of what stays constant, and of their ratio; axis by axis."""
    if not np.all(squares.sum(axis=0) > 0.0):  # a boat that never moves
        return [[None] * 3] * 3
    blocks = block_sums(
        np.column_stack([squares, np.ones(len(squares))]),
        index,
        block_length(squares, index, steps),
    )
    if blocks is None:
        return [[None] * 3] * 3
    own, still, count = blocks[:, :3], blocks[:, 3:6], np.repeat(blocks[:, 6:], 3, axis=1)
    found = np.sqrt(ratio_interval(np.hstack([own, still, own]), np.hstack([count, count, still])))
    pairs = [(float(low), float(high)) for low, high in found]
    return [[pairs[axis], pairs[3 + axis], pairs[6 + axis]] for axis in range(3)]


def _axis_score(
    prediction: Prediction, axis: int, intervals: Sequence[Interval | None]
) -> AxisScore:
    errors = prediction.errors[:, axis]
    rms = float(np.sqrt(np.mean(errors**2)))
    still = float(np.sqrt(np.mean((prediction.measured - prediction.start)[:, axis] ** 2)))
    floor = float(prediction.floor[axis])
    own, constant, ratio = intervals
    return AxisScore(
        rms,
        still,
        rms / still if still > 0 else float("inf"),
        floor,
        None if prediction.foreseen is None else float(prediction.foreseen[axis]),
        None if prediction.unsure is None else float(prediction.unsure[axis]),
        _beyond(rms, floor),
        float(np.mean(errors)),
        kurtosis(errors),
        own,
        constant,
        ratio,
        None if own is None else (_beyond(own[0], floor), _beyond(own[1], floor)),
    )


def _beyond(rms: float, floor: float) -> float:
    return float(np.sqrt(max(0.0, rms**2 - floor**2)))


def further(
    model: Model, recordings: Sequence[Recording], chosen: float = DEFAULT_HORIZON
) -> list[dict[str, Any]]:
    """For every recording `HORIZONS` and the chosen one from both starts, correlations, findings."""
    try:
        noise = believed_noise(model, recordings)
        filtered = [causal(model, r, noise) for r in recordings]
    except ModelError as error:
        lost = finding_of(FindingKind.NO_FILTER, reason=str(error))
        found = [_further(model, r, chosen, None) for r in recordings]
        return [{**each, "findings": [lost, *each["findings"]]} for each in found]
    pairs = zip(recordings, filtered, strict=True)
    found = [_further(model, recording, chosen, its) for recording, its in pairs]
    # a filter so sure of itself that it takes long to find back sees too much
    ready = loosened(noise, 1.0)
    seen = [causal(model, r, ready).residual for r in recordings]
    odd = stretches(recordings, [np.sum(residual**2, axis=1) for residual in seen])
    for i, each in enumerate(found):
        own = [s for s in odd if s.recording == i and s.times > BUMPED]
        each["findings"] += stretches_found(recordings, own)
    return found


def _further(
    model: Model, recording: Recording, chosen: float, filtered: Causal | None
) -> dict[str, Any]:
    every, findings = lookaheads(model, recording, chosen, filtered)
    found = [
        HorizonScore(horizon, ahead.steps, name, len(ahead.t), axis_scores(ahead))
        for horizon, name, ahead in every
    ]
    left = [] if filtered is None else residuals(model, recording, filtered)
    findings += unforeseen(found, seen(model, recording))
    if recording.period > SLOW:
        findings.append(finding_of(FindingKind.SLOW_POSES, period=recording.period))
    return {"horizons": found, "correlations": left, "findings": findings}


def lookaheads(
    model: Model, recording: Recording, chosen: float, filtered: Causal | None
) -> tuple[list[tuple[float, Start, Prediction]], list[Finding]]:
    """Predictions at all `HORIZONS` and the chosen one [s], as far as the recording allows.

    From the stencil's starts, and from the filter's where there is one; and what could not be had.
    """
    found: list[tuple[float, Start, Prediction]] = []
    findings: list[Finding] = []
    starts: list[tuple[Start, Lookahead]] = [("stencil", Lookahead(model, recording))]
    if filtered is not None:
        starts.append(("filter", Lookahead(model, recording, starts=filtered.motion)))
    for horizon, (name, look) in product(sorted({*HORIZONS, chosen}), starts):
        if horizon < recording.period:
            continue
        apart = max(1, round(horizon / recording.period) // STARTS)
        try:
            found.append((horizon, name, look.predict(horizon, 1 if horizon == chosen else apart)))
        except RecordingError:  # no stretch is as long
            continue
        except ModelError as error:
            findings.append(finding_of(FindingKind.HORIZON_NOT_PREDICTED, reason=str(error)))
            break
    return found, findings


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
    def scores(self) -> Mapping[str, AxisScore]:
        """By u, v, r."""


def unforeseen(scores: Iterable[Scored], known: bool) -> list[Finding]:
    """Axes in which errors are larger than the model says of itself, and why.

    known: the model was identified from it. A filter's start and a reference that share poses share errors:
    there is no finding on them.
    """
    apart = (x for x in scores if x.start == "stencil" or x.steps > SHARED)
    rows = [(x.horizon, x.scores) for x in apart]
    beyond = [_surprises(rows, symbol) for symbol in SYMBOLS]
    most = {axis: max(found) for axis, found in zip(AXES, beyond, strict=True) if found}
    if not most:
        return []
    farthest = max(horizon for horizon, _ in rows)
    if all(max(x)[1] < SOON and max(h for _, h in x) < farthest for x in beyond if x):
        cause = "pose noise"
    else:
        cause = "model mismatch" if known else "change"
    return [
        finding_of(
            FindingKind.EXCEEDS_EXPECTED_ERROR, axis, ratio=ratio, horizon=horizon, cause=cause
        )
        for axis, (ratio, horizon) in most.items()
    ]


def _surprises(
    rows: Iterable[tuple[float, Mapping[str, AxisScore]]], symbol: str
) -> list[tuple[float, float]]:
    """Errors over what the model foresees, where they are beyond that, and how far ahead [s]."""
    return [
        (score.rms / score.foreseen, horizon)
        for horizon, scores in rows
        if (score := scores[symbol]).foreseen and _beyond_doubt(score)
    ]


def _beyond_doubt(score: AxisScore) -> bool:
    """Whether it is larger than foreseen, by more than both chances explain.

    Blocks of time differ, as the interval says; coefficients are off once for all of them.
    """
    most = score.at_most
    if most is None or score.unsure is None or score.rms_interval is None:
        return False
    least = score.rms * (score.rms_interval[0] / score.rms) ** WIDER
    return score.rms > BEYOND * most and least > most


def seen(model: Model, recording: Recording) -> bool:
    """Whether the model was identified from any part of it: same file (or name), same seconds."""
    own = {source.sha256 for source in recording.sources}
    begin, end = recording.offset, recording.offset + recording.duration
    for entry in model.recordings:
        files = {file.sha256 for file in entry.files}
        same = own == files if own and files else recording.name == entry.name
        if same and begin < entry.start + entry.length and entry.start < end:
            return True
    return False


def scores_json(scores: Scores) -> dict[str, object]:
    """The content of `scores.json`."""
    content: dict[str, object] = _finite(msgspec.to_builtins(scores))
    return content


def _finite(content: Any) -> Any:  # noqa: ANN401
    """JSON has no infinity and no NaN: null (a boat that never moves has no ratio)."""
    if isinstance(content, dict):
        return {key: _finite(value) for key, value in content.items()}
    if isinstance(content, list):
        return [_finite(value) for value in content]
    return None if isinstance(content, float) and not np.isfinite(content) else content
