# SPDX-License-Identifier: MIT
"""Tracking in closed loop: the tuned controller against PDs tuned by hand, in the simulator."""
