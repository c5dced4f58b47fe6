# SPDX-License-Identifier: MIT
"""Positions of values on an axis of an SVG plot, and its ticks."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from seatrial.util.frames import Array

TICK_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)  # times a power of ten
WANTED_TICKS = 6


@dataclass(frozen=True)
class Axis:
    """Values (logarithms, where it is logarithmic) from `begin` to `end`, at pixels `low` to `high`."""

    begin: float
    end: float
    low: float  # [px]
    high: float  # [px]
    logarithmic: bool
    given: tuple[tuple[float, str], ...] = ()  # ticks

    def place(self, values: ArrayLike) -> Array:
        """Pixels of values; NaN where the value is not on the axis."""
        found = np.asarray(values, dtype=float)
        if self.logarithmic:
            positive = found > 0
            found = np.where(positive, np.log10(np.where(positive, found, 1.0)), np.nan)
        share = (found - self.begin) / (self.end - self.begin)
        return np.asarray(self.low + share * (self.high - self.low))

    def ticks(self) -> list[tuple[float, str]]:
        """Pixels and texts."""
        ticks = list(self.given) or (self._decades() if self.logarithmic else self._even())
        places = self.place([value for value, _ in ticks])
        inside = sorted((self.low, self.high))
        return [
            (float(at), text)
            for at, (_, text) in zip(places, ticks, strict=True)
            if inside[0] - 0.5 <= at <= inside[1] + 0.5
        ]

    def widened(self, each: float) -> "Axis":
        """The same around its middle, with so many units a pixel."""
        half = 0.5 * each * abs(self.high - self.low)
        middle = 0.5 * (self.begin + self.end)
        return replace(self, begin=middle - half, end=middle + half)

    def _even(self) -> list[tuple[float, str]]:
        span = self.end - self.begin
        power = 10.0 ** np.floor(np.log10(span / WANTED_TICKS))
        step = next(s * power for s in TICK_STEPS if span / (s * power) <= WANTED_TICKS + 1)
        first = np.ceil(self.begin / step - 1e-9)
        count = int(np.floor(self.end / step + 1e-9) - first) + 1
        values = ((first + np.arange(count)) * step).tolist()
        return [(v, f"{v + 0.0:.6g}".replace("-", "−")) for v in (round(v, 12) for v in values)]

    def _decades(self) -> list[tuple[float, str]]:
        powers = range(int(np.floor(self.begin)), int(np.ceil(self.end)) + 1)
        factors = (1.0, 2.0, 5.0) if len(powers) <= 4 else (1.0,)
        return [(f * 10.0**p, f"{f * 10.0**p:.6g}") for p in powers for f in factors]


def axis_of(layout: Mapping[str, Any], values: Array, low: float, high: float) -> Axis:
    """An axis from Plotly's description, that shows all values where no range is given."""
    logarithmic = layout.get("type") == "log"
    begin, end = layout["range"] if "range" in layout else _reach(layout, values, logarithmic)
    ticks: tuple[tuple[float, str], ...] = ()
    if "tickvals" in layout:
        ticks = tuple(zip(layout["tickvals"], layout["ticktext"], strict=True))
    return Axis(float(begin), float(end), low, high, logarithmic, ticks)


def _reach(layout: Mapping[str, Any], values: Array, logarithmic: bool) -> tuple[float, float]:
    found = np.log10(values[values > 0]) if logarithmic else values
    if not len(found):
        return 0.0, 1.0
    low, high = float(found.min()), float(found.max())
    if layout.get("rangemode") == "tozero" and not logarithmic:
        low, high = min(low, 0.0), max(high, 0.0)
    room = 0.05 * (high - low) or max(abs(high), 1.0) * 0.1
    zero = layout.get("rangemode") == "tozero" and low == 0.0
    return (0.0 if zero else low - room), high + room
