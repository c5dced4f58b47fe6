# SPDX-License-Identifier: MIT
"""Text and numbers for LaTeX."""

import numpy as np

_LETTERS = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_",
    "{": r"\{", "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "−": "$-$", "–": "--", "±": r"$\pm$", "²": "$^2$", "·": r"$\cdot$", "√": r"$\surd$",
    "<": "$<$", ">": "$>$", "|": "$|$", "×": r"$\times$",
}  # fmt: skip


def latex_text(text: str) -> str:
    """Text escaped for LaTeX, on one line."""
    return "".join(_LETTERS.get(c, c) if c.isprintable() else " " for c in text)


def latex_number(value: float, digits: int) -> str:
    """A number as `markup.number` writes it, in mathematics."""
    if not np.isfinite(value):
        return "--"
    text = f"{value:#.{digits}g}"
    mantissa, _, exponent = text.partition("e")
    power = rf" \cdot 10^{{{int(exponent)}}}" if exponent else ""
    return f"${mantissa.rstrip('.')}{power}$"
