# SPDX-License-Identifier: MIT
"""The parameters in which a boat may change, and the physical changes as maps of them.

The space has the model's coefficients and chain constants, a gain for each thruster that shares a force with
others, and the acceleration couplings of a mass off centre (Fossen, Handbook of Marine Craft, 2nd ed., section
6.3). Gains are 1 and couplings 0 in the unchanged boat.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from seatrial import _core
from seatrial.boat.actuators import STAGES
from seatrial.boat.allocation import with_shared_forces
from seatrial.boat.model import Model
from seatrial.boat.schema import ChainGroup
from seatrial.boat.structure import MOST_COEFFICIENTS, MOST_TERMS, Term
from seatrial.boat.vehicle import Vehicle
from seatrial.evaluation.comparison.cause_candidates import (
    BATTERY,
    BOTH_HULL_AXES,
    COUPLING_CHANGE,
    MASS,
    MASS_AND_INERTIA,
    NO_CHANGE,
    NONE_OF_THESE,
    OFF_CENTRE,
    ONE_THRUSTER,
    TYPICAL_CHANGE,
    coupling_unit,
)
from seatrial.util.frames import Array

THRUSTER_CHANGE = 0.5  # [-] standard deviation of one thruster's gain: it may fail
# a mass off centre couples these axes' equations to those accelerations
COUPLINGS = {"X_offset_r": (0, 2), "Y_offset_r": (1, 2), "N_offset_u": (2, 0), "N_offset_v": (2, 1)}
LEAST_VARIANCE = 1e-14  # of the largest: less is round-off
DIFFERENCE = 1e-5  # of a difference quotient
GAINS = "changed"  # chain group of the gains


@dataclass(frozen=True)
class PhysicalChange:
    """A change of the parameters theta (n,) to theta * factor(phi) + phi @ shift.

    phi (m,) are its unknowns, independent with mean 0 and unit variance.
    """

    cause: str
    factor: Callable[[Array], Array]  # phi to (n,)
    shift: Array  # (m, n)
    what: str = ""
    size: Callable[[Array], float] | None = None  # phi to the relative change; None: it has none
    least: float = -np.inf  # of phi: below, the boat changes no further

    def inside(self, phi: Array) -> Array:
        """Phi, so far from its bound that difference quotients are those of the side where the boat changes."""
        return np.maximum(phi, self.least + DIFFERENCE)

    @property
    def unknowns(self) -> int:
        """m."""
        return len(self.shift)

    def of(self, theta: Array, phi: Array) -> Array:
        """Parameters (n,) of the changed boat."""
        return np.asarray(theta * self.factor(phi) + phi @ self.shift)

    def slopes(self, theta: Array, root: Array, phi: Array) -> Array:
        """d of(theta + root x, phi) / d (x, phi): (n, k + m), root (n, k)."""
        by_phi = difference_quotients(lambda other: self.of(theta, other), phi)
        return np.hstack([self.factor(phi)[:, None] * root, by_phi.reshape(len(theta), -1)])


@dataclass(frozen=True)
class ChangeSpace:
    """A model, widened by gains and couplings, and its possible changes."""

    own: Model
    wider: Model

    @cached_property
    def theta(self) -> Array:
        """Parameters (n,) of the unchanged boat."""
        return np.concatenate([self.wider.coefficients, self.wider.constants])

    @cached_property
    def root(self) -> Array:
        """(n, k) with covariance = root root': the errors of the identification."""
        values, vectors = np.linalg.eigh(self.wider.covariance)
        kept = values > values.max(initial=0.0) * LEAST_VARIANCE
        known = np.diag(self.wider.covariance) > 0.0
        return np.asarray(known[:, None] * vectors[:, kept] * np.sqrt(values[kept]))

    @cached_property
    def gains(self) -> dict[str, int]:
        """Place of each thruster's gain."""
        first = len(self.wider.coefficients)
        return {name: first + i for name, i in _stated_gains(self.wider.vehicle).items()}

    def boat(self, theta: Array, covariance: Array) -> Model:
        """The changed boat, without gains and couplings that did not change. Raises ModelError if not finite."""
        names, own = self.wider.parameters, self.own.parameters
        moved = {
            n for n, a, b in zip(names, theta, self.theta, strict=True) if n not in own and a != b
        }
        gains = bool(moved - COUPLINGS.keys())
        wider = _widened(self.own, gains, [n for n in COUPLINGS if n in moved])
        places = [names.index(name) for name in wider.parameters]
        n = len(wider.coefficients)
        changed = self._with_mean_gain(theta)
        slopes = difference_quotients(self._with_mean_gain, theta)
        spread = slopes @ covariance @ slopes.T
        constants = changed[places[n:]]
        # a file states gains
        stated = {
            name: value
            for name, value in zip(wider.vehicle.constants.names, constants.tolist(), strict=True)
            if name.startswith("gain.")
        }
        return replace(
            wider, vehicle=wider.vehicle.with_stated(stated), coefficients=changed[places[:n]],
            constants=constants, covariance=spread[np.ix_(places, places)],
        )  # fmt: skip

    def _with_mean_gain(self, theta: Array) -> Array:
        """The same boat with gains of mean 1 in each group, as in files: thrust coefficients take the rest."""
        out, vehicle = theta.copy(), self.wider.vehicle
        for group in vehicle.file.chain:
            if not group.gains:
                continue
            places = [self.gains[name] for name in group.gains]
            mean = float(np.mean(theta[places]))
            driven = [vehicle.actuators.index(name) for name in group.gains]
            moved = np.abs(vehicle.mix[:, driven]).sum(axis=1) > 0.0
            forces = {f.name for f, own in zip(vehicle.forces, moved, strict=True) if own}
            out[places] /= mean
            out[self._thrust_of(forces)] *= mean
        return out

    def _thrust_of(self, forces: set[str]) -> list[int]:
        """Places of the coefficients of which every term has one of these forces."""
        return [
            i for i, name in enumerate(self.wider.structure.coefficients)
            if all(
                forces & {factor.strip("|") for factor in term.factors}
                for term in self.wider.structure.terms if term.coefficient == name
            )
        ]  # fmt: skip

    @cached_property
    def changes(self) -> list[PhysicalChange]:
        """No change, each physical change that this boat can show, and any change at all."""
        same, none = np.ones(len(self.theta)), np.zeros((0, len(self.theta)))
        rows = np.diag(self._units())
        return [
            PhysicalChange(NO_CHANGE, lambda phi: same, none),
            *self._masses(),
            *self._battery(),
            *(self._thruster(name, place) for name, place in self.gains.items()),
            PhysicalChange(NONE_OF_THESE, lambda phi: same, rows[rows.any(axis=1)]),
        ]

    @cached_property
    def slopes(self) -> dict[tuple[str, str], Array]:
        """Of each change, by cause and what changes: d theta / d phi (n, m) of the unchanged boat."""
        nothing = np.zeros((len(self.theta), 0))
        return {
            (c.cause, c.what): c.slopes(self.theta, nothing, np.zeros(c.unknowns))
            for c in self.changes
        }

    def _units(self) -> Array:
        """Typical change (n,) of each coefficient, 0 of constants."""
        units = np.zeros(len(self.theta))
        for i, name in enumerate(self.own.structure.coefficients):
            size = TYPICAL_CHANGE * abs(self.own.coefficients[i])
            units[i] = max(size, COUPLING_CHANGE * (coupling_unit(self.own, name) or 0.0))
        return units

    def _masses(self) -> list[PhysicalChange]:
        """Drag and thrust of an axis over one factor of its mass; off centre with the couplings.

        phi[0] is the logarithm of the mass in surge; those of sway and yaw are correlated with it.
        """
        of_axis = self._of_axes()
        hull, turn = BOTH_HULL_AXES, MASS_AND_INERTIA
        correlation = np.array([[1.0, hull, turn], [hull, 1.0, turn], [turn, turn, 1.0]])
        scale = TYPICAL_CHANGE * np.linalg.cholesky(correlation)

        def factor(phi: Array) -> Array:
            return np.asarray(np.exp(-(scale @ phi[:3]) @ of_axis))

        def size(phi: Array) -> float:
            return float(np.expm1(scale[0] @ phi[:3]))

        centred = np.zeros((3, len(self.theta)))
        couplings = self._couplings()
        found = [PhysicalChange(MASS, factor, centred, "mass", size)]
        if len(couplings):
            shift = np.vstack([centred, couplings])
            found.append(PhysicalChange(OFF_CENTRE, factor, shift, "mass", size))
        return found

    def _of_axes(self) -> Array:
        """(3, n) whether a coefficient is drag or thrust of an axis."""
        found = np.zeros((3, len(self.theta)))
        for i, name in enumerate(self.wider.structure.coefficients):
            for term in self.wider.structure.terms:
                if term.coefficient == name and not term.of_masses:
                    found[term.axis, i] = 1.0
        return found

    def _couplings(self) -> Array:
        """Typical changes (couplings, n) of the coefficients that couple an axis to another's acceleration."""
        rows = []
        for i, name in enumerate(self.wider.structure.coefficients):
            terms = [t for t in self.wider.structure.terms if t.coefficient == name]
            unit = coupling_unit(self.wider, name)
            if unit and all(t.acceleration is not None for t in terms):
                rows.append(COUPLING_CHANGE * unit * (np.arange(len(self.theta)) == i))
        return np.array(rows).reshape(len(rows), len(self.theta))

    def _battery(self) -> list[PhysicalChange]:
        """All thrust by one factor."""
        thrust = np.zeros(len(self.theta))
        thrust[self._thrust_of({force.name for force in self.wider.structure.forces})] = 1.0
        if not thrust.any():
            return []

        def factor(phi: Array) -> Array:
            return np.asarray(np.exp(TYPICAL_CHANGE * phi[0] * thrust))

        def size(phi: Array) -> float:
            return float(np.expm1(TYPICAL_CHANGE * phi[0]))

        return [PhysicalChange(BATTERY, factor, np.zeros((1, len(thrust))), "thrust", size)]

    def _thruster(self, name: str, place: int) -> PhysicalChange:
        """The gain of one thruster, down to none."""
        own = np.arange(len(self.theta)) == place

        def size(phi: Array) -> float:
            return max(THRUSTER_CHANGE * float(phi[0]), -1.0)

        def factor(phi: Array) -> Array:
            return np.asarray(1.0 + size(phi) * own)

        gone = -1.0 / THRUSTER_CHANGE
        return PhysicalChange(ONE_THRUSTER, factor, np.zeros((1, len(own))), name, size, gone)


def change_space(model: Model) -> ChangeSpace:
    """The space of a model's changes; what the core has no room for is left out."""
    known = {(t.axis, t.acceleration) for t in model.structure.terms if t.coefficient}
    new = [name for name, place in COUPLINGS.items() if place not in known]
    return ChangeSpace(model, _widened(model, True, new))


def _widened(model: Model, gains: bool, couplings: Sequence[str]) -> Model:
    """The same boat with a gain of 1 for each thruster, and couplings of 0."""
    vehicle = _with_gains(model.vehicle) if gains else model.vehicle
    terms = [*model.structure.terms]
    room = min(MOST_TERMS - len(terms), MOST_COEFFICIENTS - len(vehicle.structure.coefficients))
    for name in couplings[:room]:
        axis, other = COUPLINGS[name]
        terms.append(Term(axis, name, 1.0, (), other))
    vehicle = vehicle.with_terms(terms) if couplings else vehicle
    # the old parameters at their new places
    new = [*vehicle.structure.coefficients, *vehicle.constants.names]
    n = len(vehicle.structure.coefficients)
    values = np.concatenate([np.zeros(n), vehicle.constants.values])
    covariance = np.zeros((len(new), len(new)))
    places = [new.index(name) for name in model.parameters]
    values[places] = np.concatenate([model.coefficients, model.constants])
    covariance[np.ix_(places, places)] = model.covariance
    return replace(
        model, vehicle=vehicle, coefficients=values[:n], constants=values[n:], covariance=covariance
    )


def _stated_gains(vehicle: Vehicle) -> dict[str, int]:
    """Number of the constant that is an actuator's gain, where the vehicle states one."""
    index = vehicle.constants.index[:, STAGES.index("gain")].tolist()
    return {name: i for name, i in zip(vehicle.actuators, index, strict=True) if i >= 0}


def difference_quotients(of: Callable[[Array], Array], x: Array) -> Array:
    """Central difference quotients (values, unknowns)."""
    if not len(x):
        return np.zeros((len(of(x)), 0))
    steps = DIFFERENCE * np.eye(len(x))
    return np.stack([(of(x + s) - of(x - s)) / (2.0 * DIFFERENCE) for s in steps], axis=1)


def _with_gains(vehicle: Vehicle) -> Vehicle:
    """The vehicle with a gain of 1 for each thruster that shares a force, where it states none."""
    shared = sorted(k for kind in with_shared_forces(vehicle.mix) for k in kind)
    stated = _stated_gains(vehicle)
    names = [name for k in shared if (name := vehicle.actuators[k]) not in stated]
    if len(names) < 2 or len(vehicle.constants.names) + len(names) > _core.MAX_CONSTANTS:
        return vehicle
    gains = ChainGroup(name=GAINS, gains=dict.fromkeys(names, 1.0))
    return vehicle.with_chain([*vehicle.file.chain, gains])
