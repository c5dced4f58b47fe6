# SPDX-License-Identifier: MIT
"""Terms, sums and numbers as source code, common to C and MATLAB."""

from collections.abc import Callable, Iterable

from seatrial.boat.structure import Term

Spell = Callable[[str], str]  # a factor or coefficient in the language


def number(value: float) -> str:
    """A number that reads back exactly."""
    return repr(float(value))


def signed_sum(weights: Iterable[tuple[float, str]]) -> str:
    """`0.5 * a - 0.5 * b`; `0.0` without terms."""
    text = ""
    for weight, name in weights:
        if weight == 0.0:
            continue
        size = "" if abs(weight) == 1.0 else f"{number(abs(weight))} * "
        sign = ("-" if weight < 0 else "") if not text else (" - " if weight < 0 else " + ")
        text += f"{sign}{size}{name}"
    return text or "0.0"


def product(term: Term, spell: Spell) -> tuple[str, str]:
    """Sign and product of a term's number, coefficient and factors, without its acceleration."""
    names = [term.coefficient] if term.coefficient else []
    parts = [spell(name) for name in (*names, *term.factors)]
    size = abs(term.number)
    head = [] if size == 1.0 and parts else [number(size)]
    return "-" if term.number < 0 else "+", " * ".join([*head, *parts])


def aligned(rows: Iterable[tuple[str, ...]]) -> list[str]:
    """Rows of words as aligned columns; the last one is not padded."""
    rows = list(rows)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)][:-1] if rows else []
    return [
        " ".join([*(w.ljust(n) for w, n in zip(row, widths, strict=False)), row[-1]]).rstrip()
        for row in rows
    ]
