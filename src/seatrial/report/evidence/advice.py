# SPDX-License-Identifier: MIT
"""What to do next, most important first."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.identification.experiment_design import next_drive
from seatrial.recording.excitation import EXCITED
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.runs import Run, judged
from seatrial.report.text.numbers import (
    AT_FLOOR,
    GOOD_RATIO,
    floors,
    not_told_apart,
    ratio_word,
    rms_and_ratio,
)
from seatrial.util.format import joined
from seatrial.util.frames import AXES, SYMBOLS

MANY_MASKED = 0.1  # share of the poses left out that deserves a look at the sensor
BIASED = 0.5  # share of the RMS error from which on a constant part is worth a remark
BEYOND = 1.2  # times the range of speeds that the model was made from


def advice(evidence: Evidence) -> list[str]:
    """Sentences; none where nothing stands out."""
    model, runs = evidence.model, evidence.runs
    if evidence.physics.unstable:
        return [
            "Do not use this model; identify again from driving at several speeds in every axis, "
            "after a look at the recordings and the vehicle file's signs with inspect."
        ]
    found = _poor_axes(runs)
    if not any(r.unseen for r in runs if r.tested):
        found.append(
            "Validate on a recording that the model has not seen: drive one more run, or identify "
            "from a part of the recordings only. A model always looks good on its own data."
        )
    found += _one_sided(runs)
    computed = next_drive(evidence.known, evidence.gains)
    found += computed or _loose(model)
    found += _floored(runs)
    return found + [s for r in runs for s in (*_masked(r), *_biased(r), *_beyond(model, r))]


def _loose(model: Model) -> list[str]:
    loose = not_told_apart(model)
    if not loose:
        return []
    return [
        f"{joined(loose)} cannot be distinguished from zero by these recordings: drive "
        "longer, at more speeds, or take these terms out of the structure."
    ]


def _poor_axes(runs: Sequence[Run]) -> list[str]:
    chosen = judged(runs)
    if not chosen:
        return []
    rms, ratio = rms_and_ratio(chosen)
    floor = floors(chosen)
    return [
        f"The {name} prediction is {ratio_word(ratio[axis])}: drive "
        f"a minute more of {name} pulses to both sides, at several strengths, and look "
        f"whether the {name} equation lacks a term, a latency or a dead zone."
        for axis, name in enumerate(AXES)
        if ratio[axis] > GOOD_RATIO and rms[axis] >= AT_FLOOR * floor[axis]
    ]


def _floored(runs: Sequence[Run]) -> list[str]:
    chosen = judged(runs)
    if not chosen:
        return []
    rms, floor = rms_and_ratio(chosen)[0], floors(chosen)
    axes = [name for axis, name in enumerate(AXES) if rms[axis] < AT_FLOOR * floor[axis]]
    if not axes:
        return []
    return [
        f"The error in {joined(axes)} is at the floor that pose noise sets: a better model could not "
        "score better here; a longer horizon or better poses would tell more."
    ]


def _one_sided(runs: Sequence[Run]) -> list[str]:
    chosen = [r for r in runs if not r.unseen] or runs
    found = []
    for axis, name in enumerate(AXES):
        driven = [r.excitation for r in chosen if r.excitation.rms[axis] >= EXCITED]
        if driven and not any(e.both_signs[axis] for e in driven):
            found.append(
                f"The {name} commands go almost only to one side: drive {name} pulses to the other "
                "side too, or the model is proved for one side only."
            )
    return found


def _masked(run: Run) -> list[str]:
    if run.masked <= MANY_MASKED:
        return []
    return [
        f"{run.name}: {100 * run.masked:.0f} % of the poses had to be left out; look at "
        "its faults above and at the pose sensor."
    ]


def _biased(run: Run) -> list[str]:
    if not run.tested:
        return []
    axes = [
        name
        for name, sign in zip(AXES, SYMBOLS, strict=True)
        if abs(run.score.scores[sign].bias) > BIASED * run.score.scores[sign].rms
    ]
    if not axes:
        return []
    return [
        f"{run.name}: the errors in {joined(axes)} lean to one side; wind, a current, a "
        "tether or an offset of the commands would do that."
    ]


def _beyond(model: Model, run: Run) -> list[str]:
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
            low[i] < BEYOND * min(model.envelope.speeds[sign][0], 0.0)
            or high[i] > BEYOND * max(model.envelope.speeds[sign][1], 0.0)
        )
    ]
    if not axes:
        return []
    return [
        f"{run.name}: faster in {joined(axes)} than anything that the model was made "
        "from; identify from faster driving too."
    ]
