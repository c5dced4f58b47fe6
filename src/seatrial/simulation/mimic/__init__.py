# SPDX-License-Identifier: MIT
"""A carrier robot that moves like the boat (El-MallARD, reference 3 of the paper)."""

from seatrial.simulation.mimic.follow import Carrier, Mimic, MimicHealth, Motion

__all__ = ["Carrier", "Mimic", "MimicHealth", "Motion"]
