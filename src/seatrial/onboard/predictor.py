# SPDX-License-Identifier: MIT
"""The on-board predictor: commands and poses in, out of sequence, wrong or missing; motion out at any time.

An extended Kalman filter in the core (`core/include/seatrial/onboard/predictor.hpp`), here as a class.
"""

from __future__ import annotations

import enum
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NoReturn, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from seatrial import _core
from seatrial.boat.model import Model
from seatrial.boat.model_file import model_of
from seatrial.evaluation.filtering import START_VELOCITY_DEVIATION
from seatrial.onboard.parameter_uncertainty import onboard_uncertainty
from seatrial.util import rows
from seatrial.util.errors import ModelError, PredictorError
from seatrial.util.frames import POSE, SYMBOLS, Array, freeze

R = TypeVar("R", bound="Running")
Answer = tuple[float, Array, Array, Array, Array, float, int]
UNBOUNDED = (-1e300, 1e300)  # range of a quantity without an envelope
LONGEST_WINDOW = 5.0  # [s] of out-of-sequence inputs: bounds memory
DEFAULT_SPEED = 1.0  # [m/s], [rad/s] largest speed of a model without an envelope
FIRST_SHARE = 0.5  # of the largest speed: standard deviation of the velocity at the first pose


class Health(enum.Flag):
    """Health of an estimate; `advice` says what to do."""

    NO_POSE = 1
    DEAD_RECKONING = 2
    GATE_REJECTING = 4
    REINITIALISED = 8
    COMMAND_SILENCE = 16
    OUTSIDE_SPEEDS = 32
    OUTSIDE_COMMANDS = 64
    BAD_INPUT = 128
    DIVERGED = 256
    BEYOND_REACH = 512
    MODEL_DOUBTED = 1024

    @property
    def advice(self) -> tuple[str, ...]:
        """One sentence for each flag that is raised."""
        return tuple(words for bit, _, words in _core.health_words() if Health(bit) in self)

    @property
    def names(self) -> tuple[str, ...]:
        """The flags that are raised."""
        return tuple(name for bit, name, _ in _core.health_words() if Health(bit) in self)


class Taken(enum.IntEnum):
    """Outcome of an input, in the order of the core's codes."""

    USED = 0  # now or at its stamp; a pose, if it passes the gate
    NOT_A_NUMBER = 1  # NaN, infinite, out of range, or an invalid covariance
    STALE = 2  # older than `window`
    AHEAD = 3  # its stamp jumps ahead; used when the next one does, too
    TWICE = 4  # a repeated pose
    NO_ROOM = 5  # the buffer of the window is full


@dataclass(frozen=True, eq=False)
class Estimate:
    """Motion at one time, forward-left-up.

    time: [s]
    pose: (3,) x, y [m], psi [rad] in (-pi, pi], earth-fixed
    velocity: (3,) u, v [m/s], r [rad/s] body-fixed, over ground
    covariance: (6, 6) of pose and velocity
    disturbance: (3,) [m/s^2, m/s^2, rad/s^2] estimated disturbance, in its frame
    last_pose: [s] stamp of the last pose that was used; -inf: none
    health: whether it may be used, and why not
    """

    time: float
    pose: Array
    velocity: Array
    covariance: Array
    disturbance: Array
    last_pose: float
    health: Health

    def __post_init__(self) -> None:
        freeze(self, "pose", "velocity", "covariance", "disturbance")

    @classmethod
    def of(cls, answer: Answer) -> Estimate:
        """From the core's answer."""
        time, pose, velocity, covariance, disturbance, last, flags = answer
        seen = last if last > UNBOUNDED[0] else -np.inf
        return cls(time, pose, velocity, covariance, disturbance, seen, Health(flags))


def onboard_model(
    model: Model,
    *,
    disturbance: Literal["earth", "body"] = "earth",
    current: Sequence[float] = (0.0, 0.0),
    window: float = 0.5,
) -> _core.OnboardModel:
    """The core's boat for the predictor; arguments as of `Predictor`."""
    # 1. Arguments.
    if disturbance not in ("earth", "body"):
        raise PredictorError(f"disturbance '{disturbance}': expected 'earth' or 'body'")
    water = rows.finite_row(current, "current", ("x [m/s]", "y [m/s]"), PredictorError)
    if not 0.0 < window <= LONGEST_WINDOW:
        raise PredictorError(f"window {window} s: expected up to {LONGEST_WINDOW:g} s")
    # 2. Envelope of speeds and forces, for the health flags.
    vehicle, ranges = model.vehicle, model.envelope
    speeds = np.array([ranges.speeds.get(name, UNBOUNDED) for name in SYMBOLS])
    forces = np.array([ranges.forces.get(f.name, UNBOUNDED) for f in vehicle.forces])
    # 3. Noise and principal parameter errors.
    uncertainty = onboard_uncertainty(model)
    try:
        return _core.OnboardModel(
            model.boat, vehicle.chain, model.constants, uncertainty.noise, uncertainty.errors,
            disturbance == "earth", water, vehicle.file.command_timeout,
            speeds, forces, _start_deviation(model), window, np.array(vehicle.delays),
        )  # fmt: skip
    except ValueError as error:
        raise ModelError(f"{model.name}: can't be run on board: {error}") from None


POSITION, HEADING = _core.POSITION_PART, _core.HEADING_PART


class Running:
    """A filter that runs: a copy has its own state; a pickle would be without."""

    model: Model
    _core: Any  # of the core, with copy()

    def __copy__(self: R) -> R:
        other = object.__new__(type(self))
        vars(other).update(vars(self), _core=self._core.copy())
        return other

    def __deepcopy__(self: R, _: dict[int, object]) -> R:
        return self.__copy__()  # the rest does not change

    def __reduce__(self) -> NoReturn:
        kind = type(self).__name__
        raise PredictorError(
            f"a running {kind} can't be pickled; pickle its model, and make a new {kind} from that"
        )


class Predictor(Running):
    """An extended Kalman filter on pose, velocity, thrusters and a slowly varying disturbance.

    model: a Model or the path of its file. Poses are of the boat's origin and commands as a
    `Recording` has them: forward-left-up, SI units. Times are seconds of one clock. Position and heading
    are older than a pose's stamp by the vehicle's delays: each is used at its own time. Out-of-sequence inputs up
    to `window` [s] late are used at their stamp: the
    result is, to the last bit, that of inputs in sequence. `disturbance`: the frame that it is constant
    in. `current`: (2,) earth-fixed [m/s], of the water, if known.

    Never raises on data (see `Taken` and `Health`): a stamp beyond 4e9 s, as nanoseconds are, is NOT_A_NUMBER.
    Raises ModelError where the model can't be used, PredictorError where an input has the wrong shape.

    Threads may share a predictor: a call holds the interpreter's lock (GIL), as most calls last some microseconds,
    a late pose some milliseconds. A copy goes on by itself from the same state; there is no pickle of one.
    """

    def __init__(
        self,
        model: Model | str | Path,
        *,
        disturbance: Literal["earth", "body"] = "earth",
        current: Sequence[float] = (0.0, 0.0),
        window: float = 0.5,
    ) -> None:
        self.model = model_of(model)
        self._core: _core.Predictor = _core.Predictor(
            onboard_model(self.model, disturbance=disturbance, current=current, window=window)
        )

    def command(self, t: float, values: ArrayLike) -> Taken:
        """Commands (inputs,) to all inputs of the vehicle at t [s]; they hold until the next."""
        names = self.model.vehicle.inputs
        return Taken(self._core.command(t, row_of(values, "command", names)))

    def scale(self, t: float, values: ArrayLike) -> Taken:
        """Known scale signals (scales,) of the vehicle at t [s], for instance propeller speed."""
        return Taken(self._core.scale(t, row_of(values, "scale", self.model.vehicle.scales)))

    def pose(self, t: float, eta: ArrayLike, covariance: ArrayLike | None = None) -> Taken:
        """A pose (3,) x, y [m], psi [rad] stamped t [s].

        covariance: (3, 3) [m, m, rad] squared; by default the model's pose noise.
        """
        return Taken(self._core.pose(t, row_of(eta, "pose", POSE), pose_covariance(covariance)))

    def position(self, t: float, xy: ArrayLike, covariance: ArrayLike | None = None) -> Taken:
        """A position (2,) x, y [m] stamped t [s], of a sensor without a heading, such as GNSS.

        covariance: (2, 2) [m] squared; by default the model's pose noise. Motion is known when a heading was
        used, too.
        """
        return Taken(self._core.pose(t, *position_part(xy, covariance, self.model), POSITION))

    def heading(self, t: float, psi: float, deviation: float | None = None) -> Taken:
        """A heading [rad] stamped t [s], of a compass or a second antenna.

        deviation: standard deviation [rad]; by default the model's pose noise.
        """
        return Taken(self._core.pose(t, *heading_part(psi, deviation, self.model), HEADING))

    def at(self, t: float) -> Estimate:
        """Motion at t [s]: within the window, now, or up to 60 s ahead of the newest input."""
        return Estimate.of(self._core.at(t))

    def forget(self) -> None:
        """Reset: no inputs, no state."""
        self._core.forget()


def pose_covariance(covariance: ArrayLike | None) -> Array | None:
    """A pose's covariance (3, 3), or None. Raises PredictorError."""
    if covariance is None:
        return None
    return rows.numbers(covariance, "pose: covariance", (3, 3), PredictorError)


def position_part(
    xy: ArrayLike, covariance: ArrayLike | None, model: Model
) -> tuple[Array, Array | None]:
    """A pose and its covariance for the core, of which the position counts. Raises PredictorError."""
    eta = np.append(row_of(xy, "position", POSE[:2]), 0.0)
    if covariance is None:
        return eta, None
    whole = np.diag([0.0, 0.0, model.noise.heading**2])
    whole[:2, :2] = rows.numbers(covariance, "position: covariance", (2, 2), PredictorError)
    return eta, whole


def heading_part(psi: float, deviation: float | None, model: Model) -> tuple[Array, Array | None]:
    """The same, of which the heading counts."""
    eta = np.array([0.0, 0.0, rows.numbers(psi, "heading", (), PredictorError, "psi [rad]")])
    if deviation is None:
        return eta, None
    own = rows.numbers(deviation, "heading: deviation", (), PredictorError, "one number [rad]")
    position = model.noise.position**2
    return eta, np.diag([position, position, own**2])


def _start_deviation(model: Model) -> Array:
    """Standard deviations (3,) of the velocity at the first pose: the boat may be moving."""
    speeds = model.envelope.speeds
    most = [max(map(abs, speeds[name])) if name in speeds else DEFAULT_SPEED for name in SYMBOLS]
    return np.asarray(np.maximum(FIRST_SHARE * np.array(most), START_VELOCITY_DEVIATION))


def row_of(values: ArrayLike, what: str, names: Sequence[str]) -> Array:
    """One number for each name. Raises PredictorError."""
    return rows.row_of(values, what, names, PredictorError)
