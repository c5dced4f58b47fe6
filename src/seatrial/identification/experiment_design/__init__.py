# SPDX-License-Identifier: MIT
"""Experiment design: the next manoeuvre, by the information that it adds about uncertain parameters."""

from seatrial.identification.experiment_design.gain import (
    ManoeuvreGain,
    manoeuvre_gains,
    next_drive,
)
from seatrial.identification.experiment_design.information import (
    RecordingInformation,
    ReferencePoint,
    information_by_recording,
    reference_point,
)

__all__ = [
    "ManoeuvreGain",
    "RecordingInformation",
    "ReferencePoint",
    "information_by_recording",
    "manoeuvre_gains",
    "next_drive",
    "reference_point",
]
