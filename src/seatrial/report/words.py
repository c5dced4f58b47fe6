# SPDX-License-Identifier: MIT
"""The report's sentences, made of the numbers."""

from collections.abc import Callable, Sequence

import numpy as np

from seatrial.excitation import EXCITED
from seatrial.frames import AXES, SYMBOLS, Array
from seatrial.identify import caution
from seatrial.identify.equation_error import METHOD
from seatrial.model import Model
from seatrial.report.markup import number
from seatrial.report.runs import Run
from seatrial.sanity import TOLD_APART

GOOD_RATIO = 0.8  # above this share of the constant-velocity error an axis needs work
AT_FLOOR = 1.1  # an RMS below this many floors says no more about the model
MANY_MASKED = 0.1  # share of the poses left out that deserves a look at the sensor
BIASED = 0.5  # share of the RMS error from which on a constant part is worth a remark
BEYOND = 1.2  # times the range of speeds that the model was made from
UNITS = (("cm/s", 100.0), ("cm/s", 100.0), ("rad/s", 1.0))  # of errors, and what makes them
_RATIO_WORDS = (
    (0.5, "much better"),
    (GOOD_RATIO, "better"),
    (0.95, "hardly better"),
    (1.05, "no better"),
    (np.inf, "worse"),
)


def joined(words: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def minutes(seconds: float) -> str:
    """A length of time in the unit that suits it."""
    return f"{seconds / 60:.1f} min" if seconds >= 90 else f"{seconds:.0f} s"


def ratio_word(ratio: float) -> str:
    """How an error compares with that of 'velocity stays constant'."""
    return next((word for limit, word in _RATIO_WORDS if ratio <= limit), "worse")


def pooled(runs: Sequence[Run], pick: Callable[[Run], Array]) -> Array:
    """RMS (3,) over all predictions of some runs of a velocity difference (m, 3)."""
    return np.asarray(np.sqrt(np.mean(np.concatenate([pick(r) for r in runs]) ** 2, axis=0)))


def rms_and_ratio(runs: Sequence[Run]) -> tuple[Array, Array]:
    """RMS errors (3,) [m/s, m/s, rad/s] over some runs, and as shares of 'stays constant'."""
    rms = pooled(runs, lambda r: r.prediction.errors)
    still = pooled(runs, lambda r: r.prediction.measured - r.prediction.start)
    return rms, np.divide(rms, still, out=np.full(3, np.inf), where=still > 0)


def not_told_apart(model: Model) -> list[str]:
    """Coefficients within two standard errors of 0."""
    errors = model.standard_errors
    return [n for n, v in model.values.items() if abs(v) < TOLD_APART * errors[n]]


def identified(model: Model) -> str:
    """What was identified, how, from what."""
    count = len(model.structure.coefficients)
    if not model.recordings:
        return f"{model.name}: a model with {count} coefficients, {model.estimator.method}."
    length = sum(r.length for r in model.recordings)
    names = joined([r.name for r in model.recordings])
    many = len(model.recordings)
    return (
        f"{model.name}: {count} coefficients identified by the {model.estimator.method} method "
        f"from {many} recording{'s' * (many > 1)}, {minutes(length)} in all: {names}."
    )


def predicted(runs: Sequence[Run], horizon: float) -> str:
    """How well some recordings are predicted, in absolute terms and against no model at all."""
    rms, ratio = rms_and_ratio(runs)
    floor = pooled(runs, lambda r: r.prediction.floor[None, :])
    sizes = [
        f"{number(rms[i] * scale, 2)} {name} in {AXES[i]}" for i, (name, scale) in enumerate(UNITS)
    ]
    alone = [f"{number(floor[i] * scale, 2)} {name}" for i, (name, scale) in enumerate(UNITS)]
    kind = "it has not seen" if runs[0].unseen else "it was identified from"
    groups: dict[str, list[str]] = {}
    for axis, share in zip(AXES, ratio, strict=True):
        groups.setdefault(ratio_word(share), []).append(f"{axis} ({number(share, 2)})")
    compared = joined([f"{word} in {joined(axes)}" for word, axes in groups.items()])
    return (
        f"On recordings that {kind} ({_names(runs)}), the velocity predicted {horizon:g} s ahead is "
        f"off by {joined(sizes)} (RMS; pose noise alone makes {joined(alone)}). "
        f"Compared with assuming that the velocity stays as it is, the model is {compared}; "
        "in brackets its error as a share of that assumption's."
    )


def flattered(runs: Sequence[Run]) -> str:
    """The same in short for recordings that the model was identified from."""
    rms, ratio = rms_and_ratio(runs)
    sizes = [f"{number(rms[i] * scale, 2)} {name}" for i, (name, scale) in enumerate(UNITS)]
    shares = joined([number(share, 2) for share in ratio])
    return (
        f"On those that it was identified from ({_names(runs)}) it is off by {joined(sizes)}: "
        f"{shares} of that assumption's error."
    )


def verdict(model: Model, runs: Sequence[Run], horizon: float) -> list[str]:
    """The first sentences of the report."""
    fresh = [r for r in runs if r.unseen]
    known = [r for r in runs if not r.unseen]
    found = [identified(model), predicted(fresh or known, horizon)]
    found += [flattered(known)] if fresh and known else []
    return [*found, caution(model)] if model.estimator.method == METHOD else found


def _names(runs: Sequence[Run]) -> str:
    return joined([r.recording.name for r in runs])


def advice(model: Model, runs: Sequence[Run]) -> list[str]:
    """What to do next, most important first."""
    found = []
    if not any(r.unseen for r in runs):
        found.append(
            "Validate on a recording that the model has not seen: drive one more run, or identify "
            "from a part of the recordings only. A model always looks good on its own data."
        )
    found += _poor_axes(runs) + _one_sided(runs)
    loose = not_told_apart(model)
    if loose:
        found.append(
            f"{joined(loose)} cannot be told apart from 0 by these recordings: drive "
            "longer, at more speeds, or take these terms out of the structure."
        )
    return found + [s for run in runs for s in (*_masked(run), *_biased(run), *_beyond(model, run))]


def _poor_axes(runs: Sequence[Run]) -> list[str]:
    chosen = [r for r in runs if r.unseen] or runs
    rms, ratio = rms_and_ratio(chosen)
    floor = pooled(chosen, lambda r: r.prediction.floor[None, :])
    found = []
    for axis, name in enumerate(AXES):
        if rms[axis] < AT_FLOOR * floor[axis]:
            found.append(
                f"The {name} error is at the floor that pose noise sets: a better model could not "
                "score better here; a longer horizon or better poses would tell more."
            )
        elif ratio[axis] > GOOD_RATIO:
            found.append(
                f"The {name} prediction is {ratio_word(ratio[axis])} than “stays as it is”: drive "
                f"a minute more of {name} pulses to both sides, at several strengths, and look "
                f"whether the {name} equation lacks a term, a latency or a dead zone."
            )
    return found


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
        f"{run.recording.name}: {100 * run.masked:.0f} % of the poses had to be left out; look at "
        "its faults below and at the pose sensor."
    ]


def _biased(run: Run) -> list[str]:
    axes = [
        name
        for name, sign in zip(AXES, SYMBOLS, strict=True)
        if abs(run.score.scores[sign].bias) > BIASED * run.score.scores[sign].rms
    ]
    if not axes:
        return []
    return [
        f"{run.recording.name}: the errors in {joined(axes)} lean to one side; wind, a current, a "
        "tether or an offset of the commands would do that."
    ]


def _beyond(model: Model, run: Run) -> list[str]:
    if not run.unseen:
        return []
    nu = run.measured[np.isfinite(run.measured[:, 0])]
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
        f"{run.recording.name}: faster in {joined(axes)} than anything that the model was made "
        "from; identify from faster driving too."
    ]
