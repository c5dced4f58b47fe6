# SPDX-License-Identifier: MIT
"""Start values without help: weak-form least squares over a scan of the chain's constants.

The weak form is linear in the coefficients once latency, lag and dead zone are fixed, and cheap:
each of these is scanned and the one with the smallest residual kept.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.errors import IdentificationError
from seatrial.frames import Array
from seatrial.identify.weak_rows import Weighed, choose_widths, weighed
from seatrial.recording import Recording
from seatrial.vehicle import Vehicle

FINEST = 1 / 30  # [s]
OUTLIER = 1.5  # [robust spreads] from which on a row counts linearly
RIDGE = 1e-8  # of the scaled normal matrix, so that what is not excited stays near 0
DELAYS = (-0.5, -0.2, 0.1, 0.4, 0.8)  # [s] latency
LAGS = (0.02, 0.1, 0.2, 0.4, 0.8)  # [s] where the latency is given
EDGES = (0.0, 0.08, 0.16, 0.3)
REFINED = 2  # Gauss-Newton steps at most
SETTLED = 1e-3  # share of the cost that the next is worth


@dataclass(frozen=True)
class Change:
    """How far a constant may be moved."""

    probe: float  # for its derivative
    most: float  # in one step
    low: float
    high: float


CHANGES = {
    "latency": Change(0.02, 0.15, -1.0, 2.0),  # [s]
    "lag": Change(0.02, 0.15, 0.002, 2.0),  # [s]
    "edge_forward": Change(0.02, 0.08, 0.0, 0.6),
    "edge_reverse": Change(0.02, 0.08, 0.0, 0.6),
}


@dataclass(frozen=True)
class Rows:
    """All windows of all recordings."""

    each: tuple[Weighed, ...]
    left: Array  # (m, 3) accelerations
    steady: Array  # (m, 3, n + 1) what the chain's constants do not change

    def design(self, constants: Array) -> tuple[Array, Array]:
        """a (m, 3) and B (m, 3, n) of a = B theta."""
        columns = self.steady + np.concatenate([w.driven(constants) for w in self.each])
        return self.left - columns[:, :, -1], columns[:, :, :-1]


def start_values(
    recordings: Sequence[Recording], vehicle: Vehicle, free: Sequence[int] = ()
) -> tuple[Array, Array]:
    """Coefficients (n,) and constants (m,) of the chain to start a search from.

    `free`: those of `vehicle.constants` that may be changed; of these latency, lag and dead-zone
    edges are. Where latency and lag are both free the lag stays and the latency takes the sum.
    Raises IdentificationError where no recording has a stretch without drop-outs.
    """
    rows = _rows(recordings, vehicle)
    constants = vehicle.constants.values.copy()
    stage = {i: vehicle.constants.names[i].partition(".")[0] for i in free}
    latency = [i for i in free if stage[i] == "latency"]
    lag = [] if latency else [i for i in free if stage[i] == "lag"]
    edges = [i for i in free if stage[i].startswith("edge")]
    weights = _weights(*rows.design(constants))
    for places, grid in ((latency, DELAYS), (lag, LAGS), (edges, EDGES)):
        if places:
            constants = _scanned(rows, weights, constants, places, grid)
    changes = {i: CHANGES[stage[i]] for i in (*latency, *lag, *edges)}
    theta, constants = _refined(rows, constants, changes)
    return theta, constants


def _rows(recordings: Sequence[Recording], vehicle: Vehicle) -> Rows:
    widths = choose_widths(recordings)
    each, why = [], "no recording given; pass at least one"
    for recording in recordings:
        try:
            each.append(weighed(vehicle, recording, widths, FINEST))
        except IdentificationError as error:  # the others may do
            why = str(error)
    if not each:
        raise IdentificationError(why)
    left, steady = (np.concatenate(p) for p in ([w.left for w in each], [w.steady for w in each]))
    return Rows(tuple(each), left, steady)


def _solved(a: Array, B: Array, weights: Array) -> Array:
    """Weighted least squares (n,); what no row speaks of is 0."""
    flat = B.reshape(-1, B.shape[2])
    weighted = flat * weights.reshape(-1, 1)
    normal = flat.T @ weighted
    size = np.sqrt(np.diag(normal)) + 1e-12
    scaled = normal / np.outer(size, size) + RIDGE * np.eye(len(size))
    return np.asarray(np.linalg.solve(scaled, weighted.T @ a.ravel() / size) / size)


def _weights(a: Array, B: Array) -> Array:
    """Huber's weights (m, 3) over the squared robust spread of each axis' residuals."""
    spread = np.std(a, axis=0) + 1e-12
    weights: Array = np.ones_like(a) / spread**2
    for _ in range(4):
        error = np.abs(a - B @ _solved(a, B, weights))
        spread = np.median(error, axis=0) / 0.6745 + 1e-9
        weights = 1.0 / np.maximum(1.0, error / spread / OUTLIER) / spread**2
    return weights


def _scanned(
    rows: Rows, weights: Array, constants: Array, places: Sequence[int], grid: Sequence[float]
) -> Array:
    """The constants with those at `places` at the grid's best, or between it and its neighbours."""
    costs = []
    for value in grid:
        a, B = rows.design(_placed(constants, places, value))
        costs.append(_cost(a, B, _solved(a, B, weights), weights))
    i = int(np.argmin(costs))
    inside = 0 < i < len(grid) - 1
    best = _lowest(grid[i - 1 : i + 2], costs[i - 1 : i + 2]) if inside else grid[i]
    return _placed(constants, places, best)


def _refined(rows: Rows, constants: Array, changes: Mapping[int, Change]) -> tuple[Array, Array]:
    """Coefficients and constants after Gauss-Newton steps on both, the first linear."""
    a, B = rows.design(constants)
    weights = _weights(a, B)
    theta = _solved(a, B, weights)
    for _ in range(REFINED if changes else 0):
        probes = []
        for i, change in changes.items():
            a_i, B_i = rows.design(_placed(constants, [i], constants[i] + change.probe))
            probes.append(((B_i - B) @ theta - (a_i - a)) / change.probe)
        wide = np.concatenate([B, np.stack(probes, axis=2)], axis=2)
        trial = constants.copy()
        for (i, c), step in zip(
            changes.items(), _solved(a, wide, weights)[len(theta) :], strict=True
        ):
            trial[i] = np.clip(trial[i] + np.clip(step, -c.most, c.most), c.low, c.high)
        found = rows.design(trial)
        before, after = (
            _cost(a, B, theta, weights),
            _cost(*found, _solved(*found, weights), weights),
        )
        if after > before:
            break
        constants, (a, B) = trial, found
        weights = _weights(a, B)
        theta = _solved(a, B, weights)
        if after > (1 - SETTLED) * before:
            break
    return theta, constants


def _cost(a: Array, B: Array, theta: Array, weights: Array) -> float:
    return float(np.sum(weights * (a - B @ theta) ** 2))


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
