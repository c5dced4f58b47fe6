# SPDX-License-Identifier: MIT
"""Which coefficients and constants of two models differ by more than their errors."""

from dataclasses import dataclass

import msgspec
import numpy as np

from seatrial.boat.actuators import STAGES
from seatrial.boat.allocation import Scheme
from seatrial.boat.model import Model
from seatrial.boat.structure import Term
from seatrial.boat.vehicle import WRENCH, Vehicle
from seatrial.util.distributions import chi2_sf, holm, normal_two_sided
from seatrial.util.frames import AXES, Array
from seatrial.util.statistics import inverse_of

SIGNIFICANT = 0.05
UNKNOWN = 10.0  # times its value a standard error that says nothing of it
RANK = 1e-12  # share of the largest eigenvalue, of scaled covariance, below which there is none
EDGES = ("edge_forward", "edge_reverse")


class Pair(msgspec.Struct, frozen=True):
    """A parameter of both models, forward-left-up."""

    name: str
    unit: str
    a: float
    b: float
    error_a: float  # standard errors; 0: it was given
    error_b: float
    difference: float  # b - a
    error: float  # of the difference, were both estimates independent
    z: float | None  # difference / error; None: both were given
    p: float | None  # that it is chance, for the largest of all differences (Holm)

    @property
    def differs(self) -> bool:
        """Whether it differs by more than chance; two given values, whether they differ."""
        return self.difference != 0.0 if self.p is None else self.p < SIGNIFICANT


class Joint(msgspec.Struct, frozen=True):
    """Wald's test of all differences together."""

    chi2: float
    freedom: int
    p: float


class Factor(msgspec.Struct, frozen=True):
    """One factor by which all drag and thrust of an axis changed, as a change of mass does it."""

    axis: str
    coefficients: list[str]
    factor: float  # B's over A's
    error: float
    z: float  # its distance from 1 in standard errors
    fits: float  # p of all coefficients having the same factor


class OneSided(msgspec.Struct, frozen=True):
    """A parameter that only one model has, or whose meaning is another in the other."""

    name: str
    unit: str
    value: float
    error: float
    why: str = ""  # a parameter of the same name is no counterpart
    at_bound: bool = False  # of its range: estimated, but its error is not known


@dataclass(frozen=True)
class View:
    """Parameters as they are compared: converted where the other model's mean something else."""

    values: dict[str, float]
    covariance: Array  # (n, n) in the order of `values`
    slopes: Array  # (n, n) of them by the model's own parameters
    converted: str = ""  # what was done

    def of(self, names: list[str]) -> tuple[Array, Array]:
        """Values (m,) and covariance (m, m) of some of them."""
        index = [list(self.values).index(name) for name in names]
        values = np.array([self.values[name] for name in names])
        return values, self.covariance[np.ix_(index, index)]


def views(a: Model, b: Model) -> tuple[View, View]:
    """Both models' parameters in terms that can be compared."""
    return _view(a, b), _view(b, a)


def _view(model: Model, other: Model) -> View:
    """With thrust gains past the dead zone's edge where the other model knows no others.

    Under always-forward allocation thrust is (f - e) / (1 - e) of which e cancels in T f: a model
    without a dead zone finds X_F / (1 - e).
    """
    values = dict(
        zip(
            model.parameters, [*model.coefficients.tolist(), *model.constants.tolist()], strict=True
        )
    )
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
    """Whether one forward edge serves all thrusters, on a curve that is straight past it."""
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


def unlike(a: Model, b: Model) -> dict[str, str]:
    """Why parameters of the same name are not the same thing; empty where they are."""
    found = {}
    strange = {
        f.name
        for f in a.structure.forces
        if _means(a.vehicle, f.name) & _means(b.vehicle, f.name) == set()
    }
    for name in set(a.structure.coefficients) & set(b.structure.coefficients):
        mine, yours = (_terms(m, name) for m in (a, b))
        used = {f for t in mine for f in t.factors} & strange
        if {_key(t) for t in mine} != {_key(t) for t in yours}:
            said = [" + ".join(t.text() for t in terms) for terms in (mine, yours)]
            found[name] = f"it is {said[0]} in A, {said[1]} in B"
        elif used:
            found[name] = f"{', '.join(sorted(used))} is made by other actuators or weights"
    for label, model in (("A", a), ("B", b)):
        for name in model.at_bounds:
            found[name] = f"it ended at the bound of its range in {label}: its error is unknown"
    for name in set(a.vehicle.constants.names) & set(b.vehicle.constants.names):
        if _members(a.vehicle, name) != _members(b.vehicle, name):
            found[name] = "it stands for other actuators"
        elif _sides(a.vehicle, name) != _sides(b.vehicle, name):
            found[name] = "it is of the other side, as the files' axes turn the command"
    return found


def _terms(model: Model, name: str) -> list[Term]:
    return [t for t in model.structure.terms if t.coefficient == name]


def _key(term: Term) -> tuple[object, ...]:
    return term.axis, term.number, tuple(sorted(term.factors)), term.acceleration


def fixed_terms(model: Model) -> set[tuple[object, ...]]:
    """The terms without a coefficient."""
    return {_key(t) for t in model.structure.terms if t.coefficient is None}


def _means(vehicle: Vehicle, force: str) -> set[tuple[tuple[str, float], ...]]:
    """What a force is made of: actuators, and inputs where these are the forces themselves."""
    names = [f.name for f in vehicle.forces]
    if force not in names:
        return set()
    row = vehicle.mix[names.index(force)]
    found = {
        tuple(
            sorted(
                (n, round(float(w), 9)) for n, w in zip(vehicle.actuators, row, strict=True) if w
            )
        )
    }
    if vehicle.scheme is not Scheme.DIRECT and force in WRENCH:
        found.add(((force, 1.0),))  # T f = F
    return found


def _members(vehicle: Vehicle, name: str) -> set[str]:
    """Actuators that a constant serves; none named where it is all of them."""
    place = vehicle.constants.names.index(name)
    users = (vehicle.constants.index == place).any(axis=1)
    return set() if users.all() else {n for n, u in zip(vehicle.actuators, users, strict=True) if u}


def _sides(vehicle: Vehicle, name: str) -> list[set[int]]:
    """For each actuator the stages that a constant serves, in forward-left-up axes."""
    place = vehicle.constants.names.index(name)
    index = vehicle.stages[:, : len(STAGES)]
    return [set(np.flatnonzero(row == place).tolist()) for row in index]


def pairs(a: Model, b: Model, seen: tuple[View, View], odd: dict[str, str]) -> list[Pair]:
    """All parameters that both have, in A's order."""
    units = _units(a)
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


def alone(model: Model, other: Model, odd: dict[str, str]) -> list[OneSided]:
    """Parameters without a counterpart."""
    units = _units(model)
    values = [*model.coefficients.tolist(), *model.constants.tolist()]
    return [
        OneSided(n, units[n], value, model.standard_errors[n], odd.get(n, ""), n in model.at_bounds)
        for n, value in zip(model.parameters, values, strict=True)
        if n not in other.parameters or n in odd
    ]


def _units(model: Model) -> dict[str, str]:
    constants = model.vehicle.constants
    return {**model.structure.units, **{n: constants.unit(n) for n in constants.names}}


def joint(found: list[Pair], seen: tuple[View, View]) -> Joint | None:
    """d' (C_A + C_B)^-1 d over all parameters that were estimated in either model."""
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
    there = size > RANK * size[-1]
    along = axes[:, there].T @ (difference / scale)
    return float(np.sum(along**2 / size[there])), int(there.sum())


def factors(a: Model, found: list[Pair], seen: tuple[View, View]) -> list[Factor]:
    """For each axis the factor that its drag and thrust share, by generalised least squares.

    Eq. (12) is per unit mass: with k times the mass (or inertia) every coefficient is 1 / k of what
    it was. Acceleration and Coriolis terms are left out: they tell of where the mass is.
    """
    out = []
    known = {pair.name for pair in found if _tells(pair)}
    for axis, word in enumerate(AXES):
        own = [t for t in a.structure.terms if t.axis == axis and t.coefficient in known]
        still = {t.coefficient for t in own if t.of_masses}
        names = list(dict.fromkeys(t.coefficient for t in own if t.coefficient not in still))
        if len(names) >= 2:
            out.append(_factor(word, [n for n in names if n], seen))
    return out


def _tells(pair: Pair) -> bool:
    """Whether both were estimated, and known at all: what was never used may be anything."""
    errors = (pair.error_a, pair.error_b)
    return min(errors) > 0.0 and max(errors) < UNKNOWN * max(abs(pair.a), abs(pair.b))


def _factor(axis: str, names: list[str], seen: tuple[View, View]) -> Factor:
    (first, own), (second, other) = (view.of(names) for view in seen)
    k = 1.0
    for _ in range(30):  # the weights depend on the factor: it settles in a few rounds
        weight = inverse_of(other + k**2 * own)
        # b = k a* with both in error: a* by least squares, too (Deming's regression)
        best = first + k * own @ weight @ (second - k * first)
        before, k = k, float(best @ weight @ second / (best @ weight @ first))
        if abs(k - before) < 1e-12 * abs(k):
            break
    chi2, _ = _wald(second - k * first, other + k**2 * own)
    error = float(1.0 / np.sqrt(best @ weight @ best))
    return Factor(axis, names, k, error, (k - 1.0) / error, chi2_sf(chi2, len(names) - 1))
