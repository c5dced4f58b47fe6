# SPDX-License-Identifier: MIT
"""The paper's method: least squares on differentiated poses, Eqs. (12)-(17).

Pose noise biases it (errors in variables), and it takes dead zone, latency and lag from the vehicle file only;
`docs/derivations.md` says how much that matters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from seatrial import _core
from seatrial.boat.model import Model, thrust_trace
from seatrial.boat.schema import EQUATION_ERROR, EstimatorEntry, Integration, StepEntry
from seatrial.boat.structure import Structure, Term
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.provenance import envelope, recording_entry
from seatrial.identification.regression.least_squares import LeastSquares, solve_least_squares
from seatrial.recording.excitation import find_roles
from seatrial.recording.pose_noise import pose_noise
from seatrial.recording.recording import Recording
from seatrial.recording.velocity import Motion, motion
from seatrial.util.errors import IdentificationError
from seatrial.util.format import joined
from seatrial.util.frames import AXES, SYMBOLS, Array

LONGEST_STEP = 1.5  # median periods between two poses: a longer one is a gap
EQUATIONS = ("Eq. (14)", "Eq. (15)", "Eq. (16)")  # surge, sway, yaw; Eq. (17) is the coupled step


@dataclass(frozen=True)
class EquationErrorSettings:
    """Settings of the paper's method.

    literal: Eq. (17) as printed: surge acceleration one step late
    correlation: [s] >= 0, correlation time of residuals, for standard errors
    """

    literal: bool = False
    correlation: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.correlation < np.inf:
            raise IdentificationError(f"correlation {self.correlation} s: expected 0 or more")


@dataclass(frozen=True)
class StepRows:
    """One recording as rows k of the discretised Eq. (12)."""

    nu_dot: Array  # (n, 3) (nu_k - nu_k-1) / dt
    regressors: Array  # (n, terms) every term's product at k - 1
    recording: str


def equation_error(
    recordings: Sequence[Recording],
    vehicle: Vehicle,
    *,
    roles: Mapping[str, Sequence[str]] | None = None,
    settings: EquationErrorSettings | None = None,
    motions: Sequence[Motion] | None = None,
) -> Model:
    """Coefficients in the paper's four steps.

    `motions` are the stencil's by default; a test may give true ones. Where the roles of two axes
    fall on the same recordings (mixed driving), an axis' coupled terms are found with its own.
    """
    chosen = settings or EquationErrorSettings()
    _refuse_unknown_actuators(vehicle)
    _refuse_shared(vehicle.structure)
    # velocities, and the rows k of the discretised equations
    found = find_roles(vehicle, recordings, roles)
    moving = [motion(r) for r in recordings] if motions is None else list(motions)
    period = float(np.median([r.period for r in recordings]))
    samples = [
        sample_rows(vehicle, r, m, literal=chosen.literal)
        for r, m in zip(recordings, moving, strict=True)
    ]
    # the paper's steps: each axis by itself, then the couplings
    solver = _Steps(vehicle.structure, samples, found, round(chosen.correlation / period))
    for axis in range(3):
        solver.own(axis)  # Eqs. (14), (15), (16)
    for axis in range(3):
        solver.coupled(axis)  # Eq. (17)
    return Model(
        vehicle, solver.theta, solver.covariance, vehicle.constants.values,
        Integration("forward-euler", round(period, 9)), pose_noise(*recordings),
        envelope(vehicle, vehicle.constants.values, recordings, moving),
        tuple(recording_entry(r) for r in recordings),
        EstimatorEntry(
            EQUATION_ERROR, {"literal": chosen.literal, "correlation": chosen.correlation}, solver.steps
        ),
    )  # fmt: skip


def _refuse_unknown_actuators(vehicle: Vehicle) -> None:
    if vehicle.estimated:
        raise IdentificationError(
            f"{vehicle.source}: 'estimate' is given for {joined(vehicle.estimated)}; {EQUATION_ERROR} takes "
            "the actuators as known: use output-error or weak-form, or give numbers"
        )


def _refuse_shared(structure: Structure) -> None:
    """Refuses a coefficient in two axes: the later axis would overwrite the estimate of the earlier."""
    for name in structure.coefficients:
        axes = sorted({term.axis for term in structure.terms if term.coefficient == name})
        if len(axes) > 1:
            raise IdentificationError(
                f"{name} stands in {' and '.join(AXES[axis] for axis in axes)}, but "
                f"{EQUATION_ERROR} solves axis by axis; give it two names, or take another --method"
            )


def sample_rows(
    vehicle: Vehicle, recording: Recording, moving: Motion, *, literal: bool
) -> StepRows:
    """Rows k of Eq. (14)-(17): wherever the velocities at k - 1 and k (and k - 2) are usable."""
    t, nu, valid = moving.t, moving.nu, moving.valid
    if int(valid.sum()) < 3:
        raise IdentificationError(
            f"{recording.name}: {int(valid.sum())} usable velocities in {recording.duration:.1f} s; "
            "record longer, or look for drop-outs with inspect"
        )
    good = np.flatnonzero(valid)
    k = good[np.isin(good - 1, good)]
    k = k[(t[k] - t[k - 1]) < LONGEST_STEP * recording.period]
    if literal:
        k = k[np.isin(k - 2, good)]
    dt = (t[k] - t[k - 1])[:, None]
    nu_dot = (nu[k] - nu[k - 1]) / dt  # Eqs. (14)-(16)
    # the surge acceleration of Eq. (17): as printed one step late
    late = (nu[k - 1] - nu[k - 2]) / (t[k - 1] - t[k - 2])[:, None] if literal else nu_dot
    force = thrust_trace(vehicle, vehicle.constants.values, recording).forces(t[k - 1])
    table = _core.regressors(
        vehicle.structure.compiled,
        np.ascontiguousarray(nu[k - 1]),
        np.ascontiguousarray(late),
        force,
    )
    return StepRows(nu_dot, table, recording.name)


class _Steps:
    """Least-squares steps that build on each other, and the covariance through all of them."""

    def __init__(
        self,
        structure: Structure,
        samples: Sequence[StepRows],
        roles: tuple[tuple[int, ...], ...],
        correlation: int,
    ) -> None:
        n = len(structure.coefficients)
        self.structure, self.samples, self.roles = structure, samples, roles
        self.correlation = correlation
        self.theta = np.full(n, np.nan)
        self.covariance = np.zeros((n, n))
        self.steps: list[StepEntry] = []

    def own(self, axis: int) -> None:
        """Drag and force of an axis, from the recordings that excite it."""
        terms = [t for t in self._free(axis) if not couplings(t)]
        coupled = [t for t in self._free(axis) if couplings(t)]
        together = coupled and all(self._data(axis, [t]) == self.roles[axis] for t in coupled)
        self._solve(axis, terms + (coupled if together else []), self.roles[axis], EQUATIONS[axis])

    def coupled(self, axis: int) -> None:
        """Couplings from other axes, from their recordings, the axis' own coefficients being known."""
        terms = [t for t in self._free(axis) if np.isnan(self.theta[self._place(t)])]
        if terms:
            self._solve(axis, terms, self._data(axis, terms), "Eq. (17)")

    def _free(self, axis: int) -> list[Term]:
        return [t for t in self.structure.terms if t.axis == axis and t.coefficient]

    def _place(self, term: Term) -> int:
        return self.structure.coefficients.index(str(term.coefficient))

    def _data(self, axis: int, terms: Sequence[Term]) -> tuple[int, ...]:
        axes = sorted({a for t in terms for a in couplings(t)})
        return tuple(sorted({i for a in axes for i in self.roles[a]})) or self.roles[axis]

    def _solve(
        self, axis: int, terms: Sequence[Term], data: tuple[int, ...], equation: str
    ) -> None:
        places = list(dict.fromkeys(self._place(t) for t in terms))
        if not places:
            return
        names = [self.structure.coefficients[p] for p in places]
        parts = [self._rows(axis, places, self.samples[i]) for i in data]
        a, B, Z = (np.concatenate([part[j] for part in parts]) for j in range(3))
        used = [self.samples[i].recording for i in data]
        where = f"{equation}, {AXES[axis]}, {', '.join(used)}"
        fit = solve_least_squares(
            B, a, names, where, self.correlation, rows=[len(part[0]) for part in parts]
        )
        self.theta[places] = fit.theta
        self._carry(places, fit, Z)
        self.steps.append(StepEntry(equation, names, used, len(a), fit.condition, fit.explained))

    def _rows(self, axis: int, places: Sequence[int], data: StepRows) -> tuple[Array, Array, Array]:
        """a and B of a = B theta, and the columns Z of the coefficients from earlier steps."""
        n, size = len(data.nu_dot), len(self.theta)
        columns = np.zeros((n, size))
        a = data.nu_dot[:, axis].copy()  # (nu_k - nu_k-1) / dt of Eqs. (14)-(17)
        for j, term in enumerate(self.structure.terms):
            if term.axis != axis:
                continue
            if term.coefficient is None:
                a -= data.regressors[:, j]  # v r of Eq. (14), -u r of Eq. (15)
            else:
                columns[:, self._place(term)] += data.regressors[:, j]
        known = np.isfinite(self.theta)
        known[list(places)] = False
        Z = np.where(known, columns, 0.0)
        a -= Z[:, known] @ self.theta[known]  # (N_rr |r| + N_r) r + N_F F_r of Eq. (17)
        return a, columns[:, list(places)], Z

    def _carry(self, chosen: Sequence[int], fit: LeastSquares, Z: Array) -> None:
        """theta = B+ (a - Z z): the error of z from earlier steps enters through -B+ Z."""
        places = np.array(chosen)
        slope = -fit.inverse @ Z
        cross = slope @ self.covariance
        self.covariance[np.ix_(places, places)] = fit.covariance + cross @ slope.T
        others = np.setdiff1d(np.arange(len(self.theta)), places)
        self.covariance[np.ix_(places, others)] = cross[:, others]
        self.covariance[np.ix_(others, places)] = cross[:, others].T


def couplings(term: Term) -> list[int]:
    """Other axes that a term brings in, by velocity or acceleration."""
    axes = {SYMBOLS.index(f.strip("|")) for f in term.factors if f.strip("|") in SYMBOLS}
    if term.acceleration is not None:
        axes.add(term.acceleration)
    return sorted(axes - {term.axis})
