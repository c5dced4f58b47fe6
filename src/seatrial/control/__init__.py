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
from seatrial.control.tracking.controller import Tracked, TrackingController
from seatrial.control.tracking.courses import Course, at_speed, fitted
from seatrial.control.tracking.reference import Reference
from seatrial.control.tracking.shapes import ByLength, Circle, Eight, Shape, Square
from seatrial.control.tracking.thrusters import ALLOCATIONS, VEHICLE, ThrusterAllocation
from seatrial.control.tracking.tracks import Track, lawn_mower, rounded_square
from seatrial.control.tracking.waiting import WaitingReference
from seatrial.control.tuning.console import tuning_text
from seatrial.control.tuning.design import CONTROLLER_RATE, KNOB, Tuning, tune

__all__ = [
    "ALLOCATIONS", "CONTROLLER_RATE", "KNOB", "VEHICLE", "ByLength", "Circle", "Course", "Eight",
    "GainsFile", "Reference", "Shape", "Square", "ThrusterAllocation", "Track", "Tracked",
    "TrackingController", "Tuning", "WaitingReference", "at_speed", "fitted", "gains_of", "lawn_mower",
    "load_gains", "ros_parameters", "rounded_square", "save_gains", "save_ros", "tune", "tuning_text",
]  # fmt: skip
