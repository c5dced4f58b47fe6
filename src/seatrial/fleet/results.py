# SPDX-License-Identifier: MIT
"""Results of a fleet: what one boat's folder has, and what the whole has; tools/json_page.py lists the fields."""

from typing import Literal

import msgspec


class Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Of the results."""


class FleetRecording(Part, frozen=True):
    """One recording of a boat."""

    name: str
    error: str | None  # why it can't be read: the boat is identified without it; null: it was read
    bad: bool  # it can't be read, or a finding names it
    remarks: list[str]  # what is wrong with it, what it means, what to do


class Estimate(Part, frozen=True):
    """One parameter, forward-left-up."""

    value: float
    error: float  # standard error
    unit: str


class Change(Part, frozen=True):
    """The boat against its previous model."""

    previous: str  # path of that model
    p: float | None  # of no change, by Holm's correction over parameters; null: nothing to test
    text: list[str]  # which parameters changed, and the probable cause
    error: str | None  # why they can't be compared


class BoatResult(Part, frozen=True):
    """One boat by itself."""

    name: str
    kind: str
    made_from: str  # digest of its files, its options and seatrial's version
    error: str | None  # why there is no model
    recordings: list[FleetRecording]
    structure: str  # digest of terms and stages: parameters of one structure are comparable
    parameters: dict[str, Estimate]  # by name; only those that were estimated
    ratios: dict[str, float | None]  # by u, v, r: held-out RMS error over constant velocity's
    findings: list[str]  # on the model, those that ask for an action
    change: Change | None  # null: there is no previous model
    seatrial: Literal["boat 1"] = "boat 1"


class Deviation(Part, frozen=True):
    """One parameter of a boat against its kind."""

    parameter: str
    value: float
    centre: float  # of the kind
    deviation: float  # standard deviation of a boat of the kind, with its own standard error
    z: float  # (value - centre) / deviation
    p: float  # of so large a z, by Holm's correction over all boats and parameters of the kind


class FleetBoat(Part, frozen=True):
    """One boat in its fleet."""

    result: BoatResult
    report: str | None  # path of its page from the folder of the results
    differs: list[Deviation]  # parameters in which it differs from its kind, the largest |z| first
    not_compared: str | None  # why it is not compared with its kind
    changed: bool  # it differs from its previous model, by Holm's correction over all boats


class KindParameter(Part, frozen=True):
    """One parameter over the boats of a kind."""

    centre: float
    between: float  # standard deviation between boats, their standard errors taken off
    unit: str
    boats: int  # that have it


class Kind(Part, frozen=True):
    """Boats of one kind."""

    boats: int
    compared: int  # of the most frequent structure
    parameters: dict[str, KindParameter]  # by name


class FleetResult(Part, frozen=True):
    """`seatrial fleet`: all boats."""

    name: str
    boats: list[FleetBoat]
    kinds: dict[str, Kind]  # by name
    failed: list[str]  # boats without a model
    differing: list[str]  # boats that differ from their kind
    changed: list[str]  # boats that differ from their previous model
    bad_recordings: list[str]  # boat/recording
    seatrial: Literal["fleet-result 1"] = "fleet-result 1"
