# SPDX-License-Identifier: MIT
"""Control by the identified model: gains of a tracking controller, their margins, reference courses."""

from seatrial.control.gains_file import (
    GainsFile,
    gains_of,
    load_gains,
    ros_parameters,
    save_gains,
    save_ros,
)
from seatrial.control.text import tuning_text
from seatrial.control.tuning import KNOB, RATE, Tuning, tune

__all__ = [
    "KNOB",
    "RATE",
    "GainsFile",
    "Tuning",
    "gains_of",
    "load_gains",
    "ros_parameters",
    "save_gains",
    "save_ros",
    "tune",
    "tuning_text",
]
