# SPDX-License-Identifier: MIT
"""Advice during a drive: what is known well enough, and what to drive next."""

from collections.abc import Sequence

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.poolside.advisor import Advisor
from seatrial.poolside.area import Area
from seatrial.poolside.coverage import Coverage
from seatrial.poolside.enough import Enough
from seatrial.poolside.needs import parameter_states
from seatrial.poolside.session.parts import Advice, Seen
from seatrial.poolside.state import ManoeuvreState
from seatrial.workflow.fitness import Use


class DriveGuide:
    """A `Guide`. area: None without walls; uses: those that the drive must be enough for."""

    def __init__(
        self, vehicle: Vehicle, coverage: Coverage, area: Area | None, uses: Sequence[Use]
    ) -> None:
        self._coverage, self._advisor = coverage, Advisor(vehicle, area)
        self._enough = Enough(uses)
        self._flip = vehicle.axes.signs
        self._model: Model | None = None
        self._last = ""  # text of the last manoeuvre

    def advise(self, model: Model | None, seen: Seen) -> Advice:
        """As of `Guide`."""
        enough = self._enough
        if model is None or model is not self._model:
            enough.update(seen.time, model, seen.predictions, whole=seen.whole)
            self._model = model
        known = () if model is None else parameter_states(model, enough.needs)
        found = () if seen.pose is None else self._manoeuvres(model, seen)
        self._last = found[0].text if found else ""
        return Advice(known, enough.states, enough.enough, next(iter(found), None), found[1:])

    def _manoeuvres(self, model: Model | None, seen: Seen) -> tuple[ManoeuvreState, ...]:
        state = np.concatenate([seen.pose or (), np.nan_to_num(seen.nu) * self._flip])
        self._advisor.period = seen.period or self._advisor.period
        needs, driven = self._enough.needs, self._coverage.driven
        keep = self._last if seen.resting else ""
        return self._advisor.advise(model, state, needs, driven=driven, trust=seen.trust, keep=keep)
