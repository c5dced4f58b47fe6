# SPDX-License-Identifier: MIT
"""Physical changes as maps from A's coefficients to B's, with few unknowns and a Gaussian prior on them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.model import Model
from seatrial.boat.structure import Term
from seatrial.boat.vehicle import WRENCH
from seatrial.evaluation.comparison.parameters import thrust_and_drag
from seatrial.util.frames import Array

TYPICAL_CHANGE = 0.3  # [-] standard deviation of a change of mass, thrust or drag, before the logs
COUPLING_CHANGE = 0.3  # [share of full thrust] the same of a coupling term, at the envelope's edge
# correlation of the changes in surge and sway: added mass differs between them
BOTH_HULL_AXES = 0.9
MASS_AND_INERTIA = 0.7  # the same of mass and inertia: a payload may lie near the middle

NO_CHANGE = "no change"
MASS = "mass"
OFF_CENTRE = "mass off centre"
ONE_THRUSTER = "one thruster"
BATTERY = "battery"
DRAG = "drag"
CURRENT = "current"
TWO = "two of these"
NONE_OF_THESE = "none of these"
CAUSES = (NO_CHANGE, MASS, OFF_CENTRE, BATTERY, ONE_THRUSTER, DRAG, CURRENT, TWO, NONE_OF_THESE)
TWO_AT_ONCE = 0.1  # probability of two causes before the logs, over that of one
PAIRED = (MASS, BATTERY, ONE_THRUSTER, DRAG, CURRENT)  # causes of which two may be there at once


@dataclass(frozen=True)
class Problem:
    """Both estimates of the comparable coefficients, and the model that they belong to."""

    model: Model  # A
    names: tuple[str, ...]
    values: tuple[Array, Array]  # (n,) of A and B
    roots: tuple[Array, Array]  # (n, n) R with R'R = C^-1

    @property
    def units(self) -> Array:
        """(n,) a change that is typical of each coefficient."""
        size = np.maximum(*map(np.abs, self.values))
        coupled = np.array([coupling_unit(self.model, name) or 0.0 for name in self.names])
        return np.maximum(TYPICAL_CHANGE * size, COUPLING_CHANGE * coupled)


@dataclass(frozen=True)
class Candidate:
    """B's coefficients of A's and of the unknowns, whose prior has mean 0."""

    cause: str
    covariance: Array  # (m, m) of the prior
    change: Callable[[Array, Array], Array]  # theta (n,), phi (m,) to (n,)
    what: str = ""
    shown: Callable[[Array], float] | None = None  # phi to the relative change

    def described(self, phi: Array) -> str:
        """The cause with its size."""
        size = "" if self.shown is None else f" {signed(self.shown(phi))}"
        if self.cause == ONE_THRUSTER:
            return f"{self.cause} ({self.what}{size})"
        return f"{self.cause}{size}"


@dataclass(frozen=True)
class Both(Candidate):
    """Two causes at once, one map after the other."""

    parts: tuple[Candidate, ...] = ()

    def described(self, phi: Array) -> str:
        """Both with their sizes."""
        first, second = self.parts
        m = len(first.covariance)
        return f"{first.described(phi[:m])} and {second.described(phi[m:])}"


def candidates(problem: Problem) -> list[Candidate]:
    """Those that this model can show."""
    n = len(problem.names)
    found = [
        Candidate(NO_CHANGE, np.zeros((0, 0)), lambda theta, phi: theta),
        *_masses(problem),
        *_thrusters(problem),
        *_battery(problem),
        *_drag(problem),
        *_current(problem),
    ]
    found += _two(found)
    units = problem.units
    found.append(Candidate(NONE_OF_THESE, np.eye(n), lambda theta, phi: theta + units * phi))
    return found


def _two(found: Sequence[Candidate]) -> list[Candidate]:
    """Pairs of different causes of `PAIRED`; not a thruster that can't be told apart from the battery."""
    single = [c for c in found if c.cause in PAIRED and (c.cause != ONE_THRUSTER or c.shown)]
    pairs: list[Candidate] = []
    for a, b in combinations(single, 2):
        if a.cause == b.cause:
            continue
        m, n = len(a.covariance), len(b.covariance)
        prior = np.zeros((m + n, m + n))
        prior[:m, :m], prior[m:, m:] = a.covariance, b.covariance
        pairs.append(Both(TWO, prior, partial(_one_after_the_other, a, b), parts=(a, b)))
    return pairs


def _one_after_the_other(a: Candidate, b: Candidate, theta: Array, phi: Array) -> Array:
    """Coefficients (n,) after both changes."""
    m = len(a.covariance)
    return b.change(a.change(theta, phi[:m]), phi[m:])


def signed(change: float) -> str:
    """A relative change in per cent with its sign."""
    return f"{'+' if change >= 0 else '-'}{abs(100.0 * change):.0f} %"


def _masses(problem: Problem) -> list[Candidate]:
    """Every coefficient of an axis over one factor of mass; off centre the couplings change, too.

    Eq. (12) is per unit mass and inertia. phi: logarithms of the factors of mass by axis.
    """
    axis_of = _axes(problem)
    if not axis_of.any():
        return []
    there = np.flatnonzero(axis_of.any(axis=1))
    prior = _of_axes(there)
    rows = axis_of[there].astype(float)

    def heavier(theta: Array, phi: Array) -> Array:
        return np.asarray(theta * np.exp(-phi @ rows))

    first = int(there[0])
    what = "inertia" if first == 2 else "mass"

    def shown(phi: Array) -> float:
        return float(np.expm1(phi[0]))

    found = [Candidate(MASS, prior, heavier, what, shown)]
    unit = [coupling_unit(problem.model, name) for name in problem.names]
    coupled = [i for i, size in enumerate(unit) if size is not None]
    if coupled:
        size = np.zeros((len(coupled), len(unit)))
        for k, i in enumerate(coupled):
            size[k, i] = COUPLING_CHANGE * (unit[i] or 0.0)
        m = len(there)
        wider = np.block(
            [[prior, np.zeros((m, len(coupled)))], [np.zeros((len(coupled), m)), np.eye(len(coupled))]]
        )  # fmt: skip

        def moved(theta: Array, phi: Array) -> Array:
            return heavier(theta, phi[:m]) + phi[m:] @ size

        found.append(Candidate(OFF_CENTRE, wider, moved, what, shown))
    return found


def _of_axes(there: NDArray[np.intp]) -> Array:
    """Prior covariance of the logarithms of one factor for each of these axes."""
    hull, turn = BOTH_HULL_AXES, MASS_AND_INERTIA
    whole = TYPICAL_CHANGE**2 * np.array([[1.0, hull, turn], [hull, 1.0, turn], [turn, turn, 1.0]])
    return np.asarray(whole[np.ix_(there, there)])


def _drag(problem: Problem) -> list[Candidate]:
    """Drag of each axis by its own velocity over a factor: weeds on the hull, or a deeper draught."""
    model = problem.model
    own = np.array([coupling_unit(model, name) is None for name in problem.names])
    drag = _axes(problem) & own & np.logical_not(_of_thrust(problem))
    there = np.flatnonzero(drag.any(axis=1))
    if not len(there):
        return []
    rows = drag[there].astype(float)
    return [
        Candidate(
            DRAG, _of_axes(there), lambda theta, phi: np.asarray(theta * np.exp(phi @ rows)),
            "drag", lambda phi: float(np.expm1(phi[0])),
        )
    ]  # fmt: skip


def _battery(problem: Problem) -> list[Candidate]:
    """All thrust by one factor; drag and masses stay."""
    thrust = _of_thrust(problem)
    if not thrust.any():
        return []
    return [
        Candidate(
            BATTERY, np.array([[TYPICAL_CHANGE**2]]),
            lambda theta, phi: np.asarray(theta * np.exp(np.where(thrust, phi[0], 0.0))),
            "thrust", lambda phi: float(np.expm1(phi[0])),
        )
    ]  # fmt: skip


def _current(problem: Problem) -> list[Candidate]:
    """Surge and sway but for thrust, each coefficient by itself; thrust and yaw stay.

    So an estimate changes that takes velocity over ground for velocity through the water: linear drag grows,
    quadratic drag shrinks, and Coriolis terms take a part of the current.
    """
    axis_of = _axes(problem)
    own = (axis_of[0] | axis_of[1]) & np.logical_not(axis_of[2] | _of_thrust(problem))
    places = np.flatnonzero(own)
    if not len(places):
        return []
    rows = np.zeros((len(places), len(own)))
    rows[np.arange(len(places)), places] = problem.units[places]
    return [Candidate(CURRENT, np.eye(len(places)), lambda theta, phi: theta + phi @ rows, "drag")]


def _thrusters(problem: Problem) -> list[Candidate]:
    """The gain of one thruster, each in turn; with a single one that is the battery's, and none of forces.

    Without coupling terms a thruster may change all gains alike. Then it is the battery's candidate, too.
    """
    vehicle = problem.model.vehicle
    mix = np.asarray(vehicle.mix, dtype=float)  # (forces, actuators)
    forces_alone = set(vehicle.actuators) <= set(WRENCH)  # which the boat allocates itself
    if mix.shape[1] < 2 or forces_alone:
        return []
    back = np.linalg.pinv(mix)
    prior = np.array([[TYPICAL_CHANGE**2]])
    all_alike = np.diag(_of_thrust(problem).astype(float))
    found = []
    for k, name in enumerate(vehicle.actuators):
        slopes = _force_map(problem, np.outer(mix[:, k], back[k]))
        if not slopes.any():
            continue
        if np.allclose(slopes, slopes.max() * all_alike):
            return [replace(one, cause=ONE_THRUSTER, shown=None) for one in _battery(problem)]
        change = partial(_linear, slopes)
        one = Candidate(ONE_THRUSTER, prior, change, name, lambda phi: float(phi[0]))
        found.append(one)
    return found


def _linear(slopes: Array, theta: Array, phi: Array) -> Array:
    """Coefficients (n,) that change by slopes (n, n) of them."""
    return np.asarray(theta + phi[0] * (slopes @ theta))


def _force_map(problem: Problem, change: Array) -> Array:
    """(n, n) change of the thrust gains by theta, where the forces change by `change` (f, f)."""
    model = problem.model
    forces = [force.name for force in model.structure.forces]
    own = [force.name for force in model.vehicle.forces]
    gains: dict[tuple[int, str], tuple[int, float]] = {}
    for term in model.structure.terms:
        lone = len(term.factors) == 1 and term.factors[0] in forces and term.acceleration is None
        if lone and term.coefficient in problem.names:
            place = problem.names.index(term.coefficient)
            gains[term.axis, term.factors[0]] = place, term.number
    out = np.zeros((len(problem.names),) * 2)
    for (axis, force), (to, number) in gains.items():
        for (other, by), (begin, weight) in gains.items():
            if axis == other and force in own and by in own:
                out[to, begin] += weight * change[own.index(by), own.index(force)] / number
    return out


def _axes(problem: Problem) -> Array:
    """(3, n) whether a coefficient is drag, thrust or a coupling of an axis."""
    out = np.zeros((3, len(problem.names)), dtype=bool)
    for term in problem.model.structure.terms:
        if term.coefficient in problem.names:
            out[term.axis, problem.names.index(term.coefficient)] = True
    return out


def _of_thrust(problem: Problem) -> Array:
    """(n,) whether a coefficient is of thrust."""
    own = set().union(*(thrust_and_drag(problem.model, axis)["thrust"] for axis in range(3)))
    return np.array([name in own for name in problem.names])


def coupling_unit(model: Model, name: str) -> float | None:
    """The coefficient that makes full thrust at the envelope's edge; None: it couples no axes.

    A coupling is a term of another axis' acceleration, velocity or force.
    """
    terms = [t for t in model.structure.terms if t.coefficient == name]
    sizes = [_largest(model, t) for t in terms if _couples(model, t)]
    thrust = max((full_thrust(model, t.axis) for t in terms), default=0.0)
    if len(sizes) < len(terms) or not sizes or max(sizes) <= 0.0 or thrust <= 0.0:
        return None
    return thrust / max(sizes)


def _couples(model: Model, term: Term) -> bool:
    axis_of: Mapping[str, int] = {
        **{force.name: force.axis for force in model.structure.forces},
        **{s: i for i, s in enumerate("uvr")},
    }
    if term.acceleration is not None:
        return term.acceleration != term.axis
    return bool(term.factors) and all(axis_of[f.strip("|")] != term.axis for f in term.factors)


def full_thrust(model: Model, axis: int) -> float:
    """Largest acceleration that one force gave the axis, [m/s^2] or [rad/s^2]; 0: none does."""
    forces = {force.name for force in model.structure.forces}
    return max(
        (
            abs(model.values[t.coefficient]) * _largest(model, t)
            for t in model.structure.terms
            if t.axis == axis and t.coefficient and len(t.factors) == 1 and t.factors[0] in forces
            and t.acceleration is None
        ),
        default=0.0,
    )  # fmt: skip


def _largest(model: Model, term: Term) -> float:
    """Largest product of a term's factors within the envelope; without one 1 of each."""
    ranges = {**model.envelope.speeds, **model.envelope.forces}
    size = abs(term.number)
    for factor in term.factors:
        size *= max(map(abs, ranges.get(factor.strip("|"), (1.0, 1.0))))
    return size if term.acceleration is None else size * full_thrust(model, term.acceleration)
