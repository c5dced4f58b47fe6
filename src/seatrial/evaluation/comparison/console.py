# SPDX-License-Identifier: MIT
"""A comparison as text for the terminal and the report."""

from collections.abc import Iterator

from seatrial.boat.schema import CorrelatedEntry
from seatrial.evaluation.comparison.cause_candidates import (
    BATTERY,
    CURRENT,
    DRAG,
    MASS,
    NO_CHANGE,
    OFF_CENTRE,
    ONE_THRUSTER,
)
from seatrial.evaluation.comparison.cause_text import cause_text, inseparable, most_probable
from seatrial.evaluation.comparison.compare import Comparison, Side
from seatrial.evaluation.comparison.parameters import SIGNIFICANCE, Factor, OneSided, Pair
from seatrial.evaluation.comparison.prediction_text import prediction_lines
from seatrial.util.format import chance, plus_minus
from seatrial.util.frames import AXES, Axes

LEAST_FACTOR_Z = 2.4  # standard errors from 1, 5 % level over three axes
NO_NOISE = "none"
LEAST_POSE_NOISE = 1e-6  # [m], [rad] of correlated pose noise that is shown
LEAST_SHOWN_DISTURBANCE = 1e-5  # [m/s^2], [rad/s^2] of process noise that is shown
OTHER_BOAT_FACTOR = 0.1  # common factor of drag and thrust, below which a payload is no explanation
COMMON_FACTOR_P = 0.01  # p below which one factor does not explain an axis


WHAT_TO_DO = {  # by the most probable cause
    MASS: "use B while this payload is on board",
    OFF_CENTRE: "use B while this payload is on board, or move it to the middle",
    BATTERY: "measure the battery voltage; with a voltage signal under scales: one model holds for all charges",
    DRAG: "look for weeds on the hull; where a payload lowers it in the water use B",
    CURRENT: "identify both with --effect current, and compare again",
}


def next_text(found: Comparison) -> str:
    """What to do next, one line."""
    if found.same_data:
        return "keep the model that predicts a held-out recording better"
    if not found.better:
        return "give recordings, to test whether the change matters for prediction"
    return _by_cause(found) or _by_prediction(found)


def _by_cause(found: Comparison) -> str:
    """Empty where no cause is most probable, or where it leads to nothing."""
    if inseparable(found.causes):
        return "measure the battery voltage, and look for weeds or damage at each thruster"
    cause = most_probable(found.causes)
    if cause is None:
        return ""
    if cause.cause == ONE_THRUSTER:
        return f"look for weeds or damage at thruster {cause.what}"
    if cause.cause == NO_CHANGE:
        return "identify from the recordings of both together, for narrower intervals"
    return WHAT_TO_DO.get(cause.cause, "")


def _by_prediction(found: Comparison) -> str:
    better = {letter for axes in found.better.values() for letter in axes.values()} - {None}
    if better == {"B"}:
        return "use B, which predicts these recordings better"
    if better == {"A"}:
        return "keep A, which predicts these recordings better; record longer for B"
    return "record longer, with every axis excited, and identify B again"


def comparison_text(found: Comparison) -> str:
    """Models, parameters, physics, noise, prediction."""
    lines = [*_head(found), *_parameters(found), *_boat(found), *_noise(found)]
    return "\n".join([*lines, *prediction_lines(found)])


def _head(found: Comparison) -> Iterator[str]:
    width = max(len(found.a.label), len(found.b.label))
    for letter, side in (("A", found.a), ("B", found.b)):
        yield f"{letter}  {side.label:<{width}}  {_side_text(side)}"
    for note in found.notes:
        yield f"  note: {note}"


def _side_text(side: Side) -> str:
    names = ", ".join(side.recordings)
    source = f" from {names} ({side.length:.0f} s)" if names else ""
    return f"{side.vehicle}, {side.method}{source}"


def _parameters(found: Comparison) -> Iterator[str]:
    yield ""
    names = [pair.name for pair in found.pairs]
    names += [one.name for one in (*found.only_a, *found.only_b)]
    width = max([12, *map(len, names)])
    yield (
        f"{'':<{width + 2}} {'A':>20} {'B':>20} {'B - A':>10}   in s.e.  p (Holm)   unit; {Axes.FLU.value} axes"
    )
    for pair in found.pairs:
        yield _pair_text(pair, width)
    for letter, rest in (("A", found.only_a), ("B", found.only_b)):
        for one in rest:
            yield _one_sided_text(letter, one, width)
    yield ""
    yield from changes_text(found, " (*)")


def _pair_text(pair: Pair, width: int) -> str:
    mark = "*" if pair.differs else " "
    z, p = ("given", "") if pair.z is None or pair.p is None else (f"{pair.z:.1f}", chance(pair.p))
    return (
        f"{mark} {pair.name:<{width}} {_value(pair.a, pair.error_a):>20} {_value(pair.b, pair.error_b):>20} "
        f"{_shift(pair):>10} {z:>9} {p:>9}   {pair.unit}"
    )


def _one_sided_text(letter: str, one: OneSided, width: int) -> str:
    why = f"; not compared: {one.why}" if one.why else ""
    shown = plus_minus if one.at_bound else _value
    value = shown(one.value, one.error)
    left, right = (value, "") if letter == "A" else ("", value)
    return f"  {one.name:<{width}} {left:>20} {right:>20}   only {letter}, {one.unit}{why}"


def _value(value: float, error: float) -> str:
    return plus_minus(value, error) + ("" if error > 0 else " given")


def _shift(pair: Pair) -> str:
    """The difference, to the second digit of its error."""
    return plus_minus(pair.difference, pair.error).partition(" ")[0]


def changes_text(found: Comparison, mark: str = "") -> Iterator[str]:
    """Sentences: parameters that changed significantly, and axes with a common factor.

    `mark`: that of these parameters in the table of the console.
    """
    yield from _changed(found, mark)
    yield from _untested(found)
    for factor in found.factors if not found.same_data else ():
        yield from _factor(factor)
    if found.causes:
        yield f"{cause_text(found.causes)}."


def _untested(found: Comparison) -> Iterator[str]:
    """Parameters that can't be tested and may differ."""
    listed = []
    for one, other in found.untested:
        letter, known, bound = ("B", other, one) if one.at_bound else ("A", one, other)
        far = f"{abs(known.value - bound.value) / known.error:.0f}" if known.error > 0 else "many"
        listed.append(
            f"{one.name} ({plus_minus(bound.value, 0.0)} in {'AB'[letter == 'A']}, at its bound, where "
            f"{letter} is {far} of its standard errors away)"
        )
    if listed:
        yield f"Not tested, and may differ: {', '.join(listed)}."


def _changed(found: Comparison, mark: str) -> Iterator[str]:
    if found.joint is None:
        yield "Nothing was estimated in either model: differences have no standard errors and no test."
        return
    test = (
        f"jointly: chi2 = {found.joint.chi2:.1f} with {found.joint.freedom} degrees of freedom, "
        f"p {_less(found.joint.p)}"
    )
    names = [pair.name for pair in found.changed]
    if names:
        yield f"Significant changes{mark}: {', '.join(names)}; {test}."
    elif found.joint.p < SIGNIFICANCE:
        yield f"No single parameter differs significantly, but {test}: something changed."
    else:
        where = " in what can be tested" if found.untested else ""
        yield f"No significant difference{where}; {test}."


def _factor(factor: Factor) -> Iterator[str]:
    if abs(factor.z) < LEAST_FACTOR_Z:
        return
    names = ", ".join(factor.coefficients)
    if factor.fits < COMMON_FACTOR_P:
        parts = [
            f"{kind} by {_value(value, error)}"
            for kind, (value, error, fits) in factor.parts.items()
            if fits > SIGNIFICANCE
        ]
        apart = f" ({', '.join(parts)})" if len(parts) == 2 else ""
        yield (
            f"{factor.axis}: {names} changed by no common factor (p {_less(factor.fits)}): drag or thrust "
            f"changed, not mass alone{apart}."
        )
        return
    if factor.factor < OTHER_BOAT_FACTOR:
        yield (
            f"{factor.axis}: {names} changed by the factor {_value(factor.factor, factor.error)}: too much for "
            "a change of mass; check that both are of the same boat."
        )
        return
    what = "inertia" if factor.axis == AXES[2] else "mass"
    more, error = 100.0 * (1.0 / factor.factor - 1.0), 100.0 * factor.error / factor.factor**2
    size, other = ("more", "less") if more > 0 else ("less", "more")
    rest = "drag and thrust unchanged" if "thrust" in factor.parts else f"or of {other} drag"
    yield (
        f"{factor.axis}: {names} changed by the factor {_value(factor.factor, factor.error)}: as "
        f"{abs(more):.0f} % {size} {what} (± {error:.2g} %; added mass included), {rest}."
    )


def _less(p: float) -> str:
    return chance(p) if p < 0.001 else f"= {chance(p)}"


def _boat(found: Comparison) -> Iterator[str]:
    yield ""
    yield f"{'':<7} {'top speed':>22} {'63 % of it after':>20} {'coasts':>18}   at command"
    for row in found.boat:
        turn = row.axis == AXES[2]
        speed, distance = ("rad/s", "rad") if turn else ("m/s", "m")
        yield (
            f"{row.axis:<7} {_both(row.top_speed, speed):>22} {_both(row.rise_time, 's'):>20} "
            f"{_both(row.coast, distance):>18}   {row.command:.2f}"
        )


def _both(values: tuple[float, float], unit: str) -> str:
    return f"{values[0]:.2f} → {values[1]:.2f} {unit}"


def _noise(found: Comparison) -> Iterator[str]:
    one, two = found.a.noise, found.b.noise
    yield (
        f"pose noise: {1e3 * one.position:.2g} → {1e3 * two.position:.2g} mm, "
        f"{1e3 * one.heading:.2g} → {1e3 * two.heading:.2g} mrad"
    )
    if {_correlated(one.correlated), _correlated(two.correlated)} != {NO_NOISE}:
        yield f"time-correlated pose noise: {_correlated(one.correlated)} → {_correlated(two.correlated)}"
    p, q = one.process, two.process
    if p is None or q is None:
        return
    if (
        max(p.disturbance_linear, p.disturbance_yaw, q.disturbance_linear, q.disturbance_yaw)
        > LEAST_SHOWN_DISTURBANCE
    ):
        yield (
            f"process noise (disturbance): {1e3 * p.disturbance_linear:.2g} → "
            f"{1e3 * q.disturbance_linear:.2g} mm/s^2, {1e3 * p.disturbance_yaw:.2g} → "
            f"{1e3 * q.disturbance_yaw:.2g} mrad/s^2, over {p.memory:.2g} → {q.memory:.2g} s"
        )


def _correlated(entry: CorrelatedEntry | None) -> str:
    if entry is None or max(entry.position, entry.heading) < LEAST_POSE_NOISE:
        return NO_NOISE
    return f"{1e3 * entry.position:.2g} mm, {1e3 * entry.heading:.2g} mrad over {entry.memory_text}"
