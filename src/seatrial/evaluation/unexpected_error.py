# SPDX-License-Identifier: MIT
"""Errors that exceed the expected error, and their probable cause."""

from collections.abc import Iterable, Mapping

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.evaluation.scores import AxisScore, Scored
from seatrial.util.frames import AXES, SYMBOLS

BEYOND = 1.25  # times the expected error: a smaller one is not reported
WIDER = 1.5  # times its interval, as all horizons are looked at: 2.9 standard errors
SHARED = 2  # poses ahead to which the filter has used poses that the reference uses, too
# [s] within it the error is mostly that of poses, hardly that of a boat that has changed
SOON = 0.5


def unexpected_errors(scores: Iterable[Scored], known: bool) -> list[Finding]:
    """Axes in which errors exceed the expected error, with the probable cause.

    known: the model was identified from this recording. No finding where start and reference share poses, and so
    errors; nor on odometry, whose estimated disturbance hides a part of a change.
    """
    tested = (x for x in scores if x.start != "odometry")
    apart = (x for x in tested if x.start == "stencil" or x.steps > SHARED)
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
    kind = FindingKind.EXCEEDS_EXPECTED_ERROR
    return [
        finding_of(kind, axis, ratio=ratio, horizon=horizon, cause=cause)
        for axis, (ratio, horizon) in most.items()
    ]


def _surprises(
    rows: Iterable[tuple[float, Mapping[str, AxisScore]]], symbol: str
) -> list[tuple[float, float]]:
    """Errors over the expected ones, where they are significantly larger, and the horizon [s]."""
    return [
        (score.rms / score.expected_rms, horizon)
        for horizon, scores in rows
        if (score := scores[symbol]).expected_rms and _beyond_doubt(score)
    ]


def _beyond_doubt(score: AxisScore) -> bool:
    """Whether an error is significantly larger than expected.

    Blocks of time differ, as the interval says; coefficients are off once for all of them.
    """
    most = score.at_most
    if most is None or score.parameter_rms is None or score.rms_interval is None:
        return False
    least = score.rms * (score.rms_interval[0] / score.rms) ** WIDER
    return score.rms > BEYOND * most and least > most
