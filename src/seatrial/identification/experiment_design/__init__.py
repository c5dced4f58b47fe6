# SPDX-License-Identifier: MIT
"""What to drive next: which manoeuvre tells most of what is not known yet, in numbers."""

from seatrial.advice.gain import Gain, gains
from seatrial.advice.information import Alone, Around, alone, around
from seatrial.advice.words import next_drive

__all__ = ["Alone", "Around", "Gain", "alone", "around", "gains", "next_drive"]
