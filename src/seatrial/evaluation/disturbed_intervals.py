# SPDX-License-Identifier: MIT
"""Stretches in which something else than its thrusters moved the boat: a hand, a rope, a wall.

A filter's noise is one number for all of the recordings. Where its errors are far larger for a few seconds
than everywhere else, what the model leaves out is no noise.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from seatrial import _core
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.noise_parameters import OUTLIER
from seatrial.recording.recording import Recording
from seatrial.util.frames import Array

CELL = 2.0  # [s] to which a stretch is known
CELL_POSES = 5  # at the least, in a cell
GAIN = 50.0  # of twice the log likelihood that errors are larger there; chance makes 5 to 22 of it
TIMES = 1.35  # as large, at the least
MOST = 1 / 3  # of the poses can be exceptional:
FILLED = 0.1  # of that may be left: then it was more
MANY = 20  # stretches are the habit
NEAR = 6.0  # [s] what is between two of them, or from one to an end, is no better
SHORT, GROWTH = 30, 1.15  # cells up to which every length is looked at, and by what they grow then


@dataclass(frozen=True)
class Stretch:
    """Where poses are further from what a filter predicts than elsewhere."""

    recording: int
    start: float  # [s]
    end: float  # [s]
    times: float  # as far, root mean square
    gain: float  # of twice the log likelihood, of larger errors there


def stretches(recordings: Sequence[Recording], squares: Sequence[Array]) -> list[Stretch]:
    """Those in which errors are larger than elsewhere; none where they are no exceptions.

    squares: of every recording the squared errors (n,) of its poses by their covariance, three of each; NaN
    where a pose was not used.
    """
    cells = [_cells(r, s) for r, s in zip(recordings, squares, strict=True)]
    limit = room = MOST * sum(float(c.count.sum()) for c in cells)
    found: list[Stretch] = []
    while len(found) <= MANY:
        best = _clearest(cells, room)
        if best.gain < GAIN or best.times < TIMES:
            break
        found.append(best)
        own = cells[best.recording]
        inside = slice(round(best.start / own.length), round(best.end / own.length))
        room -= float(own.count[inside].sum())
        own.squares[inside] = own.count[inside] = 0.0
    joined = together(found)
    return joined if len(joined) <= MANY and room > FILLED * limit else []


def clearest(recordings: Sequence[Recording], squares: Sequence[Array]) -> Stretch:
    """The stretch that stands out most, be that by chance."""
    cells = [_cells(r, s) for r, s in zip(recordings, squares, strict=True)]
    return _clearest(cells, MOST * sum(float(c.count.sum()) for c in cells))


def squared_errors(passed: _core.FilterRun) -> Array:
    """Squared errors (n,) of a filter's poses by its covariance; NaN where a pose was not used.

    An outlier counts no more than what is about to be one: a jump is no stretch.
    """
    used = np.asarray(passed.weight) > 0.0
    spread = np.asarray(passed.spread)[used]
    covariance = np.empty((len(spread), 3, 3))
    for k, (i, j) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))):
        covariance[:, i, j] = covariance[:, j, i] = spread[:, k]
    error = np.asarray(passed.innovation)[used]
    whitened = np.linalg.solve(covariance, error[:, :, None])[..., 0]
    squares = np.full(len(used), np.nan)
    squares[used] = np.minimum(np.sum(error * whitened, axis=1), OUTLIER**2 + 3.0)
    return squares


def together(found: Sequence[Stretch]) -> list[Stretch]:
    """Stretches in order; those with little between them are one."""
    joined: list[Stretch] = []
    for s in sorted(found, key=lambda s: (s.recording, s.start)):
        before = joined[-1] if joined else None
        if before and before.recording == s.recording and s.start - before.end < NEAR:
            end, times = max(before.end, s.end), max(before.times, s.times)
            joined[-1] = replace(before, end=end, times=times, gain=before.gain + s.gain)
        else:
            joined.append(s)
    return joined


def stretches_found(recordings: Sequence[Recording], found: Sequence[Stretch]) -> list[Finding]:
    """Where they are in the recorded files, and how much larger the errors are."""
    findings = []
    for s in found:
        start, end = _span(recordings[s.recording], s)
        name, kind = recordings[s.recording].name, FindingKind.DISTURBED_INTERVAL
        findings.append(finding_of(kind, name, start=start, end=end, ratio=s.times))
    return findings


@dataclass(frozen=True)
class _Cells:
    """The errors of one recording, over equal times."""

    length: float  # [s]
    squares: Array  # (n,) sums of them
    count: Array  # (n,) how many


def _cells(recording: Recording, squares: Array) -> _Cells:
    length = max(CELL, CELL_POSES * recording.period)
    cell = (recording.t // length).astype(np.int64)
    size, used = int(cell[-1]) + 1, np.isfinite(squares)
    sums, count = np.zeros(size), np.zeros(size)
    np.add.at(sums, cell[used], squares[used])
    np.add.at(count, cell[used], 3.0)
    return _Cells(length, sums, count)


def _clearest(cells: Sequence[_Cells], room: float) -> Stretch:
    """Of all recordings, with at most `room` errors in it."""
    whole = sum(float(c.squares.sum()) for c in cells), sum(float(c.count.sum()) for c in cells)
    largest = (_largest(i, c, whole, room) for i, c in enumerate(cells))
    return max(largest, key=lambda s: s.gain)


def _largest(recording: int, cells: _Cells, whole: tuple[float, float], room: float) -> Stretch:
    """The stretch of one recording whose errors are most clearly larger than all others.

    whole: sum and number of all; room: how many a stretch may have.
    """
    squares, count = whole
    sums = [np.concatenate([[0.0], np.cumsum(x)]) for x in (cells.squares, cells.count)]
    best = Stretch(recording, 0.0, 0.0, 0.0, 0.0)
    for length in _lengths(len(cells.count)):
        inside, of = (x[length:] - x[:-length] for x in sums)
        first = np.flatnonzero(
            (of >= 3.0 * CELL_POSES) & (of <= room) & (inside > 0.0) & (inside < squares)
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
            best = Stretch(recording, begin, begin + length * cells.length, times, float(gain[k]))
    return best


def _lengths(cells: int) -> list[int]:
    """Numbers of cells to look at together."""
    found = list(range(1, min(cells, SHORT) + 1))
    while found[-1] * GROWTH < cells:
        found.append(int(found[-1] * GROWTH))
    return found


def _span(recording: Recording, stretch: Stretch) -> tuple[float, float]:
    """From and to [s] in the recorded file; what is near the recording's start or end begins or ends there."""
    start = 0.0 if stretch.start < NEAR else stretch.start
    end = recording.duration if stretch.end > recording.duration - NEAR else stretch.end
    first, last = (
        np.floor(10.0 * (recording.offset + start)),
        np.ceil(10.0 * (recording.offset + end)),
    )
    return float(first) / 10.0, float(last) / 10.0
