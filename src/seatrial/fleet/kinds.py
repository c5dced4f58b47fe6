# SPDX-License-Identifier: MIT
"""Boats against others of their kind: a robust centre and deviation of each parameter, and who is far from it.

An estimate of boat i is x_i = centre + b_i + e_i: b_i ~ N(0, tau^2) between boats, e_i ~ N(0, s_i^2) of its
recordings. This is the random-effects model of meta-analysis (DerSimonian and Laird, 1986). Centre and tau are
M-estimates with Huber's psi and his proposal 2 (Huber and Ronchetti, Robust Statistics, 2009, section 6.4): a few
odd boats move neither.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from seatrial.fleet.results import BoatResult, Deviation, Kind, KindParameter
from seatrial.util.distributions import holm, student_two_sided
from seatrial.util.frames import Array

FEWEST_BOATS = 5  # of a kind, below which nothing is compared
CLIP = 1.5  # [standard deviations] beyond which a boat counts no further
CLIPPED_VARIANCE = (  # E[min(z^2, CLIP^2)] of a standard normal z
    math.erf(CLIP / math.sqrt(2.0))
    - 2.0 * CLIP * math.exp(-0.5 * CLIP**2) / math.sqrt(2.0 * math.pi)
    + CLIP**2 * math.erfc(CLIP / math.sqrt(2.0))
)
EFFICIENCY = 0.65  # of the deviation, of as many boats that are all used
SIGNIFICANCE = 0.05  # after Holm's correction over boats and parameters of a kind
ROUNDS = 60  # of the two estimates in turns, and of halving


@dataclass(frozen=True)
class Centre:
    """One parameter of a kind."""

    value: float
    between: float  # tau, standard deviation between boats
    error: float  # standard error of the value


def centre_of(values: Array, errors: Array) -> Centre:
    """The robust centre of estimates (n,) with their standard errors (n,), and the deviation between boats."""
    at, tau = float(np.median(values)), 0.0
    for _ in range(ROUNDS):
        tau = _between(values - at, errors)
        deviation = np.hypot(errors, tau)
        weight = (
            np.minimum(1.0, CLIP / np.maximum(np.abs(values - at) / deviation, 1e-300))
            / deviation**2
        )
        moved = float(np.sum(weight * values) / np.sum(weight))
        if abs(moved - at) <= 1e-9 * float(np.min(deviation)):
            break
        at = moved
    return Centre(at, tau, float(1.0 / np.sqrt(np.sum(weight))))


def _between(off: Array, errors: Array) -> float:
    """tau: the mean of min(z^2, CLIP^2) is that of a normal distribution; 0 where the errors alone explain it."""

    def excess(tau: float) -> float:
        z = off / np.hypot(errors, tau)
        return float(np.mean(np.minimum(z**2, CLIP**2))) - CLIPPED_VARIANCE * (1.0 - 1.0 / len(off))

    if excess(0.0) <= 0.0:
        return 0.0
    low, high = 0.0, float(np.max(np.abs(off)))
    while excess(high) > 0.0:
        high *= 2.0
    for _ in range(ROUNDS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return high


@dataclass(frozen=True)
class Compared:
    """All boats of a kind: its parameters, and who differs."""

    kind: Kind
    differs: Mapping[str, list[Deviation]]  # by boat
    not_compared: Mapping[str, str]  # by boat, why


def compare_kind(boats: Sequence[BoatResult]) -> Compared:
    """Boats of one kind, those of the most frequent structure against each other."""
    with_model = [boat for boat in boats if boat.error is None]
    counted = Counter(boat.structure for boat in with_model).most_common()
    usual = min((s for s, n in counted if n == counted[0][1]), default="")
    alike = [boat for boat in with_model if boat.structure == usual]
    why = {b.name: OTHER_STRUCTURE for b in with_model if b.structure != usual}
    if len(alike) < FEWEST_BOATS:
        few = FEW.format(count=len(alike), fewest=FEWEST_BOATS)
        return Compared(Kind(len(boats), 0, {}), {}, why | {b.name: few for b in alike})
    tested: list[tuple[str, Deviation]] = []
    parameters: dict[str, KindParameter] = {}
    for name in alike[0].parameters:
        own = [boat for boat in alike if name in boat.parameters]
        if len(own) >= FEWEST_BOATS:
            parameters[name], found = deviations(name, own)
            tested += zip((boat.name for boat in own), found, strict=True)
    return Compared(Kind(len(boats), len(alike), parameters), _significant(tested), why)


OTHER_STRUCTURE = "its model has other terms or actuator stages than most boats of its kind"
FEW = "{count} boats of its kind have a model of one structure; {fewest} or more can be compared"


def deviations(name: str, boats: Sequence[BoatResult]) -> tuple[KindParameter, list[Deviation]]:
    """One parameter of the boats of a kind that have it, against their centre; p without correction."""
    values = np.array([boat.parameters[name].value for boat in boats])
    errors = np.array([boat.parameters[name].error for boat in boats])
    centre = centre_of(values, errors)
    deviation = np.hypot(np.hypot(errors, centre.between), centre.error)
    z = (values - centre.value) / deviation
    freedom = EFFICIENCY * (len(boats) - 1)
    known = KindParameter(centre.value, centre.between, boats[0].parameters[name].unit, len(boats))
    return known, [
        Deviation(
            name, float(x), centre.value, float(d), float(k), student_two_sided(float(k), freedom)
        )
        for x, d, k in zip(values, deviation, z, strict=True)
    ]


def _significant(tested: Sequence[tuple[str, Deviation]]) -> dict[str, list[Deviation]]:
    """Those that chance does not explain, by boat, the largest first."""
    found = defaultdict(list)
    for (boat, one), p in zip(tested, holm([d.p for _, d in tested]).tolist(), strict=True):
        if p < SIGNIFICANCE:
            found[boat].append(
                Deviation(one.parameter, one.value, one.centre, one.deviation, one.z, p)
            )
    return {boat: sorted(all_, key=lambda d: -abs(d.z)) for boat, all_ in found.items()}
