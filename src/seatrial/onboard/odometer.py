# SPDX-License-Identifier: MIT
"""Odometry of a node: the predictor's motion in the frames of REP-105.

In `odom` the pose integrates the filtered velocity: continuous, with drift. In `map` it follows the poses.
Computed in the core (`core/include/seatrial/onboard/odometer.hpp`), for Python and the ROS nodes alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import index
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.model_file import model_of
from seatrial.onboard.predictor import (
    HEADING,
    POSITION,
    Estimate,
    Running,
    Taken,
    heading_part,
    onboard_model,
    pose_covariance,
    position_part,
    row_of,
)
from seatrial.util.errors import PredictorError
from seatrial.util.frames import POSE, Array, freeze
from seatrial.util.rows import finite_row

FARTHEST_STAMP = 2**63 - 1  # [ns] of the core


@dataclass(frozen=True, eq=False)
class Odometry:
    """Motion at one stamp, forward-left-up.

    stamp: [ns]
    known: a pose was used; before that the other fields are undefined
    pose: (3,) x, y [m], psi [rad] in odom
    covariance: (3, 3) of pose in odom, since the start
    map_to_odom: (3,) pose of odom in map
    motion: pose in map, body velocity, their covariance, health
    """

    stamp: int
    known: bool
    pose: Array
    covariance: Array
    map_to_odom: Array
    motion: Estimate

    def __post_init__(self) -> None:
        freeze(self, "pose", "covariance", "map_to_odom")


class Odometer(Running):
    """A predictor with stamps in nanoseconds, the vehicle's lever arm, and continuous odometry.

    Arguments as of `Predictor`; poses are of the measured point, at `lever` (2,) forward, left [m] of the
    origin, by default the vehicle file's.
    Never raises on data. Raises ModelError and PredictorError as `Predictor` does. Threads and copies as there.
    """

    def __init__(
        self,
        model: Model | str | Path,
        *,
        disturbance: Literal["earth", "body"] = "earth",
        current: Sequence[float] = (0.0, 0.0),
        window: float = 0.5,
        lever: Sequence[float] | None = None,
    ) -> None:
        self.model = model_of(model)
        self._settings = disturbance, current, window
        parts = ("forward [m]", "left [m]")
        self._lever = None if lever is None else finite_row(lever, "lever", parts, PredictorError)
        self._core: _core.Odometer = _core.Odometer(
            self._onboard(self.model), self._arm(self.model)
        )

    def command(self, stamp: int, values: ArrayLike) -> Taken:
        """Commands (inputs,) to all inputs of the vehicle; they hold until the next."""
        return Taken(
            self._core.command(_within(stamp), row_of(values, "command", self.model.vehicle.inputs))
        )

    def scale(self, stamp: int, values: ArrayLike) -> Taken:
        """Known scale signals (scales,) of the vehicle."""
        return Taken(
            self._core.scale(_within(stamp), row_of(values, "scale", self.model.vehicle.scales))
        )

    def pose(self, stamp: int, eta: ArrayLike, covariance: ArrayLike | None = None) -> Taken:
        """A pose (3,) of the measured point, and its covariance (3, 3), if known."""
        return Taken(
            self._core.pose(_within(stamp), row_of(eta, "pose", POSE), pose_covariance(covariance))
        )

    def position(self, stamp: int, xy: ArrayLike, covariance: ArrayLike | None = None) -> Taken:
        """A position (2,) of the measured point without a heading, and its covariance (2, 2), if known."""
        part = position_part(xy, covariance, self.model)
        return Taken(self._core.pose(_within(stamp), *part, POSITION))

    def heading(self, stamp: int, psi: float, deviation: float | None = None) -> Taken:
        """A heading [rad] without a position, and its standard deviation [rad], if known."""
        part = heading_part(psi, deviation, self.model)
        return Taken(self._core.pose(_within(stamp), *part, HEADING))

    def look(self, stamp: int) -> Estimate:
        """Motion at any stamp within the window, now, or up to 60 s ahead; changes no state."""
        return Estimate.of(self._core.look(_within(stamp)))

    def at(self, stamp: int) -> Odometry:
        """Odometry at a stamp; stamps rise from call to call."""
        _, known, pose, covariance, place, motion = self._core.at(_within(stamp))
        return Odometry(stamp, known, pose, covariance, place, Estimate.of(motion))

    def reload(self, model: Model | str | Path) -> None:
        """Replace the model by another of the same inputs. Raises ModelError without any change."""
        new = model_of(model)
        self.model.same_signals(new)
        self._core.reload(self._onboard(new), self._arm(new))
        self.model = new

    def count(self, source: Literal["command", "scale", "pose"], taken: Taken) -> int:
        """Number of inputs of a source with an outcome."""
        return self._core.count(("command", "scale", "pose").index(source), int(taken))

    @property
    def newest(self) -> int:
        """Stamp of the newest input that was used; 0 before the first."""
        return self._core.newest

    def _arm(self, model: Model) -> Array:
        return np.array(model.vehicle.lever) if self._lever is None else self._lever

    def _onboard(self, model: Model) -> _core.OnboardModel:
        disturbance, current, window = self._settings
        return onboard_model(model, disturbance=disturbance, current=current, window=window)


def _within(stamp: int) -> int:
    """The stamp, or the nearest of 64 bits, which the core refuses as well. Raises PredictorError."""
    try:
        return min(max(index(stamp), -FARTHEST_STAMP), FARTHEST_STAMP)
    except TypeError:
        raise PredictorError(
            f"stamp {stamp!r}: expected whole nanoseconds; a Predictor has seconds"
        ) from None
