# SPDX-License-Identifier: MIT
"""The state of a session at the poolside, as its page and its API show it.

Poses, velocities and commands are in the vehicle file's own axes, SI units and radians.
"""

from typing import Literal, Protocol

import msgspec

Level = Literal["ok", "warning", "error"]


class SignalState(msgspec.Struct, frozen=True):
    """Health of a signal: poses, or one command."""

    name: str
    kind: str  # pose, position, heading, command or scale
    rows: int
    rate: float | None = None  # [Hz] over the last seconds
    age: float | None = None  # [s] since the newest row arrived
    delay: float | None = None  # [s] from stamp to arrival, median
    jitter: float | None = None  # [s] 95th percentile of the intervals less their median
    gaps: int = 0
    jumps: int = 0
    value: tuple[float, ...] = ()  # of the newest row
    level: Level = "ok"
    finding: str = ""  # what was found, and what it means
    edit: str = ""  # the line of the vehicle file that mends it


class ParameterState(msgspec.Struct, frozen=True):
    """An estimated coefficient or constant of the actuator chain."""

    name: str
    unit: str
    value: float
    error: float  # standard error
    needed: float | None  # 95 % half-width that the chosen uses need; None: no use needs it
    known: bool  # the half-width is within `needed`


class PredictionState(msgspec.Struct, frozen=True):
    """Velocity predicted one second ahead against the filtered one, of an axis."""

    axis: str  # surge, sway, yaw
    rms: float  # [m/s] or [rad/s] of the last minute
    expected: float | None  # RMS by the model's covariance
    constant: float  # RMS where velocity stays constant
    t: tuple[float, ...] = ()  # [s] since the first pose
    predicted: tuple[float, ...] = ()
    measured: tuple[float, ...] = ()


class CoverageState(msgspec.Struct, frozen=True):
    """Seconds driven by speed and command, of an axis."""

    axis: str
    speeds: tuple[float, ...]  # edges of the bins, m/s or rad/s
    commands: tuple[float, ...]  # edges, -1 to 1 of the axis's full command
    seconds: tuple[tuple[float, ...], ...]  # [speed bin][command bin]


class ManoeuvreState(msgspec.Struct, frozen=True):
    """A manoeuvre to drive next, from the boat's pose now."""

    text: str  # one sentence
    seconds: float
    parameter: str  # whose interval it shortens most
    before: float  # its 95 % half-width now
    after: float  # and expected after the manoeuvre
    t: tuple[float, ...] = ()  # [s] from its beginning
    path: tuple[tuple[float, float, float], ...] = ()  # x, y [m], psi [rad] at `t`
    commands: tuple[tuple[float, ...], ...] = ()  # (inputs,) at `t`, held until the next
    margin: float | None = None  # [m] least distance from the walls; None: no walls


class UseState(msgspec.Struct, frozen=True):
    """Whether the drive is enough for a use of the model."""

    use: str  # odometry, control, simulation
    level: str  # fit, limited, not fit
    reason: str
    share: float  # 0 to 1: how much of what is needed is known


class LiveState(msgspec.Struct, frozen=True, kw_only=True):
    """All that the page shows but the track."""

    vehicle: str
    axes: str = "forward-left-up"  # the vehicle file's
    inputs: tuple[str, ...] = ()
    source: str = ""
    folder: str = ""
    time: float = 0.0  # [s] from the first pose to the newest
    driven: float = 0.0  # [s] of it under command
    poses: int = 0  # usable ones
    pose: tuple[float, float, float] | None = None
    walls: tuple[tuple[float, float], ...] = ()  # corners [m]; none: no walls
    signals: tuple[SignalState, ...] = ()
    parameters: tuple[ParameterState, ...] = ()
    predictions: tuple[PredictionState, ...] = ()
    coverage: tuple[CoverageState, ...] = ()
    next: ManoeuvreState | None = None
    others: tuple[ManoeuvreState, ...] = ()
    uses: tuple[UseState, ...] = ()
    enough: bool = False  # for every chosen use
    change: str = ""  # a change of the boat, as text
    message: str = ""  # what hinders the estimate, and what to do
    marks: tuple[tuple[float, str], ...] = ()  # [s], text
    discards: int = 0  # so far: after one the track's rows have other indices
    stopped: bool = False
    saving: str = ""  # what is at work to save, and how far it is
    saved: tuple[tuple[str, str], ...] = ()  # what was saved, and its path
    lag: float = 0.0  # [s] by which the estimate is behind the newest pose


class Controller(Protocol):
    """What the page's server asks of a session; methods may be called from any thread."""

    def state(self) -> LiveState:
        """The newest state, at once."""

    def track(self, since: int) -> tuple[int, list[tuple[float, float, float, float]]]:
        """Rows t [s], x, y [m], psi [rad] from index `since`, at 5 Hz at most, and the next index."""

    def mark(self, text: str) -> None:
        """Mark this moment of the recording."""

    def discard(self, seconds: float) -> None:
        """Leave the last seconds out of recording, estimate, predictions and the test for a change."""

    def stop(self) -> dict[str, str]:
        """End and save: what was saved to its path (recording, vehicle, model, report)."""
