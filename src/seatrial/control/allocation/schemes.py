# SPDX-License-Identifier: MIT
"""All schemes on one boat: authority, idle power; crossings, wrench error and power along recorded commands."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.control.allocation.allocator import PRIORITY, Allocator, AllocatorScheme
from seatrial.control.allocation.thruster_effectiveness import Effectiveness, effectiveness
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from seatrial.util.errors import AllocationError
from seatrial.util.frames import Array, Mask, frozen_array

PLAIN = "moore-penrose, plain"  # thrusts sent as commands, the curve left out
RECORDED = "as recorded"
SCHEME_ORDER = (
    AllocatorScheme.MP, AllocatorScheme.AF, AllocatorScheme.NULL_SPACE,
    AllocatorScheme.SIGN_PATTERN, AllocatorScheme.FEWEST,
)  # fmt: skip
COMMAND_ROUNDING = 1e-9  # [command units]
BISECTIONS = 40


@dataclass(frozen=True)
class Drive:
    """One scheme along the commands of a recording."""

    recording: str
    minutes: float
    # by thruster [1/min]: the command enters the dead zone or jumps over it
    crossings: Mapping[str, float]
    error: Array  # (3,) RMS of resulting - requested wrench, by axis [command units]
    requested: Array  # (3,) RMS of wrench requested [command units]
    limited: float  # share of the time in which limits reduce the wrench
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
        requested = float(np.linalg.norm(self.requested))
        return float(np.linalg.norm(self.error)) / requested if requested > 0 else 0.0


@dataclass(frozen=True)
class Row:
    """One scheme."""

    name: str
    why: str  # why thrusters stay outside their dead zones, or why the scheme is not possible
    allocator: Allocator | None  # None: refused, or as recorded
    # (3, 2) largest single-axis wrench, positive and negative [command units]
    authority: Array | None
    drives: Sequence[Drive] = ()

    @property
    def idle_power(self) -> float | None:
        """At rest; 1 is one thruster at full command."""
        return None if self.allocator is None else self.allocator.idle_power


@dataclass(frozen=True)
class AllocationComparison:
    """All schemes for one boat."""

    allocator: Allocator  # of the requested scheme
    rows: Sequence[Row]
    priority: str

    @property
    def boat(self) -> Effectiveness:
        """Effectiveness of the thrusters."""
        return self.allocator.boat

    def row(self, name: str) -> Row:
        """A scheme's row, by its name."""
        return next(row for row in self.rows if row.name == name)


class Options(TypedDict):
    """Options of all schemes of a comparison."""

    priority: str
    margin: float | None


def compare_schemes(
    boat: Model | Vehicle,
    recordings: Sequence[Recording] = (),
    *,
    scheme: str = "auto",
    priority: str = PRIORITY,
    margin: float | None = None,
) -> AllocationComparison:
    """Every scheme on this boat; where geometry or limits exclude one, the reason.

    `scheme` is the requested one; it must be possible. Raises AllocationError.
    """
    # Thrusters of the boat, and the requested scheme: it scores the others
    own = effectiveness(boat)
    options = Options(priority=priority, margin=margin)
    demands = [own.requested_wrench(recording) for recording in recordings]
    chosen = Allocator(own, scheme, demands=np.vstack(demands) if demands else None, **options)
    # The recorded commands, and the baseline without the thrusters' curves
    rows = [_recorded(own, chosen, recordings)] if recordings else []
    plain = Allocator(own, "moore-penrose", invert=False, **options)
    rows.append(_row(PLAIN, plain, chosen, recordings))
    # Every scheme that geometry and limits allow; the reason where they do not
    for one in SCHEME_ORDER:
        try:
            allocator = Allocator(own, one.value, **options)
        except AllocationError as error:
            rows.append(Row(one.value, str(error), None, None))
            continue
        if allocator.scheme is one:  # fewest-crossings may be another one of them
            rows.append(_row(one.value, allocator, chosen, recordings))
    return AllocationComparison(chosen, tuple(rows), priority)


def crossings(commands: Array, edges: Array) -> Array:
    """How often each thruster (n,) enters its dead zone or jumps over it, in rows of commands (m, n).

    `edges` (2, n) forward and astern; at its edge a command is outside. Without a dead zone, only 0 is
    inside.
    """
    side = np.where(commands >= edges[0] - COMMAND_ROUNDING, 1, 0) - np.where(
        commands <= -edges[1] + COMMAND_ROUNDING, 1, 0
    )
    side = np.where((edges.sum(axis=0) == 0) & (np.abs(commands) <= COMMAND_ROUNDING), 0, side)
    before, after = side[:-1], side[1:]
    changed = (before != 0) & (after != before)
    return np.asarray(changed.sum(axis=0))


def authority(allocator: Allocator) -> Array:
    """(3, 2) largest wrench in surge, sway and yaw, one axis at a time, positive and negative [command units]."""
    both = np.vstack([np.eye(3), -np.eye(3)])
    return allocator.reach(both).reshape(2, 3).T


def yaw_beside_surge(allocator: Allocator) -> Array:
    """(m, 3) surge from full astern to full ahead, and the largest yaw to the right and to the left beside it.

    The differential limits of two thrusters, all in command units.
    """
    (ahead, astern) = authority(allocator)[0]
    rows = []
    for surge in (-astern, -0.5 * astern, 0.0, 0.5 * ahead, ahead):
        sides = [
            _most_beside(allocator, np.array([surge, 0.0, 0.0]), np.array([0.0, 0.0, sign]))
            for sign in (-1.0, 1.0)
        ]
        rows.append([surge, *sides])
    return np.array(rows)


def _most_beside(allocator: Allocator, base: Array, direction: Array) -> float:
    """The largest multiple of a direction (3,) that is attained beside a wrench (3,)."""
    low, high = 0.0, float(allocator.reach(direction[None, :])[0])
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        wrench = base + middle * direction
        inside = float(allocator.reach(wrench[None, :])[0]) >= 1.0 - COMMAND_ROUNDING
        low, high = (middle, high) if inside else (low, middle)
    return high


def _row(name: str, allocator: Allocator, judge: Allocator, recordings: Sequence[Recording]) -> Row:
    drives = []
    for recording in recordings:
        requested = allocator.boat.requested_wrench(recording)
        allocator.reset()
        commands, shares, _ = allocator.allot(requested)
        limited = shares.min(axis=1) < 1.0
        drives.append(_drive(judge, recording, requested, commands, limited))
    allocator.reset()
    return Row(name, allocator.why, allocator, authority(allocator), tuple(drives))


def _recorded(own: Effectiveness, judge: Allocator, recordings: Sequence[Recording]) -> Row:
    drives = []
    for recording in recordings:
        sent = own.sent_commands(recording)
        limited = np.zeros(len(sent), dtype=bool)
        drives.append(_drive(judge, recording, own.requested_wrench(recording), sent, limited))
    return Row(RECORDED, "the commands of the boat's own allocation", None, None, tuple(drives))


def _drive(
    judge: Allocator, recording: Recording, requested: Array, commands: Array, limited: Mask
) -> Drive:
    """Scores over time; `judge` knows curves and edges. A row of commands holds until the next."""
    held = _hold_times(recording.commands)
    weight = held / held.sum()
    minutes = float(held.sum()) / 60.0
    error = judge.wrench(commands) - requested
    count = crossings(commands, judge.edges) / minutes
    return Drive(
        recording.name,
        minutes,
        dict(zip(judge.thrusters, count.tolist(), strict=True)),
        np.sqrt(weight @ error**2),
        np.sqrt(weight @ requested**2),
        float(weight @ limited),
        float(weight @ judge.power(commands)),
        frozen_array(recording.seconds(recording.commands.stamps)),
        frozen_array(commands),
    )


def _hold_times(commands: Signal) -> Array:
    """(m,) duration of each row of commands [s]; the last: the median of the others."""
    if len(commands.stamps) < 2:
        raise AllocationError("the recording has one command; two or more are needed")
    gaps = np.diff(commands.stamps) * 1e-9
    return np.append(gaps, np.median(gaps))
