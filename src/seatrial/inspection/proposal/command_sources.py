# SPDX-License-Identifier: MIT
"""Columns of the same actuators by their names: a pilot's and an autopilot's, commanded and measured."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from seatrial.inspection.proposal.columns.names import read_name
from seatrial.util.frames import Array

PILOT = frozenset(("manual", "rc", "pilot", "stick", "joy", "joystick", "teleop", "operator"))
AUTOPILOT = frozenset(("auto", "autopilot", "autonomous", "ap", "nav", "controller", "mpc", "pid"))
COMMANDED = frozenset(
    ("cmd", "command", "commanded", "desired", "des", "setpoint", "sp", "target", "ref", "demand")
)
MEASURED = frozenset(("measured", "meas", "actual", "act", "feedback", "fb"))
# what a motor is commanded by, and what its controller measures
DRIVEN = frozenset(("thrust", "throttle", "pwm", "pct", "percent", "duty", "esc"))
SENSED = frozenset(
    ("rpm", "rps", "speed", "current", "amps", "volt", "voltage", "temp", "temperature")
)
SIDES = frozenset(  # of one of several thrusters
    ("left", "right", "port", "starboard", "stbd", "bow", "stern", "l", "r", "fl", "fr", "bl", "br")
)
ROUNDED = 0.02  # of a command's standard deviation, that rounding leaves of a sum of others


def measured_twins(names: Iterable[str]) -> set[str]:
    """Columns that measure what another one commands.

    rpm_left beside rpm_cmd_left, left_actual beside left, rpm_left beside pwm_left.
    """
    words = {name: {*read_name(name).words} for name in names}
    twins: set[str] = set()
    for same in _alike(words, COMMANDED | MEASURED):
        commanded = [n for n in same if COMMANDED & words[n]]
        kept = commanded or [n for n in same if not MEASURED & words[n]]
        twins |= {*same} - {*kept} if kept else set()
    for same in _alike(words, COMMANDED | MEASURED | DRIVEN | SENSED):
        sensed = [n for n in same if SENSED & words[n] and not COMMANDED & words[n]]
        if any(DRIVEN & words[n] and n not in sensed for n in same):
            twins |= {*sensed}
    return twins


def _alike(words: Mapping[str, set[str]], but: frozenset[str]) -> Iterable[list[str]]:
    """Names that have the same words, these left out."""
    found: dict[frozenset[str], list[str]] = {}
    for name, own in words.items():
        found.setdefault(frozenset(own - but), []).append(name)
    return found.values()


def by_source(names: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """The pilot's and the autopilot's channels of the same actuators; empty: the names are not so.

    cmd_manual_left and cmd_auto_left differ by the word for the source alone. Channels without one are of both.
    """
    found: list[dict[tuple[str, ...], str]] = [{}, {}]
    common = []
    for name in names:
        words = read_name(name).words
        of = [
            own for own, source in zip(found, (PILOT, AUTOPILOT), strict=True) if source & {*words}
        ]
        if of:
            of[0][tuple(w for w in words if w not in PILOT | AUTOPILOT)] = name
        else:
            common.append(name)
    pilot, autopilot = found
    if not pilot or pilot.keys() != autopilot.keys():
        return ()
    sets = ({*own.values(), *common} for own in found)
    return tuple(tuple(name for name in names if name in own) for own in sets)


def sums_of_sides(names: Sequence[str], values: Array) -> list[str]:
    """Columns (n, names) that are sums of those for single thrusters: M_cmd beside left_cmd and right_cmd."""
    single = [bool(SIDES & {*read_name(name).words}) for name in names]
    known = values[np.isfinite(values).all(axis=1)]
    if sum(single) < 2 or len(known) <= len(names):
        return []
    known = known - known.mean(axis=0)
    sides = known[:, single]
    left = known - sides @ np.linalg.lstsq(sides, known, rcond=None)[0]
    summed = left.std(axis=0) < ROUNDED * known.std(axis=0)
    return [n for n, one, other in zip(names, single, summed, strict=True) if other and not one]
