# SPDX-License-Identifier: MIT
"""A comparison for the terminal."""

from collections.abc import Iterator
from math import floor, log10

from seatrial.boat.schema import CorrelatedEntry
from seatrial.evaluation.comparison import Comparison, Side
from seatrial.evaluation.comparison.parameters import SIGNIFICANT, Factor, OneSided, Pair
from seatrial.evaluation.comparison.prediction import Ahead, AxisDifference, beyond_luck
from seatrial.util.format import plus_minus
from seatrial.util.frames import AXES, SYMBOLS, Axes

TOLD = (
    2.4  # standard errors: by chance one of three axes is that far from 1 in one comparison of 20
)
NONE = "nothing"
HARDLY = 1e-6  # [m], [rad] of pose errors that are not worth a word
QUIET = 1e-5  # [m/s^2], [rad/s^2] a force that is not worth a word
ANOTHER = 0.1  # a factor on all drag and thrust below which no payload is the reason
SLIGHT = (
    0.005  # of the error one second ahead: a smaller difference hardly matters, however sure it is
)
FITS = 0.01  # p below which one factor does not explain an axis


def comparison_text(found: Comparison) -> str:
    """All of it."""
    return "\n".join(
        [*_head(found), *_parameters(found), *_boat(found), *_noise(found), *_prediction(found)]
    )


def _head(found: Comparison) -> Iterator[str]:
    width = max(len(found.a.label), len(found.b.label))
    for letter, side in (("A", found.a), ("B", found.b)):
        yield f"{letter}  {side.label:<{width}}  {_side(side)}"
    for note in found.notes:
        yield f"  note: {note}"


def _side(side: Side) -> str:
    names = ", ".join(side.recordings)
    source = f" from {names} ({side.length:.0f} s)" if names else ""
    return f"{side.vehicle}, {side.method}{source}"


def _parameters(found: Comparison) -> Iterator[str]:
    yield ""
    yield (
        f"{'':<14} {'A':>20} {'B':>20} {'B - A':>10}   in s.e.  p (Holm)   unit; {Axes.FLU.value} axes"
    )
    for pair in found.pairs:
        yield _pair(pair)
    for letter, rest in (("A", found.only_a), ("B", found.only_b)):
        for one in rest:
            yield _one(letter, one)
    yield ""
    yield from changed(found)


def _pair(pair: Pair) -> str:
    mark = "*" if pair.differs else " "
    z, p = ("given", "") if pair.z is None or pair.p is None else (f"{pair.z:.1f}", _p(pair.p))
    return (
        f"{mark} {pair.name:<12} {_value(pair.a, pair.error_a):>20} {_value(pair.b, pair.error_b):>20} "
        f"{_shift(pair):>10} {z:>9} {p:>9}   {pair.unit}"
    )


def _one(letter: str, one: OneSided) -> str:
    why = f"; not compared: {one.why}" if one.why else ""
    told = plus_minus if one.at_bound else _value
    value = told(one.value, one.error)
    left, right = (value, "") if letter == "A" else ("", value)
    return f"  {one.name:<12} {left:>20} {right:>20}   only {letter}, {one.unit}{why}"


def _value(value: float, error: float) -> str:
    return plus_minus(value, error) + ("" if error > 0 else " given")


def _shift(pair: Pair) -> str:
    """The difference, to the second digit of its error."""
    return plus_minus(pair.difference, pair.error).partition(" ")[0]


def _p(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}"


def changed(found: Comparison) -> Iterator[str]:
    """Which parameters changed beyond chance, and which axes by one factor; in sentences."""
    yield from _changed(found)
    yield from _untested(found)
    for factor in found.factors if not found.same_data else ():
        yield from _factor(factor)


def _untested(found: Comparison) -> Iterator[str]:
    """What may differ all the same."""
    said = []
    for one, other in found.untested:
        letter, known, bound = ("B", other, one) if one.at_bound else ("A", one, other)
        far = f"{abs(known.value - bound.value) / known.error:.0f}" if known.error > 0 else "many"
        said.append(
            f"{one.name} ({plus_minus(bound.value, 0.0)} in {'AB'[letter == 'A']}, at its bound, where "
            f"{letter} is {far} of its standard errors away)"
        )
    if said:
        yield f"Not tested, and may differ: {', '.join(said)}."


def _changed(found: Comparison) -> Iterator[str]:
    if found.joint is None:
        yield "Nothing was estimated in either model: differences have no errors to hold them against."
        return
    test = (
        f"all together: chi2 = {found.joint.chi2:.1f} with {found.joint.freedom} degrees of freedom, "
        f"p {'' if found.joint.p < 0.001 else '= '}{_p(found.joint.p)}"
    )
    names = [pair.name for pair in found.changed]
    if names:
        yield f"Changed beyond chance (*): {', '.join(names)}; {test}."
    elif found.joint.p < SIGNIFICANT:
        yield f"No parameter alone differs beyond chance, but {test}: something changed."
    else:
        where = " in what can be tested" if found.untested else ""
        yield f"No difference seen{where}; {test}."


def _factor(factor: Factor) -> Iterator[str]:
    if abs(factor.z) < TOLD:
        return
    names = ", ".join(factor.coefficients)
    if factor.fits < FITS:
        yield (
            f"{factor.axis}: {names} changed by no common factor (p {_less(factor.fits)}): drag or thrust "
            "changed, not mass alone."
        )
        return
    if factor.factor < ANOTHER:
        yield (
            f"{factor.axis}: {names} are {_value(factor.factor, factor.error)} times what they were: no change "
            "of mass does that; is it another boat?"
        )
        return
    what = "inertia" if factor.axis == AXES[2] else "mass"
    more = 100.0 * (1.0 / factor.factor - 1.0)
    yield (
        f"{factor.axis}: {names} are {_value(factor.factor, factor.error)} times what they were: as "
        f"{abs(more):.0f} % {'more' if more > 0 else 'less'} {what} (added mass included), drag and thrust "
        "as before."
    )


def _less(p: float) -> str:
    return _p(p) if p < 0.001 else f"= {_p(p)}"


def _boat(found: Comparison) -> Iterator[str]:
    yield ""
    yield f"{'':<7} {'top speed':>22} {'63 % of it after':>20} {'coasts':>18}   at command"
    for row in found.boat:
        turn = row.axis == AXES[2]
        speed, way = ("rad/s", "rad") if turn else ("m/s", "m")
        yield (
            f"{row.axis:<7} {_both(row.top_speed, speed):>22} {_both(row.rise_time, 's'):>20} "
            f"{_both(row.coast, way):>18}   {row.command:.2f}"
        )


def _both(values: tuple[float, float], unit: str) -> str:
    return f"{values[0]:.2f} → {values[1]:.2f} {unit}"


def _noise(found: Comparison) -> Iterator[str]:
    one, two = found.a.noise, found.b.noise
    yield (
        f"pose noise: {1e3 * one.position:.2g} → {1e3 * two.position:.2g} mm, "
        f"{1e3 * one.heading:.2g} → {1e3 * two.heading:.2g} mrad"
    )
    if {_correlated(one.correlated), _correlated(two.correlated)} != {NONE}:
        yield f"of it is correlated: {_correlated(one.correlated)} → {_correlated(two.correlated)}"
    p, q = one.process, two.process
    if p is None or q is None:
        return
    if (
        max(p.disturbance_linear, p.disturbance_yaw, q.disturbance_linear, q.disturbance_yaw)
        > QUIET
    ):
        yield (
            f"what the model leaves out: {1e3 * p.disturbance_linear:.2g} → "
            f"{1e3 * q.disturbance_linear:.2g} mm/s^2, {1e3 * p.disturbance_yaw:.2g} → "
            f"{1e3 * q.disturbance_yaw:.2g} mrad/s^2, over {p.memory:.2g} → {q.memory:.2g} s"
        )


def _correlated(entry: CorrelatedEntry | None) -> str:
    if entry is None or max(entry.position, entry.heading) < HARDLY:
        return NONE
    return f"{1e3 * entry.position:.2g} mm, {1e3 * entry.heading:.2g} mrad over {entry.memory_text}"


def _prediction(found: Comparison) -> Iterator[str]:
    for name in found.better:
        rows = [row for row in found.ahead if f"{row.horizon:g}" == name]
        yield ""
        start = "measured velocities" if rows[0].starts == "stencil" else "the mean of both filters"
        yield f"RMS error {name} s ahead, both from {start}"
        width = max(9, *(len(row.recording) for row in rows))
        for row in rows:
            for axis, symbol in enumerate(SYMBOLS):
                head = row.recording if axis == 0 else ""
                yield f"  {head:<{width}}  {symbol}  {_axis(row.axes[symbol], axis)}"
        yield f"  => {matters(found, name)}"
        yield from _known(rows)


def _axis(one: AxisDifference, axis: int) -> str:
    scale, unit = _scale(axis)
    said = f"A {scale * one.a:7.3f}  B {scale * one.b:7.3f} {unit}"
    if one.interval is None:
        return f"{said}; too short to tell whether that is chance"
    return f"{said}; {_interval(one, axis)}"


def _scale(axis: int) -> tuple[float, str]:
    return (100.0, "cm/s") if axis < 2 else (1.0, "rad/s")


def _interval(one: AxisDifference, axis: int) -> str:
    """The interval, counted in favour of the better model."""
    if one.interval is None:
        return ""
    scale, _ = _scale(axis)
    low, high = (scale * x for x in one.interval)
    if one.difference < 0:
        low, high = -high, -low
    letter = "A" if one.difference < 0 else "B"
    if low > 0:
        return f"{letter} is better by {low:.2g} to {high:.2g} (95 %)"
    return f"no difference seen: {letter} by {low:.2g} to {high:.2g} (95 %)"


def matters(found: Comparison, horizon: str) -> str:
    """Which model predicts better at a horizon of `found.better`, in a sentence."""
    axes = [row for row in found.ahead if f"{row.horizon:g}" == horizon][-1].axes
    if any(axes[s].interval is None for s in SYMBOLS):
        return "too short to tell which predicts better: record a minute or more"
    beyond = beyond_luck(axes)
    said: list[str] = []
    slight: list[str] = []
    lucky: list[str] = []
    for axis, symbol in enumerate(SYMBOLS):
        letter, one = found.better[horizon][symbol], axes[symbol]
        if letter is not None:
            small = abs(one.difference) < SLIGHT * min(one.a, one.b)
            kind = lucky if symbol not in beyond else slight if small else said
            kind.append(_better(letter, one, axis))
    near = [
        AXES[axis]
        for axis, symbol in enumerate(SYMBOLS)
        if axes[symbol].better and found.better[horizon][symbol] is None
    ]
    chance = f"{' and '.join(near)} alone would show, but among three axes that may be chance"
    more = f"; {chance}" if near else ""
    if said:
        seen = found.joint is None or found.changed or found.joint.p < SIGNIFICANT
        head = (
            "the difference matters for prediction"
            if found.same_data
            else "the change matters for prediction"
            if seen or found.untested
            else "prediction shows a change that the coefficients' errors hide"
        )
        more = (
            f"; {'; '.join(lucky)}, as of two estimates of one boat one may be{more}"
            if lucky
            else more
        )
        return f"{head}: {'; '.join(said + slight)}{more}"
    if slight or lucky:
        why = (
            f"beyond chance, but less than {100 * SLIGHT:g} % of the error, which hardly matters"
            if slight
            else "two estimates of one unchanged boat may differ as much, so this shows no change"
        )
        return f"{'; '.join(slight or lucky)}: {why}{more}"
    if found.changed and near:
        return f"coefficients changed; in the prediction {chance}: record longer to tell"
    if found.changed:
        return "coefficients changed, but it does not show in the prediction of these recordings"
    return "both predict these recordings equally well"


def _better(letter: str, one: AxisDifference, axis: int) -> str:
    scale, unit = _scale(axis)
    good, bad = (one.b, one.a) if letter == "B" else (one.a, one.b)
    low, high = sorted(abs(scale * x) for x in one.interval or (0.0, 0.0))
    digits = max(0, 1 - floor(log10(abs(scale * one.difference)))) if one.difference else 3
    return (
        f"{letter} is better in {AXES[axis]}: {scale * good:.{digits}f} against {scale * bad:.{digits}f} {unit} "
        f"(95 %: {low:.2g} to {high:.2g} better)"
    )


def _known(rows: list[Ahead]) -> Iterator[str]:
    for letter, names in (
        ("A", [r.recording for r in rows if r.seen_a and r.recording != "all"]),
        ("B", [r.recording for r in rows if r.seen_b and r.recording != "all"]),
    ):
        if names:
            yield f"  warning: {letter} was identified from {', '.join(names)}: that favours it"
