# SPDX-License-Identifier: MIT
"""Gains of the channels: which of them drive an axis, and the lever arm that they show."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from seatrial.inspection.consistency.channel_assignment import (
    RUNNER_UP_SHARE,
    Assignment,
    assignments,
)
from seatrial.inspection.consistency.steering_angle import SteeringAngle
from seatrial.inspection.proposal.sources import Entries
from seatrial.util.frames import Array, Mask

LEAST_EFFECT = 1e-12  # [m/s^2], [rad/s^2] in place of no effect at all
DRIVES_T = 6.0  # least t of a gain for a channel that drives an axis
LEAST_EFFECT_SHARE = 0.3  # of the strongest channel's effect on an axis; below is cross-coupling
# of the lever's effect of yaw on an axis, that the axis' own channel has at least
OWN_STICK_SHARE = 0.1
LEAST_ALIKE = 0.9  # cosine of the gains of two channels that act alike
ALONE, OFTEN = 1e-3, 0.05  # shares of the rows: most that both are driven, least that each is
AT_REST = 0.02  # of full command
LEAST_LEVER = 0.02  # [m] of a lever arm that is proposed
LONGEST_LEVER = 1.5  # [m] that gains may show, of the measured point of a small boat


@dataclass(frozen=True)
class Channels:
    """Gain from each channel to each axis, in the axes of the file."""

    names: tuple[str, ...]
    columns: Entries  # with offset and scale
    t: Array  # (3, n)
    gains: Array  # (3, n) [m/s^2], [rad/s^2] per full command
    spread: Array  # (n,) standard deviation of the command
    driven: Mask  # (rows, n) where the command is not at rest
    angles: Mapping[str, SteeringAngle] = field(default_factory=dict)  # those like angles

    def twin(self, name: str) -> str:
        """Another channel that acts alike and is never driven together with this one: a second source."""
        i = self.names.index(name)
        share = self.driven.mean(axis=0)
        for j, other in enumerate(self.names):
            size = np.linalg.norm(self.gains[:, i]) * np.linalg.norm(self.gains[:, j])
            alike = size > 0 and self.gains[:, i] @ self.gains[:, j] > LEAST_ALIKE * size
            together = (self.driven[:, i] & self.driven[:, j]).mean()
            if i != j and alike and together < ALONE and min(share[i], share[j]) > OFTEN:
                return other
        return ""

    @cached_property
    def assigned(self) -> tuple[Assignment, ...]:
        """For each axis the channel with the largest t, each channel once."""
        t = self.t.copy()
        if self.lever is not None:
            t[:2, self.turning] = 0.0
        return tuple(a for a in assignments(self.names, t) if abs(a.t) > DRIVES_T)

    @property
    def turning(self) -> int:
        """The channel with the largest effect on yaw."""
        return int(np.argmax(self.effects[2]))

    @property
    def effects(self) -> Array:
        """Acceleration (3, n) of each axis by each channel as driven; 0 where it drives none."""
        t = np.abs(self.t)
        most = t.max(axis=1, keepdims=True)
        # in a short or calm drive the second of two thrusters may be a little below the limit
        least = np.where(most > DRIVES_T, np.minimum(DRIVES_T, RUNNER_UP_SHARE * most), DRIVES_T)
        return np.where(t > least, np.abs(self.gains) * self.spread, 0.0)

    @property
    def clear(self) -> Mask:
        """Channels (3, n) that drive an axis, cross-coupling left out.

        With a lever arm, yaw accelerates the measured point in surge and sway: that is no actuation.
        """
        effects = self.effects
        if self.lever is not None:
            effects[:2, self.turning] = 0.0
        least = LEAST_EFFECT_SHARE * effects.max(axis=1, keepdims=True)
        return np.asarray((effects > 0) & (effects >= least))

    @cached_property
    def lever(self) -> tuple[float, float] | None:
        """Lever arm [m] of the measured point, where the only yaw channel also moves surge or sway.

        Other channels must drive these axes, too: a single bow thruster has the same effect.
        """
        effects, k = self.effects, self.turning
        least = max(LEAST_EFFECT_SHARE * effects[2].max(), LEAST_EFFECT)
        if np.count_nonzero(effects[2] >= least) != 1:
            return None
        aside = effects[:2, k] > 0.0
        most = np.delete(effects[:2], k, axis=1).max(axis=1, initial=0.0)
        others = most >= OWN_STICK_SHARE * effects[:2, k]
        if not aside.any() or not others[aside].all():
            return None
        along, across = np.where(aside, self.gains[:2, k], 0.0) / self.gains[2, k]
        ahead, second = round(float(across), 2) + 0.0, round(float(-along), 2) + 0.0
        return (ahead, second) if LEAST_LEVER < np.hypot(ahead, second) < LONGEST_LEVER else None

    @property
    def shared(self) -> bool:
        """Whether several channels drive an axis together: thrusters rather than sticks."""
        together = bool((self.clear.sum(axis=1) > 1).any())
        return together and not all(a.trusted for a in self.assigned)
