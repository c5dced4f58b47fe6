# SPDX-License-Identifier: MIT
"""Head-to-head comparison of two models (`--against`), each from two kinds of start velocity.

The error of a prediction contains that of its start. Stencil starts carry the same pose noise into
both models; a filter's starts depend on the model that it runs on.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

import msgspec
import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import axis_physics
from seatrial.evaluation.filtering import filter_noise, run_filter
from seatrial.evaluation.predicted import Prediction
from seatrial.evaluation.prediction import DEFAULT_HORIZON, predict
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion, motion
from seatrial.util.block_bootstrap import block_length, block_sums, ratio_interval
from seatrial.util.errors import ModelError
from seatrial.util.frames import ERROR_UNITS, SYMBOLS, Array

CELLS = ("model, stencil", "model, filter", "other, stencil", "other, filter")
PAIRS = {  # cells that are compared: (over, under)
    "model, from stencil starts": (0, 2),
    "model, from filter starts": (1, 3),
    "start, under model": (1, 0),
    "start, under other": (3, 2),
    "model and start": (1, 2),
}


class RmsRatio(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """Ratio of two RMS errors at the same instants."""

    difference: float  # [m/s] or [rad/s] RMS minus that of the other
    ratio: float  # RMS over that of the other; below 1 is better
    interval: tuple[float, float] | None  # of the ratio, 95 %; None: the recording is too short
    significant: bool  # the interval excludes 1


class ModelScore(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """Score of one model from one kind of start."""

    rms: float  # [m/s] or [rad/s] of reference minus prediction
    interval: tuple[float, float] | None  # 95 %
    floor: float  # noise floor: RMS of a perfect model from this start
    excess: float  # excess over the floor: sqrt(rms^2 - floor^2)


class HeadToHeadTable(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """The 2 x 2 table of one recording, for one velocity."""

    recording: str
    symbol: str  # u, v, r
    predictions: int
    cells: dict[str, ModelScore]  # by CELLS
    changes: dict[str, RmsRatio]  # by PAIRS


class HeadToHead(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=False):
    """Head-to-head comparison of two models on the same recordings."""

    model: str  # method
    other: str
    horizon: float  # [s]
    reference: str  # source of the velocities that predictions are compared with
    duels: list[HeadToHeadTable]


def head_to_head(
    model: Model,
    other: Model,
    recordings: Sequence[Recording],
    horizon: float = DEFAULT_HORIZON,
    *,
    velocities: Mapping[str, Motion] | None = None,
) -> HeadToHead:
    """The 2 x 2 table of every recording: this model or the other, stencil or filter starts.

    All four predict the same instants. The reference is the stencil's velocities, or `velocities` by
    recording (the truth of simulated trials). Raises ModelError where a model is unstable or diverges,
    has other commands than the recordings, or where the two origins differ.
    """
    # 1. Both models must be of one origin, stable, and driven by the recorded commands.
    _refuse_incomparable(model, other, recordings)
    # 2. Noise of both filters, from all recordings.
    known = velocities or {}
    noises = [filter_noise(one, recordings) for one in (model, other)]
    # 3. Four predictions of the same instants, from stencil and filter starts.
    duels = []
    for recording in recordings:
        stencil, filters = motion(recording), [
            run_filter(one, recording, noise).motion
            for one, noise in zip((model, other), noises, strict=True)
        ]  # fmt: skip
        truth = known.get(recording.name)
        both = stencil.valid & filters[0].valid & filters[1].valid
        ahead = [
            predict(one, recording, horizon, velocities=truth, starts=replace(start, valid=both))
            for one, filtered in zip((model, other), filters, strict=True)
            for start in (stencil, filtered)
        ]
        # 4. RMS errors, floors, and their ratios with intervals.
        duels += _tables(recording, ahead)
    reference = "stencil" if velocities is None else "given"
    return HeadToHead(model.estimator.method, other.estimator.method, horizon, reference, duels)


def _refuse_incomparable(model: Model, other: Model, recordings: Sequence[Recording]) -> None:
    """Raise ModelError for another origin, an unstable model, or other commands than the recordings'."""
    if not model.same_origin(other):
        raise ModelError(
            f"different origins: the measured point is {model.vehicle.point} of the model's, "
            f"{other.vehicle.point} of the other's; identify both with one lever arm (pose: lever in the vehicle "
            "file)"
        )
    for one in (model, other):
        axis_physics(one)
    for one, recording in product((model, other), recordings):
        if recording.commands.names != one.vehicle.inputs:
            raise ModelError(
                f"{recording.name}: has commands {', '.join(recording.commands.names)}; model "
                f"{one.name} is driven by {', '.join(one.vehicle.inputs)}: only models of one "
                "boat and its commands can be compared"
            )


def _tables(recording: Recording, ahead: Sequence[Prediction]) -> list[HeadToHeadTable]:
    squares = np.stack([p.errors**2 for p in ahead], axis=-1)  # (m, 3, 4)
    index, steps, samples = ahead[0].index, ahead[0].steps, len(squares)
    flat = squares.reshape(samples, -1)
    length = block_length(flat, index, steps)
    blocks = block_sums(np.column_stack([flat, np.ones(samples)]), index, length)
    found = []
    for axis, symbol in enumerate(SYMBOLS):
        mean = squares[:, axis].mean(axis=0)
        own = None if blocks is None else blocks[:, 4 * axis : 4 * axis + 4]
        count = None if blocks is None else np.repeat(blocks[:, -1:], 4, axis=1)
        floors = [float(p.floor[axis]) for p in ahead]
        found.append(
            HeadToHeadTable(
                recording.name, symbol, samples,
                dict(zip(CELLS, _cells(mean, floors, own, count), strict=True)),
                dict(zip(PAIRS, _changes(mean, own), strict=True)),
            )
        )  # fmt: skip
    return found


def _cells(
    mean: Array, floors: Sequence[float], own: Array | None, count: Array | None
) -> list[ModelScore]:
    ranges = _rms_intervals(own, count, len(mean))
    return [
        ModelScore(float(np.sqrt(m)), r, f, float(np.sqrt(max(0.0, m - f**2))))
        for m, r, f in zip(mean.tolist(), ranges, floors, strict=True)
    ]


def _changes(mean: Array, own: Array | None) -> list[RmsRatio]:
    over, under = np.array(list(PAIRS.values())).T
    rms = np.sqrt(mean)
    ranges = _rms_intervals(
        None if own is None else own[:, over], None if own is None else own[:, under], len(over)
    )
    return [
        RmsRatio(
            float(rms[i] - rms[j]),
            float(rms[i] / rms[j]),
            r,
            r is not None and not r[0] <= 1 <= r[1],
        )
        for i, j, r in zip(over, under, ranges, strict=True)
    ]


def _rms_intervals(
    over: Array | None, under: Array | None, n: int
) -> list[tuple[float, float] | None]:
    """95 % intervals of RMS errors, or of their ratios."""
    if over is None or under is None:
        return [None] * n
    return [(float(a), float(b)) for a, b in np.sqrt(ratio_interval(over, under))]


def head_to_head_text(table: HeadToHead) -> str:
    """The 2 x 2 tables for the terminal."""
    width = max(9, *(len(d.recording) for d in table.duels))
    lines = [
        f"RMS error {table.horizon:g} s ahead: model ({table.model}) against other ({table.other}), "
        "same instants",
        f"  {'recording':<{width}}  unit    "
        + "".join(f"{name:>16}" for name in CELLS)
        + "   model/other from a filter",
    ]
    for duel in table.duels:
        unit, scale = ERROR_UNITS[SYMBOLS.index(duel.symbol)]
        name = duel.recording if duel.symbol == SYMBOLS[0] else ""
        cells = "".join(f"{duel.cells[c].rms * scale:16.3f}" for c in CELLS)
        change = duel.changes["model, from filter starts"]
        lines.append(f"  {name:<{width}}  {duel.symbol} {unit:<6}{cells}   {_ratio_text(change)}")
    return "\n".join(lines)


def _ratio_text(change: RmsRatio) -> str:
    if change.interval is None:
        return f"{change.ratio:.2f} (too short for an interval)"
    low, high = change.interval
    verdict = "the same" if not change.significant else "better" if change.ratio < 1 else "worse"
    return f"{change.ratio:.2f} ({low:.2f}-{high:.2f}): {verdict}"
