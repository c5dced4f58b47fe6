# SPDX-License-Identifier: MIT
"""Weak-form least squares: Eq. (12) multiplied by smooth test functions and integrated; for comparison.

Poses are never differentiated twice: integration by parts moves the derivative to the test function
(`weak_rows`). One linear problem for all axes, with Huber's weights; latency, lag and dead zone that
the vehicle file does not state are scanned and refined (`start_values`).

Remaining bias: products of the smoothed state contain its noise (errors in variables, about its share of the
squared speed, mostly between X_u and X_uu), and a product of averages is not the average of the product where
the velocity changes within the smoothing window. The widths keep both small (`choose_widths`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.model import Model
from seatrial.boat.schema import EstimatorEntry, Integration, StepEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.provenance import envelope, recording_entry
from seatrial.identification.regression.equation_error import couplings
from seatrial.identification.regression.least_squares import LeastSquares, solve_least_squares
from seatrial.identification.regression.linear_equations import (
    ConstantSteps,
    EquationFit,
    Equations,
    LinearEquations,
    fit_equations,
    movable_constants,
    with_constant_columns,
)
from seatrial.identification.regression.start_values import window_rows
from seatrial.identification.selection.actuator_stages import with_free_stages
from seatrial.recording.delays import at_one_time
from seatrial.recording.excitation import find_roles
from seatrial.recording.pose_noise import pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import motion
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array
from seatrial.util.statistics import BLOCK

WEAK_FORM = "weak-form"
INTEGRATION_STEP = 1 / 60  # [s] of the model's integration
WEAK_CHAIN_STEPS = 8  # one or two are enough near the grid's best value


def weak_form(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    roles: Mapping[str, Sequence[str]] | None = None,
    step: float = INTEGRATION_STEP,
) -> Model:
    """Coefficients, and the latencies, lags and dead zones that the vehicle file does not state.

    All recordings serve every axis; `roles` limits an axis to those it names and to those of the
    axes that it is coupled to. `step`: [s] of the integrals, at most. Raises IdentificationError, RecordingError.
    """
    recordings = [at_one_time(r) for r in recordings]
    whole, moved = sought_constants(recordings, vehicle)
    serves = axes_served(whole, recordings, roles)
    rows = window_rows(recordings, whole, step, serves)
    widths = {"state": round(rows.widths.state, 3), "test": round(rows.widths.test, 3)}
    centres = [w.centres for w in rows.each]
    return regression_model(recordings, rows, moved, centres, method=WEAK_FORM, settings=widths)


def regression_model(
    recordings: Sequence[Recording],
    rows: Equations,
    moved: Mapping[int, ConstantSteps],
    times: Sequence[Array],
    *,
    method: str,
    settings: Mapping[str, float],
) -> Model:
    """The model that solves the equations, with its covariance over blocks of time.

    moved: the constants of the chain that are estimated; times: [s] of each recording's rows.
    """
    whole = rows.vehicle
    found = fit_equations(rows, moved, WEAK_CHAIN_STEPS)
    fit = _checked_fit(found.design, found.weights, whole, method)
    found = replace(found, theta=fit.theta)
    # covariance over blocks, constants of the chain included; 0 for what is given
    wide = with_constant_columns(rows, found, moved)
    n, m = len(found.theta), len(found.constants)
    covariance, places = np.zeros((n + m, n + m)), [*range(n), *(n + i for i in moved)]
    covariance[np.ix_(places, places)] = _clustered_sandwich(wide, found, _block_numbers(times))
    step = StepEntry(
        "Eq. (12)", list(whole.structure.coefficients), [r.name for r in recordings],
        int((found.weights > 0).sum()), fit.condition, fit.explained,
    )  # fmt: skip
    return Model(
        whole, found.theta, covariance, found.constants,
        Integration("runge-kutta", INTEGRATION_STEP), pose_noise(*recordings),
        envelope(whole, found.constants, recordings, [motion(r) for r in recordings]),
        tuple(recording_entry(r) for r in recordings),
        EstimatorEntry(method, {**settings, "block": BLOCK}, [step]),
    )  # fmt: skip


def sought_constants(
    recordings: Sequence[Recording], vehicle: Vehicle
) -> tuple[Vehicle, dict[int, ConstantSteps]]:
    """The vehicle with the stages that its file does not state, and the ranges of the estimated constants."""
    whole = with_free_stages(vehicle, recordings)
    known = set(vehicle.constants.names) - set(whole.estimated)
    free = [i for i, name in enumerate(whole.constants.names) if name not in known]
    return whole, movable_constants(whole, free)


def axes_served(
    vehicle: Vehicle,
    recordings: Sequence[Recording],
    roles: Mapping[str, Sequence[str]] | None,
) -> list[tuple[bool, bool, bool]]:
    """For every recording, whether it is used for surge, sway and yaw. Raises RecordingError."""
    found = find_roles(vehicle, recordings, roles)
    if not roles:
        return [(True, True, True)] * len(recordings)
    terms = [t for t in vehicle.structure.terms if t.coefficient]
    needs = [{k} | {a for t in terms if t.axis == k for a in couplings(t)} for k in range(3)]
    data = [{i for a in need for i in found[a]} for need in needs]
    return [(i in data[0], i in data[1], i in data[2]) for i in range(len(recordings))]


def _checked_fit(
    design: LinearEquations, weights: Array, vehicle: Vehicle, where: str
) -> LeastSquares:
    """The coefficients by plain least squares, which refuses those that the data do not determine."""
    root = np.sqrt(weights).ravel()
    used = root > 0
    flat = design.B.reshape(-1, design.B.shape[2])
    B, a = (flat * root[:, None])[used], (design.a.ravel() * root)[used]
    return solve_least_squares(B, a, vehicle.structure.coefficients, where, 0)


def _block_numbers(times: Sequence[Array]) -> NDArray[np.int64]:
    """The number (m,) of the block of `BLOCK` [s] of each time [s] of each recording."""
    numbers, first = [], 0
    for t in times:
        mine = (t // BLOCK).astype(np.int64) + first
        numbers.append(mine)
        first = int(mine.max(initial=first - 1)) + 1
    return np.concatenate(numbers)


def _clustered_sandwich(
    wide: LinearEquations, found: EquationFit, blocks: NDArray[np.int64]
) -> Array:
    """Covariance (p, p) for residuals that are correlated within blocks: White's sandwich, clustered."""
    error = found.design.a - found.design.B @ found.theta
    p = wide.B.shape[2]
    score = np.einsum("mk,mkp->mp", found.weights * error, wide.B)
    sums = np.zeros((int(blocks.max()) + 1, p))
    np.add.at(sums, blocks, score)
    count = len(np.unique(blocks))
    if count < 2 * p:
        raise IdentificationError(
            f"{count} blocks of recordings for {p} parameters; at least {2 * p} are needed: record longer"
        )
    flat = wide.B.reshape(-1, p)
    inverse = np.linalg.pinv(flat.T @ (flat * found.weights.reshape(-1, 1)), hermitian=True)
    covariance = inverse @ (sums.T @ sums) @ inverse * count / (count - p)
    return np.asarray((covariance + covariance.T) / 2)
