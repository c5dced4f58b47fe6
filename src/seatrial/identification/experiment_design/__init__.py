# SPDX-License-Identifier: MIT
"""What to drive next: which manoeuvre tells most of what is not known yet, in numbers."""

from seatrial.identification.experiment_design.gain import Gain, gains
from seatrial.identification.experiment_design.information import Alone, Around, alone, around
from seatrial.identification.experiment_design.sentences import next_drive

__all__ = ["Alone", "Around", "Gain", "alone", "around", "gains", "next_drive"]
