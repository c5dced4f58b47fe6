# SPDX-License-Identifier: MIT
"""Sentences for the user on what to drive next."""

from collections.abc import Sequence

import numpy as np

from seatrial.identification.experiment_design.gain import ManoeuvreGain
from seatrial.identification.uncertainty.identifiability import Identifiability, ParameterVerdict
from seatrial.util.format import joined
from seatrial.util.statistics import NORMAL_95

MOST_SENTENCES = 4
LONGEST_DRIVE = 1800.0  # [s] a longer one for one parameter is not proposed
# times a sentence's time: parameters of the same manoeuvre within it share the sentence
SIMILAR_TIME = 2.0
IN_SECONDS, IN_MINUTES = 90, 3600  # [s] up to which a time is given so
SECONDS_ROUNDED, MINUTES_ROUNDED = 5, 30  # [s] to which it is rounded up


def next_drive(found: Identifiability, gained: Sequence[ManoeuvreGain]) -> list[str]:
    """The manoeuvres that halve the errors of the least known parameters, the worst first."""
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
    sentences: list[str] = []
    never: list[ManoeuvreGain] = []
    done: set[str] = set()
    for gain in wanted:
        if gain.seconds > LONGEST_DRIVE:
            never.append(gain)
            continue
        if gain.parameter in done or len(sentences) == MOST_SENTENCES:
            continue
        same = [
            g for g in wanted
            if g.manoeuvre == gain.manoeuvre and g.parameter not in done
            and g.seconds <= SIMILAR_TIME * gain.seconds
        ]  # fmt: skip
        done |= {g.parameter for g in same}
        sentences.append(_halves(gain.manoeuvre, same))
    if never:
        sentences.append(
            f"No manoeuvre that was tried halves within {LONGEST_DRIVE / 60:.0f} minutes the "
            f"interval{'s' * (len(never) > 1)} of {_listed(never)}: fix a value that you know "
            "otherwise, or take a term out that is not distinguishable from zero."
        )
    return sentences


def _halves(manoeuvre: str, gains: Sequence[ManoeuvreGain]) -> str:
    """One manoeuvre for one or more parameters."""
    time = drive_time(max(g.seconds for g in gains))
    many = "s" if len(gains) > 1 else ""
    return f"{time} more of {manoeuvre} would halve the 95 % interval{many} of {_listed(gains)}."


def _listed(found: Sequence[ManoeuvreGain]) -> str:
    return joined([f"{g.parameter} ({_interval(g)})" for g in found])


def drive_time(seconds: float) -> str:
    """A driving time, rounded up."""
    if not np.isfinite(seconds):
        return "no time"
    if seconds <= IN_SECONDS:
        return f"{max(1, int(np.ceil(seconds / SECONDS_ROUNDED))) * SECONDS_ROUNDED} s"
    if seconds <= IN_MINUTES:
        return f"{np.ceil(seconds / MINUTES_ROUNDED) * MINUTES_ROUNDED / 60:g} min"
    return f"{seconds / 3600:.1f} h"


def _interval(gain: ManoeuvreGain) -> str:
    return f"{gain.value:.3g} ± {NORMAL_95 * gain.error:.2g}"
