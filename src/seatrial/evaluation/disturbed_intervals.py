# SPDX-License-Identifier: MIT
"""Intervals in which something other than the thrusters moved the boat: a hand, a rope, a wall.

Process noise has one size for all recordings. Where innovations are far larger for a few seconds than everywhere
else, an external disturbance acted, which process noise does not describe.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial import _core
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.noise_parameters import OUTLIER
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

CELL_LENGTH = 2.0  # [s] resolution of an interval's ends
FEWEST_CELL_POSES = 5  # a cell with fewer has no mean square
LEAST_LIKELIHOOD_GAIN = 50.0  # of 2 log L, by larger errors there; chance reaches 5 to 22
LEAST_ERROR_RATIO = 1.35  # RMS innovation inside over outside: less hardly matters
MOST_DISTURBED_SHARE = 1 / 3  # of the poses: more are no exception, but model mismatch
# of that share must be left at the end; with less, the search ended for lack of room
LEAST_ROOM_LEFT = 0.1
MOST_INTERVALS = 20  # more are regular, not exceptions
JOINING_GAP = 6.0  # [s] between two intervals, or to an end: what lies there is disturbed, too
EVERY_LENGTH_TO = 30  # [cells] up to which every length is tried
LENGTH_GROWTH = 1.15  # from one length to the next beyond that


@dataclass(frozen=True)
class DisturbedInterval:
    """An interval in which innovations are larger than elsewhere."""

    recording: int
    start: float  # [s]
    end: float  # [s]
    times: float  # RMS of the normalised innovations inside, over outside
    gain: float  # of 2 log L, by larger errors there


def disturbed_intervals(
    recordings: Sequence[Recording], squares: Sequence[Array]
) -> list[DisturbedInterval]:
    """Intervals with larger innovations than elsewhere; none where these are no exceptions.

    squares: for every recording (n,) normalised innovations squared (NIS, 3 degrees of freedom) of its poses;
    NaN where a pose was not used.
    """
    cells = [error_cells(r, s) for r, s in zip(recordings, squares, strict=True)]
    limit = room = most_disturbed(cells)
    found: list[DisturbedInterval] = []
    while len(found) <= MOST_INTERVALS:
        best = clearest_interval(cells, room)
        if best.gain < LEAST_LIKELIHOOD_GAIN or best.times < LEAST_ERROR_RATIO:
            break
        found.append(best)
        own = cells[best.recording]
        inside = slice(round(best.start / own.length), round(best.end / own.length))
        room -= float(own.count[inside].sum())
        own.squares[inside] = own.count[inside] = 0.0
    joined = joined_intervals(found)
    return joined if len(joined) <= MOST_INTERVALS and room > LEAST_ROOM_LEFT * limit else []


def squared_innovations(passed: _core.FilterRun) -> Array:
    """Normalised innovations squared (n,) of a filter run; NaN where a pose was not used.

    They are limited at the outlier's limit: a single jump is no interval. A part that a pose has not, such as the
    heading of a position between two headings, counts for nothing.
    """
    used = np.asarray(passed.weight) > 0.0
    spread = np.asarray(passed.spread)[used]
    covariance = np.empty((len(spread), 3, 3))
    for k, (i, j) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))):
        covariance[:, i, j] = covariance[:, j, i] = spread[:, k]
    error = np.asarray(passed.innovation)[used]
    lacking = np.isnan(error)
    covariance[lacking[:, :, None] | lacking[:, None, :]] = 0.0
    covariance[:, range(3), range(3)] += lacking
    error = np.where(lacking, 0.0, error)
    whitened = np.linalg.solve(covariance, error[:, :, None])[..., 0]
    squares = np.full(len(used), np.nan)
    squares[used] = np.minimum(np.sum(error * whitened, axis=1), OUTLIER**2 + 3.0)
    return squares


def joined_intervals(found: Sequence[DisturbedInterval]) -> list[DisturbedInterval]:
    """Intervals in order; those with less than `JOINING_GAP` between them are one."""
    joined: list[DisturbedInterval] = []
    for s in sorted(found, key=lambda s: (s.recording, s.start)):
        before = joined[-1] if joined else None
        if before and before.recording == s.recording and s.start - before.end < JOINING_GAP:
            end, times = max(before.end, s.end), max(before.times, s.times)
            joined[-1] = replace(before, end=end, times=times, gain=before.gain + s.gain)
        else:
            joined.append(s)
    return joined


def interval_findings(
    recordings: Sequence[Recording], found: Sequence[DisturbedInterval]
) -> list[Finding]:
    """A finding for each: where it is in the recorded file, and how much larger the innovations are."""
    findings = []
    for s in found:
        start, end = _span(recordings[s.recording], s)
        name, kind = recordings[s.recording].name, FindingKind.DISTURBED_INTERVAL
        findings.append(finding_of(kind, name, start=start, end=end, ratio=s.times))
    return findings


@dataclass(frozen=True)
class CellErrors:
    """Squared innovations of one recording, summed over cells of equal length."""

    length: float  # [s]
    squares: Array  # (n,) sums of them
    count: Array  # (n,) how many


def error_cells(recording: Recording, squares: Array) -> CellErrors:
    """Of a recording's poses (n,); NaN: not used."""
    length = max(CELL_LENGTH, FEWEST_CELL_POSES * recording.period)
    cell = (recording.t // length).astype(np.int64)
    size, used = int(cell[-1]) + 1, np.isfinite(squares)
    sums, count = np.zeros(size), np.zeros(size)
    np.add.at(sums, cell[used], squares[used])
    np.add.at(count, cell[used], 3.0)
    return CellErrors(length, sums, count)


def most_disturbed(cells: Sequence[CellErrors]) -> float:
    """How many errors disturbed intervals may have; more are no exception."""
    return MOST_DISTURBED_SHARE * sum(float(c.count.sum()) for c in cells)


def clearest_interval(cells: Sequence[CellErrors], room: float) -> DisturbedInterval:
    """The interval with the largest gain in any recording, of at most `room` errors, significant or not."""
    whole = sum(float(c.squares.sum()) for c in cells), sum(float(c.count.sum()) for c in cells)
    largest = (_largest_in(i, c, whole, room) for i, c in enumerate(cells))
    return max(largest, key=lambda s: s.gain)


def _largest_in(
    recording: int, cells: CellErrors, whole: tuple[float, float], room: float
) -> DisturbedInterval:
    """The interval of one recording with the largest gain.

    whole: sum and number of the squared errors of all recordings; room: the most errors in an interval.
    """
    squares, count = whole
    sums = [np.concatenate([[0.0], np.cumsum(x)]) for x in (cells.squares, cells.count)]
    best = DisturbedInterval(recording, 0.0, 0.0, 0.0, 0.0)
    for length in _lengths(len(cells.count)):
        inside, of = (x[length:] - x[:-length] for x in sums)
        first = np.flatnonzero(
            (of >= 3.0 * FEWEST_CELL_POSES) & (of <= room) & (inside > 0.0) & (inside < squares)
        )
        if not len(first):
            continue
        inside, of = inside[first], of[first]
        there, elsewhere = inside / of, (squares - inside) / (count - of)
        gain = count * np.log(squares / count)
        gain = gain - of * np.log(there) - (count - of) * np.log(elsewhere)
        gain[there < elsewhere] = 0.0
        k = int(np.argmax(gain))
        if gain[k] > best.gain:
            begin, times = float(first[k]) * cells.length, float(np.sqrt(there[k] / elsewhere[k]))
            best = DisturbedInterval(
                recording, begin, begin + length * cells.length, times, float(gain[k])
            )
    return best


def _lengths(cells: int) -> list[int]:
    found = list(range(1, min(cells, EVERY_LENGTH_TO) + 1))
    while found[-1] * LENGTH_GROWTH < cells:
        found.append(int(found[-1] * LENGTH_GROWTH))
    return found


def _span(recording: Recording, stretch: DisturbedInterval) -> tuple[float, float]:
    """From and to [s] in the recorded file. An interval near the recording's start or end reaches to it."""
    start = 0.0 if stretch.start < JOINING_GAP else stretch.start
    end = recording.duration if stretch.end > recording.duration - JOINING_GAP else stretch.end
    first, last = (
        np.floor(10.0 * (recording.offset + start)),
        np.ceil(10.0 * (recording.offset + end)),
    )
    return float(first) / 10.0, float(last) / 10.0
