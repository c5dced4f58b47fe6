# SPDX-License-Identifier: MIT
"""A MATLAB and Octave function: reset, command, step, and x_dot for ode45."""

import re

from seatrial.boat.structure import ACCELERATIONS
from seatrial.export.chain import Actuator, Language
from seatrial.export.content import Content
from seatrial.export.spelling import identifiers, matlab_comment, matlab_text
from seatrial.export.template import block, fill, pieces, template
from seatrial.export.terms import aligned, number, product
from seatrial.util.frames import AXES, SYMBOLS, Array

CALLED = (
    "abs", "all", "ceil", "cos", "error", "exp", "expm1", "eye", "hypot", "isfinite", "max", "min", "nargin",
    "numel", "pi", "sign", "sin", "sum", "zeros",
)  # functions of MATLAB  # fmt: skip


def function(content: Content, name: str) -> str:
    """The function's file; MATLAB requires the file name `name`.m."""
    example = f"[{'; '.join(['0.5', *['0'] * (len(content.inputs) - 1)])}]"
    once, each = _latencies(content)
    words = {
        "name": name,
        "NAME": name.upper(),
        "vehicle": matlab_comment(content.vehicle_name),
        "source": matlab_comment(content.source),
        "axes": content.axes.value,
        "INPUTS": str(len(content.inputs)),
        "LATENCIES": str(len(once)),
        "example": example,
        "pad": " " * max(0, len(example) - 10),
        "inputs": matlab_comment(", ".join(content.inputs)),
        "inputs_text": matlab_text(", ".join(content.inputs)),
        "forces": matlab_comment(", ".join(content.forces)),
        "actuators": matlab_comment(", ".join(a.name for a in content.actuators)),
        "first": identifiers(content.values)[content.structure.coefficients[0]],
        "parameters": block(_parameters(content), "  "),
        "allocation": block(_allocation(content), "  "),
        "curves": block(_curves(content), "  "),
        "T": _matrix(content.mix),
        "turned": block(_turned(content), "  "),
        **_limited(content),
        "acceleration": block(_acceleration(content), "  "),
        "longest_step": number(content.longest_step),
        "prepare": block(_prepare(content), "  "),
        "gain": "gain .* " if content.scales else "",
        "latencies": ", ".join(once),
        "latency_of": ", ".join(map(str, each)),
        "lags": ", ".join(_own(content, a, "lag", "0") for a in content.actuators),
        "scales": _scales(content),
    }
    sections = pieces("curves.m", "% ")
    given = {**_table(content), "rates": ", ".join(_rate(content, a) for a in content.actuators)}
    helpers = "".join("\n" + fill(sections[key], given) for key in _helpers(content))
    return fill(template("boat.m"), words) + helpers


def _helpers(content: Content) -> list[str]:
    return [
        key for key in ("curve", "pair", "table", "limited", "multiplier") if key in content.helpers
    ]


def function_name(name: str) -> str:
    """A name that is none of a function that the file defines or calls."""
    local = re.findall(
        r"^function (?:.* = )?(\w+)\(", template("boat.m") + template("curves.m"), re.M
    )
    return f"boat_{name}" if name in {*local, *CALLED} else name


def _field(content: Content, name: str) -> str:
    """The function's name of a coefficient or constant."""
    return f"p.{identifiers(content.values)[name]}"


def _own(content: Content, actuator: Actuator, stage: str, neutral: str) -> str:
    found = actuator.constants.get(stage)
    return neutral if found is None else _field(content, found)


def _parameters(content: Content) -> list[str]:
    rows = []
    for name, value in content.values.items():
        error = content.errors[name]
        known = f"+- {error:.2g}" if error > 0 else "given"
        stated = f"{_field(content, name)} = {number(value)};"
        rows.append((stated, f"% {known}", f"[{content.units[name]}]"))
    return aligned(rows)


def _matrix(values: Array) -> str:
    return f"[{'; '.join(', '.join(map(number, row)) for row in values.tolist())}]"


def _allocation(content: Content) -> list[str]:
    own = content.allocation
    lines = [f"inverse = {_matrix(own.inverse)};"]
    one_sided = "sum(max(2 * inverse .* command', 0), 2)"
    lines.append(f"f = {one_sided if own.one_sided else 'inverse * command'};")
    if own.each is not None:
        lines.append(f"f = max(min(f, {number(own.each)}), -{number(own.each)});")
    if own.whole is not None:
        share = f"min(1, {number(own.whole)} / max(abs(f)))"
        lines.append(f"f = f * {share};  % a limit scales the whole wrench")
    return [*lines, *([f"f = f + {number(own.offset)};"] if own.offset else [])]


def _curves(content: Content) -> list[str]:
    octave = Language(
        lambda k: f"f({k + 1})", lambda name: _field(content, name), "{:g}".format, "", "pi / 180"
    )
    rows = [
        (f"target({k}) = {octave.text(curve)};", f"% {matlab_comment(curve.actuator)}")
        for k, curve in enumerate(content.curves, start=1)
        if not curve.plain
    ]
    return aligned(rows)


def _turned(content: Content) -> list[str]:
    """F = T f + D sin(angle): an angle takes the sine of its thrust, the thrust keeps the cosine."""
    if not content.angles:
        return ["F = T * f;"]
    lines = ["turned = f;"]
    for k, thrust in content.angles:
        angle, own = f"f({k + 1}, :)", f"f({thrust + 1}, :)"
        lines.append(f"turned({thrust + 1}, :) = {own} .* cos({angle});")
        lines.append(f"turned({k + 1}, :) = {own} .* sin({angle});")
    if not content.deflection.any():
        return [*lines, "F = T * turned;"]
    columns = ", ".join(str(k + 1) for k, _ in content.angles)
    by_sine = _matrix(content.deflection[:, [k for k, _ in content.angles]])
    return [*lines, f"D = {by_sine};", f"F = T * turned + D * sin(f([{columns}], :));"]


def _limited(content: Content) -> dict[str, str]:
    """Words for angles, and for those with a rate limit."""
    limited = [k for k, a in enumerate(content.actuators) if content.limited(a)]
    lines = []
    for k in limited:
        at = f"{k + 1}"
        left = (
            f"limited(away({at}), rate({at}), lag({at}), {share} * h)" for share in ("0.5", "1")
        )
        lines.append(f"level({at}, :) = s.target({at}) + [away({at}), {', '.join(left)}];")
    return {
        "angles": "".join(f"\n%   {matlab_comment(note)}" for note in content.angle_notes),
        "whole": "smooth" if limited else "advance",
        "smooth": ", up to the end of a rate limit" if limited else "",
        "levels": block(lines, "    ") + "\n" if limited else "",
        "free": " & rates(p) == 0" if limited else "",
    }


def _rate(content: Content, actuator: Actuator) -> str:
    own = _own(content, actuator, "slew_rate", "0")
    return own if actuator.steers is None else f"pi / 180 * {own}"


def _table(content: Content) -> dict[str, str]:
    return {
        "table_command": ", ".join(number(x) for x, _ in content.table),
        "table_thrust": ", ".join(number(y) for _, y in content.table),
    }


def _acceleration(content: Content) -> list[str]:
    terms = content.structure.terms
    used = {factor.strip("|") for t in terms for factor in t.factors}
    solved = any(t.acceleration is not None for t in terms)
    lines = [f"{s} = nu({i});" for i, s in enumerate(SYMBOLS, start=1) if s in used]
    forces = identifiers(content.forces)
    lines += [f"{forces[f]} = F({j});" for j, f in enumerate(content.forces, 1) if f in used]
    lines += ["A = zeros(3);"] if solved else []
    lines.append("g = zeros(3, 1);")

    def spell(word: str) -> str:
        if word in content.structure.coefficients:
            return _field(content, word)
        return f"abs({word[1:-1]})" if word.startswith("|") else forces.get(word, word)

    for axis, axis_name in enumerate(AXES, start=1):
        lines.append(f"% {axis_name}")
        for term in (t for t in terms if t.axis == axis - 1):
            sign, value = product(term, spell)
            if term.acceleration is None:
                lines.append(f"g({axis}) = g({axis}) {sign} {value};")
            else:
                at, times = f"A({axis}, {term.acceleration + 1})", ACCELERATIONS[term.acceleration]
                lines.append(f"{at} = {at} {sign} {value};  % times {times}")
    return [*lines, "nu_dot = (eye(3) - A) \\ g;" if solved else "nu_dot = g;"]


def _latencies(content: Content) -> tuple[list[str], list[int]]:
    """Distinct latencies, and the index of each actuator's."""
    each = [_own(content, a, "latency", "0") for a in content.actuators]
    once = list(dict.fromkeys(each))
    return once, [once.index(latency) + 1 for latency in each]


def _prepare(content: Content) -> list[str]:
    lines = ["[begin, middle, final] = fade(h, lags(p));"]
    if any(map(content.limited, content.actuators)):
        lines += ["rate = rates(p);", "lag = lags(p);"]
    if not content.scales:
        return lines
    references = list(content.scales.values())
    gains = []
    for a in content.actuators:
        if a.scale is None:
            gains.append("1")
            continue
        power = _own(content, a, "scale_power", "1")
        gains.append(f"multiplier(s.scale({a.scale + 1}), {number(references[a.scale])}, {power})")
    return [*lines, f"gain = [{'; '.join(gains)}];"]


def _scales(content: Content) -> str:
    if not content.scales:
        return ""
    references = ", ".join(map(number, content.scales.values()))
    signals = matlab_comment(", ".join(content.scales))
    return f"  s.scale = [{references}];  % known signals, may be set: {signals}\n"
