# SPDX-License-Identifier: MIT
"""All that a model's predictions of recordings are judged by, computed once: for scores and for the report."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from typing import get_args

import msgspec
import numpy as np

from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.boat.noise_parameters import disturbance_estimated, loosened, noise_vector
from seatrial.evaluation.disturbed_intervals import disturbed_intervals, interval_findings
from seatrial.evaluation.filtering import Filtered, filter_noise, run_filter
from seatrial.evaluation.predicted import Prediction
from seatrial.evaluation.prediction import Lookahead
from seatrial.evaluation.reference import Reference, smoothed_motion
from seatrial.evaluation.residuals import Correlation, residuals
from seatrial.evaluation.scores import HorizonScore, RecordingScore, Scores, Start, fingerprint
from seatrial.evaluation.scoring import axis_scores, score, seen
from seatrial.evaluation.starts_and_ends import check_horizon
from seatrial.evaluation.through_water import through_water
from seatrial.evaluation.unexpected_error import unexpected_errors
from seatrial.recording.excitation import refuse_no_commands
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import SLOW, Motion
from seatrial.util.arguments import expect, expect_each
from seatrial.util.errors import ModelError, RecordingError, SeatrialError
from seatrial.util.frames import Array
from seatrial.util.parallel import spread
from seatrial.util.progress import over

HORIZONS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)  # [s]
STARTS_PER_HORIZON = 8  # in a horizon: closer ones make predictions that are nearly the same
DISTURBED = 2.0  # times the innovations elsewhere: a disturbed interval with less is not reported
SAME_LENGTH = 1e-3  # [s] of a recording that is the same
Ahead = tuple[float, Start, Prediction]  # horizon [s], start


@dataclass(frozen=True)
class Assessment:
    """One recording: predictions, filter, scores; findings, also on scores that could not be computed."""

    recording: Recording
    seen: bool  # the model was identified from it, or from a part of it
    prediction: Prediction | None  # at the chosen horizon; None: see `failure`
    failure: SeatrialError | None
    ahead: tuple[Ahead, ...]  # at all horizons, from each kind of start
    filtered: Filtered | None
    smoothed: Motion | None  # the reference; None: the stencil's velocities
    score: RecordingScore | None  # None where there is no prediction
    correlations: tuple[Correlation, ...]  # of the filter's residuals with the forces
    findings: tuple[Finding, ...]

    def with_findings(self, more: Sequence[Finding]) -> "Assessment":
        """The same with further findings."""
        findings, scored = (*self.findings, *more), self.score
        if scored is not None:
            scored = msgspec.structs.replace(scored, findings=list(findings))
        return replace(self, score=scored, findings=findings)


def assess(
    model: Model,
    recordings: Sequence[Recording],
    horizon: float,
    reference: Reference = "smoothed",
    others: Sequence[float] = HORIZONS,
) -> list[Assessment]:
    """Every recording, predicted `horizon` [s] ahead and at the `others`.

    With a smoothed `reference` predictions start from the filter. Without a filter, or if the recording is too
    short for it to settle, the stencil's velocities are starts and reference. What fails for one recording is its
    `failure`, and does not stop the others. Raises RecordingError where there is none, or where commands are none.
    """
    expect(model, Model, "model")
    expect_each(recordings, Recording, "recordings")
    if reference not in get_args(Reference):
        raise RecordingError(
            f"reference {reference!r}: expected one of {', '.join(get_args(Reference))}"
        )
    if not recordings:
        raise RecordingError("no recording given; pass at least one")
    check_horizon(horizon)
    for recording in recordings:
        refuse_no_commands(recording)
    # velocities through the water, where a recording's current is known
    given, moved = recordings, [through_water(model, recording) for recording in recordings]
    recordings = [recording for recording, _ in moved]
    # the model's own filter along each recording: starts of predictions, and residuals
    noise, filters = _filters(model, recordings)

    # predictions, and their scores
    def one(item: tuple[Recording, Filtered | str]) -> Assessment:
        recording, filtered = item
        smooth = _smoothed(model, recording, filtered, reference)
        return _assessed(model, recording, horizon, filtered, smooth, others=others)

    found = spread(one, list(zip(recordings, filters, strict=True)), "recording")
    # intervals in which something other than the thrusters moved the boat
    if noise is not None and all(one.filtered is not None for one in found):
        found = _with_disturbances(model, found, noise)
    return [
        replace(one.with_findings(of_current), recording=recording)
        for one, recording, (_, of_current) in zip(found, given, moved, strict=True)
    ]


def assess_from(model: Model, recordings: Sequence[Recording], scores: Scores) -> list[Assessment]:
    """The same from scores that are there: only the chosen horizon is predicted again, for its plots.

    Raises ModelError where they are of another model, or of other recordings.
    """
    if scores.fingerprint != fingerprint(model):
        raise ModelError(
            f"the scores are of another model than {model.name}, or of its file before a change: "
            "validate again, with --json"
        )
    rows = {row.recording: row for row in scores.recordings}
    given, recordings = recordings, [through_water(model, one)[0] for one in recordings]
    _, filters = _filters(model, recordings)
    found = []
    for own, recording, filtered in zip(given, recordings, filters, strict=True):
        row = rows.get(recording.name)
        if row is None or abs(row.length - recording.duration) > SAME_LENGTH:
            raise ModelError(
                f"{recording.name}: {recording.duration:.1f} s long, is not among the recordings of the scores "
                f"({', '.join(f'{r.recording} {r.length:.1f} s' for r in scores.recordings)}): validate again, "
                "with --json"
            )
        smooth = _smoothed(model, recording, filtered, row.reference)
        known = filtered if isinstance(filtered, Filtered) else None
        look = Lookahead(model, recording, filtered=known, smoothed=smooth)
        found.append(
            Assessment(
                own, row.seen, look.predict(scores.horizon), None, (), known, smooth, row,
                tuple(row.correlations), tuple(row.findings),
            )
        )  # fmt: skip
    return found


def _filters(
    model: Model, recordings: Sequence[Recording]
) -> tuple[Array | None, list[Filtered | str]]:
    """The filter's noise (12,), and its run along every recording, or why there is none."""
    try:
        noise = filter_noise(model, recordings)
    except SeatrialError as error:
        return None, [str(error)] * len(recordings)

    def one(recording: Recording) -> Filtered | str:
        try:
            return run_filter(model, recording, noise)
        except ModelError as error:
            return str(error)

    return noise, spread(one, recordings)


def _smoothed(
    model: Model, recording: Recording, filtered: Filtered | str, reference: Reference
) -> Motion | None:
    """Smoothed velocities; None where the stencil's are the reference."""
    if reference == "stencil" or not isinstance(filtered, Filtered):
        return None
    # a model that states no noise has the likeliest of these recordings already
    noise = None if noise_vector(model.noise) is not None else filtered.noise
    with suppress(ModelError):
        return smoothed_motion(model, recording, noise)
    return None


def _assessed(
    model: Model,
    recording: Recording,
    horizon: float,
    filtered: Filtered | str,
    smooth: Motion | None,
    *,
    others: Sequence[float],
) -> Assessment:
    known = filtered if isinstance(filtered, Filtered) else None
    own = seen(model, recording)
    starts = None if known is None else known.motion
    # predictions: the chosen horizon, then the others
    look = Lookahead(model, recording, filtered=known, smoothed=smooth)
    prediction, failure = None, None
    try:
        prediction = look.predict(horizon)
    except (ModelError, RecordingError) as error:
        if smooth is not None and isinstance(error, RecordingError):  # too short for the filter
            return _assessed(model, recording, horizon, filtered, None, others=others)
        failure = error
    kind: Start = "stencil" if smooth is None else "filter"
    chosen: Ahead | None = None if prediction is None else (horizon, kind, prediction)
    ahead, lost = _all_horizons(look, horizon, others, starts, chosen)
    # scores with their intervals
    rows = [HorizonScore(h, p.steps, name, len(p.t), axis_scores(p)) for h, name, p in ahead]
    # correlation of the filter's residuals with the forces
    left = [] if known is None else residuals(model, recording, known)
    findings = _findings(recording, filtered, lost, unexpected_errors(rows, own))
    scored = None
    if prediction is not None:
        reference: Reference = "stencil" if smooth is None else "smoothed"
        scored = score(
            model, recording, prediction,
            horizons=rows, correlations=left, findings=findings, reference=reference,
        )  # fmt: skip
    return Assessment(
        recording, own, prediction, failure, tuple(ahead), known, smooth, scored, tuple(left), tuple(findings)
    )  # fmt: skip


def _findings(
    recording: Recording,
    filtered: Filtered | str,
    lost: Sequence[Finding],
    larger: Sequence[Finding],
) -> list[Finding]:
    """Scores that could not be computed and why (`lost`: horizons), errors above the expected ones, slow poses."""
    found = [*lost, *larger]
    if not isinstance(filtered, Filtered):
        found.insert(0, finding_of(FindingKind.NO_FILTER, reason=filtered))
    if recording.period > SLOW:
        found.append(finding_of(FindingKind.SLOW_POSES, period=recording.period))
    return found


def _all_horizons(
    look: Lookahead,
    chosen: float,
    others: Sequence[float],
    filtered: Motion | None,
    known: Ahead | None,
) -> tuple[list[Ahead], list[Finding]]:
    """Predictions at the chosen horizon and the others [s], as far as the recording allows.

    And a finding on the horizon at which the model diverges. Starts are the filter's, if there is one; with the
    stencil as reference also the stencil's; with a smoothed reference also the filter's with its disturbance.
    `known`: a prediction that is there already.
    """
    period = look.recording.period
    found: list[Ahead] = []
    kinds: list[tuple[Start, Motion | None]] = [("stencil", None)] if look.smoothed is None else []
    kinds += [("filter", filtered)] if filtered is not None else []
    if look.smoothed is not None and disturbance_estimated(look.model.noise):
        kinds.append(("odometry", filtered))
    for horizon, (name, starts) in over(list(product(sorted({*others, chosen}), kinds))):
        if horizon < period:
            continue
        if known is not None and (horizon, name) == known[:2]:
            found.append(known)
            continue
        every = 1 if horizon == chosen else max(1, round(horizon / period) // STARTS_PER_HORIZON)
        try:
            ahead = look.predict(horizon, every, starts, disturbed=name == "odometry")
            found.append((horizon, name, ahead))
        except RecordingError:  # no interval is as long
            continue
        except ModelError as error:
            reason = str(error)
            return found, [finding_of(FindingKind.HORIZON_NOT_PREDICTED, reason=reason)]
    return found, []


def _with_disturbances(model: Model, found: list[Assessment], noise: Array) -> list[Assessment]:
    """With findings on each recording that has intervals of far larger innovations.

    An overconfident filter recovers slowly and so reports too many disturbances: it is given process noise.
    """
    ready = loosened(noise, 1.0)
    same = np.array_equal(ready, noise)
    recordings = [one.recording for one in found]
    try:
        runs = [one.filtered if same else run_filter(model, one.recording, ready) for one in found]
    except ModelError:
        return found
    odd = disturbed_intervals(recordings, [np.sum(run.residual**2, axis=1) for run in runs if run])
    result = []
    for i, one in enumerate(found):
        own = [s for s in odd if s.recording == i and s.times > DISTURBED]
        result.append(one.with_findings(interval_findings(recordings, own)))
    return result


def judging(found: Sequence[Assessment]) -> list[Assessment]:
    """Those that a model is judged by: the recordings that it has not seen, if there are any."""
    tested = [one for one in found if one.prediction is not None]
    return [one for one in tested if not one.seen] or tested
