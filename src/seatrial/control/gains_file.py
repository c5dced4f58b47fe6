# SPDX-License-Identifier: MIT
"""Gains as a file for the controller, and as ROS parameters."""

from collections.abc import Sequence
from dataclasses import astuple
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import msgspec
import numpy as np

from seatrial.boat.schema import Positive, Strict
from seatrial.control.tracking.thrusters import (
    VEHICLE,
    Three,
    ThrusterAllocation,
    as_numbers,
    three,
)
from seatrial.control.tuning.dead_zone import dead_zone
from seatrial.control.tuning.design import Tuning
from seatrial.control.tuning.loops import Margins
from seatrial.util.errors import ControlError
from seatrial.util.files import convert, dump_yaml, expect_format, read_yaml, write_text

GAINS_FORMAT: Final = "gains 1"
TRACKING_NODE: Final = "seatrial_tracking"
MIX_ROUNDING = 1e-12  # [-] a smaller share of an axis command is 0


class AxisMargins(Strict, frozen=True):
    """Margins of one axis' loop with the others closed."""

    gain: float | None  # factor by which thrust may exceed the model's; none: any
    phase_deg: float
    delay: float  # [s] additional delay that keeps the loop stable
    sensitivity: float


class GuidanceEntry(Strict, frozen=True):
    """Line-of-sight guidance of a boat without sway thrust; `docs/tune.md`."""

    time: Positive  # [s] look-ahead distance over speed
    radius: Positive  # [m] least look-ahead distance, and the circle of station keeping
    slowest: Positive  # [m/s] a reference below it rests
    fastest: Positive  # [m/s] of approach
    approach: Positive  # [s] position error over the speed that the surge gains make of it


class GainsFile(Strict, frozen=True):
    """The controller's parameters. Axis commands are in command units: at 1 the largest input is full."""

    model: str  # the boat's name
    axes: Literal["forward-left-up"]
    inputs: list[str]  # of the vehicle, in the order of `mix`
    knob: Positive  # [s]
    action: Literal["pid", "pd"]
    rate: Positive  # [Hz]
    proportional: Three  # command units per m, m, rad
    integral: Three  # per m s, m s, rad s; of the earth-fixed error
    derivative: Three  # per m/s, m/s, rad/s
    authority: Three  # [m/s^2, m/s^2, rad/s^2] of an axis command of 1; 0: an axis without thrust
    mix: list[Three]  # by input: share of the axis commands
    lead: Annotated[float, msgspec.Meta(ge=0)]  # [s] by which the feed-forward looks ahead
    limit: Annotated[float, msgspec.Meta(gt=0)] = 1.0  # of each input
    delay: Three = (0.0, 0.0, 0.0)  # [s] of each loop, lag included
    dead_zone: Three = (0.0, 0.0, 0.0)  # axis commands without thrust
    margins: dict[str, AxisMargins] = msgspec.field(default_factory=dict)  # of the model
    worst: dict[str, AxisMargins] = msgspec.field(default_factory=dict)  # of all draws
    allocation: ThrusterAllocation | None = None  # none: the boat's own
    guidance: GuidanceEntry | None = None  # none: the boat has sway thrust
    draws: int = 0
    seed: int = 0
    version: str = ""  # of seatrial
    seatrial: Literal["gains 1"] = GAINS_FORMAT


def gains_of(tuning: Tuning) -> GainsFile:
    """The content of a tuning's gains file."""
    model, boat, table = tuning.model, tuning.boat, tuning.table()
    limit = model.vehicle.file.allocation.limit
    return GainsFile(
        model.name, "forward-left-up", list(model.vehicle.inputs), tuning.knob, tuning.action, tuning.rate,
        three(table[:, 0]), three(table[:, 1]), three(table[:, 2]),
        three(boat.authority), [three(row) for row in np.where(np.abs(boat.mix) < MIX_ROUNDING, 0.0, boat.mix)],
        float(tuning.delay[list(boat.driven)].mean()), 1.0 if limit is None else min(limit, 1.0),
        three(tuning.delay), three(dead_zone(model, boat, tuning.allocator)),
        _margins(tuning.nominal, tuning.loops), _margins(tuning.worst, tuning.loops),
        None if tuning.allocator is None else as_numbers(tuning.allocator),
        None if tuning.guidance is None else GuidanceEntry(*astuple(tuning.guidance)),
        tuning.draws, tuning.seed, version("seatrial"),
    )  # fmt: skip


def save_gains(tuning: Tuning, path: str | Path) -> None:
    """Write `gains.yaml` atomically."""
    content: dict[str, Any] = msgspec.to_builtins(gains_of(tuning))
    write_text(Path(path), dump_yaml({"seatrial": GAINS_FORMAT, **content}))


def load_gains(path: str | Path) -> GainsFile:
    """Gains from their file. Raises SeatrialError."""
    found = convert(expect_format(read_yaml(Path(path)), GAINS_FORMAT, path), GainsFile, path)
    if len(found.mix) != len(found.inputs):
        raise ControlError(
            f"{path}: mix has {len(found.mix)} rows; expected one for each of the inputs "
            f"{', '.join(found.inputs)}"
        )
    if min(found.authority[0], found.authority[2]) <= 0.0:
        raise ControlError(
            f"{path}: authority {found.authority}: expected more than 0 in surge and yaw"
        )
    if (found.authority[1] <= 0.0) != (found.guidance is not None):
        raise ControlError(
            f"{path}: guidance is for a boat without sway thrust (authority 0 in sway), and the file has only one "
            "of the two; run 'seatrial tune' again"
        )
    return found


def ros_parameters(tuning: Tuning) -> dict[str, Any]:
    """Parameters of the tracking node by name; lists are surge, sway, yaw."""
    g = gains_of(tuning)
    return {
        **_allocation_parameters(g.allocation),
        **({} if g.guidance is None else {"guidance": guidance_numbers(g)}),
        "knob": g.knob, "action": g.action, "rate": g.rate, "lead": g.lead, "limit": g.limit,
        "proportional": list(g.proportional), "integral": list(g.integral),
        "derivative": list(g.derivative), "authority": list(g.authority),
        "mix": [x for row in g.mix for x in row],
    }  # fmt: skip


def guidance_numbers(gains: GainsFile) -> list[float]:
    """Time, radius, slowest, fastest, approach; zeros without guidance."""
    return [0.0] * 5 if gains.guidance is None else list(msgspec.structs.astuple(gains.guidance))


def save_ros(tuning: Tuning, path: str | Path, *, ros2: bool = False) -> None:
    """Write ROS parameters: for `rosparam load FILE`, or for `--params-file FILE` of ROS 2."""
    found = ros_parameters(tuning)
    write_text(
        Path(path), dump_yaml({TRACKING_NODE: {"ros__parameters": found} if ros2 else found})
    )


def _allocation_parameters(given: ThrusterAllocation | None) -> dict[str, Any]:
    if given is None:
        return {"allocation": VEHICLE}
    rows = zip(
        given.effectiveness, given.limits, given.idle_forward, given.idle_reverse, strict=True
    )
    return {
        "allocation": given.scheme,
        "allocation_rank": [float(x) for x in given.rank],
        "allocation_hysteresis": given.hysteresis,
        "allocation_thrusters": [x for row, *rest in rows for x in (*row, *rest)],
    }


def _margins(found: Margins, loops: Sequence[str]) -> dict[str, AxisMargins]:
    degrees = np.degrees(found.phase)
    return {
        axis: AxisMargins(
            float(found.gain_up[i]) if np.isfinite(found.gain_up[i]) else None,
            float(degrees[i]), float(found.delay[i]), float(found.sensitivity[i]),
        )
        for i, axis in enumerate(loops)
    }  # fmt: skip
