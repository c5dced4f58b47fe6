# SPDX-License-Identifier: MIT
"""All schemes side by side on one boat: authority, idle power, and what a recorded drive costs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.control.allocation.allocator import HYSTERESIS, PRIORITY, Allocator, AllocatorScheme
from seatrial.control.allocation.thruster_effectiveness import Effectiveness, effectiveness
from seatrial.recording.recording import Recording, Signal
from seatrial.util.errors import AllocationError
from seatrial.util.frames import Array, Mask, frozen_array

PLAIN = "moore-penrose, plain"  # thrusts sent as commands, the curve left out
RECORDED = "as recorded"
ORDER = (
    AllocatorScheme.MP, AllocatorScheme.AF, AllocatorScheme.NULL_SPACE,
    AllocatorScheme.SIGN_PATTERN, AllocatorScheme.AUTO,
)  # fmt: skip
ROUNDING = 1e-9  # [command units]


@dataclass(frozen=True)
class Drive:
    """What a scheme makes of a recorded drive."""

    recording: str
    minutes: float
    crossings: Mapping[
        str, float
    ]  # by thruster, each minute: enters its dead zone, or jumps over it
    error: Array  # (3,) RMS of wrench given - asked, by axis [command units]
    asked: Array  # (3,) RMS of wrench asked [command units]
    limited: float  # share of the time in which limits take part of the wrench
    power: float  # mean; 1 is one thruster at full command
    t: Array  # (m,) [s] of the commands
    commands: Array  # (m, n)

    @property
    def crossing(self) -> float:
        """Crossings of all thrusters together, each minute."""
        return float(sum(self.crossings.values()))

    @property
    def error_share(self) -> float:
        """RMS wrench error over RMS wrench, axes together."""
        asked = float(np.linalg.norm(self.asked))
        return float(np.linalg.norm(self.error)) / asked if asked > 0 else 0.0


@dataclass(frozen=True)
class Row:
    """One scheme."""

    name: str
    why: str  # what keeps thrusters out, or why the scheme is not for this boat
    allocator: Allocator | None  # None: refused, or as recorded
    authority: Array | None  # (3, 2) most of each axis alone, positive and negative [command units]
    drives: Sequence[Drive] = ()

    @property
    def idle_power(self) -> float | None:
        """At rest; 1 is one thruster at full command."""
        return None if self.allocator is None else self.allocator.idle_power


@dataclass(frozen=True)
class AllocationComparison:
    """All schemes for one boat."""

    allocator: Allocator  # of the scheme asked for
    rows: Sequence[Row]
    priority: str

    @property
    def boat(self) -> Effectiveness:
        """What each thruster gives."""
        return self.allocator.boat

    def row(self, name: str) -> Row:
        """A scheme's row, by its name."""
        return next(row for row in self.rows if row.name == name)


class Options(TypedDict):
    """What all schemes of a comparison have in common."""

    priority: str
    margin: float | None
    hysteresis: float


def compare_schemes(
    boat: Model | Vehicle,
    recordings: Sequence[Recording] = (),
    *,
    scheme: str = "auto",
    priority: str = PRIORITY,
    margin: float | None = None,
    hysteresis: float = HYSTERESIS,
) -> AllocationComparison:
    """Every scheme that the boat's geometry allows, and why not where it doesn't.

    `scheme` is the one asked for; it must be possible. Raises AllocationError.
    """
    own = effectiveness(boat)
    options = Options(priority=priority, margin=margin, hysteresis=hysteresis)
    chosen = Allocator(own, scheme, **options)
    rows = [_recorded(own, chosen, recordings)] if recordings else []
    plain = Allocator(own, "moore-penrose", invert=False, **options)
    rows.append(_row(PLAIN, plain, chosen, recordings))
    for one in ORDER:
        if one is AllocatorScheme.AUTO and Allocator(own, "auto", **options).scheme is not one:
            continue  # it is one of the others
        try:
            made = Allocator(own, one.value, **options)
        except AllocationError as error:
            rows.append(Row(one.value, str(error), None, None))
        else:
            rows.append(_row(one.value, made, chosen, recordings))
    return AllocationComparison(chosen, tuple(rows), priority)


def crossings(commands: Array, edges: Array) -> Array:
    """How often each thruster (n,) enters its dead zone or jumps over it, in rows of commands (m, n).

    `edges` (2, n) forward and astern; at its edge a command is outside. Without a dead zone, only 0 is
    inside.
    """
    side = np.where(commands >= edges[0] - ROUNDING, 1, 0) - np.where(
        commands <= -edges[1] + ROUNDING, 1, 0
    )
    side = np.where((edges.sum(axis=0) == 0) & (np.abs(commands) <= ROUNDING), 0, side)
    before, after = side[:-1], side[1:]
    changed = (before != 0) & (after != before)
    return np.asarray(changed.sum(axis=0))


def authority(allocator: Allocator) -> Array:
    """(3, 2) most of surge, sway and yaw alone, positive and negative [command units]."""
    both = np.vstack([np.eye(3), -np.eye(3)])
    return allocator.reach(both).reshape(2, 3).T


def _row(name: str, made: Allocator, judge: Allocator, recordings: Sequence[Recording]) -> Row:
    drives = []
    for recording in recordings:
        asked = made.boat.asked(recording)
        made.reset()
        commands, shares, _ = made.allot(asked)
        limited = shares.min(axis=1) < 1.0
        drives.append(_drive(judge, recording, asked, commands, limited))
    made.reset()
    return Row(name, made.why, made, authority(made), tuple(drives))


def _recorded(own: Effectiveness, judge: Allocator, recordings: Sequence[Recording]) -> Row:
    """What the thrusters were told on the day."""
    drives = []
    for recording in recordings:
        sent = own.sent(recording)
        limited = np.zeros(len(sent), dtype=bool)
        drives.append(_drive(judge, recording, own.asked(recording), sent, limited))
    return Row(RECORDED, "what the boat's own allocation sent", None, None, tuple(drives))


def _drive(
    judge: Allocator, recording: Recording, asked: Array, commands: Array, limited: Mask
) -> Drive:
    """Scores over time; `judge` knows curves and edges. A row of commands holds until the next."""
    held = _held(recording.commands)
    weight = held / held.sum()
    minutes = float(held.sum()) / 60.0
    error = judge.wrench(commands) - asked
    count = crossings(commands, judge.edges) / minutes
    return Drive(
        recording.name,
        minutes,
        dict(zip(judge.thrusters, count.tolist(), strict=True)),
        np.sqrt(weight @ error**2),
        np.sqrt(weight @ asked**2),
        float(weight @ limited),
        float(weight @ judge.power(commands)),
        frozen_array(recording.seconds(recording.commands.stamps)),
        frozen_array(commands),
    )


def _held(commands: Signal) -> Array:
    """(m,) how long each row of commands was in force [s]; the last as long as the median one."""
    if len(commands.stamps) < 2:
        raise AllocationError("a recording with one command; a drive needs more")
    gaps = np.diff(commands.stamps) * 1e-9
    return np.append(gaps, np.median(gaps))
