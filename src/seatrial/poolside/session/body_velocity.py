# SPDX-License-Identifier: MIT
"""Body velocity of the measured point by the difference of two poses: without a model, for coverage and advice."""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from seatrial.poolside.session.track import MOST_LATE
from seatrial.util.frames import NS_PER_S, Array, body_velocity

BASELINE = 0.4  # [s] between the two poses
MEDIAN_OF = 5  # differences: a jump of one pose is none of the boat's
LONGEST = 2.0  # [s]: a longer one is a gap


class BodyVelocity:
    """Takes poses as they come; a position or a heading completes the pose before it."""

    def __init__(self) -> None:
        self._pose = np.full(3, np.nan)
        self._kept: deque[tuple[int, Array]] = deque()
        self._rates: deque[Array] = deque(maxlen=MEDIAN_OF)

    def use(self, kind: str, stamp: int, values: Sequence[float] | Array) -> bool:
        """An event, forward-left-up; whether it is a new pose."""
        if kind == "heading":
            self._pose[2] = values[0]
        if kind not in ("pose", "position"):
            return False
        self._pose[: len(values)] = values
        if self._kept and not -MOST_LATE <= (stamp - self._kept[-1][0]) / NS_PER_S <= LONGEST:
            self._kept.clear()
        if math.isnan(sum(self._pose.tolist())) or (self._kept and stamp <= self._kept[-1][0]):
            return False
        self._kept.append((stamp, self._pose.copy()))
        while len(self._kept) > 2 and (stamp - self._kept[1][0]) / NS_PER_S >= BASELINE:
            self._kept.popleft()
        self._rates.append(self._rate())
        return True

    @property
    def nu(self) -> Array:
        """u, v [m/s], r [rad/s]; NaN before there is one, and after a gap."""
        if not self._rates:
            return np.full(3, np.nan)
        ordered = np.sort(np.array(self._rates), axis=0)
        return np.asarray(ordered[len(ordered) // 2])

    def _rate(self) -> Array:
        if len(self._kept) < 2:
            return np.full(3, np.nan)
        (begin, first), (end, last) = self._kept[0], self._kept[-1]
        step = (end - begin) / NS_PER_S
        rate = (last - first) / step
        rate[2] = (np.remainder(last[2] - first[2] + np.pi, 2.0 * np.pi) - np.pi) / step
        middle = first[2] + 0.5 * step * rate[2]
        return np.asarray(body_velocity(np.array([middle]), rate[None])[0])
