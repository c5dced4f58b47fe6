# SPDX-License-Identifier: MIT
"""What `validate` found, for the terminal."""

from collections.abc import Iterator
from itertools import product
from typing import get_args

from seatrial.boat.findings import finding_text
from seatrial.evaluation.head_to_head import head_to_head_text
from seatrial.evaluation.residuals import in_words, significant
from seatrial.evaluation.scores import AxisScore, Interval, RecordingScore, Scores, Start
from seatrial.util.frames import AXES, ERROR_UNITS, SYMBOLS

STARTS: dict[Start, str] = {
    "stencil": "from the five-point stencil's velocity",
    "filter": "from the velocity of the model's own filter; the model alone predicts",
    "odometry": "as filter; the disturbance force that it estimates goes on and fades, as on board without poses",
}
MOST_CORRELATIONS = 2  # of the residuals of a recording with forces, shown


def validation_text(scores: Scores) -> str:
    """All tables of `validate`, with their legend."""
    beside = [] if scores.against is None else [head_to_head_text(scores.against)]
    return "\n".join([scores_text(scores), LEGEND, horizons_text(scores), *beside])


def scores_text(scores: Scores) -> str:
    """The scores as a table for the terminal; Table III's pairing is marked."""
    width = max(23, *(len(r.recording) for r in scores.recordings))
    lines = [
        f"RMS error {scores.horizon:g} s ahead",
        f"  {'recording':<{width}}       error  unit   constant  ratio   floor  expected  excess   95 % of error",
    ]
    for row in scores.recordings:
        lines += _rows(row, width)
    known = [r.recording for r in scores.recordings if r.seen]
    if known:
        lines.append(f"  note: the model was identified from {', '.join(known)}: no test of it")
    for row in scores.recordings:
        lines += _poor_axes(row)
    lines += [f"  reference: {row.recording}: {_reference(row)}" for row in scores.recordings]
    return "\n".join(lines)


def _rows(row: RecordingScore, width: int) -> Iterator[str]:
    """A line of each axis; the first columns hold `width` characters."""
    for axis, symbol in enumerate(SYMBOLS):
        s = row.scores[symbol]
        unit, scale = ERROR_UNITS[axis]
        mark = "*" if row.excited == AXES[axis] else " "
        name = (
            row.recording,
            f"  {row.predictions} predictions",
            f"  {100 * row.usable:.1f} % of poses used",
        )[axis]
        yield (
            f"  {name:<{width}}  {symbol}{mark} {s.rms * scale:7.3f}  {unit:<5}  "
            f"{s.stays_constant * scale:8.3f}  {s.ratio:5.2f}  {s.floor * scale:6.3f}  "
            f"{_expected(s.expected_rms, scale)}  {s.excess * scale:6.3f}{_mark(s)} "
            f"{_range(s.rms_interval, scale)}"
        )


def _poor_axes(row: RecordingScore) -> Iterator[str]:
    """Notes on axes in which the model is no better than constant velocity."""
    poor = {AXES[i]: row.scores[s] for i, s in enumerate(SYMBOLS) if row.scores[s].ratio > 1.0}
    bad = [axis for axis, s in poor.items() if not s.at_floor]
    hidden = [axis for axis, s in poor.items() if s.at_floor]
    if bad:
        yield (
            f"  note: {row.recording}: in {' and '.join(bad)} no better than a velocity that stays as it is"
        )
    if hidden:
        yield (
            f"  note: {row.recording}: in {' and '.join(hidden)} the error is at the noise floor: these poses "
            "do not resolve how well the model predicts"
        )


def _reference(row: RecordingScore) -> str:
    """What predictions start from and are compared with, and its standard errors."""
    if row.reference == "stencil":
        return "five-point stencil, starts too"
    errors = [
        f"{symbol} {(row.scores[symbol].reference or 0.0) * scale:.2g} {unit}"
        for symbol, (unit, scale) in zip(SYMBOLS, ERROR_UNITS, strict=True)
    ]
    return f"smoothed velocity, standard error {', '.join(errors)}; starts: the model's filter"


def _mark(score: AxisScore) -> str:
    return "=" if score.at_floor else "~" if score.as_expected else " "


def _expected(rms: float | None, scale: float) -> str:
    return f"{'-':>8}" if rms is None else f"{rms * scale:8.3f}"


def _range(interval: Interval | None, scale: float) -> str:
    if interval is None:
        return "  too short"
    return f"{interval[0] * scale:7.3f}-{interval[1] * scale:.3f}"


def horizons_text(scores: Scores) -> str:
    """Errors at all horizons, and correlation of the residuals with the forces."""
    known = sorted({x.horizon for row in scores.recordings for x in row.horizons})
    width = max(23, *(len(r.recording) for r in scores.recordings))
    head = "".join(f"{f'{h:g} s':>8}" for h in known)
    starts = [
        s
        for s in get_args(Start)
        if any(x.start == s for r in scores.recordings for x in r.horizons)
    ]
    lines = ["RMS error ahead", f"  {'recording':<{width}}  start      unit  {head}"]
    for row in scores.recordings:
        for i, (axis, start) in enumerate(product(range(3), starts)):
            unit, scale = ERROR_UNITS[axis]
            cells = [_cell(row, h, start, SYMBOLS[axis], scale) for h in known]
            name = row.recording if i == 0 else ""
            lines.append(f"  {name:<{width}}  {SYMBOLS[axis]} {start:<8} {unit:<6}{''.join(cells)}")
    lines += [f"  {start}: {STARTS[start]}" for start in starts]
    for row in scores.recordings:
        lines += [
            f"  note: {row.recording}: {text}"
            for text in (*map(finding_text, row.findings), *_left(row))
        ]
    return "\n".join(lines)


def _cell(row: RecordingScore, horizon: float, start: str, symbol: str, scale: float) -> str:
    for found in row.horizons:
        if (found.horizon, found.start) == (horizon, start):
            score = found.scores[symbol]
            return f"{score.rms * scale:7.3f}{_mark(score)}"
    return f"{'-':>7} "


def _left(row: RecordingScore) -> list[str]:
    """Significant correlations of the residuals with forces, the strongest first."""
    found = significant(row.correlations)
    shown = [in_words(c) for c in found[:MOST_CORRELATIONS]]
    if len(found) > MOST_CORRELATIONS:
        shown[-1] += f" (and {len(found) - MOST_CORRELATIONS} more, in --json)"
    return shown


LEGEND = """\
  constant: RMS of "the velocity stays constant"; ratio: error / constant;
  floor: noise floor of a perfect model, at least the reference's standard error; excess: error without it;
  =: consistent with the floor;
  expected: RMS predicted from pose noise, process noise and parameter covariance; ~: consistent with it;
  *: the axis that the recording excites, the pairing of the paper's Table III"""
