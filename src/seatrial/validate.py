# SPDX-License-Identifier: MIT
"""How far a model can be trusted: scores on recordings, each beside what they must be compared with."""

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np

from seatrial.excitation import excitation
from seatrial.frames import AXES, SYMBOLS
from seatrial.model import Model
from seatrial.predict import DEFAULT_HORIZON, Prediction, predict
from seatrial.recording import Recording
from seatrial.sanity import sanity
from seatrial.statistics import kurtosis

SCORES_FORMAT = "scores 1"


class AxisScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """One velocity on one recording. RMS values in m/s or rad/s."""

    rms: float  # of measured minus predicted
    stays_constant: float  # RMS of "velocity stays constant" at the same instants
    ratio: float  # rms / stays_constant: below 1 the model is worth having
    floor: float  # what a perfect model would score, because of pose noise
    excess: float  # sqrt(rms^2 - floor^2), 0 where the score is at its floor
    bias: float  # mean of measured minus predicted
    kurtosis: float  # 3 for a normal distribution


class RecordingScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """All three velocities on one recording."""

    recording: str
    length: float  # [s]
    predictions: int
    usable: float  # share of its poses that are not left out as faulty
    seen: bool  # the model was identified from it, or from a part of it
    excited: str | None  # the axis that dominates it, if one does: Table III's pairing
    scores: dict[str, AxisScore]  # by u, v, r


class Scores(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """What `validate` found."""

    seatrial: str
    model: str
    method: str
    horizon: float  # [s]
    recordings: list[RecordingScore]


def validate(
    model: Model, recordings: Sequence[Recording], horizon: float = DEFAULT_HORIZON
) -> Scores:
    """Scores of the model on every recording, `horizon` [s] ahead. Refuses an unstable model."""
    sanity(model)
    found = [score(model, r, predict(model, r, horizon)) for r in recordings]
    return Scores(SCORES_FORMAT, model.name, model.estimator.method, horizon, found)


def score(model: Model, recording: Recording, prediction: Prediction) -> RecordingScore:
    """Scores of one prediction."""
    dominant = excitation(model.vehicle, recording).dominant
    scores = {symbol: _axis_score(prediction, axis) for axis, symbol in enumerate(SYMBOLS)}
    return RecordingScore(
        recording.name,
        recording.duration,
        len(prediction.t),
        recording.usable,
        seen(model, recording),
        None if dominant is None else AXES[dominant],
        scores,
    )


def _axis_score(prediction: Prediction, axis: int) -> AxisScore:
    errors = prediction.errors[:, axis]
    rms = float(np.sqrt(np.mean(errors**2)))
    still = float(np.sqrt(np.mean((prediction.measured - prediction.start)[:, axis] ** 2)))
    floor = float(prediction.floor[axis])
    return AxisScore(
        rms,
        still,
        rms / still if still > 0 else float("inf"),
        floor,
        float(np.sqrt(max(0.0, rms**2 - floor**2))),
        float(np.mean(errors)),
        kurtosis(errors),
    )


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
    width = max(21, *(len(r.recording) for r in scores.recordings))
    lines = [
        f"RMS error {scores.horizon:g} s ahead",
        f"  {'recording':<{width}}       error  unit   constant  ratio   floor  excess",
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
                f"{s.excess * scale:6.3f}"
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


LEGEND = """\
  constant: error if the velocity stays as it is; ratio: error / constant;
  floor: what pose noise alone makes; excess: what is left without it;
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
