# SPDX-License-Identifier: MIT
"""What --json writes, a struct for each command. The page on JSON is made of these lines, comments included.

Results with a class of their own elsewhere (scores, comparison, gains, model) and larger ones: schemas.py.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import msgspec

if TYPE_CHECKING:
    from seatrial.boat.model import Model


class Result(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Of one command."""


class IdentifiedParameter(Result, frozen=True):
    """One parameter, forward-left-up."""

    value: float
    standard_error: float | None  # null: given, not estimated
    unit: str
    verdict: str  # how well it is known


class ModelFinding(Result, frozen=True):
    """What the estimator found."""

    kind: str  # of finding
    text: str  # what was found, what it means, what to do


class IdentifyResult(Result, frozen=True):
    """`seatrial identify`: the model's parameters and the findings. The model file has everything."""

    model: str  # path of the model file
    name: str  # of the boat
    method: str
    recordings: list[str]  # names
    parameters: dict[str, IdentifiedParameter]  # by name
    findings: list[ModelFinding]
    doubts: list[str]  # why the model may be wrong
    next: str  # what to do next
    seatrial: Literal["identify 1"] = "identify 1"


class AutoResult(Result, frozen=True):
    """`seatrial auto`: the model, its report and what was assumed."""

    folder: str  # of everything
    report: str  # path of the page
    scores: str  # path of the scores, as of `seatrial validate --json`
    identified: IdentifyResult
    assumed: list[str]  # instead of answers of the user's
    next: str  # what to do next
    seatrial: Literal["auto 1"] = "auto 1"


class LiveResult(Result, frozen=True):
    """`seatrial live`: what was driven and saved."""

    folder: str  # of everything
    seconds: float  # from the first pose to the last
    poses: int  # usable ones
    enough: bool  # for every chosen use
    recording: str  # folder of its tables, with the vehicle file that reads it
    model: str | None  # path; null: the drive did not give one
    report: str | None  # path of the page
    next: str  # what to do next
    seatrial: Literal["live 1"] = "live 1"


def identified(model: "Model", path: Path, following: str) -> IdentifyResult:
    """The result of an identification. following: what to do next."""
    from seatrial.boat.findings import finding_text
    from seatrial.identification.uncertainty.identifiability import identifiability

    parameters = {
        one.name: IdentifiedParameter(one.value, one.error or None, one.unit, one.verdict.value)
        for one in identifiability(model).findings
    }
    findings = [ModelFinding(f.kind.value, finding_text(f)) for f in model.estimator.findings]
    names = [recording.name for recording in model.recordings]
    return IdentifyResult(
        str(path), model.name, model.estimator.method, names, parameters, findings,
        list(model.warnings), following,
    )  # fmt: skip


class DemoResult(Result, frozen=True):
    """`seatrial demo`: a whole tour."""

    folder: str  # all that was written is below it
    written: list[str]  # files
    seatrial: Literal["demo 1"] = "demo 1"


class RecognisedSignal(Result, frozen=True):
    """A signal of the boat that was found in a recording."""

    signal: str  # such as x, heading, stamps of the commands
    column: str  # column of a table, or topic and field
    why: str  # the evidence
    sure: str  # chosen (by you), certain, likely or guess
    others: list[str]  # further candidates


class InitResult(Result, frozen=True):
    """`seatrial init`: the proposed vehicle file."""

    vehicle: str  # path of the file
    recordings: list[str]  # paths that it is proposed from
    recognised: list[RecognisedSignal]  # of tables and autopilots' logs; else empty
    next: str  # what to do next
    seatrial: Literal["init 1"] = "init 1"


class ConvertResult(Result, frozen=True):
    """`seatrial convert`: the files of the copy."""

    recording: str  # path of the original
    written: list[str]  # paths
    next: str  # what to do next
    seatrial: Literal["convert 1"] = "convert 1"


class SimulatedVehicle(Result, frozen=True):
    """Trials of one vehicle."""

    vehicle: str  # path of its file
    trials: list[str]  # path of each: a folder of tables, or a bag


class SimulateResult(Result, frozen=True):
    """`seatrial simulate`: where the trials are."""

    plan: str  # its name
    folder: str  # of everything; the truth is in truth/ below it
    vehicles: list[SimulatedVehicle]
    seatrial: Literal["simulate 1"] = "simulate 1"


class ReportResult(Result, frozen=True):
    """`seatrial report`: the page, and the folders of figures and tables beside it."""

    model: str  # path
    recordings: list[str]  # paths
    written: list[str]  # the page first
    seatrial: Literal["report 1"] = "report 1"


class PredictResult(Result, frozen=True):
    """`seatrial predict` along a recording. With --live the output itself is lines of JSON (docs/live.md)."""

    model: str  # path
    recording: str  # its name
    duration: float  # [s]
    rate: float  # [Hz] of the odometry
    estimates: int  # lines of odometry
    written: str  # path
    seatrial: Literal["predict 1"] = "predict 1"


class ExportResult(Result, frozen=True):
    """`seatrial export`: the file for another program."""

    model: str  # path
    format: str  # as of --to
    about: str  # what the file is, and what it lacks
    written: str  # path
    seatrial: Literal["export 1"] = "export 1"


class SimResult(Result, frozen=True):
    """`seatrial sim`, when it has ended."""

    boats: list[str]  # names
    seed: int  # of the sensors' noise
    duration: float  # [s] simulated
    lines: int  # that were read
    mistakes: int  # lines that could not be used
    seatrial: Literal["sim 1"] = "sim 1"


class MimicResult(Result, frozen=True):
    """`seatrial mimic`, when it has ended."""

    model: str  # path
    lines: int  # that were read
    mistakes: int  # lines that could not be used
    seatrial: Literal["mimic 1"] = "mimic 1"


class CompletionResult(Result, frozen=True):
    """`seatrial completion`: the script as text."""

    shell: str  # bash, zsh or tcsh
    script: str  # to be sourced by it
    seatrial: Literal["completion 1"] = "completion 1"
