# SPDX-License-Identifier: MIT
"""Cells of a table: the same content for the page, for CSV and for LaTeX."""

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from seatrial.report.text.latex import latex_number, latex_text
from seatrial.report.text.markup import NOT_A_NUMBER, data, unit
from seatrial.report.text.names import html_symbol, latex_symbol
from seatrial.util.statistics import NORMAL_95


class Cell(ABC):
    """One cell."""

    @abstractmethod
    def html(self) -> str:
        """For the page."""

    @abstractmethod
    def plain(self) -> str:
        """For CSV: numbers in full, names as they stand in files."""

    @abstractmethod
    def latex(self) -> str:
        """For a paper."""


@dataclass(frozen=True)
class Text(Cell):
    """Words."""

    text: str

    def html(self) -> str:
        """Escaped."""
        return escape(self.text)

    def plain(self) -> str:
        """As it is."""
        return self.text

    def latex(self) -> str:
        """Escaped."""
        return latex_text(self.text)


@dataclass(frozen=True)
class Number(Cell):
    """A number with its full value; `scale` makes the unit that is shown, and what CSV gets."""

    value: float
    digits: int = 4
    scale: float = 1.0
    suffix: str = ""

    def html(self) -> str:
        """A few digits, with the unscaled value for machines."""
        return data(self.value, self.digits, self.scale) + escape(self.suffix)

    def plain(self) -> str:
        """Ten digits."""
        return f"{self.value * self.scale:.10g}" if np.isfinite(self.value) else ""

    def latex(self) -> str:
        """A few digits, powers of ten written out."""
        return latex_number(self.value * self.scale, self.digits) + latex_text(self.suffix)


@dataclass(frozen=True)
class Interval(Cell):
    """From one number to another."""

    low: float
    high: float
    digits: int = 3
    scale: float = 1.0

    @property
    def shown_digits(self) -> int:
        """Digits that distinguish both ends."""
        width, size = abs(self.high - self.low), max(abs(self.low), abs(self.high))
        if not 0.0 < width < size:
            return self.digits
        return max(self.digits, min(8, 2 + int(np.ceil(np.log10(size / width)))))

    def html(self) -> str:
        """Both ends."""
        ends = [data(x, self.shown_digits, self.scale) for x in (self.low, self.high)]
        return " to ".join(ends)

    def ends(self) -> tuple[str, str]:
        """Ten digits of each end."""
        return f"{self.low * self.scale:.10g}", f"{self.high * self.scale:.10g}"

    def plain(self) -> str:
        """Both ends, in one cell."""
        return " to ".join(self.ends())

    def latex(self) -> str:
        """Both ends."""
        ends = [latex_number(x * self.scale, self.shown_digits) for x in (self.low, self.high)]
        return " to ".join(ends)


@dataclass(frozen=True)
class Worded(Cell):
    """A number that is shown in words: half a minute."""

    value: float
    words: str
    unit: str = ""  # of the number

    def html(self) -> str:
        """The words, with the number for machines."""
        return f'<data value="{self.value!r}">{escape(self.words)}</data>'

    def plain(self) -> str:
        """The number."""
        return f"{self.value:.10g}" if np.isfinite(self.value) else ""

    def latex(self) -> str:
        """The words."""
        return latex_text(self.words)


@dataclass(frozen=True)
class Name(Cell):
    """A coefficient, constant, force or velocity, or several of them; set in italics."""

    name: str
    more: str = ""  # words after it

    def html(self) -> str:
        """With subscripts."""
        return ", ".join(html_symbol(n) for n in self.name.split(", ")) + escape(self.more)

    def plain(self) -> str:
        """As files have it."""
        return self.name + self.more

    def latex(self) -> str:
        """With subscripts."""
        names = ", ".join(latex_symbol(n) for n in self.name.split(", "))
        return names + latex_text(self.more)


class Unit(Text):
    """A unit such as `m/s^2`."""

    def html(self) -> str:
        """With raised powers."""
        return unit(self.text)

    def latex(self) -> str:
        """With raised powers."""
        raised = re.sub(r"\\textasciicircum\{\}(\d+)", r"$^{\1}$", latex_text(self.text))
        return raised if self.text != "-" else "--"


@dataclass(frozen=True)
class Nothing(Cell):
    """No number."""

    def html(self) -> str:
        """A dash."""
        return NOT_A_NUMBER

    def plain(self) -> str:
        """An empty cell."""
        return ""

    def latex(self) -> str:
        """A dash."""
        return "--"


NOTHING = Nothing()


def known(value: float | None, digits: int = 4, scale: float = 1.0) -> Cell:
    """A number, or a dash where there is none."""
    return NOTHING if value is None or not np.isfinite(value) else Number(value, digits, scale)


def with_error(value: float, error: float) -> list[Cell]:
    """A value, its standard error and its 95 % interval; dashes where it has none."""
    width = NORMAL_95 * error
    interval = (value - width, value + width) if error > 0 else None
    return [Number(value, 4), known(error if error > 0 else None, 2), between(interval)]


def between(pair: Sequence[float] | None, digits: int = 3, scale: float = 1.0) -> Cell:
    """An interval, or a dash where there is none."""
    if pair is None or not np.isfinite(pair).all():
        return NOTHING
    return Interval(float(pair[0]), float(pair[1]), digits, scale)
