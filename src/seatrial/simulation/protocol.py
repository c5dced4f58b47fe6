# SPDX-License-Identifier: MIT
"""JSON lines of `seatrial sim`, in the axes of each model file; `docs/sim.md` lists them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import msgspec
import numpy as np

from seatrial.boat.schema import Strict
from seatrial.onboard.live.protocol import Values, line_error, ordered_values
from seatrial.simulation.readings import ImuReading, PoseReading, Reading, Scan
from seatrial.simulation.world import SimulatedBoat
from seatrial.util.errors import LiveError
from seatrial.util.frames import Array

Kind = Literal["pose", "truth", "imu", "scan", "command"]
LINE_KINDS: tuple[Kind, ...] = get_args(Kind)


class SimLine(Strict, frozen=True):
    """An input line: a command, or a time to advance to."""

    t: float | None = None  # [s] simulated
    boat: str | None = None  # optional with one boat
    command: Values | None = None
    at: float | None = None  # [s] to advance to


@dataclass(frozen=True)
class LineRequest:
    """The request of a line, forward-left-up."""

    t: float | None  # [s]; None: now
    boat: SimulatedBoat | None
    command: Array | None


_decode = msgspec.json.Decoder(SimLine).decode
_encode = msgspec.json.Encoder().encode


def read_line(text: str, boats: Sequence[SimulatedBoat]) -> LineRequest:
    """The request of a line. Raises LiveError."""
    try:
        line = _decode(text)
    except (msgspec.DecodeError, UnicodeError) as error:
        raise line_error(error, SimLine, text) from None
    if (line.command is None) == (line.at is None):
        raise LiveError(f"expected command or at, one of them; got {text.strip()[:80]}")
    if line.command is None:
        return LineRequest(line.at, None, None)
    boat = _named(line.boat, boats)
    vehicle = boat.model.vehicle
    row = ordered_values("command", line.command, vehicle.inputs) * vehicle.input_signs
    return LineRequest(line.t, boat, row)


def _named(name: str | None, boats: Sequence[SimulatedBoat]) -> SimulatedBoat:
    found = [b for b in boats if b.name == name] if name is not None else list(boats)
    if len(found) != 1:
        names = ", ".join(b.name for b in boats)
        raise LiveError(f"boat: got {name or 'none'}; expected one of {names}")
    return found[0]


class SimWriter:
    """Readings, truth and commands as lines; of several boats with the boat's name."""

    def __init__(self, boats: Sequence[SimulatedBoat]) -> None:
        self._several = len(boats) > 1
        self._flips = {b.name: _signs(b) for b in boats}

    def reading(self, reading: Reading) -> str:
        """A reading, with its stamp."""
        flip = self._flips[reading.boat]
        if isinstance(reading, PoseReading):
            return self._line(reading.boat, reading.stamp, pose=(reading.eta * flip).tolist())
        if isinstance(reading, ImuReading):
            # yaw rate, forward, second axis
            rotated = (reading.values * np.array([flip[2], 1.0, flip[1]])).tolist()
            return self._line(reading.boat, reading.stamp, imu=rotated)
        assert isinstance(reading, Scan)
        ends = (reading.angles[[0, -1]] * flip[2]).tolist()
        seen = [r if np.isfinite(r) else None for r in np.round(reading.ranges, 5).tolist()]
        return self._line(reading.boat, reading.stamp, scan=seen, angles=ends, sweep=reading.sweep)

    def truth(self, boat: SimulatedBoat) -> str:
        """Pose and velocity now."""
        flip = self._flips[boat.name]
        now = [*(boat.eta * flip).tolist(), *(boat.nu * flip).tolist()]
        return self._line(boat.name, boat.time, truth=now)

    def command(self, boat: SimulatedBoat, values: Array) -> str:
        """A command of this instant."""
        given = (values * boat.model.vehicle.input_signs).tolist()
        return self._line(boat.name, boat.time, command=given)

    def _line(self, boat: str, t: float, **content: object) -> str:
        owner = {"boat": boat} if self._several else {}
        return _encode({"t": round(t, 9), **owner, **content}).decode()


def _signs(boat: SimulatedBoat) -> Array:
    return boat.model.vehicle.axes.signs
