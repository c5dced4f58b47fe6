# SPDX-License-Identifier: MIT
"""Start values for the maximum-likelihood search, from the recordings alone.

The weak form is linear in the coefficients once latency, lag and dead zone are fixed, and cheap to solve.
Each of these is scanned on a grid, the value with the smallest residual is kept, and refined by Gauss-Newton.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from seatrial.boat.vehicle import Vehicle
from seatrial.identification.regression.weak_rows import Widths, Windows, choose_widths, windows_of
from seatrial.recording.pose_faults import usual_step
from seatrial.recording.recording import Recording
from seatrial.util.errors import IdentificationError, RecordingError
from seatrial.util.frames import Array, Mask

START_GRID_STEP = 1 / 30  # [s] of the weak form's integrals
START_DURATION = 610.0  # [s] of recordings that are enough for start values
PIECE_DURATION = 100.0  # [s] of the pieces that longer recordings are represented by
# 10th percentile of the pose periods over the usual one: below it stamps are resampled
UNEVEN_STAMPS = 0.5
LATENCY_GRID = (-0.5, -0.2, 0.1, 0.4, 0.8)  # [s]
LAG_GRID = (0.02, 0.1, 0.2, 0.4, 0.8)  # [s] where the latency is given
RATE_GRID = (15.0, 40.0, 100.0)  # [deg/s] of an angle
DEAD_ZONE_GRID = (0.0, 0.08, 0.16, 0.3)  # of full command
START_CHAIN_STEPS = 2  # Gauss-Newton steps
STEP_SHARES = (1.0, 0.3)  # of a Gauss-Newton step that are tried
CONVERGED_SHARE = 1e-4  # of the cost, that a step must gain for another one
ROW_OUTLIER = 1.5  # [robust standard deviations] beyond which a row counts linearly (Huber)
HUBER_ROUNDS = 4  # of reweighting
MEDIAN_TO_DEVIATION = 0.6745  # median absolute value of a standard normal variable
LEAST_RESIDUAL_DEVIATION = 1e-9  # [m/s^2, rad/s^2] of residuals, where there is no noise
LEAST_SCALE = 1e-12  # of a scale, against a division by 0
ZERO_COLUMN = 1e-9  # RMS of a column below which it is rounding
NORMAL_RIDGE = 1e-8  # on the scaled normal matrix: parameters without excitation stay near 0


@dataclass(frozen=True)
class ConstantRange:
    """The range of a constant of the chain, and its steps."""

    probe: float  # finite difference for its derivative
    most: float  # largest change in one step
    low: float
    high: float
    grid: tuple[float, ...]  # values of the first scan


CONSTANT_RANGES = {
    "latency": ConstantRange(0.02, 0.15, -1.0, 2.0, LATENCY_GRID),  # [s]
    "lag": ConstantRange(0.02, 0.15, 0.01, 2.0, LAG_GRID),  # [s]
    "edge_forward": ConstantRange(0.02, 0.08, 0.0, 0.6, DEAD_ZONE_GRID),
    "edge_reverse": ConstantRange(0.02, 0.08, 0.0, 0.6, DEAD_ZONE_GRID),
    "pair_dead_zone": ConstantRange(0.02, 0.08, 0.0, 0.6, DEAD_ZONE_GRID),
    "steer_rate": ConstantRange(2.0, 20.0, 3.0, 1000.0, RATE_GRID),  # [deg/s]
    "steer_angle": ConstantRange(2.0, 10.0, 3.0, 180.0, ()),  # [deg]
    "steer_offset": ConstantRange(1.0, 5.0, -45.0, 45.0, ()),  # [deg]
    "steer_dead_zone": ConstantRange(0.02, 0.08, 0.0, 0.6, DEAD_ZONE_GRID),
    "pair_offset_along": ConstantRange(0.02, 0.08, -0.5, 0.5, ()),
    "pair_offset_across": ConstantRange(0.02, 0.08, -0.5, 0.5, ()),
}


class Equations(Protocol):
    """Equations linear in the coefficients, for given constants of the chain."""

    @property
    def vehicle(self) -> Vehicle:
        """Whose constants they are."""

    @property
    def use(self) -> Mask:
        """(m, 3) rows that count."""

    def design(self, constants: Array) -> "LinearEquations":
        """The equations for these constants."""


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


@dataclass(frozen=True)
class LinearEquations:
    """a = B theta."""

    a: Array  # (m, 3)
    B: Array  # (m, 3, n)

    def solved(self, weights: Array) -> Array:
        """Weighted least squares (n,); coefficients without any data are 0."""
        flat = self.B.reshape(-1, self.B.shape[2])
        weighted = flat * weights.reshape(-1, 1)
        normal = flat.T @ weighted
        alive = np.linalg.norm(flat, axis=0) > ZERO_COLUMN * np.sqrt(len(flat))
        size = np.where(alive, np.sqrt(np.diag(normal)) + LEAST_SCALE, np.inf)
        scaled = normal / np.outer(size, size) + NORMAL_RIDGE * np.eye(len(size))
        return np.asarray(np.linalg.solve(scaled, weighted.T @ self.a.ravel() / size) / size)

    def cost(self, theta: Array, weights: Array) -> float:
        """Weighted sum of squared residuals."""
        return float(np.sum(weights * (self.a - self.B @ theta) ** 2))

    def weights(self, use: Mask) -> Array:
        """Huber's weights (m, 3) over the squared robust spread of each axis' residuals."""
        spread = np.array([np.std(self.a[use[:, k], k]) for k in range(3)]) + LEAST_SCALE
        weights: Array = use / spread**2
        for _ in range(HUBER_ROUNDS):
            error = np.abs(self.a - self.B @ self.solved(weights))
            middle = [np.median(error[use[:, k], k]) for k in range(3)]
            spread = np.array(middle) / MEDIAN_TO_DEVIATION + LEAST_RESIDUAL_DEVIATION
            weights = use / np.maximum(1.0, error / spread / ROW_OUTLIER) / spread**2
        return weights


@dataclass(frozen=True)
class EquationFit:
    """A solution of the equations."""

    theta: Array  # (n,)
    constants: Array  # (m,)
    design: LinearEquations
    weights: Array  # (m, 3)


def start_values(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    free: Sequence[int] = (),
    *,
    widths: Widths | None = None,
) -> tuple[Array, Array]:
    """Coefficients (n,) and constants (m,) of the chain to start a search from.

    `free`: indices of `vehicle.constants` that may change; latency, lag and dead-zone edges do. Lag and latency
    are hardly separable, their sum is well known. `widths`: of the windows, by default chosen from the recordings.
    Raises IdentificationError where no recording is long enough without drop-outs.
    """
    rows = window_rows(
        [at_even_stamps(r) for r in spread_pieces(recordings)],
        vehicle,
        START_GRID_STEP,
        widths=widths,
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
    if np.percentile(steps, 10) > UNEVEN_STAMPS * usual_step(steps):
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


def movable_constants(vehicle: Vehicle, free: Sequence[int]) -> dict[int, ConstantRange]:
    """The ranges of the constants that are estimated, by index."""
    stage = {i: vehicle.constants.names[i].partition(".")[0] for i in free}
    found = {i: CONSTANT_RANGES[s] for i, s in stage.items() if s in CONSTANT_RANGES}
    delayed = any(c.grid == LATENCY_GRID for c in found.values())
    # scan one of lag and latency only: they are separated later
    return {
        i: replace(c, grid=()) if delayed and c.grid == LAG_GRID else c for i, c in found.items()
    }


def fit_equations(rows: Equations, moved: Mapping[int, ConstantRange], steps: int) -> EquationFit:
    """Coefficients and constants: a scan of each kind on its grid, then Gauss-Newton steps."""
    constants = rows.vehicle.constants.values.copy()
    weights = rows.design(constants).weights(rows.use)
    for grid in (LATENCY_GRID, LAG_GRID, DEAD_ZONE_GRID):
        places = [i for i, change in moved.items() if change.grid == grid]
        if places:
            constants = _scanned(rows, weights, constants, places, grid)
    return _refined(rows, constants, moved, steps if moved else 0)


def with_constant_columns(
    rows: Equations, at: EquationFit, moved: Mapping[int, ConstantRange]
) -> LinearEquations:
    """The equations with further columns for changes of the constants, by finite differences."""
    columns = []
    for i, change in moved.items():
        probe = rows.design(_placed(at.constants, [i], at.constants[i] + change.probe))
        tilt = (probe.B - at.design.B) @ at.theta - (probe.a - at.design.a)
        columns.append(tilt[:, :, None] / change.probe)
    return LinearEquations(at.design.a, np.concatenate([at.design.B, *columns], axis=2))


def _scanned(
    rows: Equations, weights: Array, constants: Array, places: Sequence[int], grid: Sequence[float]
) -> Array:
    """The constants with those at `places` at the best grid value, refined by a parabola."""
    costs = []
    for value in grid:
        design = rows.design(_placed(constants, places, value))
        costs.append(design.cost(design.solved(weights), weights))
    i = int(np.argmin(costs))
    inside = 0 < i < len(grid) - 1
    best = _lowest(grid[i - 1 : i + 2], costs[i - 1 : i + 2]) if inside else grid[i]
    return _placed(constants, places, best)


def _refined(
    rows: Equations, constants: Array, moved: Mapping[int, ConstantRange], steps: int
) -> EquationFit:
    """Gauss-Newton steps on coefficients and constants together; the coefficients are solved exactly."""
    at = _solved_at(rows, constants)
    for _ in range(steps):
        step = with_constant_columns(rows, at, moved).solved(at.weights)[len(at.theta) :]
        before = at.design.cost(at.theta, at.weights)
        for share in STEP_SHARES:
            trial = _moved(at.constants, moved, share * step)
            design = rows.design(trial)
            after = design.cost(design.solved(at.weights), at.weights)
            if after < before:
                at = _solved_at(rows, trial, design)
                break
        if after > (1 - CONVERGED_SHARE) * before:
            break
    return at


def _moved(constants: Array, moved: Mapping[int, ConstantRange], step: Array) -> Array:
    out = constants.copy()
    for (i, c), s in zip(moved.items(), step, strict=True):
        out[i] = np.clip(out[i] + np.clip(s, -c.most, c.most), c.low, c.high)
    return out


def _solved_at(
    rows: Equations, constants: Array, design: LinearEquations | None = None
) -> EquationFit:
    there = design or rows.design(constants)
    weights = there.weights(rows.use)
    return EquationFit(there.solved(weights), constants, there, weights)


def _placed(constants: Array, places: Sequence[int], value: float) -> Array:
    out = constants.copy()
    out[list(places)] = value
    return out


def _lowest(x: Sequence[float], y: Sequence[float]) -> float:
    """The minimum of the parabola through three points, the middle one being the lowest."""
    left, right = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    bend = (right - left) / (x[2] - x[0])
    if bend <= 0:
        return x[1]
    return float(np.clip((x[0] + x[1]) / 2 - left / (2 * bend), x[0], x[2]))
