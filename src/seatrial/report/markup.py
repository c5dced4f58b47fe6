# SPDX-License-Identifier: MIT
"""HTML in small pieces: numbers, names with subscripts, units, tables, equations."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from html import escape

import numpy as np

from seatrial.frames import SYMBOLS
from seatrial.structure import ACCELERATIONS, Structure, Term

NOT_A_NUMBER = "–"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 4) -> str:
    """A number as people write it: `digits` significant, a true minus, powers of ten."""
    if not np.isfinite(value):
        return NOT_A_NUMBER
    text = f"{value:#.{digits}g}"
    mantissa, _, exponent = text.partition("e")
    mantissa = mantissa.rstrip(".").replace("-", "−")
    if not exponent:
        return mantissa
    return f"{mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPT)}"


def data(value: float, digits: int = 4, scale: float = 1.0) -> str:
    """A number that carries its full value for machines; `scale` is for the eye only."""
    return f'<data value="{value!r}">{number(value * scale, digits)}</data>'


def symbol(name: str) -> str:
    """A coefficient, velocity, acceleration or force: `X_uu` with its subscript, `u_dot` dotted."""
    if name in ACCELERATIONS:
        return f"<i>{name[0]}\u0307</i>"
    if name.startswith("|") and name.endswith("|"):
        return f"|<i>{escape(name[1:-1])}</i>|"
    head, _, tail = name.partition("_")
    if len(head) > 1:  # a constant of the thrusters: a word
        return escape(name)
    return f"<i>{escape(head)}</i>" + (f"<sub>{escape(tail)}</sub>" if tail else "")


def unit(text: str) -> str:
    """A unit with its powers raised: `m/s^2`."""
    return re.sub(r"\^(\d+)", r"<sup>\1</sup>", escape(text))


def equation(structure: Structure, axis: int, values: Mapping[str, float] | None = None) -> str:
    """One axis' equation with names or with numbers; its plain text is the element's title."""
    right = ""
    for term in (t for t in structure.terms if t.axis == axis):
        size, parts = _factors(term, values)
        sign = "−" if size < 0 else "+"
        right += f" {sign} " if right else sign.strip("+")
        known = abs(size) == 1.0 and parts
        right += "\u2009".join([*([] if known else [number(abs(size))]), *map(symbol, parts)])
    left = symbol(f"{SYMBOLS[axis]}_dot")
    plain = escape(structure.equation(axis, values), quote=True)
    return f'<span class="equation" title="{plain}">{left} = {right or "0"}</span>'


def table(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    kind: str = "",
    marked: Collection[int] = (),
) -> str:
    """A table of cells that are HTML already; the first of a row heads it; `marked` rows stand out.

    A row of one cell heads the rows below it.
    """
    top = "".join(f'<th scope="col">{cell}</th>' for cell in head)
    body = ""
    for place, (first, *rest) in enumerate(rows):
        if not rest:
            body += (
                f'<tr class="group"><th scope="rowgroup" colspan="{len(head)}">{first}</th></tr>'
            )
            continue
        mark = ' class="marked"' if place in marked else ""
        cells = "".join(f"<td>{cell}</td>" for cell in rest)
        body += f'<tr{mark}><th scope="row">{first}</th>{cells}</tr>'
    return (
        f'<div class="scroll" tabindex="0"><table class="{kind}"><thead><tr>{top}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def listing(items: Iterable[str], kind: str = "") -> str:
    """An unordered list of items that are HTML already."""
    return f'<ul class="{kind}">' + "".join(f"<li>{item}</li>" for item in items) + "</ul>"


def _factors(term: Term, values: Mapping[str, float] | None) -> tuple[float, list[str]]:
    """The number before a term, and the names after it."""
    size, names = term.number, [term.coefficient] if term.coefficient else []
    if values is not None and term.coefficient:
        size, names = size * values[term.coefficient], []
    names += term.factors
    names += [ACCELERATIONS[term.acceleration]] if term.acceleration is not None else []
    return size, names
