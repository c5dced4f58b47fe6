# SPDX-License-Identifier: MIT
"""An older model as prior for a short recording: how far it is trusted, and what became of it.

Its own errors say how well it knew the boat of then. The boat of now has another payload: the
prior is widened by what that may change, so that it can be wrong.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from seatrial.boat.finding_kinds import QUANTITIES
from seatrial.boat.findings import Finding, FindingKind, finding_of
from seatrial.boat.model import Model
from seatrial.boat.structure import Structure, Term
from seatrial.boat.vehicle import Vehicle
from seatrial.identification.diagnostics.scale_factors import thrust_and_drag
from seatrial.util.distributions import chi2_sf, holm, normal_two_sided
from seatrial.util.errors import IdentificationError
from seatrial.util.frames import AXES, SYMBOLS, Array, Axes

SPREAD = 0.2  # relative change of a coefficient that is to be expected
COMMON = (
    0.5  # share of that variance that is one factor for all drag and thrust of an axis: its mass
)
SLIGHT = 0.2  # share of an axis' largest term below which a term is taken to be as large as that
CLOCK = 0.05  # [s] that latency may change by: it holds what two clocks are apart
EDGE = 0.05  # dead-zone edges are taken to be at least so large
LEAST = 1e-6  # share of the prior's variance that a move from it has at least
CONFLICT = 0.05  # chance that a prior that is right is said to be contradicted
SILENT = 0.75  # share of the prior's variance from which on the recordings said nothing


@dataclass(frozen=True)
class Shift:
    """What became of one parameter: prior and result with their standard deviations."""

    name: str
    prior: float
    width: float  # of the widened prior
    found: float
    error: float

    @property
    def pull(self) -> float:
        """Move away from the prior over what it should be: var(found - prior) = width^2 - error^2."""
        expected = self.width**2 - self.error**2
        return float((self.found - self.prior) / np.sqrt(max(expected, LEAST * self.width**2)))

    @property
    def silent(self) -> bool:
        """Whether the recordings said nothing of it: it stayed what the prior says."""
        return self.error**2 > SILENT * self.width**2


def widened(prior: Model, spread: float = SPREAD) -> Model:
    """The prior with its covariance widened by a relative change `spread` of every parameter.

    Half of it is common to an axis, as with its mass. A coefficient near 0 may change as if its term
    were `SLIGHT` of its axis' largest at the speeds that the prior was identified at; latency by
    `CLOCK` [s]. Of parameters at a bound it is not known how well they are known: their variance
    stays 0. Raises IdentificationError.
    """
    if not 0.0 < spread < np.inf:
        raise IdentificationError(
            f"prior spread {spread:g}: expected a share above 0, like {SPREAD:g}"
        )
    least = _least(prior)
    sizes = [max(abs(value), least.get(name, 0.0)) for name, value in prior.values.items()]
    names = [name.partition(".")[0] for name in prior.vehicle.constants.names]
    more = [spread * size for size in sizes]
    for name, value in zip(names, prior.constants.tolist(), strict=True):
        size = max(abs(value), EDGE) if name.startswith("edge") else abs(value)
        more.append(CLOCK if name == "latency" else spread * size)
    said = np.array([name not in prior.at_bounds for name in prior.parameters])
    added = np.diag(np.square(more) * said)
    for axis in range(3):
        together = [i for i in _of_axis(prior, axis) if said[i]]
        for i in together:
            for j in set(together) - {i}:
                added[i, j] = COMMON * spread**2 * prior.coefficients[i] * prior.coefficients[j]
    return replace(prior, covariance=prior.covariance + added)


def _of_axis(model: Model, axis: int) -> list[int]:
    """Coefficients of drag and thrust that stand in this axis alone: Eq. (12) is per unit mass."""
    out = []
    for i, name in enumerate(model.structure.coefficients):
        own = [t for t in model.structure.terms if t.coefficient == name]
        if all(t.axis == axis and not t.of_masses for t in own):
            out.append(i)
    return out


def _least(model: Model) -> dict[str, float]:
    """By coefficient the value that makes its term `SLIGHT` of its axis' largest."""
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
            out[term.coefficient or ""] = SLIGHT * float(largest[term.axis]) / size
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
    prior.vehicle.check_sides(vehicle)
    if not lever and not vehicle.same_origin(prior.vehicle):
        ahead, left = prior.vehicle.lever
        point = f"[{ahead:.3f}, {-left if vehicle.axes is Axes.FRD else left:.3f}]"
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


def shifts(prior: Model, found: Model) -> list[Shift]:
    """What became of every parameter that a widened `prior` knows and that was sought."""
    old = dict(zip(prior.parameters, _values(prior), strict=True))
    return [
        Shift(name, old[name], prior.standard_errors[name], value, found.standard_errors[name])
        for name, value in zip(found.parameters, _values(found), strict=True)
        if name in old and prior.standard_errors[name] > 0 and found.standard_errors[name] > 0
    ]


def _values(model: Model) -> list[float]:
    return [*model.coefficients.tolist(), *model.constants.tolist()]


def conflicts(found: Sequence[Shift]) -> list[Shift]:
    """Parameters that recordings pull further from the prior than all of them together by chance."""
    heard = [s for s in found if not s.silent]
    chance = holm([normal_two_sided(s.pull) for s in heard])
    return [s for s, p in zip(heard, chance, strict=True) if p < CONFLICT]


@dataclass(frozen=True)
class Common:
    """One factor by axis on thrust, drag or both: found over prior."""

    what: str  # of QUANTITIES
    factors: dict[str, float]  # by axis
    p: float  # chance of factors as far from 1, of a prior that is right


def commons(prior: Model, found: Model) -> list[Common]:
    """By cause the factors that all coefficients of an axis share, the `prior` being widened.

    One parameter may change by twice what is expected; all of a kind together hardly do.
    """
    heard = [s.name for s in shifts(prior, found) if not s.silent]
    out = []
    for what in QUANTITIES:
        factors, chi2 = {}, 0.0
        for axis, word in enumerate(AXES):
            thrust, drag = thrust_and_drag(found.structure, axis)
            kinds = {"thrust": thrust, "drag": drag}
            names = [n for n in heard if n in kinds.get(what, thrust | drag)]
            if names:
                more, known = _factor(prior, found, names)
                factors[word] = 1.0 + more
                chi2 += more**2 * known
        if factors:
            out.append(Common(what, factors, chi2_sf(chi2, len(factors))))
    return out


def _factor(prior: Model, found: Model, names: Sequence[str]) -> tuple[float, float]:
    """Relative change of coefficients, a mean weighed as the prior knows each, and its information."""
    (old, width), (new, error) = (_of(model, names) for model in (prior, found))
    weights = old / np.diag(width)
    weights /= weights @ old
    # var(found - prior) = width^2 - error^2, as in `Shift.pull`
    wide = weights @ width @ weights
    expected = max(wide - weights @ error @ weights, LEAST * wide)
    return float(weights @ (new - old)), float(1.0 / expected)


def _of(model: Model, names: Sequence[str]) -> tuple[Array, Array]:
    """Values (m,) and covariance (m, m) of some parameters."""
    at = [model.parameters.index(name) for name in names]
    return np.array(_values(model))[at], model.covariance[np.ix_(at, at)]


def shift_findings(
    found: Sequence[Shift], spread: float, common: Sequence[Common] = ()
) -> list[Finding]:
    """The same as findings."""
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
    if best is not None and best.p * len(common) < CONFLICT:
        for axis, factor in best.factors.items():
            kind = FindingKind.PRIOR_FACTOR
            findings.append(finding_of(kind, axis, quantity=best.what, factor=factor))
    silent = [s.name for s in found if s.silent]
    return [*findings, finding_of(FindingKind.PRIOR_DOMINATES, *silent)] if silent else findings


def with_prior_said(found: Model, prior: Model, spread: float) -> Model:
    """The result with what its prior was: its recordings stand behind it, too."""
    wide = widened(prior, spread)
    findings = shift_findings(shifts(wide, found), spread, commons(wide, found))
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
