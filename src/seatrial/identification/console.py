# SPDX-License-Identifier: MIT
"""Summary of an identified model for the terminal."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.earth_effects import earth_effects, forces_as_noise
from seatrial.boat.finding_kinds import ASK_FOR_ACTION, FindingKind
from seatrial.boat.findings import finding_text, most_important, sentence_of
from seatrial.boat.model import Model
from seatrial.boat.physics import physics_line
from seatrial.boat.schema import EQUATION_ERROR
from seatrial.identification.likelihood.parameters import typical_size
from seatrial.identification.regression.smoother import SMOOTHER
from seatrial.identification.uncertainty.identifiability import (
    CORRELATED,
    INSEPARABLE,
    Combination,
    Identifiability,
    identifiability,
)
from seatrial.identification.uncertainty.parameter_verdict import (
    SHARP_ERROR,
    ParameterAccuracy,
    ParameterVerdict,
    full_thrust,
    reach_text,
)
from seatrial.recording.velocity import STENCIL_NOISE
from seatrial.util.format import joined, percent, plus_minus
from seatrial.util.frames import AXES, Axes

LEAST_WALK = 1e-4  # [m/s], [rad/s] in 1 s: a smaller random walk is not shown
MOST_FINDINGS = 3  # in a brief summary
AT_TOP = (FindingKind.CONTRADICTED,)  # of the summary, before the numbers
ASKED_FOR = (FindingKind.PRIOR_USED, FindingKind.DELAY_DIFFERENCE, FindingKind.DELAY)


SMOOTHER_BIAS = (
    "± covers scatter only: accelerations are smoothed and commands are not, which biases this method, "
    "latency and lag most of all."
)
RATED = (ParameterVerdict.SHARP, ParameterVerdict.USABLE, ParameterVerdict.WEAK)


def caution(model: Model) -> str:
    """The bias that the paper's method has no standard error for, with this recording's pose noise."""
    spread = STENCIL_NOISE / model.integration.step
    noise = model.noise
    return (
        f"± covers scatter only. {1e3 * noise.position:.2g} mm and {1e3 * noise.heading:.2g} mrad of "
        f"pose noise are {100 * spread * noise.position:.2g} cm/s and {spread * noise.heading:.2g} "
        "rad/s in the differentiated velocities; that biases this method, drag most of all."
    )


def summary(model: Model, *, brief: bool = False) -> str:
    """Parameters with verdicts, noise, record length, findings, doubts, and top speeds.

    `brief`: doubts and findings that matter most, `MOST_FINDINGS` of them, without condition and record length.
    """
    found = identifiability(model)
    scatter = model.estimator.method == EQUATION_ERROR
    lines = [*_parameters(found), *map(combined, found.combinations)]
    lines += [] if brief else condition_text(found)
    lines += [caution(model)] if scatter else [_noise(model)]
    lines += [] if scatter or brief else _how_long(model, found)
    lines += [SMOOTHER_BIAS] if model.estimator.method == SMOOTHER else []
    lines += [*_effects(model), *(_important(model) if brief else _all_findings(model))]
    flipped = [n for n in model.values if n in model.structure.flipped_coefficients]
    if model.vehicle.axes is not Axes.FLU and flipped:
        lines.append(
            f"The file is in {model.vehicle.axes.value} axes: {', '.join(flipped)} negated."
        )
    wrong = map(finding_text, model.findings_of(FindingKind.CONTRADICTED))
    head = f"{model.name}, {model.estimator.method}, in {Axes.FLU.value} axes; {_from(model)}:"
    return "\n".join([*wrong, head, *lines, physics_line(model)])


def _all_findings(model: Model) -> list[str]:
    """Every finding, then every doubt."""
    return [
        *(finding_text(f) for f in model.estimator.findings if f.kind not in AT_TOP),
        *(f"  doubt: {warning}" for warning in model.warnings),
    ]


def _important(model: Model) -> list[str]:
    """Prior and delays, doubts and findings that matter most, and how many there are beside them."""
    found = model.estimator.findings
    used = [sentence_of(f) for f in found if f.kind in ASKED_FOR]
    elsewhere = (*ASKED_FOR, *AT_TOP)
    findings = most_important(f for f in found if f.kind not in elsewhere)
    asking = [finding_text(f) for f in findings if f.kind in ASK_FOR_ACTION]
    messages = [*(f"doubt: {warning}" for warning in model.warnings), *asking][:MOST_FINDINGS]
    rest = len(model.warnings) + len(findings) - len(messages)
    more = f" ({_further(rest)})" if rest > 0 else ""
    if not messages:
        return [*used, f"No finding asks for an action{more}."] if rest else used
    return [*used, f"What matters most{more}:", *(f"  - {text}" for text in messages)]


def _further(count: int) -> str:
    """How many doubts and findings are not shown, and where they are."""
    return (
        "1 further remark: -v shows it" if count == 1 else f"{count} further remarks: -v shows them"
    )


def _effects(model: Model) -> list[str]:
    """Lever arm and effects of each recording, where they were estimated."""
    ahead, aside = model.vehicle.lever
    lines = []
    if ahead or aside:
        fore, side = ("ahead of", "behind")[ahead < 0], ("left", "right")[aside < 0]
        lines.append(
            f"  the measured point is {abs(ahead):.3f} m {fore} the origin, {abs(aside):.3f} m to its {side}"
        )
    for recording in model.recordings:
        if recording.effects:
            sizes = (
                f"{name} {plus_minus(value, recording.errors.get(name, 0.0))}"
                for name, value in recording.effects.items()
            )
            lines.append(f"  {recording.name}: {', '.join(sizes)}")
        for found in earth_effects(model.vehicle, recording):
            size = plus_minus(found.size, found.error)
            lines.append(
                f"  {recording.name}: {found.kind} of {size} {found.unit} toward {found.direction}"
            )
    if any(r.effects for r in model.recordings):  # the file's own axes may be forward-right-down
        lines.append("  (z up, as in the model file: y to the left of x, turns counter-clockwise)")
    return lines


def _parameters(found: Identifiability) -> list[str]:
    """A line for each: value, standard error, unit, verdict."""
    names = max(len(f.name) for f in found.findings)
    units = max(len(f.unit) for f in found.findings)
    lines = []
    texts = [plus_minus(f.value, f.error).partition(" ± ") for f in found.findings]
    values, errors = (max(least, *(len(t[i]) for t in texts)) for i, least in ((0, 10), (2, 8)))
    for one, (value, _, error) in zip(found.findings, texts, strict=True):
        shown = (
            f"{value:>{values}} ± {error:<{errors}}"
            if error
            else f"{value:>{values}}{'':<{errors + 3}}"
        )
        verdict = f"{one.unit:<{units}}  {_verdict(one, found.combinations)}"
        lines.append(f"  {one.name:<{names}} {shown} {verdict}")
    return lines


def _verdict(found: ParameterAccuracy, combinations: Sequence[Combination]) -> str:
    """The verdict with the relative standard error, an upper limit or correlated parameters."""
    text = found.verdict.value
    if found.verdict in RATED:
        typical = typical_size(found.name)
        of = f" of {typical:g}" if typical > abs(found.value) else ""
        text += f" ({percent(found.relative)}{of})"
    if limit := reach_text(found):
        text += f": {limit}"
    shown = {name for c in combinations if found.name in c.names for name in c.names}
    near = [
        f"{n} ({rho:.2f})" for n, rho in found.partners if abs(rho) > CORRELATED and n not in shown
    ]
    loose = found.verdict is not ParameterVerdict.SHARP
    return text + (f"; correlated with {', '.join(near)}" if near and loose else "")


def combined(found: Combination) -> str:
    """A combination of parameters that is better known than each of them."""
    names = joined(found.names)
    apart = "can't be told apart" if abs(found.correlation) > INSEPARABLE else "are correlated"
    value = plus_minus(found.value, found.error)
    return (
        f"{names} {apart} ({found.correlation:.2f}): {found.text} is {value} {found.unit}, "
        f"{found.verdict.value}."
    )


def condition_text(found: Identifiability) -> list[str]:
    """The condition number of the correlations, and what makes it large."""
    if len(found.names) < 2:
        return []
    narrow = np.abs(np.linalg.eigh(found.correlation)[1][:, 0])
    first, second = (found.names[i] for i in np.argsort(-narrow)[:2])
    return [
        f"Condition number of the correlations {found.condition:.2g}, by {first} and {second} "
        "most of all."
    ]


def _noise(model: Model) -> str:
    """Pose noise and process noise in words."""
    noise, process = model.noise, model.noise.process
    text = f"Pose noise {1e3 * noise.position:.2g} mm and {1e3 * noise.heading:.2g} mrad"
    if noise.correlated is not None:
        c = noise.correlated
        lasting = _above(1e-7, (c.position, "mm"), (c.heading, "mrad"))
        text += f" (white), {lasting} (time-correlated over {c.memory_text})"
    if process is None:
        return f"{text}."
    most = [full_thrust(model, axis) for axis in range(3)]
    linear, ratio = process.disturbance_linear, process.sway_ratio
    sizes = linear, ratio * linear, process.disturbance_yaw
    # of other axes the thrust is no measure
    driven = {force.axis for force in model.vehicle.forces}
    parts = [
        f"{percent(size / thrust)} in {AXES[axis]}"
        for axis, (size, thrust) in enumerate(zip(sizes, most, strict=True))
        if axis in driven and thrust > 0 and size > 1e-3 * thrust
    ]
    text += (
        f"; process noise (disturbance force): {joined(parts)} of the largest commanded force, time constant "
        f"{process.memory:.2g} s{', earth-fixed' if process.earth_fixed else ''}{_with_effects(model)}"
        if parts else "; no significant process noise"
    )  # fmt: skip
    if max(process.walk_linear, process.walk_yaw) > LEAST_WALK:
        walks = (process.walk_linear, "mm/s"), (process.walk_yaw, "mrad/s")
        text += f"; velocity random walk {_above(LEAST_WALK, *walks)} in 1 s"
    if ratio != 1.0:
        text += f"; accelerations of sway by process noise are {ratio:.2g} times those of surge"
    return f"{text}."


def _with_effects(model: Model) -> str:
    """Text on effects that the process noise includes, as they are not known on board."""
    kinds = forces_as_noise(model.recordings)
    return (
        f", including the {joined(kinds)} of the recordings, which is not known on board"
        if kinds
        else ""
    )


def _above(least: float, *sizes: tuple[float, str]) -> str:
    """Sizes in thousandths, with their units; those at the floor of the search are left out."""
    return " and ".join(f"{1e3 * size:.2g} {unit}" for size, unit in sizes if size > least)


def _how_long(model: Model, found: Identifiability) -> list[str]:
    """Record length for standard errors of 5 %: they fall with the square root of time."""
    length = sum(r.length for r in model.recordings) / 60  # [min]
    helped = {n for c in found.combinations if c.verdict is ParameterVerdict.SHARP for n in c.names}
    loose = [
        f for f in found.findings
        if f.verdict in {ParameterVerdict.USABLE, ParameterVerdict.WEAK} and f.name not in helped
    ]  # fmt: skip
    if not (length and found.names) or "prior" in model.estimator.settings:
        return []
    if not loose:
        return [f"Halving every error takes four times these {minutes(length)}."]
    loose.sort(key=lambda f: -f.relative)
    wanted = [
        f"{minutes(length * (f.relative / SHARP_ERROR) ** 2)} for {f.name}" for f in loose[:3]
    ]
    return [
        f"Driven like these {minutes(length)}, knowing them to {100 * SHARP_ERROR:.0f} % takes "
        f"{', '.join(wanted)}; the report says what to drive instead."
    ]


def minutes(value: float) -> str:
    """A length of time, given in minutes."""
    if value > 120:
        return f"{value / 60:.0f} h" if value > 600 else f"{value / 60:.1f} h"
    return f"{value:.0f} min" if value >= 20 else f"{value:.1f} min"


def _from(model: Model) -> str:
    """Which recordings identified which axis."""
    parts = {
        axis: ", ".join(step.recordings)
        for axis, step in zip(AXES, model.estimator.steps, strict=False)
    } or {"": ", ".join(r.name for r in model.recordings)}
    if len(set(parts.values())) == 1:
        return f"all from {next(iter(parts.values()))}"
    return ", ".join(f"{axis} from {names}" for axis, names in parts.items())
