# SPDX-License-Identifier: MIT
"""Start values without help: weak-form least squares over a scan of the chain's constants.

The weak form is linear in the coefficients once latency, lag and dead zone are fixed, and cheap:
each of these is scanned and the one with the smallest residual kept.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.identification.regression.weak_rows import Weighed, Widths, choose_widths, weighed
from seatrial.recording.pose_faults import usual_step
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError, RecordingError
from seatrial.util.frames import Array, Mask

FINEST = 1 / 30  # [s]
OUTLIER = 1.5  # [robust spreads] from which on a row counts linearly
ENOUGH = 610.0  # [s] of recordings for a start
PIECE = 100.0  # [s]
DEAD = 1e-9  # RMS of a column from which on it is more than rounding
RIDGE = 1e-8  # of the scaled normal matrix, so that what is not excited stays near 0
DELAYS = (-0.5, -0.2, 0.1, 0.4, 0.8)  # [s] latency
LAGS = (0.02, 0.1, 0.2, 0.4, 0.8)  # [s] where the latency is given
EDGES = (0.0, 0.08, 0.16, 0.3)
STEPS = 2  # of Gauss-Newton
LEAST_SPREAD = 1e-9  # [m/s^2, rad/s^2] of residuals, where there is no noise
CLOSE = (
    0.5  # a tenth of the steps between poses is shorter than this share of the usual: uneven stamps
)
SETTLED = 1e-4  # share of the cost that a step is worth


@dataclass(frozen=True)
class Change:
    """How far a constant may be moved."""

    probe: float  # for its derivative
    most: float  # in one step
    low: float
    high: float
    grid: tuple[float, ...]  # where to look first


CHANGES = {
    "latency": Change(0.02, 0.15, -1.0, 2.0, DELAYS),  # [s]
    "lag": Change(0.02, 0.15, 0.01, 2.0, LAGS),  # [s]
    "edge_forward": Change(0.02, 0.08, 0.0, 0.6, EDGES),
    "edge_reverse": Change(0.02, 0.08, 0.0, 0.6, EDGES),
    "pair_dead_zone": Change(0.02, 0.08, 0.0, 0.6, EDGES),
    "pair_offset_along": Change(0.02, 0.08, -0.5, 0.5, ()),
    "pair_offset_across": Change(0.02, 0.08, -0.5, 0.5, ()),
}


class Equations(Protocol):
    """Equations linear in the coefficients, for given constants of the chain."""

    @property
    def vehicle(self) -> Vehicle:
        """Whose constants they are."""

    @property
    def use(self) -> Mask:
        """(m, 3) rows that count."""

    def design(self, constants: Array) -> "Design":
        """The equations for these constants."""


@dataclass(frozen=True)
class Rows:
    """All windows of all recordings."""

    vehicle: Vehicle
    each: tuple[Weighed, ...]
    left: Array  # (m, 3) accelerations
    steady: Array  # (m, 3, n + 1) what the chain's constants do not change
    use: Mask  # (m, 3) rows that count
    widths: Widths

    def design(self, constants: Array) -> "Design":
        """The equations for these constants."""
        columns = self.steady + np.concatenate([w.driven(constants) for w in self.each])
        return Design(self.left - columns[:, :, -1], columns[:, :, :-1])


@dataclass(frozen=True)
class Design:
    """a = B theta."""

    a: Array  # (m, 3)
    B: Array  # (m, 3, n)

    def solved(self, weights: Array) -> Array:
        """Weighted least squares (n,); what no row speaks of is 0."""
        flat = self.B.reshape(-1, self.B.shape[2])
        weighted = flat * weights.reshape(-1, 1)
        normal = flat.T @ weighted
        alive = np.linalg.norm(flat, axis=0) > DEAD * np.sqrt(len(flat))
        size = np.where(alive, np.sqrt(np.diag(normal)) + 1e-12, np.inf)
        scaled = normal / np.outer(size, size) + RIDGE * np.eye(len(size))
        return np.asarray(np.linalg.solve(scaled, weighted.T @ self.a.ravel() / size) / size)

    def cost(self, theta: Array, weights: Array) -> float:
        """Weighted sum of squared residuals."""
        return float(np.sum(weights * (self.a - self.B @ theta) ** 2))

    def weights(self, use: Mask) -> Array:
        """Huber's weights (m, 3) over the squared robust spread of each axis' residuals."""
        spread = np.array([np.std(self.a[use[:, k], k]) for k in range(3)]) + 1e-12
        weights: Array = use / spread**2
        for _ in range(4):
            error = np.abs(self.a - self.B @ self.solved(weights))
            middle = [np.median(error[use[:, k], k]) for k in range(3)]
            spread = np.array(middle) / 0.6745 + LEAST_SPREAD
            weights = use / np.maximum(1.0, error / spread / OUTLIER) / spread**2
        return weights


@dataclass(frozen=True)
class Found:
    """Where the search ended."""

    theta: Array  # (n,)
    constants: Array  # (m,)
    design: Design
    weights: Array  # (m, 3)


def start_values(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    free: Sequence[int] = (),
    *,
    widths: Widths | None = None,
) -> tuple[Array, Array]:
    """Coefficients (n,) and constants (m,) of the chain to start a search from.

    `free`: those of `vehicle.constants` that may be changed; of these latency, lag and dead-zone
    edges are. Lag and latency are hardly told apart, their sum is sharp. `widths`: of the windows, by
    default what suits the recordings.
    Raises IdentificationError where no recording has a stretch without drop-outs.
    """
    rows = gathered([evened(r) for r in pieces(recordings)], vehicle, FINEST, widths=widths)
    found = search(rows, changes(vehicle, free), STEPS)
    return found.theta, found.constants


def pieces(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings, or where they are long, pieces spread over them: enough for a start."""
    total = sum(r.duration for r in recordings)
    if total <= ENOUGH:
        return list(recordings)
    every = PIECE * total / ENOUGH
    found = []
    for r in recordings:
        for t in np.arange(0.0, max(r.duration - PIECE, every), every):
            with suppress(RecordingError):  # a piece without poses
                found.append(r.cut(float(t), float(t) + PIECE))
    return found or list(recordings)


def evened(recording: Recording) -> Recording:
    """A recording whose poses often come close together, at even stamps between them: for a start."""
    t, good = recording.t, recording.valid
    steps = np.diff(t[good])
    if np.percentile(steps, 10) > CLOSE * usual_step(steps):
        return recording
    even = np.arange(0.0, t[good][-1], float(np.mean(steps)))
    place = np.maximum(np.searchsorted(t[good], even, side="right") - 1, 0)
    segment = recording.segment[good]
    inside = segment[place] == segment[np.minimum(place + 1, len(segment) - 1)]
    inside &= even >= t[good][0]
    eta = np.column_stack([np.interp(even, t[good], column) for column in recording.eta[good].T])
    stamps = recording.origin + np.round(1e9 * even).astype(np.int64)
    return replace(recording, stamps=stamps, eta=eta, raw=eta, valid=inside, segment=segment[place])


def gathered(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    finest: float,
    serves: Sequence[Sequence[bool]] = (),
    *,
    widths: Widths | None = None,
) -> Rows:
    """The windows of all recordings that have one, by default as wide as suits them.

    `serves`: for every recording, whether it serves surge, sway and yaw; all by default.
    """
    if not recordings:
        raise IdentificationError("no recording given; pass at least one")
    widths = choose_widths(recordings) if widths is None else widths
    each, use, why = [], [], ""
    for i, recording in enumerate(recordings):
        try:
            found = weighed(vehicle, recording, widths, finest)
        except IdentificationError as error:  # the others may do
            why = str(error)
            continue
        each.append(found)
        mine = serves[i] if serves else (True, True, True)
        use.append(np.tile(np.array(mine, dtype=bool), (len(found.left), 1)))
    if not each:
        raise IdentificationError(why)
    left, steady = (np.concatenate(p) for p in ([w.left for w in each], [w.steady for w in each]))
    return Rows(vehicle, tuple(each), left, steady, np.concatenate(use), widths)


def changes(vehicle: Vehicle, free: Sequence[int]) -> dict[int, Change]:
    """Which constants are moved, and how far."""
    stage = {i: vehicle.constants.names[i].partition(".")[0] for i in free}
    found = {i: CHANGES[s] for i, s in stage.items() if s in CHANGES}
    delayed = any(c.grid == DELAYS for c in found.values())
    # the delay is looked for by one of the two, lag and latency are told apart later
    return {i: replace(c, grid=()) if delayed and c.grid == LAGS else c for i, c in found.items()}


def search(rows: Equations, moved: Mapping[int, Change], steps: int) -> Found:
    """Coefficients and constants: a coarse scan, then so many Gauss-Newton steps at most."""
    constants = rows.vehicle.constants.values.copy()
    weights = rows.design(constants).weights(rows.use)
    for grid in (DELAYS, LAGS, EDGES):
        places = [i for i, change in moved.items() if change.grid == grid]
        if places:
            constants = _scanned(rows, weights, constants, places, grid)
    return _refined(rows, constants, moved, steps if moved else 0)


def widened(rows: Equations, at: Found, moved: Mapping[int, Change]) -> Design:
    """The equations with columns for steps of the constants behind those of the coefficients."""
    columns = []
    for i, change in moved.items():
        probe = rows.design(_placed(at.constants, [i], at.constants[i] + change.probe))
        tilt = (probe.B - at.design.B) @ at.theta - (probe.a - at.design.a)
        columns.append(tilt[:, :, None] / change.probe)
    return Design(at.design.a, np.concatenate([at.design.B, *columns], axis=2))


def _scanned(
    rows: Equations, weights: Array, constants: Array, places: Sequence[int], grid: Sequence[float]
) -> Array:
    """The constants with those at `places` at the grid's best, or between it and its neighbours."""
    costs = []
    for value in grid:
        design = rows.design(_placed(constants, places, value))
        costs.append(design.cost(design.solved(weights), weights))
    i = int(np.argmin(costs))
    inside = 0 < i < len(grid) - 1
    best = _lowest(grid[i - 1 : i + 2], costs[i - 1 : i + 2]) if inside else grid[i]
    return _placed(constants, places, best)


def _refined(rows: Equations, constants: Array, moved: Mapping[int, Change], steps: int) -> Found:
    """Gauss-Newton steps on coefficients and constants together; the coefficients' are exact."""
    at = _settled(rows, constants)
    for _ in range(steps):
        step = widened(rows, at, moved).solved(at.weights)[len(at.theta) :]
        before = at.design.cost(at.theta, at.weights)
        for share in (1.0, 0.3):
            trial = _moved(at.constants, moved, share * step)
            design = rows.design(trial)
            after = design.cost(design.solved(at.weights), at.weights)
            if after < before:
                at = _settled(rows, trial, design)
                break
        if after > (1 - SETTLED) * before:
            break
    return at


def _moved(constants: Array, moved: Mapping[int, Change], step: Array) -> Array:
    out = constants.copy()
    for (i, c), s in zip(moved.items(), step, strict=True):
        out[i] = np.clip(out[i] + np.clip(s, -c.most, c.most), c.low, c.high)
    return out


def _settled(rows: Equations, constants: Array, design: Design | None = None) -> Found:
    there = design or rows.design(constants)
    weights = there.weights(rows.use)
    return Found(there.solved(weights), constants, there, weights)


def _placed(constants: Array, places: Sequence[int], value: float) -> Array:
    out = constants.copy()
    out[list(places)] = value
    return out


def _lowest(x: Sequence[float], y: Sequence[float]) -> float:
    """Where the parabola through three points, the middle one the lowest, is lowest."""
    left, right = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    bend = (right - left) / (x[2] - x[0])
    if bend <= 0:
        return x[1]
    return float(np.clip((x[0] + x[1]) / 2 - left / (2 * bend), x[0], x[2]))
