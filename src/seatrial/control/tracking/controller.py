# SPDX-License-Identifier: MIT
"""The tracking controller: a reference and the boat's motion in, commands out.

The core (`core/include/seatrial/control/tracking.hpp`) computes it, here and on board.
"""

from __future__ import annotations

import enum
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.model_file import model_of
from seatrial.control.allocation.steered import steering_of
from seatrial.control.gains_file import GainsFile, gains_of, guidance_numbers, load_gains
from seatrial.control.tracking.reference import Reference
from seatrial.control.tuning.design import Tuning
from seatrial.control.tuning.linear import linearise
from seatrial.onboard.predictor import row_of
from seatrial.util.arguments import expect
from seatrial.util.errors import ControlError
from seatrial.util.frames import POSE, SYMBOLS, Array

SAME_AUTHORITY = 1e-6  # relative difference of two authorities that counts as equal


class Tracked(enum.IntEnum):
    """Outcome of a call, in the order of the core's codes."""

    FOLLOWING = 0
    LIMITED = 1  # the command is beyond the thrusters' limits
    NOT_A_NUMBER = 2  # an input is not a number: the command is zero


class TrackingController:
    """Feed-forward by the inverse model, PID on the error, in body axes.

    Of a boat without sway thrust the reference's position is followed, bow first, by line-of-sight guidance;
    about a reference at rest it keeps station within `gains.guidance.radius`.

    gains: a Tuning, a GainsFile or the path of one. model: the model of the gains, or its path; a Tuning
    has it. feed_forward: False for PID only.

    Never raises on data. Raises ControlError where the gains are of another model.
    """

    def __init__(
        self,
        gains: Tuning | GainsFile | str | Path,
        model: Model | str | Path | None = None,
        *,
        feed_forward: bool = True,
    ) -> None:
        if isinstance(gains, Tuning):
            self.gains, chosen = gains_of(gains), gains.model if model is None else model
        elif model is None:
            raise ControlError("gains from a file: give the model, too, that they were tuned for")
        else:
            chosen = model
            self.gains = gains if isinstance(gains, GainsFile) else load_gains(gains)
        self.model = model_of(chosen)
        self._check()
        g = self.gains
        self._core = _core.Tracker(
            self.model.boat, self.model.vehicle.chain,
            np.array([g.proportional, g.integral, g.derivative, g.authority]),
            np.array(g.mix), g.limit, feed_forward,
            None if g.allocation is None else g.allocation.core(self.model),
            np.array(guidance_numbers(g)), steering_of(self.model, g.limit),
        )  # fmt: skip
        self._last: float | None = None
        self.outcome = Tracked.FOLLOWING

    def command(
        self,
        t: float,
        eta: ArrayLike,
        nu: ArrayLike,
        reference: Reference,
        ahead: Reference | None = None,
    ) -> Array:
        """Commands (inputs,) at t [s] to all inputs of the vehicle, forward-left-up.

        eta: pose (3,); nu: body velocity over ground (3,). ahead: the reference `gains.lead` [s] later, where
        it is known: it compensates the thrusters' delay. `outcome` holds the result.
        """
        dt = 0.0 if self._last is None else t - self._last
        later = reference if ahead is None else ahead
        expect(reference, Reference, "reference")
        expect(later, Reference, "ahead")
        values, code = self._core.command(
            len(self.gains.inputs), dt, row_of(eta, "eta", POSE), row_of(nu, "nu", SYMBOLS),
            reference.rows, later.rows,
        )  # fmt: skip
        self.outcome = Tracked(code)
        if self.outcome is not Tracked.NOT_A_NUMBER:
            self._last = t
        return values

    def forget(self) -> None:
        """Reset the integral."""
        self._core.forget()
        self._last = None

    @property
    def integral(self) -> Array:
        """Integral (3,) of the pose error, earth-fixed [m s, m s, rad s]."""
        return self._core.integral

    @property
    def drift(self) -> Array:
        """Drift velocity (2,) [m/s] that the guidance compensates, earth-fixed."""
        return np.asarray(self._core.drift[:2])

    def _check(self) -> None:
        inputs = list(self.model.vehicle.inputs)
        if self.gains.inputs != inputs:
            raise ControlError(
                f"the gains are for the inputs {', '.join(self.gains.inputs)}; {self.model.name} has "
                f"{', '.join(inputs)}: tune it"
            )
        own = linearise(self.model).authority
        if not np.allclose(self.gains.authority, own, rtol=SAME_AUTHORITY):
            raise ControlError(
                f"the gains are for full commands of {_listed(self.gains.authority)} m/s^2, m/s^2, rad/s^2; "
                f"{self.model.name} has {_listed(own)}: tune it"
            )


def _listed(values: ArrayLike) -> str:
    return ", ".join(f"{x:.4g}" for x in np.asarray(values))
