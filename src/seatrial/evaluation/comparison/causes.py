# SPDX-License-Identifier: MIT
"""Which one physical change explains the difference of two models best: posterior probabilities.

Every candidate is a map g(theta, phi) from A's coefficients to B's, with few unknowns phi and a Gaussian
prior on them. Its evidence is Laplace's approximation (MacKay, Information Theory, chapter 27; Kass and
Raftery 1995); the candidates are equally probable before.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import msgspec
import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.structure import Term
from seatrial.evaluation.comparison.parameters import (
    Pair,
    View,
    estimated_in_both,
    thrust_and_drag,
)
from seatrial.evaluation.comparison.thrust_curves import stages_apart
from seatrial.util.errors import SeatrialError
from seatrial.util.frames import Array
from seatrial.util.statistics import inverse_of

TYPICAL_CHANGE = 0.3  # [-] standard deviation of a change of mass, thrust or drag, before the logs
COUPLING_CHANGE = 0.3  # [share of full thrust] the same of a coupling term, at the envelope's edge
BOTH_HULL_AXES = (
    0.9  # correlation of the changes in surge and sway: added mass differs between them
)
MASS_AND_INERTIA = 0.7  # the same of mass and inertia: a payload may lie near the middle
ROUNDS, HALVINGS, CONVERGED = 40, 20, 1e-9  # of the search; relative step that ends it
SAME_EVIDENCE = 1e-6  # [-] difference of logarithms, of two candidates with one map
PROBABLE = 0.5  # from which on one cause is more probable than all others together

NO_CHANGE = "no change"
MASS = "mass"
OFF_CENTRE = "mass off centre"
ONE_THRUSTER = "one thruster"
BATTERY = "battery"
CURRENT = "current"
NONE_OF_THESE = "none of these"
CAUSES = (NO_CHANGE, MASS, OFF_CENTRE, BATTERY, ONE_THRUSTER, CURRENT, NONE_OF_THESE)


class Cause(msgspec.Struct, frozen=True):
    """One candidate. Probabilities of all add up to 1."""

    cause: str  # one of `CAUSES`
    probability: float
    change: float | None = (
        None  # [-] the relative change that fits best; None: it has no single one
    )
    what: str = ""  # of what: a quantity, or a thruster
    log_evidence: float = 0.0  # less that of the best


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


def causes(a: Model, b: Model, found: Sequence[Pair], seen: tuple[View, View]) -> list[Cause]:
    """All candidates, the most probable first; none where no coefficient can be compared."""
    problem = _problem(a, b, found, seen)
    if problem is None:
        return []
    best: list[tuple[float, Candidate, Array]] = []
    for cause in CAUSES:
        own = [one for one in candidates(problem) if one.cause == cause]
        tried = [(*evidence(problem, one), one) for one in own]
        if not tried:
            continue
        log, phi, one = max(tried, key=lambda t: t[0])
        whole = np.logaddexp.reduce([t[0] for t in tried]) - np.log(len(tried))
        best.append((float(whole) if len(tried) > 1 else log, one, phi))
    most = max(log for log, _, _ in best)
    total = sum(np.exp(log - most) for log, _, _ in best)
    out = [
        Cause(
            one.cause,
            float(np.exp(log - most) / total),
            None if one.shown is None else one.shown(phi),
            one.what,
            log - most,
        )
        for log, one, phi in best
    ]
    return sorted(out, key=lambda cause: -cause.probability)


def _problem(a: Model, b: Model, found: Sequence[Pair], seen: tuple[View, View]) -> Problem | None:
    """Coefficients that both estimate; no thrust where its curves differ in stages."""
    left_out: set[str] = set()
    if stages_apart(a, b, any(view.converted for view in seen)):
        left_out = set().union(*(thrust_and_drag(a, axis)["thrust"] for axis in range(3)))
    names = [
        pair.name
        for pair in found
        if pair.name in a.values and pair.name not in left_out and estimated_in_both(pair)
    ]
    if not names:
        return None
    values, roots = [], []
    for view in seen:
        own, covariance = view.of(names)
        values.append(own)
        roots.append(np.asarray(np.linalg.cholesky(inverse_of(covariance)).T))
    return Problem(a, tuple(names), (values[0], values[1]), (roots[0], roots[1]))


def candidates(problem: Problem) -> list[Candidate]:
    """Those that this model can show."""
    n = len(problem.names)
    found = [
        Candidate(NO_CHANGE, np.zeros((0, 0)), lambda theta, phi: theta),
        *_masses(problem),
        *_thrusters(problem),
        *_battery(problem),
        *_current(problem),
    ]
    units = problem.units
    found.append(Candidate(NONE_OF_THESE, np.eye(n), lambda theta, phi: theta + units * phi))
    return found


def _masses(problem: Problem) -> list[Candidate]:
    """Every coefficient of an axis over one factor of mass; off centre the couplings change, too.

    Eq. (12) is per unit mass and inertia. phi: logarithms of the factors of mass by axis.
    """
    axis_of = _axes(problem)
    if not axis_of.any():
        return []
    hull, turn = BOTH_HULL_AXES, MASS_AND_INERTIA
    whole = TYPICAL_CHANGE**2 * np.array([[1.0, hull, turn], [hull, 1.0, turn], [turn, turn, 1.0]])
    there = np.flatnonzero(axis_of.any(axis=1))
    prior = whole[np.ix_(there, there)]
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


def _battery(problem: Problem) -> list[Candidate]:
    """All thrust by one factor; drag and masses stay."""
    thrust = _of_kind(problem, "thrust")
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
    own = (axis_of[0] | axis_of[1]) & np.logical_not(axis_of[2] | _of_kind(problem, "thrust"))
    places = np.flatnonzero(own)
    if not len(places):
        return []
    rows = np.zeros((len(places), len(own)))
    rows[np.arange(len(places)), places] = problem.units[places]
    return [Candidate(CURRENT, np.eye(len(places)), lambda theta, phi: theta + phi @ rows, "drag")]


def _thrusters(problem: Problem) -> list[Candidate]:
    """The gain of one thruster, each in turn; with a single one that is the battery's.

    Without coupling terms a thruster may change all gains alike. Then it is the battery's candidate, too.
    """
    vehicle = problem.model.vehicle
    mix = np.asarray(vehicle.mix, dtype=float)  # (forces, actuators)
    if mix.shape[1] < 2:
        return []
    back = np.linalg.pinv(mix)
    prior = np.array([[TYPICAL_CHANGE**2]])
    all_alike = np.diag(_of_kind(problem, "thrust").astype(float))
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


def _of_kind(problem: Problem, kind: str) -> Array:
    """(n,) whether a coefficient is of thrust, or of drag."""
    own = set().union(*(thrust_and_drag(problem.model, axis)[kind] for axis in range(3)))
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


def evidence(problem: Problem, candidate: Candidate) -> tuple[float, Array]:
    """Logarithm of the evidence, but for a constant of all candidates; the unknowns (m,) that fit best."""
    # 1. Gauss-Newton over A's coefficients and the unknowns, from no change.
    n, m = len(problem.names), len(candidate.covariance)
    scale = np.concatenate([problem.units, np.sqrt(np.diag(candidate.covariance))])
    best = np.concatenate([problem.values[0], np.zeros(m)])
    root = np.linalg.cholesky(np.linalg.inv(candidate.covariance)).T if m else np.zeros((0, 0))

    def residuals(x: Array) -> Array:
        theta, phi = x[:n], x[n:]
        a, b = problem.values
        return np.concatenate(
            [
                problem.roots[0] @ (a - theta),
                problem.roots[1] @ (b - candidate.change(theta, phi)),
                root @ phi,
            ]
        )

    def slopes(x: Array) -> Array:
        steps = 1e-6 * scale
        return (
            np.stack(
                [(residuals(x + step) - residuals(x - step)) / 2.0 for step in np.diag(steps)],
                axis=1,
            )
            / 1e-6
        )  # by the scaled unknowns

    for _ in range(ROUNDS):
        step = -np.linalg.lstsq(slopes(best), residuals(best), rcond=None)[0] * scale
        share, before = 1.0, float(np.sum(residuals(best) ** 2))
        for _ in range(HALVINGS):
            if float(np.sum(residuals(best + share * step) ** 2)) <= before:
                break
            share /= 2.0
        else:
            break
        best = best + share * step
        if np.max(np.abs(share * step / scale)) < CONVERGED:
            break
    # 2. Laplace: the cost, and the widths of likelihood and prior (units are those of `scale`).
    cost = float(np.sum(residuals(best) ** 2))
    jacobian = slopes(best)
    likelihood = float(np.linalg.slogdet(jacobian.T @ jacobian)[1])
    correlation = candidate.covariance / np.outer(scale[n:], scale[n:]) if m else np.zeros((0, 0))
    prior = float(np.linalg.slogdet(correlation)[1]) if m else 0.0
    log = -0.5 * (cost + likelihood + prior)
    if not np.isfinite(log):
        raise SeatrialError(f"the evidence of '{candidate.cause}' is not finite")
    return log, best[n:]


def most_probable(found: Sequence[Cause]) -> Cause | None:
    """The cause that is more probable than all others together; None: there is none."""
    return found[0] if found and found[0].probability > PROBABLE else None


def inseparable(found: Sequence[Cause]) -> bool:
    """Whether battery and one thruster lead, with one map: no term of the structure separates them."""
    leading = {cause.cause for cause in found[:2]} == {BATTERY, ONE_THRUSTER}
    return leading and abs(found[0].log_evidence - found[1].log_evidence) < SAME_EVIDENCE


def cause_text(found: Sequence[Cause]) -> str:
    """One sentence: what explains the difference best, and with which probability."""
    if not found:
        return "No cause can be computed: no coefficient was estimated in both models"
    first, rest = found[0], found[1:]
    if inseparable(found):
        both = f"{BATTERY} or {ONE_THRUSTER}"
        change = next(c.change for c in found if c.cause == BATTERY) or 0.0
        whole = sum(c.probability for c in found if c.cause in (BATTERY, ONE_THRUSTER))
        return (
            f"Most probable cause: {both} (thrust {_signed(change)}), {probability_text(whole)}. No term of this "
            "structure separates the two"
        )
    others = ", ".join(
        f"{c.cause} {probability_text(c.probability)}" for c in rest if c.probability >= 0.01
    )
    tail = f" ({others})" if others else ""
    if most_probable(found) is None:
        listed = ", ".join([f"{first.cause} {probability_text(first.probability)}", others]).rstrip(
            ", "
        )
        return f"The cause is not clear: {listed}"
    return f"Most probable cause: {_named(first)}, {probability_text(first.probability)}{tail}"


def _named(cause: Cause) -> str:
    if cause.cause == NONE_OF_THESE:
        return "none of the single causes"
    if cause.change is None:
        return cause.cause
    return f"{cause.cause} ({cause.what} {_signed(cause.change)})"


def _signed(change: float) -> str:
    return f"{'+' if change >= 0 else '-'}{abs(100.0 * change):.0f} %"


def probability_text(probability: float) -> str:
    """In per cent, without a false 0 or 100."""
    if probability > 0.99:
        return "> 99 %"
    return "< 1 %" if probability < 0.01 else f"{100.0 * probability:.0f} %"
