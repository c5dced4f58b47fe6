# SPDX-License-Identifier: MIT
"""Nonlinear model predictive control on the identified model."""

from seatrial.control.mpc.controller import Nmpc
from seatrial.control.mpc.problem import Grid, Weights
from seatrial.control.mpc.thrusters import by_thrusters

__all__ = ["Grid", "Nmpc", "Weights", "by_thrusters"]
