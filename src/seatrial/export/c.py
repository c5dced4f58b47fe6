# SPDX-License-Identifier: MIT
"""A C99 header: reset, command, step: the core's model, written out for one boat."""

from seatrial.boat.structure import ACCELERATIONS
from seatrial.export.c_chain import (
    allocation,
    curves,
    functions,
    levels,
    mix,
    parts,
    prepare,
    table_words,
    thrusts,
)
from seatrial.export.c_names import Names, names_of
from seatrial.export.content import Content
from seatrial.export.spelling import c_comment
from seatrial.export.template import block, fill, pieces, template
from seatrial.export.terms import aligned, number, product
from seatrial.util.frames import AXES, SYMBOLS

HIGHEST_COMMAND_RATE = 1000.0  # [Hz] for which the queue of delayed commands has room
MOST_PENDING = 1 << 16  # commands in the queue


def header(content: Content, name: str) -> str:
    """The header's text; every name in it starts with `name`."""
    return fill(template("boat.h"), words(content, names_of(content, name)))


def words(content: Content, names: Names) -> dict[str, str]:
    """The substitutions of `boat.h`."""
    late = any(content.latency(a) > 0.0 for a in content.actuators)
    common = {
        "name": names.name,
        "NAME": names.name.upper(),
        "vehicle": c_comment(content.vehicle_name),
        "source": c_comment(content.source),
    }
    queue = fill(
        template("queue.h" if late else "at_once.h"), {**common, **_queue_words(content, names)}
    )
    return {
        **common,
        "axes": content.axes.value,
        "INPUTS": str(len(content.inputs)),
        "ACTUATORS": str(len(content.actuators)),
        "FORCES": str(len(content.forces)),
        "example": ", ".join(["0.5", *["0.0"] * (len(content.inputs) - 1)]),
        "angles": "".join(f"\n * {c_comment(note)}" for note in content.angle_notes),
        "radians": "; an angle in rad" if content.angles else "",
        "input_comment": c_comment(", ".join(content.inputs)),
        "coefficients": "\n".join(_numbers(content, content.structure.coefficients, names)),
        "constants": _constants(content, names),
        "longest_step": number(content.longest_step),
        "sizes": _sizes(content, names) if late else "",
        "members": _members(content, names, late=late),
        "allocation": block(allocation(content), "  "),
        "curves": block(curves(content, names), "  "),
        "mix": block(mix(content), "  "),
        "acceleration": block(acceleration(content, names), "  "),
        "prepare": prepare(content, names),
        "levels": block(levels(content, names), "      "),
        **_functions(content, names, common),
        "queue": queue,
        "thrusts": block(thrusts(content, names), "  "),
        "reset": _reset(content),
    }


def _functions(content: Content, names: Names, common: dict[str, str]) -> dict[str, str]:
    """The substitutions that are functions which this boat needs, or the names of these."""
    sections = pieces("curves.h", "/* ")
    used = functions(content)
    return {
        "curve_functions": "".join(
            "\n" + fill(sections[key], {**common, **table_words(content)})
            for key in ("curve", "pair", "table", "fade", "degree", "limited", "multiplier")
            if key in used
        ),
        "solve_function": "\n" + fill(sections["solve"], common) if "solve" in used else "",
        "whole": "_smooth" if "limited" in used else "_advance",
        "smooth": ", up to the end of a rate limit" if "limited" in used else "",
        "parts_function": fill(
            sections["parts"], {**common, "parts": block(parts(content, names), "    ")}
        )
        if "limited" in used
        else "",
    }


def _numbers(content: Content, parameters: tuple[str, ...], names: Names) -> list[str]:
    rows = []
    for p in parameters:
        error = content.errors[p]
        known = f"+- {error:.2g}" if error > 0 else "given"
        stated = ("#define", names.macros[p], f"({number(content.values[p])})")
        rows.append((*stated, f"/* {known}", f"[{content.units[p]}] */"))
    return aligned(rows)


def _constants(content: Content, names: Names) -> str:
    constants = content.model.vehicle.constants.names
    if not constants:
        return ""
    return "\n".join(
        ["", "/* Constants of the thrusters. */", *_numbers(content, constants, names), ""]
    )


def _pending(content: Content) -> int:
    """Size of the queue of delayed commands: a power of two, so that a counter may overflow."""
    longest = max(map(content.latency, content.actuators))
    return min(MOST_PENDING, 1 << int(longest * HIGHEST_COMMAND_RATE + 1).bit_length())


def _latencies(content: Content, names: Names) -> list[str]:
    """The latency of every actuator, as source code."""
    return [
        names.macros[a.constants["latency"]] if content.latency(a) > 0.0 else "0.0"
        for a in content.actuators
    ]


def _sizes(content: Content, names: Names) -> str:
    upper, room = names.name.upper(), _pending(content)
    return (
        f"enum {{ {upper}_LATENCIES = {len(set(_latencies(content, names)))}, "
        f"{upper}_PENDING = {room} /* delayed commands at once */ }};\n"
    )


def _members(content: Content, names: Names, *, late: bool) -> str:
    upper = names.name.upper()
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


def _queue_words(content: Content, names: Names) -> dict[str, str]:
    each = _latencies(content, names)
    once = list(dict.fromkeys(each))
    settle = [
        f"  boat->level[{k}] = boat->target[{k}];"
        for k, a in enumerate(content.actuators)
        if not content.lagged(a) and not content.limited(a)
    ]
    return {
        "latencies": ", ".join(once),
        "latency_of": ", ".join(str(once.index(latency)) for latency in each),
        "pending": str(_pending(content)),
        "settle": "".join(line + "\n" for line in settle),
    }


def acceleration(content: Content, names: Names) -> list[str]:
    """Eq. (12), a statement a term."""
    terms = content.structure.terms
    used = {factor.strip("|") for t in terms for factor in t.factors}
    solved = any(t.acceleration is not None for t in terms)
    lines = [f"const double {s} = nu[{i}];" for i, s in enumerate(SYMBOLS) if s in used]
    forces = [(j, names.forces[f]) for j, f in enumerate(content.forces) if f in used]
    lines += [f"const double {f} = F[{j}];" for j, f in forces]
    lines += ["double A[3][3] = {{0.0}};"] if solved else []
    lines += ["double g[3] = {0.0, 0.0, 0.0};" if solved else "double* const g = nu_dot;"]
    if not used & set(content.forces):
        lines.append("(void)F;")
    if not solved:
        lines.append("g[0] = g[1] = g[2] = 0.0;")

    spelled = names.macros | names.forces

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
    return [*lines, *([f"{names.name}_solve(A, g, nu_dot);"] if solved else [])]


def _reset(content: Content) -> str:
    return "".join(
        f"  boat->scale[{i}] = {number(value)}; /* {c_comment(signal)} at its reference */\n"
        for i, (signal, value) in enumerate(content.scales.items())
    )
