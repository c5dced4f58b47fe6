# SPDX-License-Identifier: MIT
"""HTML in small pieces: numbers, units, lists."""

import re
from collections.abc import Iterable
from html import escape

import numpy as np

NOT_A_NUMBER = "–"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 4) -> str:
    """A number as text: `digits` significant, a true minus, powers of ten."""
    if not np.isfinite(value):
        return NOT_A_NUMBER
    text = f"{value:#.{digits}g}"
    mantissa, _, exponent = text.partition("e")
    mantissa = mantissa.rstrip(".").replace("-", "−")
    if not exponent:
        return mantissa
    return f"{mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPT)}"


def data(value: float, digits: int = 4, scale: float = 1.0) -> str:
    """A number that carries its full value for machines; `scale` only changes the text."""
    return f'<data value="{value!r}">{number(value * scale, digits)}</data>'


def true_minus(text: str) -> str:
    """Text whose numbers have a minus that is as wide as a plus, and no `e+02`."""
    plain = re.sub(r"\b\d+(\.\d+)?e[+-]\d+\b", lambda m: number(float(m[0]), 2), text)
    return re.sub(r"(?<![\w.)])-(?=\.?\d)", "−", plain)


def unit(text: str) -> str:
    """A unit with its powers raised: `m/s^2`."""
    return re.sub(r"\^(\d+)", r"<sup>\1</sup>", escape(text))


def listing(items: Iterable[str], kind: str = "") -> str:
    """An unordered list of items that are HTML already."""
    return f'<ul class="{kind}">' + "".join(f"<li>{item}</li>" for item in items) + "</ul>"
