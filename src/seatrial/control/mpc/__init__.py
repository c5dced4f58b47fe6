# SPDX-License-Identifier: MIT
"""Nonlinear model predictive control on the identified model."""

from seatrial.mpc.controller import Nmpc
from seatrial.mpc.problem import Grid, Weights
from seatrial.mpc.thrusters import by_thrusters

__all__ = ["Grid", "Nmpc", "Weights", "by_thrusters"]
