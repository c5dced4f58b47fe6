# SPDX-License-Identifier: MIT
"""What a finding of one kind has: its sentence, the advice, its subject, and its values with their units.

Sentence and advice are filled in with subject and values. `{x:.0%}` shows a share in per cent, `{x:.2deg}` an
angle in degrees. Of a word that is one of several, `{x_means}` is what it stands for.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

QUANTITIES = {  # scale factors that recordings disagree in, or that drift, and their causes
    "thrust": "Possible causes: battery voltage, trim",
    "drag": "Possible causes: the water, a trailing rope or weeds, a missing drag term",
    "thrust and drag": "Possible cause: payload",
}
DEAD_ZONE = {  # of the thrusters: whether the model has one
    "modelled": "",
    "not modelled": "Small commands thrust less where there is a dead zone, and none was estimated. ",
}
ONE_NAME, NAMES = "one name", "names"  # that a part of a subject is


@dataclass(frozen=True)
class Spec:
    """What a finding of one kind has."""

    sentence: str  # what was found, what it means
    advice: str  # what to do
    subject: Mapping[str, str] = field(default_factory=dict)  # its parts; NAMES only as the last
    numbers: Mapping[str, str] = field(default_factory=dict)  # units by name; >= 0 unless `signed`
    # choices; None: any
    words: Mapping[str, Mapping[str, str] | None] = field(default_factory=dict)
    signed: tuple[str, ...] = ()  # numbers that may be negative
    parameter: tuple[str, ...] = ()  # numbers that change sign with the parameter between axes
    each: tuple[str, ...] = ()  # numbers of which there is one for every name of the subject
