# SPDX-License-Identifier: MIT
"""Combinations of parameters that are known better than each of them.

They are the directions in which the covariance is narrow (Belsley, Kuh, Welsch, Regression
Diagnostics, 1980, section 3.2).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.boat.model import Model
from seatrial.identification.uncertainty.parameter_verdict import Finding, Verdict, pure, verdict_of
from seatrial.util.frames import SYMBOLS, Array

TOGETHER = 0.9  # correlation from which on it is said of two
APART = 0.95  # from which on they can't be told apart
NARROW = 0.2  # eigenvalue of a correlation matrix below which its direction is well determined
SHARE = 0.3  # of the largest entry: smaller ones of an eigenvector are left out
NEEDED = 1.2  # times the error without a parameter: those that do less are left out
SIMPLE = 1.5  # times the best error that a plain sum may have, rather than the best combination
PAIRS = ("lag", "latency"), ("edge_forward", "edge_reverse")  # in the same unit: a sum says it
EDGES = ("edge_forward", "edge_reverse")


@dataclass(frozen=True)
class Combination:
    """Parameters that are known together better than each."""

    names: tuple[str, ...]
    text: str  # how they are combined
    value: float
    error: float
    unit: str
    correlation: float  # of the first two
    verdict: Verdict


@dataclass(frozen=True)
class Known:
    """What was estimated, for the search of combinations."""

    model: Model
    names: tuple[str, ...]
    values: Array  # (p,)
    covariance: Array  # (p, p)
    findings: dict[str, Finding]

    def correlation(self, i: int, j: int) -> float:
        """Of two parameters."""
        size = np.sqrt(self.covariance[i, i] * self.covariance[j, j])
        return float(self.covariance[i, j] / size)

    def spread(self, weights: Array, places: Sequence[int]) -> float:
        """Standard error of a weighted sum."""
        part = self.covariance[np.ix_(places, places)]
        return float(np.sqrt(max(0.0, float(weights @ part @ weights))))


def combinations(known: Known) -> tuple[Combination, ...]:
    """Named pairs that are correlated, then what else the weak parameters tell together."""
    found = [*_sums(known), *_slopes(known)]
    used = {frozenset(c.names) for c in found}
    weak = [i for i in _loose(known) if not any(known.names[i] in names for names in used)]
    for places in _narrow(known, weak):
        combined = _combined(known, places)
        if combined.verdict.enough and not any(used & {frozenset(combined.names)}):
            used.add(frozenset(combined.names))
            found.append(combined)
    return tuple(found)


def _loose(known: Known) -> list[int]:
    """Parameters that one may not rely on, and those that are correlated with one of them."""
    every = range(len(known.names))
    weak = [i for i in every if not known.findings[known.names[i]].verdict.enough]
    return [
        i for i in every if any(abs(known.correlation(i, j)) > TOGETHER for j in weak) or i in weak
    ]


def _sums(known: Known) -> list[Combination]:
    """Lag + latency, and both edges, of each group of actuators, where one of the two is loose."""
    found = []
    for first, second in PAIRS:
        for i, name in enumerate(known.names):
            stage, dot, group = name.partition(".")
            other = f"{second}{dot}{group}"
            if stage != first or other not in known.names:
                continue
            j = known.names.index(other)
            sharp = {known.findings[n].verdict for n in (name, other)} == {Verdict.SHARP}
            if abs(known.correlation(i, j)) > TOGETHER and (first == "lag" or not sharp):
                found.append(_combined(known, [i, j]))
    return found


def _slopes(known: Known) -> list[Combination]:
    """Gain past the dead zone's edge, where gain and edge are correlated."""
    gains = {t.coefficient for t in known.model.structure.terms if pure(known.model, t)}
    found = []
    for i, gain in enumerate(known.names):
        for j, edge in enumerate(known.names):
            if gain not in gains or edge.partition(".")[0] not in EDGES:
                continue
            both = {known.findings[n].verdict for n in (gain, edge)}
            if abs(known.correlation(i, j)) < TOGETHER or both == {Verdict.SHARP}:
                continue
            left = 1.0 - known.values[j]
            value = float(known.values[i] / left)
            error = known.spread(np.array([1.0 / left, value / left]), [i, j])
            said, _ = verdict_of(gain, value, error)
            unit, text = (
                known.findings[gain].unit,
                f"the gain past the edge, {gain} / (1 - {edge}),",
            )
            rho = known.correlation(i, j)
            found.append(Combination((gain, edge), text, value, error, unit, rho, said))
    return found


def _narrow(known: Known, weak: Sequence[int]) -> list[list[int]]:
    """Sets of weak parameters that a narrow direction of their correlations consists of."""
    if len(weak) < 2:
        return []
    size = np.sqrt(np.diag(known.covariance))[list(weak)]
    correlation = known.covariance[np.ix_(weak, weak)] / np.outer(size, size)
    spectrum, vectors = np.linalg.eigh(correlation)
    found = []
    for i in np.flatnonzero(spectrum < NARROW):
        entries = np.abs(vectors[:, i])
        places = [weak[int(j)] for j in np.argsort(-entries) if entries[j] > SHARE * entries.max()]
        found += [places] if len(places) > 1 else []
    return found


def _combined(known: Known, places: Sequence[int]) -> Combination:
    """The first of some parameters, plus what of the others makes the sum sharpest.

    The least variance of a sum in which one weight is 1 is that one's, given the others.
    """
    order = sorted(places)
    for i in order[1:]:
        without = [j for j in order if j != i]
        if len(without) > 1 and _best(known, without)[1] < NEEDED * _best(known, order)[1]:
            order = without
    weights = _best(known, order)[0]
    plain = np.sign(weights)
    units = {known.findings[known.names[i]].unit for i in order}
    if len(units) == 1 and known.spread(plain, order) < SIMPLE * known.spread(weights, order):
        weights = plain
    return _weighted(known, order, weights)


def _best(known: Known, order: Sequence[int]) -> tuple[Array, float]:
    """Weights, the first 1 and all as they are printed, of the sharpest sum; its error."""
    C = known.covariance[np.ix_(order, order)]
    others = -np.linalg.lstsq(C[1:, 1:], C[1:, 0], rcond=None)[0]
    weights = np.array([1.0, *(float(f"{w:.2g}") for w in others)])
    return weights, known.spread(weights, order)


def _weighted(known: Known, places: Sequence[int], weights: Array) -> Combination:
    names = [known.names[i] for i in places]
    value, error = float(weights @ known.values[list(places)]), known.spread(weights, places)
    unit = known.findings[names[0]].unit
    said, _ = verdict_of(names[0], value, error)
    text = _said(known.model, names, weights)
    rho = known.correlation(places[0], places[1])
    return Combination(tuple(names), text, value, error, unit, rho, said)


def _said(model: Model, names: Sequence[str], weights: Array) -> str:
    """A weighted sum as people say it."""
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
