# SPDX-License-Identifier: MIT
"""Which parameters of the same name are comparable: same terms, forces, actuators and stages."""

import numpy as np

from seatrial.boat.actuators import STAGES
from seatrial.boat.allocation import Scheme
from seatrial.boat.model import Model
from seatrial.boat.structure import Term
from seatrial.boat.vehicle import WRENCH, Vehicle


def not_comparable(a: Model, b: Model) -> dict[str, str]:
    """Reasons why parameters of the same name are not comparable; empty where they are."""
    found = {}
    strange = {
        f.name
        for f in a.structure.forces
        if _actuation(a.vehicle, f.name) & _actuation(b.vehicle, f.name) == set()
    }
    for name in set(a.structure.coefficients) & set(b.structure.coefficients):
        mine, yours = (_terms(m, name) for m in (a, b))
        used = {f for t in mine for f in t.factors} & strange
        if {_key(t) for t in mine} != {_key(t) for t in yours}:
            texts = [" + ".join(t.text() for t in terms) for terms in (mine, yours)]
            found[name] = f"it is {texts[0]} in A, {texts[1]} in B"
        elif used:
            found[name] = f"{', '.join(sorted(used))} is a sum of other actuators or weights"
    for label, model in (("A", a), ("B", b)):
        for name in model.at_bounds:
            found[name] = f"it is at the bound of its range in {label}: its error is unknown"
    for name in set(a.vehicle.constants.names) & set(b.vehicle.constants.names):
        if _actuators_of(a.vehicle, name) != _actuators_of(b.vehicle, name):
            found[name] = "it is of other actuators"
        elif _stages_of(a.vehicle, name) != _stages_of(b.vehicle, name):
            found[name] = "it is of the opposite direction, as the files' axes negate the command"
    return found


def _terms(model: Model, name: str) -> list[Term]:
    return [t for t in model.structure.terms if t.coefficient == name]


def _key(term: Term) -> tuple[object, ...]:
    return term.axis, term.number, tuple(sorted(term.factors)), term.acceleration


def fixed_terms(model: Model) -> set[tuple[object, ...]]:
    """The terms without a coefficient."""
    return {_key(t) for t in model.structure.terms if t.coefficient is None}


def _actuation(vehicle: Vehicle, force: str) -> set[tuple[tuple[str, float], ...]]:
    """Actuators and weights of a force, and the input where inputs are the forces."""
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


def _actuators_of(vehicle: Vehicle, name: str) -> set[str]:
    """Actuators of a constant; empty where it is of all."""
    place = vehicle.constants.names.index(name)
    users = (vehicle.constants.index == place).any(axis=1)
    return set() if users.all() else {n for n, u in zip(vehicle.actuators, users, strict=True) if u}


def _stages_of(vehicle: Vehicle, name: str) -> list[set[int]]:
    """For each actuator the stages of a constant, in forward-left-up axes."""
    place = vehicle.constants.names.index(name)
    index = vehicle.stages[:, : len(STAGES)]
    return [set(np.flatnonzero(row == place).tolist()) for row in index]
