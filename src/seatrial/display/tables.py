# SPDX-License-Identifier: MIT
"""A model, scores and a recording as HTML tables: what `_repr_html_` returns."""

import numpy as np

from seatrial.boat.findings import finding_text
from seatrial.boat.model import Model
from seatrial.display.html import counted, folded, plain, table
from seatrial.evaluation.scores import AxisScore, Scores
from seatrial.recording.faults.course_heading import course_doubt
from seatrial.recording.recording import Recording
from seatrial.recording.sampled_commands import sampling_doubt
from seatrial.recording.signal import Signal
from seatrial.report.text.markup import number, true_minus, unit
from seatrial.report.text.names import html_symbol
from seatrial.report.text.numbers import minutes
from seatrial.util.format import percent, plus_minus, shortened
from seatrial.util.frames import AXES, ERROR_UNITS, SYMBOLS, Axes
from seatrial.util.statistics import NORMAL_95

GIVEN = "given"  # in place of a relative error
MOST_SYMBOL = 60  # [characters] of a coefficient's name


def model_html(model: Model) -> str:
    """Coefficients and constants with standard errors, and the findings, folded."""
    errors = model.standard_errors
    rows = []
    for name, value in model.parameter_values.items():
        text = true_minus(plus_minus(value, errors[name]))
        rows.append((_symbol(name), text, unit(model.units[name]), _relative(model, name, value)))
    found = [finding_text(one) for one in model.estimator.findings]
    sentences = [*found, *model.warnings]
    caption = f"<b>{plain(model.name)}</b>: {_origin(model)}, {Axes.FLU.value} axes"
    head = ("parameter", "value ± standard error", "unit", "relative 95 % interval")
    return table(head, rows, caption=caption) + folded(
        counted(len(sentences), "finding"), sentences
    )


def scores_html(scores: Scores) -> str:
    """Error, noise floor and constant velocity's error of every recording and velocity."""
    rows = []
    for one in scores.recordings:
        for axis, symbol in enumerate(SYMBOLS):
            if symbol not in one.scores:
                continue
            name, scale = ERROR_UNITS[axis]
            where = plain(one.recording) + (" (seen)" if one.seen else "")
            cells = _score(one.scores[symbol], scale)
            rows.append((where, f"{AXES[axis]} <i>{symbol}</i>", *cells, name))
    caption = (
        f"<b>{plain(scores.model)}</b> ({plain(scores.method)}): "
        f"error {scores.horizon:g} s ahead; ratio: error over that of constant velocity"
    )
    head = ("recording", "velocity", "error", "floor", "expected", "constant", "ratio", "unit")
    sentences = [
        f"{one.recording}: {finding_text(finding)}"
        for one in scores.recordings
        for finding in one.findings
    ]
    return table(head, rows, caption=caption, words=2) + folded(
        counted(len(sentences), "finding"), sentences
    )


def recording_html(recording: Recording) -> str:
    """Length, rates, ranges of poses and commands, and faults, folded."""
    eta = recording.eta[recording.valid]
    rows: list[tuple[str, ...]] = [
        (name, *_range(eta[:, i]), own)
        for i, (name, own) in enumerate((("x", "m"), ("y", "m"), ("psi", "rad")))
    ]
    for signal in (recording.commands, recording.scales):
        rows += _signal_rows(signal)
    steps = np.diff(recording.commands.stamps) * 1e-9
    often = f"{1 / np.median(steps):.3g} Hz" if len(steps) else "one row"
    caption = (
        f"<b>{plain(recording.name)}</b>: {minutes(recording.duration)}, {len(recording.t)} poses at "
        f"{1 / recording.period:.3g} Hz, {percent(recording.usable)} usable; commands at {often}"
    )
    faults = [
        f"{one.start:.2f} to {one.end:.2f} s: {one.kind.value} ({counted(one.samples, 'pose')})"
        for one in recording.faults
    ]
    doubts = [*recording.doubts, *course_doubt(recording), *sampling_doubt(recording)]
    sentences = [*faults, *recording.remarks, *doubts]
    return table(("signal", "least", "largest", "unit"), rows, caption=caption) + folded(
        _counted_faults(len(faults), len(sentences) - len(faults)), sentences
    )


def _symbol(name: str) -> str:
    return html_symbol(name) if len(name) <= MOST_SYMBOL else plain(name)


def _origin(model: Model) -> str:
    if not model.recordings:
        return plain(model.estimator.method)
    length = minutes(sum(one.length for one in model.recordings))
    names = plain(shortened([one.name for one in model.recordings]), 200)
    return f"{plain(model.estimator.method)} from {length} ({names})"


def _relative(model: Model, name: str, value: float) -> str:
    """Half-width of the 95 % interval over the value."""
    error = model.standard_errors[name]
    if error == 0.0:
        return "at its bound" if name in model.at_bounds else GIVEN
    return "" if value == 0.0 else f"± {percent(NORMAL_95 * error / abs(value))}"


def _score(score: AxisScore, scale: float) -> tuple[str, ...]:
    expected = float("nan") if score.expected_rms is None else score.expected_rms
    errors = (score.rms, score.floor, expected, score.stays_constant)
    return *(number(scale * one, 3) for one in errors), number(score.ratio, 2)


def _signal_rows(signal: Signal | None) -> list[tuple[str, ...]]:
    if signal is None:
        return []
    return [
        (_symbol(name), *_range(signal.values[:, i]), "-") for i, name in enumerate(signal.names)
    ]


def _range(values: np.ndarray) -> tuple[str, str]:
    finite = values[np.isfinite(values)]
    if not len(finite):
        return "–", "–"
    return number(float(finite.min()), 3), number(float(finite.max()), 3)


def _counted_faults(faults: int, remarks: int) -> str:
    parts = ((faults, "fault"), (remarks, "remark"))
    return ", ".join(counted(count, word) for count, word in parts if count)
