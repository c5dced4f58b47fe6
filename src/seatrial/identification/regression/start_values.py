# SPDX-License-Identifier: MIT
"""Start values for the maximum-likelihood search, from the recordings alone.

The weak form is linear in the coefficients once latency, lag and dead zone are fixed, and cheap to solve. In the
lever arm it is linear but for the drag: a few Gauss-Newton steps find it from 0, whatever its length.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.identification.regression.linear_equations import (
    LinearEquations,
    fit_equations,
    movable_constants,
)
from seatrial.identification.regression.weak_rows import Widths, Windows, choose_widths, windows_of
from seatrial.recording.faults.pose_faults import usual_step
from seatrial.recording.origin import poses_of_origin
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError, RecordingError
from seatrial.util.frames import Array, Mask

START_GRID_STEP = 1 / 30  # [s] of the weak form's integrals
START_DURATION = 610.0  # [s] of recordings that are enough for start values
PIECE_DURATION = 100.0  # [s] of the pieces that longer recordings are represented by
START_CHAIN_STEPS = 2  # Gauss-Newton steps


@dataclass(frozen=True)
class WindowRows:
    """All windows of all recordings."""

    vehicle: Vehicle
    each: tuple[Windows, ...]
    left: Array  # (m, 3) accelerations
    steady: Array  # (m, 3, n + 1) columns that do not depend on the chain's constants
    use: Mask  # (m, 3) rows that count
    widths: Widths

    def design(self, constants: Array) -> "LinearEquations":
        """The equations for these constants."""
        columns = self.steady + np.concatenate([w.driven(constants) for w in self.each])
        return LinearEquations(self.left - columns[:, :, -1], columns[:, :, :-1])


def start_values(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    free: Sequence[int] = (),
) -> tuple[Array, Array]:
    """Coefficients (n,) and constants (m,) of the chain to start a search from.

    `free`: indices of `vehicle.constants` that may change; latency, lag and dead-zone edges do. Lag and latency
    are hardly separable, their sum is well known.
    Raises IdentificationError where no recording is long enough without drop-outs.
    """
    rows = window_rows(
        [at_even_stamps(r) for r in spread_pieces(recordings)],
        vehicle,
        START_GRID_STEP,
    )
    found = fit_equations(rows, movable_constants(vehicle, free), START_CHAIN_STEPS)
    return found.theta, found.constants


def spread_pieces(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings, or evenly spread pieces of long ones."""
    total = sum(r.duration for r in recordings)
    if total <= START_DURATION:
        return list(recordings)
    every = PIECE_DURATION * total / START_DURATION
    found = []
    for r in recordings:
        for t in np.arange(0.0, max(r.duration - PIECE_DURATION, every), every):
            with suppress(RecordingError):  # a piece without poses
                found.append(r.cut(float(t), float(t) + PIECE_DURATION))
    return found or list(recordings)


def at_even_stamps(recording: Recording) -> Recording:
    """The recording; if its stamps are uneven, resampled at even stamps."""
    t, good = recording.t, recording.valid
    steps = np.diff(t[good])
    if np.percentile(steps, 10) > 0.5 * usual_step(steps):
        return recording
    even = np.arange(0.0, t[good][-1], float(np.mean(steps)))
    place = np.maximum(np.searchsorted(t[good], even, side="right") - 1, 0)
    segment = recording.segment[good]
    inside = segment[place] == segment[np.minimum(place + 1, len(segment) - 1)]
    inside &= even >= t[good][0]
    eta = np.column_stack([np.interp(even, t[good], column) for column in recording.eta[good].T])
    stamps = recording.origin + np.round(1e9 * even).astype(np.int64)
    return replace(
        recording, stamps=stamps, eta=eta, raw=eta, valid=inside, segment=segment[place],
        parts=None, asynchronous=None,
    )  # fmt: skip


def window_rows(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    finest: float,
    serves: Sequence[Sequence[bool]] = (),
    *,
    widths: Widths | None = None,
) -> WindowRows:
    """The windows of all recordings that are long enough; `widths` are chosen from them by default.

    `serves`: for every recording, whether it serves surge, sway and yaw; all by default.
    """
    if not recordings:
        raise IdentificationError("no recording given; pass at least one")
    widths = choose_widths(recordings) if widths is None else widths
    each, use, why = [], [], ""
    for i, recording in enumerate(recordings):
        try:
            found = windows_of(vehicle, recording, widths, finest)
        except IdentificationError as error:  # other recordings may be long enough
            why = str(error)
            continue
        each.append(found)
        mine = serves[i] if serves else (True, True, True)
        use.append(np.tile(np.array(mine, dtype=bool), (len(found.left), 1)))
    if not each:
        raise IdentificationError(why)
    left, steady = (np.concatenate(p) for p in ([w.left for w in each], [w.steady for w in each]))
    return WindowRows(vehicle, tuple(each), left, steady, np.concatenate(use), widths)


def lever_from_poses(
    recordings: Sequence[Recording], vehicle: Vehicle, free: Sequence[int] = ()
) -> Array:
    """The lever arm (2,) [m], forward and left; `free` as in `start_values`.

    Raises IdentificationError where no recording is long enough without drop-outs.
    """
    whole = [at_even_stamps(r) for r in spread_pieces(recordings)]
    widths = choose_widths(whole)

    def residual(lever: Array) -> Array:
        """Residual accelerations (m,) in surge and sway with the best coefficients."""
        moved = window_rows(
            [poses_of_origin(r, lever) for r in whole], vehicle, START_GRID_STEP, widths=widths
        )
        found = fit_equations(moved, movable_constants(vehicle, free), START_CHAIN_STEPS)
        error = found.design.a - found.design.B @ found.theta
        return np.asarray(error[:, :2].ravel())

    lever = np.zeros(2)
    here = residual(lever)
    for _ in range(5):
        slopes = np.column_stack(
            [(residual(lever + 0.1 * e) - here) / 0.1 for e in np.eye(2)]  # [m]
        )
        further = lever - np.linalg.lstsq(slopes, here, rcond=None)[0]
        there = residual(further)
        if np.linalg.norm(there) > 0.99 * np.linalg.norm(here):
            break
        lever, here = further, there
    return lever
