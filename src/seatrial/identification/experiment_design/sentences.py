# SPDX-License-Identifier: MIT
"""The next drive in sentences."""

from collections.abc import Sequence

import numpy as np

from seatrial.identification.experiment_design.gain import ManoeuvreGain
from seatrial.identification.uncertainty.identifiability import Identifiability, ParameterVerdict
from seatrial.util.format import joined
from seatrial.util.statistics import NORMAL_95

MOST_SENTENCES = 4  # sentences
LONGEST_DRIVE = 1800.0  # [s] more than this nobody drives for one number
SIMILAR_TIME = 2.0  # times a sentence's time that another parameter of the same manoeuvre may take


def next_drive(found: Identifiability, gained: Sequence[ManoeuvreGain]) -> list[str]:
    """What more driving would do for what is known worst, most needed first."""
    helped = {n for c in found.combinations if c.verdict is ParameterVerdict.SHARP for n in c.names}
    loose = {
        ParameterVerdict.USABLE,
        ParameterVerdict.WEAK,
        ParameterVerdict.ZERO,
        ParameterVerdict.LOST,
    }
    wanted = [
        g for g in gained if found[g.parameter].verdict in loose and g.parameter not in helped
    ]
    wanted.sort(key=lambda g: -found[g.parameter].relative)
    said: list[str] = []
    never: list[ManoeuvreGain] = []
    done: set[str] = set()
    for one in wanted:
        if one.seconds > LONGEST_DRIVE:
            never.append(one)
            continue
        if one.parameter in done or len(said) == MOST_SENTENCES:
            continue
        same = [
            g for g in wanted
            if g.manoeuvre == one.manoeuvre and g.seconds <= SIMILAR_TIME * one.seconds and g.parameter not in done
        ]  # fmt: skip
        done |= {g.parameter for g in same}
        longest = max(g.seconds for g in same)
        listed = _listed(same)
        many = "s" if len(same) > 1 else ""
        said.append(
            f"{drive_time(longest)} more of {one.manoeuvre} would halve the 95 % interval{many} of {listed}."
        )
    if never:
        said.append(
            f"No manoeuvre that was tried halves within {LONGEST_DRIVE / 60:.0f} minutes the "
            f"interval{'s' * (len(never) > 1)} of {_listed(never)}: fix a value that you know "
            "otherwise, or take a term out that is not distinguishable from zero."
        )
    return said


def _listed(found: Sequence[ManoeuvreGain]) -> str:
    return joined([f"{g.parameter} ({_interval(g)})" for g in found])


def drive_time(seconds: float) -> str:
    """A time to drive, rounded up to what a person would drive."""
    if not np.isfinite(seconds):
        return "no time"
    if seconds <= 90:
        return f"{max(5, 5 * int(np.ceil(seconds / 5)))} s"
    if seconds <= 3600:
        return f"{np.ceil(seconds / 30) / 2:g} min"
    return f"{seconds / 3600:.1f} h"


def _interval(one: ManoeuvreGain) -> str:
    return f"{one.value:.3g} ± {NORMAL_95 * one.error:.2g}"
