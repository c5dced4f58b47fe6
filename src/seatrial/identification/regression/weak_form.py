# SPDX-License-Identifier: MIT
"""Weak-form least squares: both sides of Eq. (12) weighed by smooth test functions, for comparison.

Poses are never differentiated twice: the acceleration's derivatives are moved to the test function
by parts (`weak_rows`). One linear problem for all axes, with Huber's weights; delay and dead zone
that the vehicle file does not state are found on the way (`start`).

What bias is left: the products of the smoothed state still hold what noise is left in it (errors in
variables, about its share of the squared speed, most between X_u and X_uu), and a product of
averages is not the average of the product where the velocity bends within the smoothing window.
Widths are chosen so that both stay small (`choose_widths`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.model import Model
from seatrial.boat.schema import EstimatorEntry, Integration, StepEntry
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.provenance import envelope, recording_entry
from seatrial.identification.regression.equation_error import couplings
from seatrial.identification.regression.least_squares import Fit, solve
from seatrial.identification.regression.start_values import (
    Change,
    Design,
    Found,
    changes,
    gathered,
    search,
    widened,
)
from seatrial.identification.selection.actuator_stages import with_free_stages
from seatrial.recording.excitation import find_roles
from seatrial.recording.pose_noise import pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import motion
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import Array
from seatrial.util.statistics import BLOCK

METHOD = "weak-form"
STEP = 1 / 60  # [s] of the model's integration


@dataclass(frozen=True)
class WeakFormSettings:
    """Choices of the method."""

    step: float = 1 / 60  # [s] of the integrals, at most
    steps: int = 8  # of Gauss-Newton on the chain's constants, at most
    block: float = BLOCK  # [s] over which scores may be correlated, for the standard errors


def weak_form(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    roles: Mapping[str, Sequence[str]] | None = None,
    settings: WeakFormSettings | None = None,
) -> Model:
    """Coefficients, and those of delay and dead zone that the vehicle file does not state.

    All recordings serve every axis; `roles` limits an axis to those it names and to those of the
    axes that it is coupled to. Raises IdentificationError, RecordingError.
    """
    chosen = settings or WeakFormSettings()
    whole, moved = to_find(recordings, vehicle)
    serves = serving(whole, recordings, roles)
    rows = gathered(recordings, whole, chosen.step, serves)
    found = search(rows, moved, chosen.steps)
    fit = checked(found.design, found.weights, whole, METHOD)
    found = replace(found, theta=fit.theta)
    blocks = numbered_blocks([w.centres for w in rows.each], chosen.block)
    covariance = sandwich(widened(rows, found, moved), found, blocks)
    widths = {"state": round(rows.widths.state, 3), "test": round(rows.widths.test, 3)}
    entry = EstimatorEntry(
        METHOD, {**widths, "block": chosen.block}, [step_entry(fit, whole, recordings, found)]
    )
    return model_of(whole, recordings, found, placed_covariance(covariance, found, moved), entry)


def to_find(recordings: Sequence[Recording], vehicle: Vehicle) -> tuple[Vehicle, dict[int, Change]]:
    """The vehicle with the stages that its file does not state, and which constants are sought."""
    whole = with_free_stages(vehicle, recordings)
    known = set(vehicle.constants.names) - set(whole.estimated)
    free = [i for i, name in enumerate(whole.constants.names) if name not in known]
    return whole, changes(whole, free)


def serving(
    vehicle: Vehicle,
    recordings: Sequence[Recording],
    roles: Mapping[str, Sequence[str]] | None,
) -> list[tuple[bool, bool, bool]]:
    """For every recording, whether it serves surge, sway and yaw. Raises RecordingError."""
    found = find_roles(vehicle, recordings, roles)
    if not roles:
        return [(True, True, True)] * len(recordings)
    terms = [t for t in vehicle.structure.terms if t.coefficient]
    needs = [{k} | {a for t in terms if t.axis == k for a in couplings(t)} for k in range(3)]
    data = [{i for a in need for i in found[a]} for need in needs]
    return [(i in data[0], i in data[1], i in data[2]) for i in range(len(recordings))]


def checked(design: Design, weights: Array, vehicle: Vehicle, where: str) -> Fit:
    """The coefficients again, refused in words where the data do not hold them."""
    root = np.sqrt(weights).ravel()
    used = root > 0
    flat = design.B.reshape(-1, design.B.shape[2])
    B, a = (flat * root[:, None])[used], (design.a.ravel() * root)[used]
    return solve(B, a, vehicle.structure.coefficients, where, 0)


def numbered_blocks(times: Sequence[Array], block: float) -> NDArray[np.int64]:
    """The number (m,) of the stretch of `block` [s] that each time [s] of each recording is in."""
    numbers, first = [], 0
    for t in times:
        mine = (t // block).astype(np.int64) + first
        numbers.append(mine)
        first = int(mine.max(initial=first - 1)) + 1
    return np.concatenate(numbers)


def sandwich(wide: Design, found: Found, blocks: NDArray[np.int64]) -> Array:
    """Covariance (p, p) of p columns: rows near each other in time share their errors.

    Scores summed over blocks between two inverses (White's sandwich, clustered).
    """
    error = found.design.a - found.design.B @ found.theta
    p = wide.B.shape[2]
    score = np.einsum("mk,mkp->mp", found.weights * error, wide.B)
    sums = np.zeros((int(blocks.max()) + 1, p))
    np.add.at(sums, blocks, score)
    count = len(np.unique(blocks))
    if count < 2 * p:
        raise IdentificationError(
            f"{count} stretches to compare for {p} parameters; at least {2 * p} are needed: record longer"
        )
    flat = wide.B.reshape(-1, p)
    inverse = np.linalg.pinv(flat.T @ (flat * found.weights.reshape(-1, 1)), hermitian=True)
    covariance = inverse @ (sums.T @ sums) @ inverse * count / (count - p)
    return np.asarray((covariance + covariance.T) / 2)


def step_entry(
    fit: Fit, vehicle: Vehicle, recordings: Sequence[Recording], found: Found
) -> StepEntry:
    """The one step, as the report shows it."""
    names = list(vehicle.structure.coefficients)
    rows = int((found.weights > 0).sum())
    return StepEntry(
        "Eq. (12)", names, [r.name for r in recordings], rows, fit.condition, fit.explained
    )


def placed_covariance(part: Array, found: Found, moved: Mapping[int, Change]) -> Array:
    """The covariance of coefficients and sought constants among that of all."""
    n, m = len(found.theta), len(found.constants)
    whole = np.zeros((n + m, n + m))
    places = [*range(n), *(n + i for i in moved)]
    whole[np.ix_(places, places)] = part
    return whole


def model_of(
    vehicle: Vehicle,
    recordings: Sequence[Recording],
    found: Found,
    covariance: Array,
    estimator: EstimatorEntry,
) -> Model:
    """The model; `covariance` is of all coefficients and constants."""
    return Model(
        vehicle,
        found.theta,
        covariance,
        found.constants,
        Integration("runge-kutta", STEP),
        pose_noise(*recordings),
        envelope(vehicle, found.constants, recordings, [motion(r) for r in recordings]),
        tuple(recording_entry(r) for r in recordings),
        estimator,
    )
