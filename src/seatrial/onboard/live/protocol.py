# SPDX-License-Identifier: MIT
"""The lines: JSON or CSV, in the model file's own axes and SI units; `docs/live.md` lists them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import msgspec
import numpy as np

from seatrial.boat.schema import Strict
from seatrial.boat.vehicle import Vehicle
from seatrial.onboard.boat_change import BoatChange
from seatrial.onboard.odometer import Odometry
from seatrial.onboard.predictor import Estimate
from seatrial.util.errors import LiveError
from seatrial.util.frames import POSE, SYMBOLS, Array

LINE_FORMATS = ("json", "csv")
NANO = 1_000_000_000
LATEST_STAMP = 4e9  # [s] largest stamp that fits nanoseconds in 64 bits
Kind = Literal["pose", "position", "heading", "command", "scale", "at", "reload", "adapt"]
KINDS: tuple[Kind, ...] = get_args(Kind)
ORDERS: tuple[Kind, ...] = ("reload", "adapt")  # kinds without values
PARTS = {"position": POSE[:2], "heading": POSE[2:]}  # of a pose: what a line of CSV has
Values = list[float] | dict[str, float]
Row = tuple[float, float, float]


class Line(Strict, frozen=True):
    """A line of JSON: one of the kinds, and its time."""

    t: float | None = None  # [s]
    stamp: int | None = None  # [ns], instead of t
    pose: Row | None = None
    covariance: tuple[Row, Row, Row] | None = None
    position: tuple[float, float] | None = None  # of a sensor without a heading
    heading: float | None = None  # of one without a position
    command: Values | None = None
    scale: Values | None = None
    at: float | None = None
    reload: Literal[True] | None = None
    adapt: Literal[True] | None = None


def line_error(error: Exception, kind: type[Strict], text: str) -> LiveError:
    """The error of a line, with the fields it may have."""
    fields = ", ".join(kind.__struct_fields__)
    return LiveError(f"{error}; expected JSON with some of {fields}; got {text.strip()[:80]}")


@dataclass(frozen=True)
class Event:
    """Content of a line, forward-left-up."""

    kind: Kind
    stamp: int | None  # [ns]; None: time of arrival
    values: Array
    covariance: Array | None = None


class Reader:
    """Reads lines; raises LiveError where one can't be used."""

    def __init__(self, vehicle: Vehicle, form: str) -> None:
        self.vehicle = vehicle
        self._decode = msgspec.json.Decoder(Line).decode
        self._line: Callable[[str], Event] = self._json if form == "json" else self._csv
        self._flip = vehicle.axes.signs

    def __call__(self, text: str) -> Event:
        """The event of a line."""
        return self._line(text)

    def _json(self, text: str) -> Event:
        try:
            line = self._decode(text)
        except (msgspec.DecodeError, UnicodeError) as error:
            raise line_error(error, Line, text) from None
        given = [kind for kind in KINDS if getattr(line, kind) is not None]
        if len(given) != 1:
            raise LiveError(f"expected one of {', '.join(KINDS)}; got {', '.join(given) or 'none'}")
        kind = given[0]
        if kind == "at":
            return Event(kind, _nano(line.at), np.zeros(0))
        if line.t is not None and line.stamp is not None:
            raise LiveError("give t [s] or stamp [ns], not both")
        stamp = _whole(line.stamp) if line.t is None else _nano(line.t)
        if kind == "pose":
            spread = None if line.covariance is None else np.array(line.covariance)
            return self._pose(stamp, np.array(line.pose), spread)
        if kind in ORDERS:
            return Event(kind, stamp, np.zeros(0))
        if kind in ("position", "heading"):
            return self._part(
                kind, stamp, np.atleast_1d(np.array(getattr(line, kind), dtype=float))
            )
        if kind == "command":
            return self._signal(kind, stamp, line.command)
        return self._signal("scale", stamp, line.scale)

    def _csv(self, text: str) -> Event:
        kind, *cells = (cell.strip() for cell in text.split(","))
        try:
            t, *numbers = [float(cell) if cell else None for cell in cells] or [None]
        except ValueError:
            raise LiveError(f"expected numbers after '{kind}'; got {text.strip()[:80]}") from None
        stamp = None if t is None else _nano(t)
        values = [number for number in numbers if number is not None]
        if kind == "pose":
            if len(numbers) not in (3, 12) or len(values) != len(numbers):
                raise LiveError(
                    f"pose: expected t, x, y, psi and no or nine numbers of a covariance; got "
                    f"{text.strip()[:80]}"
                )
            spread = np.reshape(values[3:], (3, 3)) if len(values) > 3 else None
            return self._pose(stamp, np.array(values[:3]), spread)
        if kind in PARTS:
            if len(values) != len(PARTS[kind]) or len(values) != len(numbers):
                raise LiveError(
                    f"{kind}: expected t, {', '.join(PARTS[kind])}; got {text.strip()[:80]}"
                )
            return self._part(kind, stamp, np.array(values))
        if kind == "command":
            return self._signal("command", stamp, values)
        if kind == "scale":
            return self._signal("scale", stamp, values)
        if kind == "at" and stamp is not None:
            return Event("at", stamp, np.zeros(0))
        for order in ORDERS:
            if kind == order:
                return Event(order, stamp, np.zeros(0))
        raise LiveError(f"a line begins with {', '.join(KINDS)}; got {text.strip()[:80]}")

    def _pose(self, stamp: int | None, eta: Array, spread: Array | None) -> Event:
        flip = self._flip
        return Event(
            "pose", stamp, eta * flip, None if spread is None else spread * np.outer(flip, flip)
        )

    def _part(self, kind: str, stamp: int | None, values: Array) -> Event:
        if kind == "position":
            return Event("position", stamp, values * self._flip[:2])
        return Event("heading", stamp, values * self._flip[2:])

    def _signal(
        self, kind: Literal["command", "scale"], stamp: int | None, got: Values | None
    ) -> Event:
        own = self.vehicle.inputs if kind == "command" else self.vehicle.scales
        row = ordered_values(kind, got or [], own)
        return Event(kind, stamp, row * self.vehicle.input_signs if kind == "command" else row)


def _nano(t: float | None) -> int:
    if t is None or not abs(t) <= LATEST_STAMP:
        raise LiveError(f"t {t}: expected seconds, up to {LATEST_STAMP:.0e}")
    return round(t * NANO)


def _whole(stamp: int | None) -> int | None:
    if stamp is not None and abs(stamp) > LATEST_STAMP * NANO:
        raise LiveError(f"stamp {str(stamp)[:24]}: expected [ns], up to {LATEST_STAMP * NANO:.0e}")
    return stamp


def ordered_values(kind: str, got: Values, names: Sequence[str]) -> Array:
    """Values by order or by name, in the order of the names (names,). Raises LiveError."""
    if isinstance(got, Mapping):
        if set(got) != set(names):
            raise LiveError(
                f"{kind}: expected {', '.join(names) or 'none'}; got {', '.join(got) or 'none'}"
            )
        return np.array([got[name] for name in names])
    if len(got) != len(names):
        raise LiveError(
            f"{kind}: expected {len(names)} numbers: {', '.join(names) or 'none'}; got {len(got)}"
        )
    return np.array(got, dtype=float)


class ChangeLine(msgspec.Struct, frozen=True, omit_defaults=True):
    """A change of the boat: `BoatChange` as JSON."""

    state: str
    cause: str
    what: str
    probability: float
    size: float | None = None  # [-]
    error: float | None = None  # [-]


class Answer(msgspec.Struct, frozen=True, omit_defaults=True):
    """A line of odometry as JSON; `pose` and its covariance only in a stream, `change` while there is one."""

    t: float  # [s]
    pose: list[float] | None  # x, y [m], psi [rad] in odom
    pose_covariance: list[list[float]] | None
    velocity: list[float]  # u, v [m/s], r [rad/s]
    velocity_covariance: list[list[float]]
    map: list[float]  # x, y [m], psi [rad] in map
    map_covariance: list[list[float]]
    last_pose: float | None  # [s] age of the last pose that was used
    health: tuple[str, ...]
    change: ChangeLine | None = None


CSV_HEADER = ",".join(
    ["t", *POSE, *SYMBOLS, *(f"map_{name}" for name in POSE), *(f"sd_{name}" for name in POSE),
     *(f"sd_{name}" for name in SYMBOLS), *(f"sd_map_{name}" for name in POSE), "last_pose", "health"]
)  # fmt: skip


class Writer:
    """Odometry as lines."""

    def __init__(self, vehicle: Vehicle, form: str) -> None:
        self._flip = vehicle.axes.signs
        self._encode = msgspec.json.Encoder().encode
        self._as_json = form == "json"
        self.change: BoatChange | None = None  # of the lines from now on

    @property
    def header(self) -> str | None:
        """The header line of CSV; None for JSON."""
        return None if self._as_json else CSV_HEADER

    def odometry(self, out: Odometry) -> str:
        """A line of the stream."""
        return self._text(out.stamp, out.motion, out.pose, out.covariance)

    def estimate(self, stamp: int, out: Estimate) -> str:
        """The answer to `at`."""
        return self._text(stamp, out, None, None)

    def _text(self, stamp: int, motion: Estimate, pose: Array | None, spread: Array | None) -> str:
        flip, square = self._flip, np.outer(self._flip, self._flip)
        age = motion.time - motion.last_pose
        answer = Answer(
            stamp / NANO,
            None if pose is None else (pose * flip).tolist(),
            None if spread is None else (spread * square).tolist(),
            (motion.velocity * flip).tolist(),
            (motion.covariance[3:, 3:] * square).tolist(),
            (motion.pose * flip).tolist(),
            (motion.covariance[:3, :3] * square).tolist(),
            float(age) if np.isfinite(age) else None,
            motion.health.names,
            None if self.change is None else change_line(self.change),
        )
        return self._encode(answer).decode() if self._as_json else _csv(answer)


def change_line(change: BoatChange) -> ChangeLine:
    """A change as it stands in a line."""
    return ChangeLine(
        change.state.value, change.cause, change.what, change.probability, change.size, change.error
    )


def _csv(answer: Answer) -> str:
    def sd(covariance: list[list[float]] | None) -> list[float | None]:
        if covariance is None:
            return [None] * 3
        return [float(np.sqrt(covariance[i][i])) for i in range(3)]

    cells: list[float | None] = [
        answer.t, *([None] * 3 if answer.pose is None else answer.pose), *answer.velocity, *answer.map,
        *sd(answer.pose_covariance), *sd(answer.velocity_covariance), *sd(answer.map_covariance),
        answer.last_pose,
    ]  # fmt: skip
    return ",".join(["" if c is None else repr(c) for c in cells] + [";".join(answer.health)])
