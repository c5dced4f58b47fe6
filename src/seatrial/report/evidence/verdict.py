# SPDX-License-Identifier: MIT
"""The report's first sentences: verdict, what was identified, how well it predicts, what to do."""

from collections import Counter
from collections.abc import Sequence

from seatrial.boat.earth_effects import forces_as_noise
from seatrial.boat.finding_kinds import ASK_FOR_ACTION
from seatrial.boat.findings import FindingKind, finding_text, most_important
from seatrial.boat.model import Model
from seatrial.boat.physics import implausible_coefficients
from seatrial.identification.uncertainty.identifiability import Identifiability
from seatrial.identification.uncertainty.parameter_verdict import ParameterVerdict
from seatrial.report.evidence.advice import advice
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.runs import Run, judged
from seatrial.report.text.markup import number
from seatrial.report.text.numbers import (
    at_floor,
    expected_rms,
    floors,
    minutes,
    names_of,
    ratio_word,
    resolved_ratio,
    rms_and_ratio,
)
from seatrial.util.format import joined, shortened
from seatrial.util.frames import AXES, ERROR_UNITS, Array
from seatrial.workflow.fitness import Fitness, Level

CAUTIOUS = 0.8  # of the expected RMS: below, the stated errors are larger than needed
USE_WITHIN_ENVELOPE = "within the speeds and commands of its identification data"


def verdict(evidence: Evidence) -> list[str]:
    """Three sentences in numbers."""
    return [identified(evidence), predicted(evidence), following(evidence)]


def headline(evidence: Evidence) -> str:
    """The verdict in plain words: how well the model predicts, and what it is fit for."""
    runs = judged(evidence.runs)
    if useless := _useless(evidence):
        return useless
    kind = "which it has not seen" if runs[0].unseen else "which it was identified from"
    fit = {level: [f.use.value for f in evidence.fitness if f.level is level] for level in Level}
    words = {Level.FIT: "Fit for", Level.LIMITED: "limited for", Level.NOT_FIT: "not fit for"}
    parts = [f"{words[level]} {joined(uses)}" for level, uses in fit.items() if uses]
    uses = "; ".join(parts)
    return (
        f"It predicts {_by_axis(runs)}, {evidence.horizon:g}\u00a0s ahead on {names_of(runs)}, {kind}. "
        f"{uses[:1].upper()}{uses[1:]}."
    )


def identified(evidence: Evidence) -> str:
    """What was identified, how, from what, and how well its parameters are known."""
    model, known = evidence.model, evidence.known
    parts = [_count(len(model.values), "coefficient")]
    constants = [n for n in model.vehicle.constants.names if model.standard_errors[n] > 0]
    parts += [f"{_count(len(constants), 'constant')} of the thrusters"] if constants else []
    what = f"{model.name}: {joined(parts)}"
    if not model.recordings:
        return f"{what}, {model.estimator.method}{_accuracy(known)}."
    length = minutes(sum(r.length for r in model.recordings))
    names = [r.name for r in model.recordings]
    listed = shortened(names)
    return (
        f"{what}, identified by {model.estimator.method} from {_count(len(names), 'recording')}, "
        f"{length} in all ({listed}){_accuracy(known)}."
    )


def _accuracy(known: Identifiability) -> str:
    """How many are sharp, and which are not reliable."""
    if not known.names:
        return "; none has a standard error"
    found = [f for f in known.findings if f.verdict.estimated]
    counts = Counter(f.verdict for f in found)
    parts = [f"{counts[v]} {v.value}" for v in ParameterVerdict if counts[v]]
    poor = [f.name for f in found if not f.verdict.reliable]
    listed = "" if not poor else f" ({', '.join(poor[:6])}{' …' if len(poor) > 6 else ''})"
    return f"; of these {joined(parts)}{listed}"


def _useless(evidence: Evidence) -> str:
    """Why the model predicts nothing; empty: it does."""
    if evidence.physics.unstable:
        return f"It can't be used: {evidence.physics.unstable}."
    if not judged(evidence.runs):
        return f"It predicts none of the recordings: {evidence.runs[0].failure}."
    return ""


def predicted(evidence: Evidence) -> str:
    """Prediction of velocities: verdict, RMS errors, ratio to constant velocity."""
    runs = judged(evidence.runs)
    if useless := _useless(evidence):
        return useless
    rms, ratio = rms_and_ratio(runs)
    verdicts = _by_axis(runs)
    sizes = [f"{number(r * s, 2)} {u}" for r, (u, s) in zip(rms.tolist(), ERROR_UNITS, strict=True)]
    shares = [number(share, 2) for share in ratio.tolist()]
    kind = "that it has not seen" if runs[0].unseen else "that it was identified from"
    failed = len(evidence.runs) - len(evidence.tested)
    missing = (
        f" {failed} of {len(evidence.runs)} recordings could not be predicted." if failed else ""
    )
    return (
        f"{evidence.horizon:g} s ahead, on recordings {kind} ({names_of(runs)}), it predicts {verdicts}. "
        f"RMS error: {joined(sizes)}, which is {joined(shares)} times that of constant velocity. "
        f"{_floor(runs)}{_over_expected(evidence.model, runs, rms)}{missing}"
    )


def _by_axis(runs: Sequence[Run]) -> str:
    """`surge and sway well and yaw fairly`."""
    ratio = rms_and_ratio(runs)[1].tolist()
    words = map(axis_word, resolved_ratio(runs).tolist(), at_floor(runs).tolist(), ratio)
    groups: dict[str, list[str]] = {}
    for axis, word in zip(AXES, words, strict=True):
        groups.setdefault(word, []).append(axis)
    return joined([f"{joined(axes)} {word}" for word, axes in groups.items()])


def axis_word(resolved: float, hidden: bool, ratio: float) -> str:
    """Verdict on one axis: by its excess over the noise floor, or that the poses show no more."""
    if not hidden:
        return ratio_word(resolved)
    word = ratio_word(ratio)
    return word if word == ratio_word(0.0) else "as well as these poses resolve"


def _floor(runs: Sequence[Run]) -> str:
    noise = floors(runs)
    sizes = [
        f"{number(f * s, 2)} {u}" for f, (u, s) in zip(noise.tolist(), ERROR_UNITS, strict=True)
    ]
    more = ", not exceeded" if at_floor(runs).all() else ""
    return f"Noise floor: {joined(sizes)}{more}."


def _over_expected(model: Model, runs: Sequence[Run], rms: Array) -> str:
    own = expected_rms(runs)
    if own is None:
        return ""
    over = (rms / own).tolist()
    times = joined([number(t, 2) for t in over])
    kinds = forces_as_noise(model.recordings)
    cautious = (
        f", which allows for an unknown {joined(kinds)}"
        if kinds
        else ": the model states larger errors than it makes"
    )
    return f" Error over expected RMS: {times}{cautious if max(over) < CAUTIOUS else ''}."


def following(evidence: Evidence) -> str:
    """The most important thing to do next."""
    first = wished(evidence) or use_text(evidence.fitness)
    start = first[0].lower() if first[1:2].islower() else first[0]
    return f"Next: {start}{first[1:]}"


def wished(evidence: Evidence) -> str:
    """What coefficients, findings and scores ask for first; empty where there is no open issue."""
    odd = [] if evidence.physics.unstable else implausible_coefficients(evidence.model)
    asking = [
        finding_text(finding)
        for finding in most_important(evidence.model.estimator.findings)
        if finding.kind in ASK_FOR_ACTION and not evidence.physics.unstable
    ]
    wrong = map(finding_text, evidence.model.findings_of(FindingKind.CONTRADICTED))
    return next(iter([*wrong, *odd, *asking, *advice(evidence)]), "")


def use_text(found: Sequence[Fitness]) -> str:
    """For what to use a model without an open issue, and what its worst use lacks."""
    fit = [one.use.value for one in found if one.level is Level.FIT]
    lacking = [one for one in found if one.level is not Level.FIT]
    if not lacking:
        return f"Use it {USE_WITHIN_ENVELOPE}."
    worst = max(lacking, key=lambda one: list(Level).index(one.level))
    lack = f"{worst.use.value} ({worst.level.value}): {worst.action}."
    return f"Use it for {joined(fit)} {USE_WITHIN_ENVELOPE}. For {lack}" if fit else f"For {lack}"


def _count(n: int, word: str) -> str:
    return f"{n} {word}{'s' * (n != 1)}"
