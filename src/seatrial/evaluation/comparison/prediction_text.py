# SPDX-License-Identifier: MIT
"""Predictions of two models in words: errors of each axis, and which predicts better."""

from collections.abc import Iterator, Mapping
from math import floor, log10

from seatrial.evaluation.comparison.compare import Comparison
from seatrial.evaluation.comparison.parameters import SIGNIFICANCE
from seatrial.evaluation.comparison.prediction import (
    AxisDifference,
    PredictionRow,
    beyond_same_boat,
)
from seatrial.util.frames import AXES, ERROR_UNITS, SYMBOLS

SLIGHT_DIFFERENCE = 0.005  # of the error; a smaller difference is negligible, however significant


def prediction_lines(found: Comparison) -> Iterator[str]:
    """Errors of both models at each horizon, and what follows."""
    for name in found.better:
        rows = [row for row in found.ahead if f"{row.horizon:g}" == name]
        yield ""
        start = "measured velocities" if rows[0].starts == "stencil" else "the mean of both filters"
        yield f"RMS error {name} s ahead, both from {start}; the reference, the stencil's"
        yield "velocity, has pose noise that is in both errors: those of 'validate' are smaller"
        width = max(9, *(len(row.recording) for row in rows))
        for row in rows:
            for axis, symbol in enumerate(SYMBOLS):
                head = row.recording if axis == 0 else ""
                yield f"  {head:<{width}}  {symbol}  {_axis(row.axes[symbol], axis)}"
        yield f"  => {prediction_text(found, name)}"
        yield from _seen_recordings(rows)


def _axis(one: AxisDifference, axis: int) -> str:
    """Both errors, and the interval of their difference, positive for the better model."""
    unit, scale = ERROR_UNITS[axis]
    errors = f"A {scale * one.a:7.3f}  B {scale * one.b:7.3f} {unit}"
    if one.interval is None:
        return f"{errors}; too short for a significance test"
    letter, sign = ("A", -scale) if one.difference < 0 else ("B", scale)
    low, high = sorted(sign * x for x in one.interval)
    if low > 0:
        return f"{errors}; {letter} is better by {low:.2g} to {high:.2g} (95 %)"
    return f"{errors}; not significant: {letter} by {low:.2g} to {high:.2g} (95 %)"


def prediction_text(found: Comparison, horizon: str) -> str:
    """Sentence: which model predicts better at a horizon of `found.better`."""
    # 1. The rows of all recordings together; they may be too short for a test.
    axes = [row for row in found.ahead if f"{row.horizon:g}" == horizon][-1].axes
    if any(axes[s].interval is None for s in SYMBOLS):
        return "too short to decide which predicts better: record a minute or more"
    # 2. Significant differences: real, negligible, or within two estimates of one boat.
    real, slight, same_boat = _differences(found.better[horizon], axes)
    # 3. Axes that are significant alone, but not after Holm's correction.
    near = [
        AXES[axis]
        for axis, symbol in enumerate(SYMBOLS)
        if axes[symbol].better and found.better[horizon][symbol] is None
    ]
    chance = f"{' and '.join(near)} is significant alone, but not among three axes (Holm)"
    more = f"; {chance}" if near else ""
    # 4. The strongest statement that holds.
    if real:
        if same_boat:
            more = f"; {'; '.join(same_boat)}, within the difference of two estimates of one boat{more}"
        return f"{_what_matters(found)}: {'; '.join(real + slight)}{more}"
    if slight or same_boat:
        why = (
            f"significant, but less than {100 * SLIGHT_DIFFERENCE:g} % of the error, which is negligible"
            if slight
            else "two estimates of one unchanged boat may differ as much, so this shows no change"
        )
        return f"{'; '.join(slight or same_boat)}: {why}{more}"
    if found.changed and near:
        return f"coefficients changed; in the prediction {chance}: record longer"
    if found.changed:
        return "coefficients changed, without a significant effect on the prediction of these recordings"
    return "both predict these recordings equally well"


def _differences(
    better: Mapping[str, str | None], axes: Mapping[str, AxisDifference]
) -> tuple[list[str], list[str], list[str]]:
    """Significant differences: those that matter, negligible ones, those within two estimates of one boat."""
    beyond = beyond_same_boat(axes)
    real: list[str] = []
    slight: list[str] = []
    same_boat: list[str] = []
    for axis, symbol in enumerate(SYMBOLS):
        letter, one = better[symbol], axes[symbol]
        if letter is not None:
            small = abs(one.difference) < SLIGHT_DIFFERENCE * min(one.a, one.b)
            kind = same_boat if symbol not in beyond else slight if small else real
            kind.append(_better(letter, one, axis))
    return real, slight, same_boat


def _what_matters(found: Comparison) -> str:
    """What a real difference in prediction means, as the coefficients show it."""
    if found.same_data:
        return "the difference matters for prediction"
    if found.joint is None or found.changed or found.joint.p < SIGNIFICANCE or found.untested:
        return "the change matters for prediction"
    return "prediction shows a change within the coefficients' errors"


def _better(letter: str, one: AxisDifference, axis: int) -> str:
    unit, scale = ERROR_UNITS[axis]
    good, bad = (one.b, one.a) if letter == "B" else (one.a, one.b)
    low, high = sorted(abs(scale * x) for x in one.interval or (0.0, 0.0))
    digits = max(0, 1 - floor(log10(abs(scale * one.difference)))) if one.difference else 3
    return (
        f"{letter} is better in {AXES[axis]}: {scale * good:.{digits}f} against {scale * bad:.{digits}f} {unit} "
        f"(95 %: {low:.2g} to {high:.2g} better)"
    )


def _seen_recordings(rows: list[PredictionRow]) -> Iterator[str]:
    for letter, names in (
        ("A", [r.recording for r in rows if r.seen_a and r.recording != "all"]),
        ("B", [r.recording for r in rows if r.seen_b and r.recording != "all"]),
    ):
        if names:
            yield f"  warning: {letter} was identified from {', '.join(names)}, which favours it"
