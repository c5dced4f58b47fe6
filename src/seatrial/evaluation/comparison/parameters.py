# SPDX-License-Identifier: MIT
"""Significant differences between the coefficients and constants of two models."""

from dataclasses import dataclass

import msgspec
import numpy as np

from seatrial.boat.actuators import STAGES
from seatrial.boat.allocation import Scheme
from seatrial.boat.model import Model
from seatrial.evaluation.comparison.common_factor import CommonFactor, ScaledEstimate, common_factor
from seatrial.evaluation.comparison.thrust_curves import EDGES, stages_apart
from seatrial.util.distributions import chi2_sf, holm, normal_two_sided
from seatrial.util.frames import AXES, Array

SIGNIFICANCE = 0.05  # level of all tests, after Holm's correction
UNKNOWN_ERROR = 10.0  # times its value: standard error of a parameter without information
# of the largest, of the scaled covariance: a direction without variance
LEAST_DIRECTION_VARIANCE = 1e-12


class Pair(msgspec.Struct, frozen=True):
    """A parameter of both models, forward-left-up.

    name: of the parameter
    unit: of its values
    a: A's value
    b: B's value
    error_a: its standard error; 0: given
    error_b: the same of B
    difference: b - a
    error: standard error of the difference, for independent estimates
    z: difference / error; None: both were given
    p: of no difference, with Holm's correction; None: both were given
    """

    name: str
    unit: str
    a: float
    b: float
    error_a: float
    error_b: float
    difference: float
    error: float
    z: float | None
    p: float | None

    @property
    def differs(self) -> bool:
        """Whether the difference is significant; of two given values, whether they differ."""
        return self.difference != 0.0 if self.p is None else self.p < SIGNIFICANCE


class Joint(msgspec.Struct, frozen=True):
    """Joint Wald test of all differences.

    chi2: the statistic
    freedom: its degrees of freedom
    p: of no difference
    """

    chi2: float
    freedom: int
    p: float


class Factor(msgspec.Struct, frozen=True):
    """A common factor of all drag and thrust of an axis, the effect of a change of mass.

    axis: surge, sway or yaw
    coefficients: names of those that have it
    factor: B's over A's
    error: its standard error
    z: its distance from 1 in standard errors
    fits: p of the hypothesis of one factor for all
    parts: "thrust", "drag" alone: factor, error, fits
    """

    axis: str
    coefficients: list[str]
    factor: float
    error: float
    z: float
    fits: float
    parts: dict[str, tuple[float, float, float]] = {}


class OneSided(msgspec.Struct, frozen=True):
    """A parameter without a counterpart in the other model.

    name: of the parameter
    unit: of its value
    value: as estimated or given
    error: its standard error; 0: given
    why: why the parameter of the same name is no counterpart
    at_bound: whether it is at a bound of its range: estimated, error unknown
    """

    name: str
    unit: str
    value: float
    error: float
    why: str = ""
    at_bound: bool = False


@dataclass(frozen=True)
class View:
    """Parameters in comparable terms: converted where their meaning differs between the models."""

    values: dict[str, float]
    covariance: Array  # (n, n) in the order of `values`
    slopes: Array  # (n, n) derivatives by the model's own parameters
    converted: str = ""  # the conversion

    def of(self, names: list[str]) -> tuple[Array, Array]:
        """Values (m,) and covariance (m, m) of some of them."""
        index = [list(self.values).index(name) for name in names]
        values = np.array([self.values[name] for name in names])
        return values, self.covariance[np.ix_(index, index)]


def views(a: Model, b: Model) -> tuple[View, View]:
    """Parameters of both models in comparable terms."""
    return _view(a, b), _view(b, a)


def _view(model: Model, other: Model) -> View:
    """Thrust gains beyond the dead zone's edge, where the other model has no dead zone.

    With always-forward allocation thrust is (f - e) / (1 - e), and e cancels in T f: a model without a
    dead zone has X_F / (1 - e).
    """
    values = dict(model.parameter_values)
    if not _has_edge(model) or _has_edges(other) or other.vehicle.scheme is not Scheme.AF:
        return View(values, model.covariance, np.eye(len(values)))
    edge = values[EDGES[0]]
    slopes = np.eye(len(values))
    names = list(values)
    gains = [n for n in model.structure.coefficients if _is_gain(model, n)]
    for name in gains:
        i = names.index(name)
        slopes[i, i] = 1.0 / (1.0 - edge)
        slopes[i, names.index(EDGES[0])] = values[name] / (1.0 - edge) ** 2
        values[name] /= 1.0 - edge
    converted = f"{', '.join(gains)} / (1 - edge)"
    return View(values, slopes @ model.covariance @ slopes.T, slopes, converted)


def _has_edge(model: Model) -> bool:
    """Whether all thrusters share one forward edge, on a linear curve."""
    index = model.vehicle.constants.index
    own = index[:, STAGES.index(EDGES[0])]
    straight = bool(np.all(index[:, STAGES.index("power")] < 0))
    return EDGES[0] in model.parameters and bool(np.all(own == own[0])) and straight


def _has_edges(model: Model) -> bool:
    curved = any(group.table or group.pair for group in model.vehicle.file.chain)
    return curved or any(name.partition(".")[0] in EDGES for name in model.parameters)


def _is_gain(model: Model, name: str) -> bool:
    forces = {force.name for force in model.structure.forces}
    return all(
        sum(f in forces for f in t.factors) == 1
        for t in model.structure.terms
        if t.coefficient == name
    )


def pairs(a: Model, b: Model, seen: tuple[View, View], odd: dict[str, str]) -> list[Pair]:
    """All parameters that both have, in A's order."""
    units = a.units
    names = [n for n in a.parameters if n in b.parameters and n not in odd]
    (first, own), (second, other) = (view.of(names) for view in seen)
    errors = np.sqrt(np.diag(own)), np.sqrt(np.diag(other))
    error = np.hypot(*errors)
    tested = error > 0
    z = np.where(tested, (second - first) / np.where(tested, error, 1.0), np.nan)
    p = np.full(len(names), np.nan)
    p[tested] = holm([normal_two_sided(value) for value in z[tested]])
    return [
        Pair(
            name, units[name], float(first[i]), float(second[i]), float(errors[0][i]), float(errors[1][i]),
            float(second[i] - first[i]), float(error[i]),
            float(z[i]) if tested[i] else None, float(p[i]) if tested[i] else None,
        )
        for i, name in enumerate(names)
    ]  # fmt: skip


def unmatched(model: Model, other: Model, odd: dict[str, str]) -> list[OneSided]:
    """Parameters without a counterpart."""
    return [
        OneSided(
            n, model.units[n], value, model.standard_errors[n], odd.get(n, ""), n in model.at_bounds
        )
        for n, value in model.parameter_values.items()
        if n not in other.parameters or n in odd
    ]


def joint(found: list[Pair], seen: tuple[View, View]) -> Joint | None:
    """d' (C_A + C_B)^-1 d over all parameters estimated in either model."""
    names = [pair.name for pair in found if pair.z is not None]
    if not names:
        return None
    (first, own), (second, other) = (view.of(names) for view in seen)
    chi2, freedom = _wald(second - first, own + other)
    return Joint(chi2, freedom, chi2_sf(chi2, freedom))


def _wald(difference: Array, covariance: Array) -> tuple[float, int]:
    """Wald's statistic and its degrees of freedom: directions that have a variance."""
    scale = np.sqrt(np.diag(covariance))
    size, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    there = size > LEAST_DIRECTION_VARIANCE * size[-1]
    along = axes[:, there].T @ (difference / scale)
    return float(np.sum(along**2 / size[there])), int(there.sum())


def factors(a: Model, b: Model, found: list[Pair], seen: tuple[View, View]) -> list[Factor]:
    """The common factor of drag and thrust by axis, with the covariance of both models.

    Eq. (12) is per unit mass: with k times the mass (or inertia) every coefficient is divided by k.
    Acceleration and Coriolis terms are left out: they depend on the distribution of mass. So is thrust
    where its curves differ in stages: one unknown factor is then in all its rows.
    """
    out = []
    known = {pair.name for pair in found if estimated_in_both(pair)}
    thrust_differs = bool(stages_apart(a, b, any(view.converted for view in seen)))
    for axis, word in enumerate(AXES):
        kinds = {kind: names & known for kind, names in thrust_and_drag(a, axis).items()}
        if thrust_differs:
            del kinds["thrust"]
        names = [n for n in a.structure.coefficients if n in set().union(*kinds.values())]
        if len(names) >= 2:
            one = _common(names, seen)
            parts = {kind: _common(sorted(of), seen) for kind, of in kinds.items() if of}
            each = {kind: (p.factor, p.error, p.fits) for kind, p in parts.items()}
            out.append(Factor(word, names, one.factor, one.error, one.z, one.fits, each))
    return out


def estimated_in_both(pair: Pair) -> bool:
    """Whether both were estimated with information; an unused parameter is arbitrary."""
    errors = (pair.error_a, pair.error_b)
    return min(errors) > 0.0 and max(errors) < UNKNOWN_ERROR * max(abs(pair.a), abs(pair.b))


def _common(names: list[str], seen: tuple[View, View]) -> CommonFactor:
    a, b = (ScaledEstimate.of(*view.of(names)) for view in seen)
    return common_factor(a, b)


def thrust_and_drag(model: Model, axis: int) -> dict[str, set[str]]:
    """Coefficients of an axis' terms with a force, and of all others, without those of masses."""
    own = [t for t in model.structure.terms if t.axis == axis and t.coefficient]
    of_masses = {t.coefficient for t in own if t.of_masses}
    forces = {force.name for force in model.structure.forces}
    thrust = {t.coefficient for t in own if forces & {*t.factors}} - of_masses
    drag = {t.coefficient for t in own} - thrust - of_masses
    return {"thrust": {n for n in thrust if n}, "drag": {n for n in drag if n}}
