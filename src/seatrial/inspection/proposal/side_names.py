# SPDX-License-Identifier: MIT
"""Thrusters whose names say on which side of the boat they are, against what they do."""

import re
from collections.abc import Mapping
from typing import Any

from seatrial.util.frames import Axes

SIDES = {"port|left": 1.0, "starboard|stbd|right": -1.0}  # y of a thruster, forward-left-up
PART = re.compile(r"[A-Za-z]+")


def contradicting_names(forces: Mapping[str, Mapping[str, Any]], axes: str) -> tuple[str, ...]:
    """Thrusters that turn the boat as those of the other side do, where all with such names do.

    A thruster on the left that drives the boat ahead turns it to the right. forces: of a proposal, in `axes`.
    """
    by_axis = {force["axis"]: force["of"] for force in forces.values()}
    surge, yaw = by_axis.get("surge", {}), by_axis.get("yaw", {})
    left_up = -1.0 if axes == Axes.FRD.value else 1.0
    named = {name: side for name in yaw if (side := _side(name)) and surge.get(name)}
    wrong = [n for n, side in named.items() if left_up * side * surge[n] * yaw[n] > 0.0]
    return tuple(wrong) if len(wrong) == len(named) else ()


def _side(name: str) -> float:
    """1: left, -1: right; 0: the name does not say."""
    words = {word.lower() for word in PART.findall(name.replace("_", " "))}
    found = {side for pattern, side in SIDES.items() if words & set(pattern.split("|"))}
    return found.pop() if len(found) == 1 else 0.0
