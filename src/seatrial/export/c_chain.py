# SPDX-License-Identifier: MIT
"""The actuator chain in C: allocation, curves, lags and rate limits, F = T f."""

from seatrial.export.c_names import Names
from seatrial.export.chain import Actuator, Allocation, Language
from seatrial.export.content import Content
from seatrial.export.spelling import c_comment
from seatrial.export.terms import aligned, number, signed_sum


def functions(content: Content) -> set[str]:
    """Helpers of this boat's chain and structure."""
    actuators = content.actuators
    needs = {
        "fade": any(map(content.lagged, actuators)) or any(map(content.limited, actuators)),
        "degree": bool(content.angles),
        "solve": any(t.acceleration is not None for t in content.structure.terms),
    }
    return content.helpers | {key for key, needed in needs.items() if needed}


def allocation(content: Content) -> list[str]:
    """Commands to the boat into commands f of the actuators."""
    own = content.allocation
    if own.one_sided:
        shares = [
            " + ".join(
                f"fmax({signed_sum([(2.0 * w, f'command[{j}]')])}, 0.0)"
                for j, w in enumerate(row)
                if w
            )
            for row in own.inverse
        ]
    else:
        shares = [
            signed_sum((w, f"command[{j}]") for j, w in enumerate(row)) for row in own.inverse
        ]
    if own.each is not None:
        limit = number(own.each)
        shares = [f"fmin(fmax({share}, -{limit}), {limit})" for share in shares]
    return [*_named(content, shares), *_limited(own)]


def _limited(own: Allocation) -> list[str]:
    """The limit of the whole wrench, and the offset."""
    offset, n = number(own.offset), len(own.inverse)
    if own.whole is None:
        return [f"f[{k}] += {offset};" for k in range(n)] if own.offset else []
    room = number(own.whole)
    scaled = "alpha * f[k]" if not own.offset else f"{offset} + alpha * f[k]"
    return [
        "double alpha = 1.0; /* share of the wrench within the limits */",
        "int k;",
        f"for (k = 0; k < {n}; ++k) {{",
        f"  if (alpha * fabs(f[k]) > {room}) alpha = {room} / fabs(f[k]);",
        "}",
        f"for (k = 0; k < {n}; ++k) f[k] = {scaled};",
    ]


def _named(content: Content, values: list[str]) -> list[str]:
    """f[k] = value, with the actuators' names."""
    rows = [
        (f"f[{k}] = {v};", f"/* {c_comment(a.name)} */")
        for k, (v, a) in enumerate(zip(values, content.actuators, strict=True))
    ]
    return aligned(rows)


def curves(content: Content, names: Names) -> list[str]:
    """Steady thrust of each actuator, or angle [rad], for its command."""
    c = Language("f[{}]".format, names.macros.__getitem__, number, f"{names.name}_", names.degree)
    rows = [
        (f"target[{k}] = {c.text(curve)};", f"/* {c_comment(curve.actuator)} */")
        for k, curve in enumerate(content.curves)
    ]
    return aligned(rows)


def table_words(content: Content) -> dict[str, str]:
    """The substitutions of the tabulated curve."""
    points = content.table
    return {
        "points": str(len(points)),
        "table_command": ", ".join(number(x) for x, _ in points),
        "table_thrust": ", ".join(number(y) for _, y in points),
    }


def mix(content: Content) -> list[str]:
    """F = T f + D sin(angle): an angle takes the sine of its thrust, the thrust keeps the cosine."""
    given = {k: f"f[{k}]" for k in range(len(content.actuators))}
    sines = dict.fromkeys(given, "")
    lines = []
    for k, thrust in content.angles:
        lines.append(f"const double c{k} = cos(f[{k}]), s{k} = sin(f[{k}]);")
        given |= {thrust: f"f[{thrust}] * c{k}", k: f"f[{thrust}] * s{k}"}
        sines[k] = f"s{k}"
    rows = zip(content.forces, content.mix.tolist(), content.deflection.tolist(), strict=True)
    sums = []
    for j, (force, row, sine) in enumerate(rows):
        weights = [(w, given[k]) for k, w in enumerate(row)]
        weights += [(w, sines[k]) for k, w in enumerate(sine)]
        sums.append((f"F[{j}] = {signed_sum(weights)};", f"/* {c_comment(force)} */"))
    return [*lines, *_unused(content, sums), *aligned(sums)]


def _unused(content: Content, sums: list[tuple[str, str]]) -> list[str]:
    """Statements that keep a compiler from warning of a sine or cosine that no force has."""
    text = " ".join(line for line, _ in sums)
    return [
        f"(void){part}{k};" for k, _ in content.angles for part in "cs" if f"{part}{k}" not in text
    ]


def prepare(content: Content, names: Names) -> str:
    """Constants of all steps of an advance: fades and multipliers."""
    lines = []
    n = len(content.actuators)
    if "fade" in functions(content):
        lines.append(
            f"double begin[{n}], middle[{n}], end[{n}]; /* decay of the distance to the target by the lag */"
        )
    if content.scales:
        lines.append(f"double gain[{n}]; /* of the known signals */")
    if "limited" in functions(content):
        rates = ", ".join(_rate(content, names, a) for a in content.actuators)
        lags = ", ".join(_lag(content, names, a) for a in content.actuators)
        lines += [
            f"const double rate[{n}] = {{{rates}}}; /* [rad/s] limit of an angle; 0: none */",
            f"const double lag[{n}] = {{{lags}}};",
        ]
    for k, a in enumerate(content.actuators):
        if "fade" in functions(content):
            lag = _lag(content, names, a)
            lines.append(f"{names.name}_fade(h, {lag}, &begin[{k}], &middle[{k}], &end[{k}]);")
    for k, a in enumerate(content.actuators):
        if content.scales:
            lines.append(f"gain[{k}] = {_multiplier(content, names, a)};")
    return "".join(f"  {line}\n" for line in lines)


def _multiplier(content: Content, names: Names, actuator: Actuator) -> str:
    if actuator.scale is None:
        return "1.0"
    reference = number(list(content.scales.values())[actuator.scale])
    power = names.macros[actuator.constants["scale_power"]]
    return f"{names.name}_multiplier(boat->scale[{actuator.scale}], {reference}, {power})"


def thrusts(content: Content, names: Names) -> list[str]:
    """Thrust of each actuator now, with its known signal."""
    gains = [
        f"{_multiplier(content, names, a)} * " if a.scale is not None else ""
        for a in content.actuators
    ]
    return [f"thrust[{k}] = {gain}boat->level[{k}];" for k, gain in enumerate(gains)]


def levels(content: Content, names: Names) -> list[str]:
    """Thrust at begin, middle and end of a step; the levels move to its end."""
    gain = "gain[k] * " if content.scales else ""
    used = functions(content)
    if "fade" not in used:
        return [f"thrust[0][k] = thrust[1][k] = thrust[2][k] = {gain}boat->level[k];"]
    open_, close = ("(", ")") if gain else ("", "")
    constant = "" if "limited" in used else "const "
    limited = [
        "if (rate[k] > 0.0) {",
        "  left[0] = away;",
        f"  left[1] = {names.name}_limited(away, rate[k], lag[k], 0.5 * h);",
        f"  left[2] = {names.name}_limited(away, rate[k], lag[k], h);",
        "}",
    ]
    return [
        "const double away = boat->level[k] - boat->target[k];",
        f"{constant}double left[3] = {{away * begin[k], away * middle[k], away * end[k]}};",
        *(limited if "limited" in used else []),
        f"thrust[0][k] = {gain}{open_}boat->target[k] + left[0]{close};",
        f"thrust[1][k] = {gain}{open_}boat->target[k] + left[1]{close};",
        "boat->level[k] = boat->target[k] + left[2];",
        f"thrust[2][k] = {gain}boat->level[k];",
    ]


def parts(content: Content, names: Names) -> list[str]:
    """The part of the time in which no level reaches the end of its rate limit."""
    return [
        f"part = {names.name}_smooth_part(boat->level[{k}] - boat->target[{k}], {_rate(content, names, a)}, "
        f"{_lag(content, names, a)}, part);"
        for k, a in enumerate(content.actuators)
        if content.limited(a)
    ]


def _lag(content: Content, names: Names, actuator: Actuator) -> str:
    """[s], as source code."""
    return names.macros[actuator.constants["lag"]] if content.lagged(actuator) else "0.0"


def _rate(content: Content, names: Names, actuator: Actuator) -> str:
    """Rate limit of a level [1/s], of an angle [rad/s], as source code; 0 without one."""
    if not content.limited(actuator):
        return "0.0"
    rate = names.macros[actuator.constants["slew_rate"]]
    return rate if actuator.steers is None else f"{names.degree} * {rate}"
