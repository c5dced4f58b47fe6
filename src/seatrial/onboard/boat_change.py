# SPDX-License-Identifier: MIT
"""A change of the boat against its model, as a detector reports it."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from numpy.typing import ArrayLike

from seatrial.boat.model import Model
from seatrial.evaluation.comparison.cause_candidates import NO_CHANGE, NONE_OF_THESE, ONE_THRUSTER
from seatrial.util.statistics import NORMAL_95

SHOWN_PROBABILITY = 0.01  # of another cause


class ChangeState(enum.Enum):
    """How sure a change is."""

    NOTICED = "noticed"  # false alarms are as rare as stated
    CONFIRMED = "confirmed"  # and a window after the notice shows it, too
    WITHDRAWN = "withdrawn"  # that window does not: something passing moved the boat


@dataclass(frozen=True)
class BoatChange:
    """A change of the boat against its model.

    state: how sure it is
    stamp: [ns] of the newest pose
    cause: the most probable of CAUSES
    what: of what the size is: mass, thrust, or a thruster's name
    probability: of the cause, if the boat changed
    size: [-] relative change; None: the cause has no single one
    error: [-] its standard error
    log_ratio: of the evidences of a change and of none
    causes: cause to probability
    model: the changed boat; None while it is not confirmed
    """

    state: ChangeState
    stamp: int
    cause: str
    what: str = ""
    probability: float = 1.0
    size: float | None = None
    error: float | None = None
    log_ratio: float = 0.0
    causes: Mapping[str, float] = field(default_factory=dict)
    model: Model | None = None

    @property
    def text(self) -> str:
        """What changed, by how much (95 %), and how sure that is."""
        if self.cause == NO_CHANGE:
            return "no change of the boat: something passing moved it"
        said = {ONE_THRUSTER: f"thruster {self.what}", NONE_OF_THESE: "cause unclear"}
        text = f"boat changed ({self.state.value}): {said.get(self.cause, self.cause)}"
        if self.size is not None and self.error is not None:
            of = "" if self.cause in (self.what, ONE_THRUSTER) else f"{self.what} "
            text += f", {of}{100.0 * self.size:+.0f} ± {100.0 * NORMAL_95 * self.error:.0f} %"
        others = [
            f"{cause} {100.0 * p:.0f} %" for cause, p in self.causes.items()
            if cause != self.cause and p >= SHOWN_PROBABILITY
        ]  # fmt: skip
        rest = f", else {', '.join(others)}" if others else ""
        return f"{text}; probability of this cause {100.0 * self.probability:.0f} %{rest}"


class Detector(Protocol):
    """Takes what the odometer takes, and tests it for a change."""

    @property
    def due(self) -> bool:
        """Whether it is time for `look`."""

    def use(self, kind: str, stamp: int, values: ArrayLike) -> None:
        """A pose, position, heading, command or scale at a stamp [ns]."""

    def begin_after(self, stamp: int) -> None:
        """Test by poses after a stamp [ns]: until then the boat was touched, or towed."""

    def look(self) -> BoatChange | None:
        """A new finding, or None."""

    def restart(self, model: Model) -> None:
        """The same with another model."""
