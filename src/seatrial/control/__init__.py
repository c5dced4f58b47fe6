# SPDX-License-Identifier: MIT
"""Control by the identified model: gains of a tracking controller, their margins, reference courses."""

from seatrial.control.controller import Tracked, TrackingController
from seatrial.control.courses import Circle, Course, Eight, Shape, Square, fitted
from seatrial.control.gains_file import (
    GainsFile,
    gains_of,
    load_gains,
    ros_parameters,
    save_gains,
    save_ros,
)
from seatrial.control.reference import Reference
from seatrial.control.text import tuning_text
from seatrial.control.thrusters import ALLOCATIONS, VEHICLE, ThrusterAllocation
from seatrial.control.tuning import KNOB, RATE, Tuning, tune

__all__ = [
    "ALLOCATIONS",
    "KNOB",
    "RATE",
    "VEHICLE",
    "Circle",
    "Course",
    "Eight",
    "GainsFile",
    "Reference",
    "Shape",
    "Square",
    "ThrusterAllocation",
    "Tracked",
    "TrackingController",
    "Tuning",
    "fitted",
    "gains_of",
    "load_gains",
    "ros_parameters",
    "save_gains",
    "save_ros",
    "tune",
    "tuning_text",
]
