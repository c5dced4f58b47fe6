# SPDX-License-Identifier: MIT
"""Identifiability: how well each parameter is known, and which combinations of parameters are better known.

Combinations are the narrow directions of the covariance (Belsley, Kuh, Welsch, Regression Diagnostics, 1980,
section 3.2).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.identification.uncertainty.parameter_verdict import (
    ParameterAccuracy,
    ParameterVerdict,
    is_force_term,
    parameter_accuracy,
    verdict_of,
)
from seatrial.util.frames import SYMBOLS, Array

CORRELATED = 0.9  # correlation of two parameters from which on it is reported
INSEPARABLE = 0.95  # correlation from which on two parameters count as not separable
NARROW_EIGENVALUE = 0.2  # of a correlation matrix: below it a direction is well determined
LEAST_ENTRY = 0.3  # of an eigenvector's largest entry: smaller ones are left out
# ratio of the errors without and with a parameter: those with less are left out
LEAST_IMPROVEMENT = 1.2
# of the error of a plain sum or difference over the best: up to here it is taken
PLAIN_SUM_RATIO = 1.5
SUMMABLE_PAIRS = (("lag", "latency"), ("edge_forward", "edge_reverse"))  # of one unit


@dataclass(frozen=True)
class Combination:
    """Parameters of which a combination is better known than each."""

    names: tuple[str, ...]
    text: str  # the combination
    value: float
    error: float
    unit: str
    correlation: float  # of the first two
    verdict: ParameterVerdict


@dataclass(frozen=True)
class Estimates:
    """The estimated parameters of a model."""

    model: Model
    names: tuple[str, ...]
    values: Array  # (p,)
    covariance: Array  # (p, p)
    findings: dict[str, ParameterAccuracy]

    def correlation(self, i: int, j: int) -> float:
        """Of two parameters."""
        size = np.sqrt(self.covariance[i, i] * self.covariance[j, j])
        return float(self.covariance[i, j] / size)

    def spread(self, weights: Array, places: Sequence[int]) -> float:
        """Standard error of a weighted sum."""
        part = self.covariance[np.ix_(places, places)]
        return float(np.sqrt(max(0.0, float(weights @ part @ weights))))


@dataclass(frozen=True)
class Identifiability:
    """Verdicts, and the correlations of the estimated parameters."""

    findings: tuple[ParameterAccuracy, ...]
    names: tuple[str, ...]  # (p,) of what was estimated
    correlation: Array  # (p, p)
    condition: float  # of the correlation matrix; 1 without correlations
    combinations: tuple[Combination, ...]

    def __getitem__(self, name: str) -> ParameterAccuracy:
        return next(found for found in self.findings if found.name == name)


def identifiability(model: Model) -> Identifiability:
    """Verdicts from a model's covariance, with the combinations that are better known."""
    values = np.concatenate([model.coefficients, model.constants])
    errors = np.sqrt(np.diag(model.covariance))
    sought = np.flatnonzero(errors > 0)
    names = tuple(model.parameters[i] for i in sought)
    matrix = model.covariance[np.ix_(sought, sought)]
    correlation = matrix / np.outer(errors[sought], errors[sought])
    findings = [parameter_accuracy(model, name, names, correlation) for name in model.parameters]
    known = Estimates(model, names, values[sought], matrix, {f.name: f for f in findings})
    return Identifiability(
        tuple(findings), names, correlation, condition(correlation), combinations(known)
    )


def condition(correlation: Array) -> float:
    """Largest over smallest eigenvalue of a correlation matrix (p, p); infinite if singular."""
    if not correlation.size:
        return 1.0
    spectrum = np.linalg.eigvalsh(correlation)
    return float(spectrum[-1] / spectrum[0]) if spectrum[0] > 1e-12 * spectrum[-1] else np.inf


def combinations(known: Estimates) -> tuple[Combination, ...]:
    """Named pairs that are correlated, then further combinations of the weak parameters."""
    found = [*_sums(known), *_slopes(known)]
    used = {frozenset(c.names) for c in found}
    weak = [i for i in _unreliable(known) if not any(known.names[i] in names for names in used)]
    for places in _narrow(known, weak):
        combined = _combined(known, places)
        if combined.verdict.reliable and not any(used & {frozenset(combined.names)}):
            used.add(frozenset(combined.names))
            found.append(combined)
    return tuple(found)


def _unreliable(known: Estimates) -> list[int]:
    """Parameters that are not reliable, and those correlated with one of them."""
    every = range(len(known.names))
    weak = [i for i in every if not known.findings[known.names[i]].verdict.reliable]
    return [
        i
        for i in every
        if any(abs(known.correlation(i, j)) > CORRELATED for j in weak) or i in weak
    ]


def _sums(known: Estimates) -> list[Combination]:
    """Lag + latency, and both edges, of each group of actuators, where one of the two is not sharp."""
    found = []
    for first, second in SUMMABLE_PAIRS:
        for i, name in enumerate(known.names):
            stage, dot, group = name.partition(".")
            other = f"{second}{dot}{group}"
            if stage != first or other not in known.names:
                continue
            j = known.names.index(other)
            sharp = {known.findings[n].verdict for n in (name, other)} == {ParameterVerdict.SHARP}
            if abs(known.correlation(i, j)) > CORRELATED and (first == "lag" or not sharp):
                found.append(_combined(known, [i, j]))
    return found


def _slopes(known: Estimates) -> list[Combination]:
    """Gain past the dead zone's edge, where gain and edge are correlated."""
    gains = {t.coefficient for t in known.model.structure.terms if is_force_term(known.model, t)}
    found = []
    for i, gain in enumerate(known.names):
        for j, edge in enumerate(known.names):
            if gain not in gains or edge.partition(".")[0] not in SUMMABLE_PAIRS[1]:
                continue
            both = {known.findings[n].verdict for n in (gain, edge)}
            if abs(known.correlation(i, j)) < CORRELATED or both == {ParameterVerdict.SHARP}:
                continue
            left = 1.0 - known.values[j]
            value = float(known.values[i] / left)
            error = known.spread(np.array([1.0 / left, value / left]), [i, j])
            verdict, _ = verdict_of(gain, value, error)
            unit, text = (
                known.findings[gain].unit,
                f"the gain past the edge, {gain} / (1 - {edge}),",
            )
            rho = known.correlation(i, j)
            found.append(Combination((gain, edge), text, value, error, unit, rho, verdict))
    return found


def _narrow(known: Estimates, weak: Sequence[int]) -> list[list[int]]:
    """Sets of weak parameters that have large entries in a narrow direction of their correlations."""
    if len(weak) < 2:
        return []
    size = np.sqrt(np.diag(known.covariance))[list(weak)]
    correlation = known.covariance[np.ix_(weak, weak)] / np.outer(size, size)
    spectrum, vectors = np.linalg.eigh(correlation)
    found = []
    for i in np.flatnonzero(spectrum < NARROW_EIGENVALUE):
        entries = np.abs(vectors[:, i])
        places = [
            weak[int(j)] for j in np.argsort(-entries) if entries[j] > LEAST_ENTRY * entries.max()
        ]
        found += [places] if len(places) > 1 else []
    return found


def _combined(known: Estimates, places: Sequence[int]) -> Combination:
    """The first of some parameters, plus the multiples of the others that make the sum best known.

    The least variance of a sum in which one weight is 1 is the variance of that one, given the others.
    """
    order = sorted(places)
    for i in order[1:]:
        without = [j for j in order if j != i]
        if (
            len(without) > 1
            and _best(known, without)[1] < LEAST_IMPROVEMENT * _best(known, order)[1]
        ):
            order = without
    weights = _best(known, order)[0]
    plain = np.sign(weights)
    units = {known.findings[known.names[i]].unit for i in order}
    if len(units) == 1 and known.spread(plain, order) < PLAIN_SUM_RATIO * known.spread(
        weights, order
    ):
        weights = plain
    return _weighted(known, order, weights)


def _best(known: Estimates, order: Sequence[int]) -> tuple[Array, float]:
    """Weights of the best-known sum, the first 1, rounded as they are printed; its error."""
    C = known.covariance[np.ix_(order, order)]
    others = -np.linalg.lstsq(C[1:, 1:], C[1:, 0], rcond=None)[0]
    weights = np.array([1.0, *(float(f"{w:.2g}") for w in others)])
    return weights, known.spread(weights, order)


def _weighted(known: Estimates, places: Sequence[int], weights: Array) -> Combination:
    names = [known.names[i] for i in places]
    value, error = float(weights @ known.values[list(places)]), known.spread(weights, places)
    unit = known.findings[names[0]].unit
    verdict, _ = verdict_of(names[0], value, error)
    text = _combination_text(known.model, names, weights)
    rho = known.correlation(places[0], places[1])
    return Combination(tuple(names), text, value, error, unit, rho, verdict)


def _combination_text(model: Model, names: Sequence[str], weights: Array) -> str:
    """A weighted sum as text."""
    if len(names) == 2 and abs(weights[1]) == 1.0:
        return "their sum" if weights[1] > 0 else "their difference"
    text = names[0]
    for name, weight in zip(names[1:], weights[1:], strict=True):
        text += f" {'-' if weight < 0 else '+'} {abs(weight):.2g} {name}"
    kinds = [{t.factors for t in model.structure.terms if t.coefficient == n} for n in names]
    for i, symbol in enumerate(SYMBOLS):
        if kinds == [{(symbol,)}, {(f"|{symbol}|", symbol)}] and weights[1] > 0:
            return f"the drag at {weights[1]:.2g} {'rad/s' if i == 2 else 'm/s'}, {text},"
    return text
