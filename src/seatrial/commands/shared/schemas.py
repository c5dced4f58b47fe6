# SPDX-License-Identifier: MIT
"""All kinds of content that --json writes, for the page on JSON and its test. No command imports this file."""

from typing import Literal

from seatrial.commands.shared.results import (
    AutoResult,
    CompletionResult,
    ConvertResult,
    DemoResult,
    ExportResult,
    IdentifyResult,
    InitResult,
    LiveResult,
    MimicResult,
    PredictResult,
    ReportResult,
    Result,
    SimResult,
    SimulateResult,
)
from seatrial.control.gains_file import GainsFile
from seatrial.evaluation.comparison.compare import COMPARISON_FORMAT, Comparison
from seatrial.evaluation.scores import SCORES_FORMAT, Scores
from seatrial.fleet.results import FleetResult
from seatrial.inspection.consistency.check import Gain
from seatrial.inspection.overview import RecordingView
from seatrial.io.columns import TableView
from seatrial.recording.timing import Clock, Delay


class SignFinding(Result, frozen=True):
    """A contradiction between vehicle file and recordings."""

    kind: str  # of finding
    text: str  # what was found, what it means, what to do


class Signs(Result, frozen=True):
    """Units, signs and order of the vehicle file, from all recordings."""

    findings: list[SignFinding]
    seen: list[str]  # what each input does
    gains: list[Gain]


class InspectionResult(Result, frozen=True):
    """`seatrial inspect --vehicle`: each recording, and its consistency with the vehicle file."""

    vehicle: str  # name
    axes: str  # of the vehicle file
    recordings: list[RecordingView]
    signs: Signs
    seatrial: Literal["inspection 1"] = "inspection 1"


class Topic(Result, frozen=True, omit_defaults=True):
    """One topic of a bag or of an autopilot's log."""

    role: str | None  # what it could be: poses, position, heading, commands
    source: str  # its name
    kind: str  # message type
    clock: Clock  # where its stamps come from
    count: int  # messages
    rate: float  # [Hz] by the median step; 0 with fewer than two stamps
    longest: float  # [s] longest step
    jitter: float  # [s] standard deviation of the steps, gaps aside
    duplicated: int  # stamps equal to the one before
    backward: int  # stamps before the one before
    on_change: bool  # written on change rather than periodically
    delay: Delay | None = None  # where both stamp and arrival are known
    publishers: int = 1
    cut: bool = False
    fields: list[str] | None = None  # of an autopilot's log
    units: dict[str, str] | None = None  # of an autopilot's log, by field


class Contents(Result, frozen=True, omit_defaults=True):
    """What one recording has: topics of a bag or log, or tables."""

    path: str
    kind: str  # of bag, of log, or tables
    length: float | None = None  # [s] of a bag or log
    topics: list[Topic] | None = None
    remarks: list[str] | None = None
    parameters: dict[str, float] | None = None  # of an autopilot's log
    tables: list[TableView] | None = None


class ContentsResult(Result, frozen=True):
    """`seatrial inspect` without a vehicle file: topics or columns."""

    recordings: list[Contents]
    seatrial: Literal["contents 1"] = "contents 1"


class TermRow(Result, frozen=True, omit_defaults=True):
    """A term of the vehicle or a candidate. Without `value` and what follows: never removed, or an exact alias."""

    term: str  # as in a vehicle file, forward-left-up
    coefficient: str
    axis: str  # surge, sway or yaw
    unit: str
    kept: bool  # whether it is in the chosen structure
    verdict: str  # stays, comes, goes, out or aliased
    reason: str
    value: float | None = None
    error: float | None = None  # standard error
    p: float | None = None  # of its test against zero
    repeats: list[float] | None = None  # value of each repeat
    repeats_errors: list[float] | None = None  # their standard errors
    repeats_p: float | None = None  # of the test that the repeats agree
    repeats_between: float | None = None  # standard deviation between repeats, beyond their errors
    held_out_percent: float | None = None  # [%] by which held-out prediction is worse without it
    held_out_moves: float | None = None  # [%] by which it moves the prediction
    held_out_z: float | None = None  # standard errors of that change


class Repeat(Result, frozen=True):
    """One repeat of the experiment."""

    name: str
    recordings: list[str]  # names


class SelectionResult(Result, frozen=True):
    """`seatrial select`: every term with its tests."""

    vehicle: str  # name
    horizon: float  # [s] of held-out prediction
    repeats: list[Repeat]
    structure: dict[str, list[str]]  # chosen terms of each axis, as in a vehicle file
    terms: list[TermRow]
    asked: list[str]  # findings to check first
    seatrial: Literal["selection 1"] = "selection 1"


class DeadZone(Result, frozen=True):
    """Commands without thrust."""

    forward: float
    reverse: float


class Thruster(Result, frozen=True):
    """One thruster."""

    effectiveness: list[float]  # column of the allocation matrix: surge, sway, yaw
    dead_zone: DeadZone
    limit: float  # of its command


class Authority(Result, frozen=True):
    """Largest wrench in both directions of an axis."""

    positive: float
    negative: float


class AllocatedDrive(Result, frozen=True):
    """A scheme on the commands of a recording."""

    recording: str  # name
    minutes: float  # [min] of commands
    crossings_per_minute: dict[str, float]  # of the dead zone, by thruster
    wrench_error: dict[str, float]  # RMS, by axis
    wrench_asked: dict[str, float]  # RMS, by axis
    limited: float  # share of the time at a limit
    power: float  # relative


class SchemeRow(Result, frozen=True, omit_defaults=True):
    """One scheme; without the fields from `authority` on where it does not fit the boat."""

    scheme: str
    why: str  # why it fits, or does not
    drives: list[AllocatedDrive]
    authority: dict[str, Authority] | None = None  # by axis
    idle_power: float | None = None  # relative, at rest
    idle: dict[str, float] | None = None  # command of each thruster at rest
    switching: list[str] | None = None  # thrusters that change their direction


class AllocationResult(Result, frozen=True):
    """`seatrial allocate`: the schemes side by side, forward-left-up."""

    vehicle: str  # name
    axes: str
    thrusters: dict[str, Thruster]  # by name
    scale: dict[str, float]  # by axis
    priority: str  # of the axes at the limits
    chosen: str  # scheme
    schemes: list[SchemeRow]
    seatrial: Literal["allocation 1"] = "allocation 1"


SCHEMAS = {  # command: kinds of its content, with their classes
    "auto": {"auto 1": AutoResult},
    "live": {"live 1": LiveResult},
    "identify": {"identify 1": IdentifyResult},
    "demo": {"demo 1": DemoResult},
    "inspect": {"inspection 1": InspectionResult, "contents 1": ContentsResult},
    "init": {"init 1": InitResult},
    "convert": {"convert 1": ConvertResult},
    "simulate": {"simulate 1": SimulateResult},
    "validate": {SCORES_FORMAT: Scores},
    "report": {"report 1": ReportResult},
    "compare": {COMPARISON_FORMAT: Comparison},
    "fleet": {"fleet-result 1": FleetResult},
    "select": {"selection 1": SelectionResult},
    "tune": {"gains 1": GainsFile},
    "predict": {"predict 1": PredictResult},
    "allocate": {"allocation 1": AllocationResult},
    "export": {"export 1": ExportResult},
    "sim": {"sim 1": SimResult},
    "mimic": {"mimic 1": MimicResult},
    "completion": {"completion 1": CompletionResult},
}
