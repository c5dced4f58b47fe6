# SPDX-License-Identifier: MIT
"""An older model as prior for a short recording: its width, and the shift of each parameter.

Its covariance describes the boat at that time. The boat has another payload now: the covariance is widened by
the expected change of every parameter, so that the recording can correct it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from seatrial.boat.finding_texts.spec import QUANTITIES
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.boat.structure import Structure, Term
from seatrial.boat.vehicle import Vehicle
from seatrial.util.distributions import chi2_sf, holm, normal_two_sided
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import AXES, SYMBOLS, Array

SPREAD = 0.2  # expected relative change of a coefficient: a payload of a fifth of the mass
COMMON_SHARE = 0.5  # of that variance: one factor on all drag and thrust of an axis, its mass
LEAST_TERM_SHARE = 0.2  # of an axis' largest term: a smaller term is widened like one of this size
LATENCY_CHANGE = 0.05  # [s] expected: it includes the offset of two clocks
CONFLICT_LEVEL = 0.05  # significance level, over all parameters together
DOMINATED_SHARE = 0.75  # of the prior's variance left: more, and the estimate is mostly the prior's


@dataclass(frozen=True)
class PriorShift:
    """Prior and estimate of one parameter, with their standard deviations."""

    name: str
    prior: float
    width: float  # of the widened prior
    found: float
    error: float

    @property
    def normalised(self) -> float:
        """Shift from the prior over its standard deviation: var(found - prior) = width^2 - error^2."""
        expected = self.width**2 - self.error**2  # never 0, so that it divides
        return float((self.found - self.prior) / np.sqrt(max(expected, 1e-6 * self.width**2)))

    @property
    def dominated(self) -> bool:
        """Whether the recordings have little information on it: the estimate is mostly the prior's."""
        return self.error**2 > DOMINATED_SHARE * self.width**2


def widened(prior: Model, spread: float = SPREAD) -> Model:
    """The prior with its covariance widened by a relative change `spread` of every parameter.

    Half of it is common to an axis, as with its mass. A coefficient near 0 changes as if its term were
    `LEAST_TERM_SHARE` of its axis' largest at the speeds of the prior's recordings; latency by `LATENCY_CHANGE`.
    Parameters at a bound have no standard error: their variance stays 0. Raises IdentificationError.
    """
    if not 0.0 < spread < np.inf:
        raise IdentificationError(
            f"prior spread {spread:g}: expected a share above 0, like {SPREAD:g}"
        )
    least = _least_values(prior)
    sizes = [max(abs(value), least.get(name, 0.0)) for name, value in prior.values.items()]
    names = [name.partition(".")[0] for name in prior.vehicle.constants.names]
    more = [spread * size for size in sizes]
    for name, value in zip(names, prior.constants.tolist(), strict=True):
        size = max(abs(value), 0.05) if name.startswith("edge") else abs(value)
        more.append(LATENCY_CHANGE if name == "latency" else spread * size)
    has_error = np.array([name not in prior.at_bounds for name in prior.parameters])
    added = np.diag(np.square(more) * has_error)
    for axis in range(3):
        together = [i for i in _of_axis(prior, axis) if has_error[i]]
        for i in together:
            for j in set(together) - {i}:
                added[i, j] = (
                    COMMON_SHARE * spread**2 * prior.coefficients[i] * prior.coefficients[j]
                )
    return replace(prior, covariance=prior.covariance + added)


def _of_axis(model: Model, axis: int) -> list[int]:
    """Coefficients of drag and thrust that stand in this axis alone: Eq. (12) is per unit mass."""
    out = []
    for i, name in enumerate(model.structure.coefficients):
        own = [t for t in model.structure.terms if t.coefficient == name]
        if all(t.axis == axis and not t.of_masses for t in own):
            out.append(i)
    return out


def _least_values(model: Model) -> dict[str, float]:
    """For each coefficient the value that makes its term `LEAST_TERM_SHARE` of its axis' largest."""
    sizes = {**model.envelope.speeds, **model.envelope.forces}
    top = {name: max(abs(low), abs(high)) for name, (low, high) in sizes.items()}
    named = [t for t in model.structure.terms if t.coefficient is not None]

    def regressor(term: Term) -> float:
        return float(np.prod([top.get(f.strip("|"), 0.0) for f in term.factors])) * abs(term.number)

    largest = np.zeros(3)
    for term in named:
        if term.acceleration is None:
            value = abs(model.values[term.coefficient or ""]) * regressor(term)
            largest[term.axis] = max(largest[term.axis], value)
    out = {}
    for term in named:
        moved = 1.0 if term.acceleration is None else largest[term.acceleration]
        size = regressor(term) * moved
        if size > 0 and all(top.get(symbol) for symbol in SYMBOLS):
            out[term.coefficient or ""] = LEAST_TERM_SHARE * float(largest[term.axis]) / size
    return out


def check_prior(prior: Model, vehicle: Vehicle, *, lever: bool = False) -> None:
    """Refuse a prior of another structure, other actuators or another origin than the vehicle's.

    `lever`: the origin is sought. Raises IdentificationError, VehicleError.
    """
    mine, theirs = vehicle.actuators, prior.vehicle.actuators
    if mine != theirs:
        raise IdentificationError(
            f"the prior's actuators are {', '.join(theirs)}, the vehicle file's {', '.join(mine)}; take the "
            "vehicle file that the prior was identified with"
        )
    prior.check_sides(vehicle)
    if not lever and not vehicle.same_origin(prior.vehicle):
        ahead, left = prior.vehicle.lever
        point = f"[{ahead:.3f}, {vehicle.axes.lateral_sign * left:.3f}]"
        stated = list(vehicle.file.pose.lever or (0.0, 0.0))
        raise IdentificationError(
            f"the prior's poses are of a point {point} m from its origin, the vehicle file's of {stated}; "
            f"write 'lever: {point}' there, under pose, or add --effect lever"
        )
    for name in vehicle.structure.coefficients:
        if name in prior.values:
            own, other = (_meaning(s, name) for s in (vehicle.structure, prior.structure))
            if own != other:
                raise IdentificationError(
                    f"{name} is {' + '.join(sorted(other))} in the prior, {' + '.join(sorted(own))} in the "
                    "vehicle file; take a prior of the same terms"
                )


def _meaning(structure: Structure, name: str) -> set[str]:
    return {
        replace(t, factors=tuple(sorted(t.factors))).text()
        for t in structure.terms
        if t.coefficient == name
    }


def prior_shifts(prior: Model, found: Model) -> list[PriorShift]:
    """The shift of every estimated parameter that a widened `prior` has a variance of."""
    old = dict(zip(prior.parameters, _values(prior), strict=True))
    return [
        PriorShift(name, old[name], prior.standard_errors[name], value, found.standard_errors[name])
        for name, value in zip(found.parameters, _values(found), strict=True)
        if name in old and prior.standard_errors[name] > 0 and found.standard_errors[name] > 0
    ]


def _values(model: Model) -> list[float]:
    return [*model.coefficients.tolist(), *model.constants.tolist()]


def conflicts(found: Sequence[PriorShift]) -> list[PriorShift]:
    """Parameters whose shift is significant (Holm over all that are not dominated by the prior)."""
    informed = [s for s in found if not s.dominated]
    chance = holm([normal_two_sided(s.normalised) for s in informed])
    return [s for s, p in zip(informed, chance, strict=True) if p < CONFLICT_LEVEL]


@dataclass(frozen=True)
class CommonFactor:
    """One factor by axis on thrust, drag or both: estimate over prior."""

    what: str  # of QUANTITIES
    factors: dict[str, float]  # by axis
    p: float  # p-value of all axes' factors together


def common_factors(prior: Model, found: Model) -> list[CommonFactor]:
    """For each quantity the factors that all coefficients of an axis have in common; `prior` is widened.

    One parameter may change by twice the expected amount; all of one quantity together hardly do.
    """
    informed = [s.name for s in prior_shifts(prior, found) if not s.dominated]
    out = []
    for what in QUANTITIES:
        factors, chi2 = {}, 0.0
        for axis, word in enumerate(AXES):
            thrust, drag = found.structure.thrust_and_drag(axis)
            kinds = {"thrust": thrust, "drag": drag}
            names = [n for n in informed if n in kinds.get(what, thrust | drag)]
            if names:
                more, known = _factor(prior, found, names)
                factors[word] = 1.0 + more
                chi2 += more**2 * known
        if factors:
            out.append(CommonFactor(what, factors, chi2_sf(chi2, len(factors))))
    return out


def _factor(prior: Model, found: Model, names: Sequence[str]) -> tuple[float, float]:
    """Weighted mean of the coefficients' relative changes, and its information."""
    (old, width), (new, error) = (_of(model, names) for model in (prior, found))
    weights = old / np.diag(width)
    weights /= weights @ old
    # var(found - prior) = width^2 - error^2, as in `PriorShift.normalised`
    wide = weights @ width @ weights
    expected = max(wide - weights @ error @ weights, 1e-6 * wide)
    return float(weights @ (new - old)), float(1.0 / expected)


def _of(model: Model, names: Sequence[str]) -> tuple[Array, Array]:
    """Values (m,) and covariance (m, m) of some parameters."""
    at = [model.parameters.index(name) for name in names]
    return np.array(_values(model))[at], model.covariance[np.ix_(at, at)]


def prior_findings(
    found: Sequence[PriorShift], spread: float, common: Sequence[CommonFactor] = ()
) -> list[Finding]:
    """Findings on the prior: its use, significant shifts, parameters that it dominates."""
    findings = [finding_of(FindingKind.PRIOR_USED, spread=spread)]
    for s in conflicts(found):
        findings.append(
            finding_of(
                FindingKind.PRIOR_CONFLICT,
                s.name,
                prior=s.prior,
                prior_error=s.width,
                found=s.found,
                found_error=s.error,
            )
        )
    best = min(common, key=lambda c: c.p, default=None)
    if best is not None and best.p * len(common) < CONFLICT_LEVEL:
        for axis, factor in best.factors.items():
            kind = FindingKind.PRIOR_FACTOR
            findings.append(finding_of(kind, axis, quantity=best.what, factor=factor))
    dominated = [s.name for s in found if s.dominated]
    return (
        [*findings, finding_of(FindingKind.PRIOR_DOMINATES, *dominated)] if dominated else findings
    )


def with_prior_findings(found: Model, prior: Model, spread: float) -> Model:
    """The result with findings on its prior, and with the prior's recordings."""
    wide = widened(prior, spread)
    findings = prior_findings(prior_shifts(wide, found), spread, common_factors(wide, found))
    older = [entry for entry in prior.recordings if entry not in found.recordings]
    files = {f.sha256 for entry in prior.recordings for f in entry.files}
    again = [r.name for r in found.recordings if any(f.sha256 in files for f in r.files)]
    if again:
        findings.append(finding_of(FindingKind.PRIOR_COUNTED_TWICE, *again))
    settings = {**found.estimator.settings, "prior": prior.estimator.method, "prior_spread": spread}
    estimator = msgspec.structs.replace(
        found.estimator, settings=settings, findings=[*found.estimator.findings, *findings]
    )
    return replace(found, recordings=(*found.recordings, *older), estimator=estimator)
