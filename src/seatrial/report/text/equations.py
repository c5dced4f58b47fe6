# SPDX-License-Identifier: MIT
"""The equations of a model as MathML, as text and for LaTeX; with names or with numbers."""

from collections.abc import Mapping
from html import escape

from seatrial.boat.structure import ACCELERATIONS, Structure, Term
from seatrial.report.text.latex import latex_number
from seatrial.report.text.markup import number
from seatrial.report.text.names import latex_symbol, mathml_symbol
from seatrial.util.frames import SYMBOLS

Values = Mapping[str, float]
_ROOM = "0.25em"  # beside a sign; on the other side there is a space, where a line may break
_TIMES = '<mo lspace="0" rspace="0.17em">\u2062</mo>'  # invisible


def equations(structure: Structure, values: Values | None = None) -> str:
    """All three as HTML, and below them what can be copied: text, and LaTeX for `align*`."""
    drawn = "".join(_mathml(structure, axis, values) for axis in range(3))
    plain = "\n".join(structure.equation(axis, values) for axis in range(3))
    tex = latex_equations(structure, values)
    return (
        f'<div class="equations">{drawn}<details class="fine"><summary>as text and LaTeX</summary>'
        f'<pre tabindex="0">{escape(plain)}</pre><pre tabindex="0">{escape(tex)}</pre></details></div>'
    )


def latex_equations(structure: Structure, values: Values | None = None) -> str:
    """All three as the lines of an `align*`."""
    return " \\\\\n".join(_latex(structure, axis, values) for axis in range(3))


def _mathml(structure: Structure, axis: int, values: Values | None) -> str:
    """One axis; a `math` element for each term, so that a narrow screen breaks between them."""
    own = [t for t in structure.terms if t.axis == axis]
    terms = [_term(t, values, first=i == 0) for i, t in enumerate(own)] or ["<mn>0</mn>"]
    left = mathml_symbol(f"{SYMBOLS[axis]}_dot") + f'<mo lspace="{_ROOM}" rspace="0">=</mo>'
    right = " ".join(f"<math>{term}</math>" for term in terms)
    plain = escape(structure.equation(axis, values), quote=True)
    return f'<div class="equation" title="{plain}"><math>{left}</math><span>{right}</span></div>'


def _term(term: Term, values: Values | None, *, first: bool) -> str:
    """Sign, number where it is not 1, names."""
    size, names = _factors(term, values)
    sign = "−" if size < 0 else "+"
    shown = (
        ""
        if first and size >= 0
        else f'<mo lspace="0" rspace="{0 if first else _ROOM}">{sign}</mo>'
    )
    bare = abs(size) == 1.0 and names
    parts = [] if bare else [f"<mn>{number(abs(size))}</mn>"]
    return f"{shown}{_TIMES.join([*parts, *map(mathml_symbol, names)])}"


def _latex(structure: Structure, axis: int, values: Values | None) -> str:
    """One line of an `align*`."""
    right = ""
    for term in (t for t in structure.terms if t.axis == axis):
        size, names = _factors(term, values)
        sign = "-" if size < 0 else "+"
        right += f" {sign} " if right else sign.strip("+")
        parts = [] if abs(size) == 1.0 and names else [latex_number(abs(size), 4)]
        right += r" \, ".join(part.strip("$") for part in [*parts, *map(latex_symbol, names)])
    return f"{latex_symbol(f'{SYMBOLS[axis]}_dot').strip('$')} &= {right or '0'}"


def _factors(term: Term, values: Values | None) -> tuple[float, list[str]]:
    """The number before a term, and the names after it."""
    size, names = term.number, [term.coefficient] if term.coefficient else []
    if values is not None and term.coefficient:
        size, names = size * values[term.coefficient], []
    names += term.factors
    names += [ACCELERATIONS[term.acceleration]] if term.acceleration is not None else []
    return size, names
