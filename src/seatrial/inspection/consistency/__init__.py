# SPDX-License-Identifier: MIT
"""Are units, signs and order right? Asked of the data: which command moves which axis, and where to.

Every reading of the file's columns - another unit of heading or length, coordinates negated or
exchanged, inputs negated or permuted - is a hypothesis. Readings of the poses are compared by what
they leave unexplained of the acceleration; readings of the inputs by the gains that they must have:
a force may not push its own axis backwards. The fewest edits that explain the data are reported.

What no data can tell: recordings that are mirrored as a whole, poses and commands alike; which of
the two is mirrored where one is; inputs that only ever enter as a sum, exchanged; and whatever was
hardly excited, which the report says.
"""

from seatrial.inspection.consistency.between_recordings import check_apart
from seatrial.inspection.consistency.check import Gain, SignReport, check_signs
from seatrial.inspection.consistency.findings import Finding, Wrong
from seatrial.inspection.consistency.propose import Assignment, assignments
from seatrial.inspection.consistency.repair import Repair, mended

__all__ = [
    "Assignment",
    "Finding",
    "Gain",
    "Repair",
    "SignReport",
    "Wrong",
    "assignments",
    "check_apart",
    "check_signs",
    "mended",
]
