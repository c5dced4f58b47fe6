# SPDX-License-Identifier: MIT
"""Schema of vehicle and model files, key by key. Unknown keys are refused."""

import math
from typing import Annotated, Literal

import msgspec

from seatrial.boat.findings import Finding

VEHICLE_FORMAT = "vehicle 1"
Number = float | int
Clock = Literal["header", "bag"]  # stamps of the messages, or of their arrival in the bag
Positive = Annotated[float, msgspec.Meta(gt=0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]
Edge = Annotated[float, msgspec.Meta(ge=0, lt=1)]
Offset = Annotated[float, msgspec.Meta(gt=-1, lt=1)]
FullAngle = Annotated[float, msgspec.Meta(gt=0, le=360)]  # [deg]
TrimAngle = Annotated[float, msgspec.Meta(ge=-180, le=180)]  # [deg]
Length = Annotated[float, msgspec.Meta(ge=-1000, le=1000)]  # [m] from a small boat's origin
Delay = Annotated[float, msgspec.Meta(ge=-5, le=5)]  # [s] of a sensor; negative: stamped late
Estimate = Literal["estimate"]  # instead of a number: the stage exists, its value is estimated


class Strict(msgspec.Struct, forbid_unknown_fields=True, frozen=True, omit_defaults=True):
    """A mapping whose unknown keys are errors."""


TO_SI = {  # by a column's unit; stamps are whole nanoseconds
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
    "rad": 1.0,
    "deg": math.pi / 180,
    "-": 1.0,
}


class Column(Strict, frozen=True):
    """A number out of each row or message: value = sign (raw - offset) / scale, in `unit`.

    `column` counts in tables, `field` in bags; one vehicle file may serve both.
    """

    column: str = ""  # of a table
    field: str = ""  # of a message: axes[1], wrench.force.x
    index: Annotated[int, msgspec.Meta(ge=0)] | None = None  # into the field: axes, 1
    topic: str = ""  # where it is not the signal's own
    file: str = ""  # the same for a table of a folder
    stamp: str = ""  # column of that table with the stamps; absent: named as the signal's
    unit: Literal["m", "mm", "cm", "rad", "deg", "s", "ms", "us", "ns", "s.ns", "-"] | None = None
    sign: Literal[1, -1] = 1
    scale: Positive = 1.0
    offset: float = 0.0
    off: float | None = None  # raw value that means no command: PWM of a disarmed autopilot
    nanoseconds: str = ""  # of a stamp in whole seconds: the column with the rest
    quaternion: tuple[str, str, str, str] | None = None  # of psi: columns or fields x, y, z, w


def as_column(entry: str | Column) -> Column:
    """The long form of a column: a bare name is a table's column and a message's field."""
    return Column(column=entry, field=entry) if isinstance(entry, str) else entry


class PoseSource(Strict, frozen=True):
    """Where the pose comes from: columns of a table, a topic of a bag, or either."""

    stamp: str | Column = Column()
    x: str | Column = Column()  # in a bag, x, y and psi are found in the usual messages
    y: str | Column = Column()
    psi: str | Column = Column()
    # [deg] instead of x and y; the pose is in the plane that touches the earth at the origin,
    # x east and y north (axes forward-left-up), or x north and y east (forward-right-down)
    latitude: str | Column | None = None
    longitude: str | Column | None = None
    origin: tuple[float, float] | None = None  # latitude, longitude [deg]; absent: the first pose
    yaw_rate: str | Column | None = None  # of a gyro, in rad/s or (unit: deg) deg/s
    file: str | None = None  # of a folder recording
    valid: str | None = None  # column that is 0 where the pose is invalid
    topic: str | None = None  # of a bag
    parent: str | None = None  # frames of a tf, or of messages from several
    child: str | None = None
    clock: Clock = "header"
    # [m] lever arm of the measured point from the origin: forward, second axis
    lever: tuple[Length, Length] | None = None  # not stated: it is the origin
    # [s] a pose stamped t shows the boat as it was at t - delay
    delay: Delay | Estimate | None = None  # of the position; not stated: none
    heading_delay: Delay | Estimate | None = None  # of the heading; not stated: the position's

    @property
    def columns(self) -> dict[str, Column]:
        """Those of x, y and psi."""
        return {"x": as_column(self.x), "y": as_column(self.y), "psi": as_column(self.psi)}


class CommandSource(Strict, frozen=True):
    """Where the commands come from: a name for each input."""

    inputs: dict[str, str | Column]
    stamp: str | Column = Column()
    file: str | None = None  # of a folder recording
    topic: str | None = None  # of a bag
    clock: Clock = "header"
    # whether rows are a logger's samples; estimate: the recordings show it; without it as the log shows
    sampled: bool | Estimate | None = None


class ScaleSource(Strict, frozen=True):
    """A known signal that scales thrust, for instance propeller speed."""

    column: str | Column  # in a bag, its field; the topic is the commands' or its own
    reference: Positive  # value at which the scale is 1


class ThrusterEntry(Strict, frozen=True):
    """A fixed thruster."""

    x: Length
    y: Length
    angle_deg: float  # direction of thrust, from forward towards the second axis [deg]


class ForceEntry(Strict, frozen=True):
    """A generalised force as a weighted sum of actuators, and of the sines of angles."""

    axis: Literal["surge", "sway", "yaw"]
    of: dict[str, float] = {}
    deflection: dict[str, float] = {}  # angles of `steered`: their sines, a rudder in the flow


class AllocationEntry(Strict, frozen=True):
    """Scheme and limits, in command units."""

    scheme: Literal["direct", "moore-penrose", "always-forward"] = "direct"
    F_os: NotNegative = 0.0
    limit: Positive | None = None


class DeadZone(Strict, frozen=True):
    """Edges of the dead zone, both >= 0, in command units. `reverse: forward`: one edge for both sides."""

    forward: Edge | Estimate
    reverse: Edge | Estimate | Literal["forward"]

    @property
    def symmetric(self) -> bool:
        """Whether one constant, edge_forward, is both edges."""
        return self.reverse == "forward"


class PairOffset(Strict, frozen=True):
    """What is added to a pair's vector, in command units; absent: nothing."""

    along: Offset | Estimate | None = None
    across: Offset | Estimate | None = None


class PairEntry(Strict, frozen=True):
    """Propellers whose two commands are the components of one vector (Voith-Schneider, azimuth).

    Both components limit each other: thrust is along the vector, and grows with its length from
    the dead zone to 1.
    """

    of: list[tuple[str, str]]  # actuators, along and across
    mirrored: list[str] = []  # of these: components with the opposite sign in the vector
    offset: PairOffset = PairOffset()
    dead_zone: Edge | Estimate | None = None  # of the vector's length


class SteeredEntry(Strict, frozen=True):
    """Thrusters that an angle turns: rudder behind a propeller, outboard, azimuth thruster.

    A thrust f and an angle a give f cos(a) in the thrust's place, f sin(a) in the angle's.
    """

    of: list[tuple[str, str]]  # actuators, thrust and angle
    angle_deg: FullAngle | Estimate  # [deg] at command 1, from forward to the second axis
    offset_deg: TrimAngle | Estimate | None = None  # [deg] at command 0; absent: none
    rate_deg: Positive | Estimate | None = None  # [deg/s] rate limit; absent: none
    dead_zone: Edge | Estimate | None = None  # of the angle's command, both ways


class ScaleUse(Strict, frozen=True):
    """Thrust is multiplied by (signal / reference) ^ power."""

    signal: str
    power: float | Estimate = 1.0


class ChainGroup(Strict, frozen=True):
    """Stages of the actuator chain, for some or all actuators. Absent: no such stage."""

    name: str = ""
    actuators: list[str] | None = None  # None: all
    # [s] transport delay plus clock offset: positive acts later than its stamp
    latency: Annotated[float, msgspec.Meta(ge=-5, le=5)] | Estimate | None = None
    dead_zone: DeadZone | Estimate | None = None
    reverse_ratio: Positive | Estimate | None = None  # full reverse over full forward thrust
    power: Positive | Estimate | None = None  # exponent past the edge
    table: list[tuple[float, float]] | None = None  # command, thrust; instead of edge and power
    pair: PairEntry | None = None  # instead of all these
    steered: SteeredEntry | None = None  # thrusters that an angle turns
    lag: NotNegative | Estimate | None = None  # [s]
    slew_rate: Positive | Estimate | None = None  # [1/s] largest change of thrust, of full thrust
    scale: ScaleUse | None = None
    gains: dict[str, float] | None = None  # by actuator, mean 1


class VehicleFile(Strict, frozen=True):
    """`vehicle.yaml`."""

    seatrial: Literal["vehicle 1"]
    name: str
    axes: Literal["forward-left-up", "forward-right-down"]
    pose: PoseSource
    commands: CommandSource
    structure: str | dict[str, list[str]]
    command_timeout: Positive | None = None  # [s] without commands, after which they are unknown
    scales: dict[str, ScaleSource] = {}
    thrusters: dict[str, ThrusterEntry] = {}
    forces: dict[str, ForceEntry] = {}
    allocation: AllocationEntry = AllocationEntry()
    chain: list[ChainGroup] = []


class CoefficientEntry(Strict, frozen=True):
    """An estimated coefficient or constant; standard error 0: given."""

    value: float
    standard_error: NotNegative
    unit: str = ""


class Integration(Strict, frozen=True):
    """Integration of the model."""

    scheme: Literal["runge-kutta", "forward-euler"]
    step: Positive  # [s] longest step of Runge-Kutta; the step of forward Euler


class ProcessEntry(Strict, frozen=True):
    """Process noise of the filter: random walks of velocity, and Gauss-Markov disturbance forces."""

    walk_linear: NotNegative  # [m/s / sqrt(s)] random walk of u and v
    walk_yaw: NotNegative  # [rad/s / sqrt(s)]
    disturbance_linear: NotNegative  # [m/s^2] standard deviation of the disturbance
    disturbance_yaw: NotNegative  # [rad/s^2]
    memory: Positive  # [s] its time constant
    sway_ratio: Positive = 1.0  # of sway's noise over that of surge; 1 where earth-fixed
    earth_fixed: bool = False  # constant direction in the world, or in the boat


class CorrelatedEntry(Strict, frozen=True):
    """Gauss-Markov pose noise, in addition to white noise.

    Its correlation after t is exp(-t / memory). With a period (waves) it is a damped oscillation:
    e'' + (2 / memory) e' + (2 pi / period)^2 e = white noise.
    """

    position: NotNegative  # [m] standard deviation
    heading: NotNegative  # [rad]
    memory: Positive  # [s] time constant
    period: Positive | None = None  # [s] of oscillating noise (waves); None: first order

    @property
    def memory_text(self) -> str:
        """Memory and period as text."""
        oscillation = (
            "" if self.period is None else f", oscillating with a period of {self.period:.2g} s"
        )
        return f"{self.memory:.2g} s{oscillation}"


class NoiseEntry(Strict, frozen=True):
    """White pose noise, and the other noise that was estimated."""

    position: NotNegative  # [m]
    heading: NotNegative  # [rad]
    process: ProcessEntry | None = None
    correlated: CorrelatedEntry | None = None


class EnvelopeEntry(Strict, frozen=True):
    """Ranges that occurred in the recordings: 0.5th to 99.5th percentile of speeds, all forces."""

    speeds: dict[str, tuple[float, float]]
    forces: dict[str, tuple[float, float]]


class SourceEntry(Strict, frozen=True):
    """A file that a recording was read from."""

    name: str
    sha256: str


class RecordingEntry(Strict, frozen=True):
    """A recording that the model was identified from."""

    name: str
    length: float  # [s]
    start: float = 0.0  # [s] cut off at the beginning
    files: list[SourceEntry] = []
    effects: dict[str, float] = {}  # current, trim and wind, forward-left-up, where estimated
    errors: dict[str, float] = {}  # their standard errors
    without: list[tuple[float, float]] = []  # [s] from the file's start, excluded (--without)


class StepEntry(Strict, frozen=True):
    """One least-squares step, as the report shows it."""

    equation: str
    coefficients: list[str]
    recordings: list[str]
    rows: int
    condition: float  # of the column-scaled regressor
    explained: float  # R^2


EQUATION_ERROR = "equation-error"  # the method of the paper, Eqs. (13)-(17)


class EstimatorEntry(Strict, frozen=True):
    """Method and settings of the estimate."""

    method: str
    settings: dict[str, str | float | int | bool | None] = {}
    steps: list[StepEntry] = []
    findings: list[Finding] = []


class ModelFile(Strict, frozen=True):
    """`model.yaml`."""

    seatrial: Literal["model 3"]
    version: str  # of seatrial
    name: str
    axes: Literal["forward-left-up", "forward-right-down"]
    structure: dict[str, list[str]]
    coefficients: dict[str, CoefficientEntry]
    constants: dict[str, CoefficientEntry]
    covariance: list[list[float]]  # of coefficients and constants, in this order
    integration: Integration
    noise: NoiseEntry
    envelope: EnvelopeEntry
    recordings: list[RecordingEntry]
    estimator: EstimatorEntry
    warnings: list[str]
    vehicle: dict[str, object]
