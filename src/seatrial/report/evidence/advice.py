# SPDX-License-Identifier: MIT
"""What to do next, most important first."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import implausible_coefficients
from seatrial.evaluation.scores import GOOD_RATIO
from seatrial.identification.experiment_design import next_drive
from seatrial.recording.excitation import EXCITED
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.runs import Run, judged
from seatrial.report.text.numbers import (
    VERY_GOOD_RATIO,
    at_floor,
    insignificant,
    names_of,
    ratio_word,
    resolved_ratio,
    rms_and_ratio,
)
from seatrial.util.format import joined
from seatrial.util.frames import AXES, SYMBOLS

MANY_EXCLUDED = 0.1  # share of excluded poses above which the sensor needs a check
BIASED = 0.5  # bias over RMS error above which a constant cause is reported
BEYOND_ENVELOPE = 1.2  # times the identified speeds: extrapolation is reported above it


def advice(evidence: Evidence) -> list[str]:
    """Sentences; none where there is no open issue."""
    model, runs = evidence.model, evidence.runs
    if evidence.physics.unstable:
        return [
            "Do not use this model. Check the recordings and the vehicle file's signs with inspect, "
            "then identify again from driving at several speeds in every axis."
        ]
    found = poor_axes(model, runs)
    if not any(r.unseen for r in runs if r.tested):
        found.append(
            "Validate on a recording that the model has not seen: drive one more run, or identify "
            "from a part of the recordings. Scores on the identification data are optimistic."
        )
    found += _one_sided(runs)
    found += _more_of_an_axis(evidence)
    found += _at_floor(runs)
    return found + [
        s
        for r in runs
        for s in (*_many_excluded(r), *_biased(model, r), *_beyond_envelope(model, r))
    ]


def wants_more_data(evidence: Evidence) -> bool:
    """Whether the first advice is to drive more, which recordings that only tested the model may replace."""
    if evidence.physics.unstable:
        return False
    wanted = [
        *implausible_coefficients(evidence.model),
        *_one_sided(evidence.runs),
        *_more_of_an_axis(evidence),
        *(s for r in evidence.runs for s in _beyond_envelope(evidence.model, r)),
    ]
    first = [*implausible_coefficients(evidence.model), *advice(evidence)][:1]
    return bool(first) and first[0] in wanted


def _more_of_an_axis(evidence: Evidence) -> list[str]:
    """What to drive for the coefficients that are not known well."""
    return next_drive(evidence.known, evidence.gains) or _insignificant(evidence.model)


def _insignificant(model: Model) -> list[str]:
    names = insignificant(model)
    if not names:
        return []
    return [
        f"These recordings do not distinguish {joined(names)} from zero: drive longer and at more "
        "speeds, or remove these terms from the structure."
    ]


def poor_axes(model: Model, runs: Sequence[Run]) -> list[str]:
    """Axes that are hardly predicted: of another boat or other conditions, or for want of data or of a term."""
    chosen = judged(runs)
    if not chosen:
        return []
    ratio, driven = resolved_ratio(chosen), _driven(model)
    poor = [axis for axis in range(3) if ratio[axis] > GOOD_RATIO]
    # predicted where it was identified: more of the same driving does not help
    seen = [r for r in runs if r.tested and not r.unseen]
    known = resolved_ratio(seen) if seen and chosen[0].unseen else np.full(3, np.inf)
    differing = [axis for axis in poor if known[axis] <= GOOD_RATIO]
    found = []
    if differing:
        axes = joined([AXES[axis] for axis in differing])
        found.append(
            f"{names_of(chosen)}: {axes} predictions are hardly better than constant velocity, but good on the "
            "identification data. Compare battery, propeller speed, payload and wind of both, or identify this "
            "recording alone and run 'seatrial compare'."
        )
    return found + [
        f"The {name} prediction is {ratio_word(ratio[axis])}: "
        + (
            f"drive one minute more of {name} pulses in both directions at several amplitudes. Then check "
            f"whether the {name} equation lacks a term, a latency or a dead zone."
            if axis in driven
            else f"no command drives {name}, so check whether its equation lacks a term, and look for wind "
            "and current."
        )
        for axis, name in enumerate(AXES)
        if axis in poor and axis not in differing
    ]


def _driven(model: Model) -> set[int]:
    """Axes with a force in their equation."""
    forces = {force.name for force in model.structure.forces}
    return {term.axis for term in model.structure.terms if forces & {*term.factors}}


def _at_floor(runs: Sequence[Run]) -> list[str]:
    chosen = judged(runs)
    if not chosen:
        return []
    ratio = rms_and_ratio(chosen)[1]
    hidden = at_floor(chosen) & (ratio > VERY_GOOD_RATIO)
    axes = [name for axis, name in enumerate(AXES) if hidden[axis]]
    if not axes:
        return []
    return [
        f"The error in {joined(axes)} is at the noise floor of the poses, so the score does not measure "
        "the model: use a longer horizon or better poses."
    ]


def _one_sided(runs: Sequence[Run]) -> list[str]:
    chosen = [r for r in runs if not r.unseen] or runs
    found = []
    for axis, name in enumerate(AXES):
        driven = [r.excitation for r in chosen if r.excitation.rms[axis] >= EXCITED]
        if driven and not any(e.both_signs[axis] for e in driven):
            found.append(
                f"The {name} commands have almost only one sign, so the model is validated for one "
                f"direction only: drive {name} pulses in the other direction too."
            )
    return found


def _many_excluded(run: Run) -> list[str]:
    if run.excluded <= MANY_EXCLUDED:
        return []
    return [
        f"{run.name}: {100 * run.excluded:.0f} % of the poses are excluded; check its faults above "
        "and the pose sensor."
    ]


def _biased(model: Model, run: Run) -> list[str]:
    known = {r.name for r in model.recordings if {"wind_x", "trim_u"} & set(r.effects)}
    if not run.tested or run.name in known:  # the model alone predicts, without this steady force
        return []
    axes = [
        name
        for name, sign in zip(AXES, SYMBOLS, strict=True)
        if abs(run.score.scores[sign].bias) > BIASED * run.score.scores[sign].rms
    ]
    if not axes:
        return []
    return [
        f"{run.name}: the errors in {joined(axes)} are biased. Possible causes: wind, a current, a "
        "tether or an offset of the commands."
    ]


def _beyond_envelope(model: Model, run: Run) -> list[str]:
    if not run.unseen:
        return []
    nu = run.measured[np.isfinite(run.measured[:, 0])]
    if not len(nu):
        return []
    low, high = np.percentile(nu, [0.5, 99.5], axis=0)
    axes = [
        name
        for i, (name, sign) in enumerate(zip(AXES, SYMBOLS, strict=True))
        if sign in model.envelope.speeds
        and (
            low[i] < BEYOND_ENVELOPE * min(model.envelope.speeds[sign][0], 0.0)
            or high[i] > BEYOND_ENVELOPE * max(model.envelope.speeds[sign][1], 0.0)
        )
    ]
    if not axes:
        return []
    exceed = "exceeds" if len(axes) == 1 else "exceed"
    return [
        f"{run.name}: {joined(axes)} {exceed} the speeds of the identification data, so the model "
        "extrapolates; identify from faster driving too."
    ]
