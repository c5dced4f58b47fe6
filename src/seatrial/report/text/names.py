# SPDX-License-Identifier: MIT
"""Names as mathematics, `X_uu` with its subscript: for the page, its plots, MathML and LaTeX."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape

from seatrial.boat.model import Model
from seatrial.boat.structure import ACCELERATIONS
from seatrial.report.text.latex import latex_text
from seatrial.report.text.markup import true_minus

_DOT = "\u0307"  # combining, above


@dataclass(frozen=True)
class Symbol:
    """A coefficient, velocity, acceleration or force, parsed; or a word."""

    letter: str  # the whole of a word
    below: str = ""  # subscript
    dotted: bool = False
    bars: bool = False
    word: bool = False  # a constant of the thrusters


def parsed(name: str) -> Symbol:
    """`X_uu`, `|u|`, `u_dot`, `F_u`, or `lag.bow`."""
    if name in ACCELERATIONS:
        return Symbol(name[0], dotted=True)
    if name.startswith("|") and name.endswith("|"):
        return Symbol(name[1:-1], bars=True)
    head, _, tail = name.partition("_")
    return Symbol(name, word=True) if len(head) > 1 or "." in name else Symbol(head, tail)


def html_symbol(name: str) -> str:
    """In italics, with subscript; a word may break after a dot or an underscore."""
    own = parsed(name)
    letter = escape(own.letter)
    if own.word:
        return letter.replace(".", ".<wbr>").replace("_", "_<wbr>")
    if own.bars:
        return f"|<i>{letter}</i>|"
    below = f"<sub>{escape(own.below)}</sub>" if own.below else ""
    return f"<i>{letter}{_DOT if own.dotted else ''}</i>{below}"


def plotly_symbol(name: str) -> str:
    """With the subscripts that Plotly and `svg` read."""
    own = parsed(name)
    letter = f"|{own.letter}|" if own.bars else own.letter + (_DOT if own.dotted else "")
    return escape(letter) + (f"<sub>{escape(own.below)}</sub>" if own.below else "")


def latex_symbol(name: str) -> str:
    """In mathematics."""
    own = parsed(name)
    if own.word:
        return latex_text(name)
    if own.bars:
        return f"$|{own.letter}|$"
    if own.dotted:
        return rf"$\dot {own.letter}$"
    below = rf"_{{\mathrm{{{latex_text(own.below)}}}}}" if own.below else ""
    return f"${latex_text(own.letter)}{below}$"


def mathml_symbol(name: str) -> str:
    """MathML Core; the page's style sets `mi` in italics, so that no special font is needed."""
    own = parsed(name)
    letter = f'<mi mathvariant="normal">{escape(own.letter)}</mi>'
    if own.word:
        return f"<mtext>{escape(own.letter)}</mtext>"
    if own.bars:
        sides = (f'<mo form="{f}" stretchy="false">|</mo>' for f in ("prefix", "postfix"))
        return letter.join(sides)
    if own.dotted:
        return f'<mover accent="true">{letter}<mo stretchy="false">\u02d9</mo></mover>'
    return f"<msub>{letter}<mtext>{escape(own.below)}</mtext></msub>" if own.below else letter


def names_in(*models: Model) -> tuple[str, ...]:
    """Coefficients and forces of models."""
    own = (n for m in models for n in (*m.values, *(f.name for f in m.structure.forces)))
    return tuple(dict.fromkeys(own))


def sentence(text: str, names: Iterable[str] = ()) -> str:
    """Words as HTML; these names in them as mathematics, numbers with a true minus."""
    known = "|".join(re.escape(name) for name in names)
    parts = re.split(rf"(?<![\w.])({known})(?!\w|\.\w)", text) if known else [text]
    return "".join(
        html_symbol(part) if i % 2 else escape(true_minus(part)) for i, part in enumerate(parts)
    )
