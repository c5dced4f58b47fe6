# SPDX-License-Identifier: MIT
"""Another robot moves as the boat would (El-MallARD, reference 3 of the paper)."""

from seatrial.simulation.mimic.follow import Carrier, Mimic, MimicHealth, Motion

__all__ = ["Carrier", "Mimic", "MimicHealth", "Motion"]
