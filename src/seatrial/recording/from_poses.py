# SPDX-License-Identifier: MIT
"""A recording from raw poses and commands: what repeats is left out, faults are found and masked."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seatrial.recording.asynchronous import Asynchronous, split_rates
from seatrial.recording.faults.pose_faults import Fault, FaultKind, examine, silences
from seatrial.recording.recording import Recording, Source
from seatrial.recording.signal import Signal
from seatrial.recording.timing import Stream, only_changes
from seatrial.util.errors import RecordingError
from seatrial.util.frames import Array, Mask, Stamps


def make_recording(
    name: str,
    stamps: Stamps,
    eta: Array,
    commands: Signal,
    *,
    scales: Signal | None = None,
    marked_valid: Mask | None = None,
    timeout: float | None = None,
    sources: Sequence[Source] = (),
    streams: Sequence[Stream] = (),
    remarks: Sequence[str] = (),
    doubts: Sequence[str] = (),
    position_delay: float = 0.0,
    parts: NDArray[np.int8] | None = None,
    asynchronous: Asynchronous | None = None,
    paused: Sequence[int] = (),
) -> Recording:
    """A recording from raw poses: heading unwrapped, faults detected and masked.

    stamps (n,) [ns]; eta (n, 3) x, y [m], psi [rad], forward-left-up. position_delay [s]: positions are
    this much older than the stamps, which are the headings' times. Commands are unknown after
    `timeout` seconds without any, and while one is not a number. parts (n,), asynchronous: of sensors with
    stamps of their own; without them the rows themselves show what is new. paused: [ns] stamps of commands that
    are no number as the recorder paused. Raises RecordingError.
    """
    if len(stamps) < 2:
        raise RecordingError(f"{name}: {len(stamps)} poses; record a few seconds at least")
    # 1. Rows that only repeat the last position or heading.
    if parts is None:
        fresh = split_rates(stamps, eta, marked_valid)
        stamps, eta, parts = fresh.stamps, fresh.eta, fresh.parts
        remarks = [*remarks, *fresh.remarks]
        marked_valid = None if marked_valid is None else marked_valid[fresh.rows]
        if fresh.asynchronous is not None:
            asynchronous = fresh.asynchronous.joined(asynchronous)
    # 2. Faults of the poses.
    found = examine(name, stamps, eta, marked_valid)
    # 3. Intervals with unknown commands: poses in them are masked.
    kept = found.in_order
    driven = _driven(name, found.t, commands, stamps[kept][0], timeout, paused=paused)
    streams = [
        replace(s, on_change=s.on_change or (s.role == "commands" and driven.on_change))
        for s in streams
    ]
    # 4. Poses with rising stamps.
    faults = sorted([*found.faults, *driven.faults], key=lambda f: f.start)
    return Recording(
        name, stamps[kept], found.eta[kept], eta[kept], (found.valid & ~driven.hidden)[kept],
        found.segment[kept], driven.commands, scales, tuple(faults),
        tuple(sources), tuple(streams), tuple(remarks), tuple(doubts), position_delay=position_delay,
        parts=None if parts is None else parts[kept], asynchronous=asynchronous,
    )  # fmt: skip


@dataclass(frozen=True)
class _Driven:
    """Commands without the rows that are no numbers, and where they are unknown."""

    commands: Signal
    on_change: bool  # whether these are logged only where they change
    faults: Sequence[Fault]
    hidden: Mask  # (n,) poses without known commands


def _driven(
    name: str,
    t: Array,
    commands: Signal,
    origin: np.int64,
    timeout: float | None,
    *,
    paused: Sequence[int],
) -> _Driven:
    """Of poses at t (n,) [s] from `origin` [ns]."""
    finite, unknown = _finite_rows(commands)
    held, not_finite = ((some - origin).astype(float) * 1e-9 for some in (finite.stamps, unknown))
    if not len(held):
        return _Driven(finite, False, (), np.zeros(len(t), dtype=bool))
    silent = silences(name, t, held, finite.values, timeout)
    holes = [(FaultKind.SILENT, *hole) for hole in silent]
    for (stamp, _), (begin, end) in zip(unknown.tolist(), not_finite.tolist(), strict=True):
        if begin < t[-1] and end > 0:
            kind = FaultKind.PAUSED if stamp in paused else FaultKind.NO_NUMBER
            holes.append((kind, begin, end))
    return _Driven(finite, only_changes(held, finite.values), *_unknown_commands(t, holes))


def _unknown_commands(
    t: Array, holes: Sequence[tuple[FaultKind, float, float]]
) -> tuple[list[Fault], Mask]:
    """Faults, and the poses (n,) at t (n,) [s] in them; holes: of the commands, their kind, begin and end [s]."""
    faults, hidden = [], np.zeros(len(t), dtype=bool)
    for kind, begin, end in holes:
        inside = (t >= begin) & (t < end)
        hidden |= inside
        until = float(min(end, t[-1]))
        faults.append(Fault(kind, max(0.0, float(begin)), until, int(inside.sum())))
    return faults, hidden


def _finite_rows(commands: Signal) -> tuple[Signal, Stamps]:
    """The finite rows, and the intervals (k, 2) [ns] from another row to the next finite one."""
    good = np.asarray(np.isfinite(commands.values).all(axis=1))
    if good.all():
        return commands, np.zeros((0, 2), dtype=np.int64)
    rows = np.flatnonzero(~good)
    first = rows[np.diff(rows, prepend=-2) > 1]
    later = np.append(np.flatnonzero(good), len(good))
    after = later[np.searchsorted(later, first)]
    ends = np.append(commands.stamps, np.iinfo(np.int64).max // 2)[after]
    known = Signal(commands.names, commands.stamps[good], commands.values[good])
    return known, np.column_stack([commands.stamps[first], ends])
