# SPDX-License-Identifier: MIT
"""How far a model can be trusted: scores on recordings, each beside what they must be compared with."""

from collections.abc import Sequence
from itertools import product
from typing import Any, Literal, get_args

import msgspec
import numpy as np
from numpy.typing import NDArray

from seatrial.against import Against, against
from seatrial.bootstrap import block_length, block_sums, ratio_interval
from seatrial.causal import Causal, believed_noise, causal
from seatrial.errors import ModelError, RecordingError
from seatrial.excitation import excitation
from seatrial.frames import AXES, SYMBOLS, Array
from seatrial.identify.first_noise import loosened
from seatrial.model import Model
from seatrial.predict import DEFAULT_HORIZON, Lookahead, Prediction, predict
from seatrial.recording import Recording
from seatrial.residuals import Correlation, in_words, residuals
from seatrial.sanity import sanity
from seatrial.statistics import kurtosis
from seatrial.stretches import stretches, stretches_said
from seatrial.velocity import SLOW

SCORES_FORMAT = "scores 2"
HORIZONS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # [s]
STARTS = 8  # in a horizon: closer ones make predictions that are nearly the same
BUMPED = 2.0  # times the errors elsewhere, of a stretch that is worth a word
MOST_SAID = 2  # sentences on the residuals of a recording
Start = Literal["stencil", "filter"]
Interval = tuple[float, float]


class AxisScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """One velocity on one recording. RMS values in m/s or rad/s."""

    rms: float  # of measured minus predicted
    stays_constant: float  # RMS of "velocity stays constant" at the same instants
    ratio: float  # rms / stays_constant: below 1 the model is worth having
    floor: float  # what a perfect model would score, because of pose noise
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
    notes: list[str] = []  # what could not be had


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
    """For every recording `HORIZONS` and the chosen one from both starts, correlations, notes."""
    try:
        noise = believed_noise(model, recordings)
        filtered = [causal(model, r, noise) for r in recordings]
    except ModelError as error:
        lost = f"no starts from a filter, no residuals: {error}"
        found = [_further(model, r, chosen, None) for r in recordings]
        return [{**each, "notes": [lost, *each["notes"]]} for each in found]
    pairs = zip(recordings, filtered, strict=True)
    found = [_further(model, recording, chosen, its) for recording, its in pairs]
    # a filter so sure of itself that it takes long to find back sees too much
    ready = loosened(noise, 1.0)
    seen = [causal(model, r, ready).residual for r in recordings]
    odd = stretches(recordings, [np.sum(residual**2, axis=1) for residual in seen])
    for i, each in enumerate(found):
        own = [s for s in odd if s.recording == i and s.times > BUMPED]
        each["notes"] += [stretches_said(recordings, own)] if own else []
    return found


def _further(
    model: Model, recording: Recording, chosen: float, filtered: Causal | None
) -> dict[str, Any]:
    every, notes = lookaheads(model, recording, chosen, filtered)
    found = [
        HorizonScore(horizon, ahead.steps, name, len(ahead.t), axis_scores(ahead))
        for horizon, name, ahead in every
    ]
    left = [] if filtered is None else residuals(model, recording, filtered)
    if recording.period > SLOW:
        notes.append(
            f"poses are {recording.period:.2g} s apart: velocities by the stencil, which errors are taken "
            "against, miss what the boat does within four of them; excess is theirs, too"
        )
    return {"horizons": found, "correlations": left, "notes": notes}


def lookaheads(
    model: Model, recording: Recording, chosen: float, filtered: Causal | None
) -> tuple[list[tuple[float, Start, Prediction]], list[str]]:
    """Predictions at all `HORIZONS` and the chosen one [s], as far as the recording allows.

    From the stencil's starts, and from the filter's where there is one; and what could not be had.
    """
    found: list[tuple[float, Start, Prediction]] = []
    notes: list[str] = []
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
            notes.append(str(error))
            break
    return found, notes


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


def scores_text(scores: Scores) -> str:
    """The scores as a table for the terminal; Table III's pairing is marked."""
    width = max(23, *(len(r.recording) for r in scores.recordings))
    lines = [
        f"RMS error {scores.horizon:g} s ahead",
        f"  {'recording':<{width}}       error  unit   constant  ratio   floor  excess   95 % of error",
    ]
    for row in scores.recordings:
        for axis, symbol in enumerate(SYMBOLS):
            s = row.scores[symbol]
            scale, unit = (100.0, "cm/s") if axis < 2 else (1.0, "rad/s")
            mark = "*" if row.excited == AXES[axis] else " "
            name = (
                row.recording,
                f"  {row.predictions} predictions",
                f"  {100 * row.usable:.1f} % of poses used",
            )[axis]
            lines.append(
                f"  {name:<{width}}  {symbol}{mark} {s.rms * scale:7.3f}  {unit:<5}  "
                f"{s.stays_constant * scale:8.3f}  {s.ratio:5.2f}  {s.floor * scale:6.3f}  "
                f"{s.excess * scale:6.3f}{'=' if s.at_floor else ' '} {_range(s.rms_interval, scale)}"
            )
    known = [r.recording for r in scores.recordings if r.seen]
    if known:
        lines.append(f"  note: the model was identified from {', '.join(known)}: no test of it")
    for row in scores.recordings:
        bad = [AXES[i] for i, s in enumerate(SYMBOLS) if row.scores[s].ratio > 1.0]
        if bad:
            lines.append(
                f"  note: {row.recording}: in {' and '.join(bad)} no better than a velocity that stays as it is"
            )
    return "\n".join(lines)


def _range(interval: Interval | None, scale: float) -> str:
    if interval is None:
        return "  too short"
    return f"{interval[0] * scale:7.3f}-{interval[1] * scale:.3f}"


def horizons_text(scores: Scores) -> str:
    """Errors at all horizons, and what residuals still have to do with the forces."""
    known = sorted({x.horizon for row in scores.recordings for x in row.horizons})
    width = max(23, *(len(r.recording) for r in scores.recordings))
    head = "".join(f"{f'{h:g} s':>8}" for h in known)
    lines = [
        "RMS error ahead, from the stencil's starts and from the model's own filter's",
        f"  {'recording':<{width}}  start      unit  {head}",
    ]
    for row in scores.recordings:
        for i, (axis, start) in enumerate(product(range(3), get_args(Start))):
            scale, unit = (100.0, "cm/s") if axis < 2 else (1.0, "rad/s")
            cells = [_cell(row, h, start, SYMBOLS[axis], scale) for h in known]
            name = row.recording if i == 0 else ""
            lines.append(
                f"  {name:<{width}}  {SYMBOLS[axis]} {start:<7}  {unit:<6}{''.join(cells)}"
            )
    for row in scores.recordings:
        lines += [f"  note: {row.recording}: {text}" for text in (*row.notes, *_left(row))]
    return "\n".join(lines)


def _cell(row: RecordingScore, horizon: float, start: str, symbol: str, scale: float) -> str:
    for found in row.horizons:
        if (found.horizon, found.start) == (horizon, start):
            score = found.scores[symbol]
            return f"{score.rms * scale:7.3f}{'=' if score.at_floor else ' '}"
    return f"{'-':>7} "


def _left(row: RecordingScore) -> list[str]:
    """What its residuals say, the clearest first."""
    found = sorted(
        (c for c in row.correlations if c.found), key=lambda c: abs(c.peak) / c.limit, reverse=True
    )
    said = [in_words(c) for c in found[:MOST_SAID]]
    if len(found) > MOST_SAID:
        said[-1] += f" (and {len(found) - MOST_SAID} more, in --json)"
    return said


LEGEND = """\
  constant: error if the velocity stays as it is; ratio: error / constant;
  floor: what pose noise alone makes; excess: what is left without it; =: may be the floor alone;
  *: the axis that the recording excites, the pairing of the paper's Table III"""


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
