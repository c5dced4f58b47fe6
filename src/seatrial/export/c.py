# SPDX-License-Identifier: MIT
"""A C99 header: reset, command, step: the core's model, written out for one boat."""

import re

from seatrial.boat.allocation import Scheme
from seatrial.boat.structure import ACCELERATIONS
from seatrial.export.content import Actuator, Content
from seatrial.export.spelling import c_comment, identifiers
from seatrial.export.template import block, fill, pieces, template
from seatrial.export.terms import aligned, number, product, signed_sum
from seatrial.util.frames import AXES, SYMBOLS

HIGHEST_COMMAND_RATE = 1000.0  # [Hz] for which the queue of delayed commands has room
MOST_PENDING = 1 << 16  # commands in the queue


def header(content: Content, name: str) -> str:
    """The header's text; every name in it starts with `name`."""
    return fill(template("boat.h"), words(content, name))


def words(content: Content, name: str) -> dict[str, str]:
    """The substitutions of `boat.h`."""
    late = any(content.latency(a) > 0.0 for a in content.actuators)
    common = {
        "name": name,
        "NAME": name.upper(),
        "vehicle": c_comment(content.vehicle_name),
        "source": c_comment(content.source),
    }
    sections = pieces("curves.h", "/* ")
    used = _functions(content)
    queue = fill(
        template("queue.h" if late else "at_once.h"), {**common, **_queue_words(content, name)}
    )
    return {
        **common,
        "axes": content.axes.value,
        "INPUTS": str(len(content.inputs)),
        "ACTUATORS": str(len(content.actuators)),
        "FORCES": str(len(content.forces)),
        "example": ", ".join(["0.5", *["0.0"] * (len(content.inputs) - 1)]),
        "input_comment": c_comment(", ".join(content.inputs)),
        "coefficients": "\n".join(_numbers(content, content.structure.coefficients, name)),
        "constants": _constants(content, name),
        "longest_step": number(content.longest_step),
        "sizes": _sizes(content, name) if late else "",
        "members": _members(content, name, late=late),
        "allocation": block(_allocation(content), "  "),
        "curve_functions": "".join(
            "\n" + fill(sections[key], {**common, **_table_words(content)})
            for key in ("curve", "pair", "table", "fade", "multiplier")
            if key in used
        ),
        "curves": block(_curves(content, name), "  "),
        "mix": block(_mix(content), "  "),
        "solve_function": "\n" + fill(sections["solve"], common) if "solve" in used else "",
        "acceleration": block(acceleration(content, name), "  "),
        "prepare": _prepare(content, name),
        "levels": block(_levels(content), "      "),
        "queue": queue,
        "thrusts": block(_thrusts(content, name), "  "),
        "reset": _reset(content),
    }


def _functions(content: Content) -> set[str]:
    """Helpers of this boat's chain and structure."""
    actuators = content.actuators
    needs = {
        "curve": any(a.curved for a in actuators),
        "pair": any(a.partner is not None for a in actuators),
        "table": any(a.tabulated for a in actuators),
        "fade": any(map(content.lagged, actuators)),
        "multiplier": any(a.scale is not None for a in actuators),
        "solve": any(t.acceleration is not None for t in content.structure.terms),
    }
    return {key for key, needed in needs.items() if needed}


def _spelled(content: Content, name: str) -> dict[str, str]:
    """The header's names of coefficients and constants (macros) and of forces (variables)."""
    own, macros = _own_names(name), {p: f"{name.upper()}_{p}" for p in content.values}
    found = identifiers(macros.values(), own)
    forces = identifiers(content.forces, {*own, *found.values()})
    return {p: found[macro] for p, macro in macros.items()} | forces


def _own_names(name: str) -> set[str]:
    """What the header itself names, in any boat."""
    text = "".join(map(template, ("boat.h", "queue.h", "at_once.h", "curves.h")))
    upper, lower = (set(re.findall(rf"\$\{{{n}\}}_(\w+)", text)) for n in ("NAME", "name"))
    return {f"{name.upper()}_{word}" for word in upper} | {f"{name}_{word}" for word in lower}


def _macro(content: Content, name: str, parameter: str) -> str:
    """The header's name of a coefficient or constant."""
    return _spelled(content, name)[parameter]


def _numbers(content: Content, parameters: tuple[str, ...], name: str) -> list[str]:
    rows = []
    for p in parameters:
        error = content.errors[p]
        known = f"+- {error:.2g}" if error > 0 else "given"
        rows.append(
            (
                "#define",
                _macro(content, name, p),
                f"({number(content.values[p])})",
                f"/* {known}",
                f"[{content.units[p]}] */",
            )
        )
    return aligned(rows, " ")


def _constants(content: Content, name: str) -> str:
    names = content.model.vehicle.constants.names
    if not names:
        return ""
    return "\n".join(["", "/* Constants of the thrusters. */", *_numbers(content, names, name), ""])


def _pending(content: Content) -> int:
    """Size of the queue of delayed commands: a power of two, so that a counter may overflow."""
    longest = max(map(content.latency, content.actuators))
    return min(MOST_PENDING, 1 << int(longest * HIGHEST_COMMAND_RATE + 1).bit_length())


def _latencies(content: Content, name: str) -> list[str]:
    """The latency of every actuator, as source code."""
    return [
        _macro(content, name, a.constants["latency"]) if content.latency(a) > 0.0 else "0.0"
        for a in content.actuators
    ]


def _sizes(content: Content, name: str) -> str:
    upper, room = name.upper(), _pending(content)
    return (
        f"enum {{ {upper}_LATENCIES = {len(set(_latencies(content, name)))}, "
        f"{upper}_PENDING = {room} /* delayed commands at once */ }};\n"
    )


def _members(content: Content, name: str, *, late: bool) -> str:
    upper = name.upper()
    lines = []
    if content.scales:
        signals = c_comment(", ".join(content.scales))
        lines.append(
            f"double scale[{len(content.scales)}]; /* known signals, may be set: {signals} */"
        )
    if late:
        lines += [
            "unsigned given;  /* commands so far */",
            f"unsigned arrived[{upper}_LATENCIES]; /* of these, by latency */",
            f"double given_at[{upper}_PENDING]; /* [s] */",
            f"double pending[{upper}_PENDING][{upper}_COMMANDS];",
        ]
    return "".join(f"\n  {line}" for line in lines)


def _queue_words(content: Content, name: str) -> dict[str, str]:
    each = _latencies(content, name)
    once = list(dict.fromkeys(each))
    settle = [
        f"  boat->level[{k}] = boat->target[{k}];"
        for k, a in enumerate(content.actuators)
        if not content.lagged(a)
    ]
    return {
        "latencies": ", ".join(once),
        "latency_of": ", ".join(str(once.index(latency)) for latency in each),
        "pending": str(_pending(content)),
        "settle": "".join(line + "\n" for line in settle),
    }


def _allocation(content: Content) -> list[str]:
    limit = None if content.limit is None else number(content.limit)
    if content.scheme is Scheme.DIRECT:
        commands = [
            signed_sum((w, f"command[{j}]") for j, w in enumerate(row)) for row in content.inverse
        ]
        if limit is not None:
            commands = [f"fmin(fmax({c}, -{limit}), {limit})" for c in commands]
        return _named(content, commands)
    if content.scheme is Scheme.MP:
        shares = [
            signed_sum((w, f"command[{j}]") for j, w in enumerate(row)) for row in content.inverse
        ]
    else:  # Table I and Eq. (11): a share astern is left to the opposite thruster
        shares = [
            " + ".join(
                f"fmax({signed_sum([(2.0 * w, f'command[{j}]')])}, 0.0)"
                for j, w in enumerate(row)
                if w
            )
            for row in content.inverse
        ]
    return [*_named(content, shares), *_limited(content, limit)]


def _limited(content: Content, limit: str | None) -> list[str]:
    """A limit scales the whole wrench, never a single thruster."""
    offset = number(content.offset)
    n = len(content.actuators)
    if limit is None:
        return [f"f[{k}] += {offset};" for k in range(n)] if content.offset else []
    room = number(max(0.0, (content.limit or 0.0) - content.offset))
    scaled = "alpha * f[k]" if not content.offset else f"{offset} + alpha * f[k]"
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
    return aligned(rows, " ")


def _curves(content: Content, name: str) -> list[str]:
    def own(actuator: Actuator, stage: str, neutral: str) -> str:
        found = actuator.constants.get(stage)
        return neutral if found is None else _macro(content, name, found)

    def component(k: int) -> str:
        a = content.actuators[k]
        offset = own(a, "pair_offset_across" if a.across else "pair_offset_along", "")
        return f"{'-' if a.mirrored else ''}f[{k}]" + (f" + {offset}" if offset else "")

    lines = []
    for k, a in enumerate(content.actuators):
        if a.partner is not None:
            sign = "-" if a.mirrored else ""
            dead = own(a, "pair_dead_zone", "0.0")
            value = f"{sign}{name}_pair({component(k)}, {component(a.partner)}, {dead})"
        elif a.tabulated:
            value = f"{name}_table(f[{k}])"
        elif a.curved:
            stages = (
                ("edge_forward", "0.0"),
                ("edge_reverse", "0.0"),
                ("reverse_ratio", "1.0"),
                ("power", "1.0"),
            )
            given = ", ".join(own(a, stage, neutral) for stage, neutral in stages)
            value = f"{name}_curve(f[{k}], {given})"
        else:
            value = f"f[{k}]"
        gain = own(a, "gain", "")
        lines.append(
            (f"target[{k}] = {gain + ' * ' if gain else ''}{value};", f"/* {c_comment(a.name)} */")
        )
    return aligned(lines, " ")


def _table_words(content: Content) -> dict[str, str]:
    points = content.table
    return {
        "points": str(len(points)),
        "table_command": ", ".join(number(x) for x, _ in points),
        "table_thrust": ", ".join(number(y) for _, y in points),
    }


def _mix(content: Content) -> list[str]:
    return aligned(
        [
            (
                f"F[{j}] = {signed_sum((w, f'f[{k}]') for k, w in enumerate(row))};",
                f"/* {c_comment(force)} */",
            )
            for j, (force, row) in enumerate(zip(content.forces, content.mix.tolist(), strict=True))
        ],
        " ",
    )


def acceleration(content: Content, name: str) -> list[str]:
    """Eq. (12), a statement a term."""
    terms = content.structure.terms
    used = {factor.strip("|") for t in terms for factor in t.factors}
    solved = any(t.acceleration is not None for t in terms)
    lines = [f"const double {s} = nu[{i}];" for i, s in enumerate(SYMBOLS) if s in used]
    spelled = _spelled(content, name)
    forces = [(j, spelled[f]) for j, f in enumerate(content.forces) if f in used]
    lines += [f"const double {f} = F[{j}];" for j, f in forces]
    lines += ["double A[3][3] = {{0.0}};"] if solved else []
    lines += ["double g[3] = {0.0, 0.0, 0.0};" if solved else "double* const g = nu_dot;"]
    if not used & set(content.forces):
        lines.append("(void)F;")
    if not solved:
        lines.append("g[0] = g[1] = g[2] = 0.0;")

    def spell(word: str) -> str:
        return f"fabs({word[1:-1]})" if word.startswith("|") else spelled.get(word, word)

    for axis, axis_name in enumerate(AXES):
        lines.append(f"/* {axis_name} */")
        for term in (t for t in terms if t.axis == axis):
            sign, value = product(term, spell)
            if term.acceleration is None:
                lines.append(f"g[{axis}] {sign}= {value};")
            else:
                times = ACCELERATIONS[term.acceleration]
                lines.append(f"A[{axis}][{term.acceleration}] {sign}= {value}; /* times {times} */")
    return [*lines, *([f"{name}_solve(A, g, nu_dot);"] if solved else [])]


def _prepare(content: Content, name: str) -> str:
    """Constants of all steps of an advance: fades and multipliers."""
    lines = []
    n = len(content.actuators)
    if "fade" in _functions(content):
        lines.append(
            f"double begin[{n}], middle[{n}], end[{n}]; /* decay of the distance to the target by the lag */"
        )
    if content.scales:
        lines.append(f"double gain[{n}]; /* of the known signals */")
    for k, a in enumerate(content.actuators):
        if "fade" in _functions(content):
            lag = _macro(content, name, a.constants["lag"]) if content.lagged(a) else "0.0"
            lines.append(f"{name}_fade(h, {lag}, &begin[{k}], &middle[{k}], &end[{k}]);")
    for k, a in enumerate(content.actuators):
        if content.scales:
            lines.append(f"gain[{k}] = {_multiplier(content, name, a)};")
    return "".join(f"  {line}\n" for line in lines)


def _multiplier(content: Content, name: str, actuator: Actuator) -> str:
    if actuator.scale is None:
        return "1.0"
    reference = number(list(content.scales.values())[actuator.scale])
    power = _macro(content, name, actuator.constants["scale_power"])
    return f"{name}_multiplier(boat->scale[{actuator.scale}], {reference}, {power})"


def _thrusts(content: Content, name: str) -> list[str]:
    gains = [
        f"{_multiplier(content, name, a)} * " if a.scale is not None else ""
        for a in content.actuators
    ]
    return [f"thrust[{k}] = {gain}boat->level[{k}];" for k, gain in enumerate(gains)]


def _levels(content: Content) -> list[str]:
    gain = "gain[k] * " if content.scales else ""
    if "fade" not in _functions(content):
        return [f"thrust[0][k] = thrust[1][k] = thrust[2][k] = {gain}boat->level[k];"]
    return [
        "const double away = boat->level[k] - boat->target[k];",
        f"thrust[0][k] = {gain}{'(' if gain else ''}boat->target[k] + away * begin[k]{')' if gain else ''};",
        f"thrust[1][k] = {gain}{'(' if gain else ''}boat->target[k] + away * middle[k]{')' if gain else ''};",
        "boat->level[k] = boat->target[k] + away * end[k];",
        f"thrust[2][k] = {gain}boat->level[k];",
    ]


def _reset(content: Content) -> str:
    return "".join(
        f"  boat->scale[{i}] = {number(value)}; /* {c_comment(signal)} at its reference */\n"
        for i, (signal, value) in enumerate(content.scales.items())
    )
