# SPDX-License-Identifier: MIT
"""The tables of docs/tune.md."""

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.harness.markdown import table
from benchmarks.studies.guidance.boat import CALM, WINDY, Weather
from benchmarks.studies.guidance.study import (
    PILOTS,
    SHAPES,
    SPEEDS,
    Outcome,
    by_hand,
    keeping_station,
    outcomes,
    tuned,
)

WEAK = 0.7  # gain of the left thruster that has lost some


def cell(found: Sequence[Outcome]) -> str:
    """RMS and 95 % of the distance from the path [m]."""
    rms = np.sqrt(np.mean([one.rms**2 for one in found]))
    return f"{rms:.2f}, {max(one.most for one in found):.2f}"


def _followed(windy: bool, left: float = 1.0) -> str:
    rows = [
        [shape, f"{speed:g}", *(cell(outcomes(shape, speed, pilot, windy=windy, left=left)) for pilot in PILOTS)]
        for shape in SHAPES
        for speed in SPEEDS
    ]  # fmt: skip
    return table(["course", "speed [m/s]", *(f"{pilot} [m]" for pilot in PILOTS)], rows)


def courses() -> str:
    """In wind and current."""
    return _followed(windy=True)


def calm() -> str:
    """In calm water."""
    return _followed(windy=False)


def weak() -> str:
    """In wind and current, the left thruster at 70 %."""
    return _followed(windy=True, left=WEAK)


def station() -> str:
    """Keeping station."""
    places: dict[str, tuple[Weather, float]] = {
        "calm": (CALM, 1.0),
        "current 0.1 m/s": (Weather(WINDY.current), 1.0),
        "wind and current": (WINDY, 1.0),
        "wind and current, one thruster at 70 %": (WINDY, WEAK),
    }
    rows = []
    for name, (weather, left) in places.items():
        rms, most = keeping_station(weather, left)
        rows.append([name, f"{rms:.2f}", f"{most:.2f}"])
    return table(["", "RMS [m]", "95 % [m]"], rows)


def constants() -> str:
    """What the two controllers use."""
    hand, own = by_hand(), tuned()
    p, d = own.table()[:, 0], own.table()[:, 2]
    guidance = own.guidance
    assert guidance is not None
    rows = [
        ["by hand", f"{hand.heading[0]:g}, {hand.heading[1]:g}", f"{hand.speed:g}", f"{hand.ahead:g}"],
        ["tuned", f"{p[2]:.2f}, {d[2]:.2f}", f"{d[0]:.2f}", f"{guidance.time:.1f} s times the speed"],
    ]  # fmt: skip
    return table(["", "heading P, D", "speed P", "look-ahead [m]"], rows)


MAKERS: dict[str, Callable[[], str]] = {
    "twin-constants": constants, "twin-courses": courses, "twin-weak": weak, "twin-station": station,
    "twin-calm": calm,
}  # fmt: skip
