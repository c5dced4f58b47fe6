# SPDX-License-Identifier: MIT
"""The verdict on one parameter: sharp, usable, weak, by its relative standard error."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.physics import SIGNIFICANT
from seatrial.boat.structure import Term
from seatrial.identification.likelihood.parameters import typical_size
from seatrial.util.format import percent
from seatrial.util.frames import AXES, Array

# relative standard errors below which a parameter is sharp, usable
SHARP_ERROR, USABLE_ERROR = 0.05, 0.2


class ParameterVerdict(Enum):
    """How well a parameter is known."""

    SHARP = "sharp"
    USABLE = "usable"
    WEAK = "weak"
    ZERO = "not distinguishable from zero"
    LOST = "not identifiable"
    GIVEN = "given"
    BOUND = "at its bound"

    @property
    def estimated(self) -> bool:
        """Whether the data give it a standard error."""
        return self not in (ParameterVerdict.GIVEN, ParameterVerdict.BOUND)

    @property
    def reliable(self) -> bool:
        """Whether one may rely on the value."""
        return self in (ParameterVerdict.SHARP, ParameterVerdict.USABLE, ParameterVerdict.GIVEN)


@dataclass(frozen=True)
class ParameterAccuracy:
    """The accuracy of one coefficient, or of one constant of the actuator chain."""

    name: str
    value: float
    error: float  # standard error; 0: given, or at its bound
    unit: str
    relative: float  # standard error over the value, or over a typical value of such a constant
    verdict: ParameterVerdict
    partners: tuple[tuple[str, float], ...] = ()  # strongest first, with the correlation
    reach: float | None = None  # its term's share of full thrust, at most: value and two errors
    thrust_axis: str = ""  # the axis of that thrust, where no thruster pushes along the term's own


def verdict_of(
    name: str, value: float, error: float, thrust_share: float = 0.0
) -> tuple[ParameterVerdict, float]:
    """Verdict and relative error; `thrust_share`: of the error at the envelope's edge, in full thrusts."""
    typical = typical_size(name)
    size = max(abs(value), typical)
    relative = error / size if size > 0 else np.inf
    if error == 0.0:
        return ParameterVerdict.GIVEN, 0.0
    near_zero = abs(value) < SIGNIFICANT * error
    if (near_zero and thrust_share > 1.0) or (typical and relative > 1.0) or not np.isfinite(error):
        return ParameterVerdict.LOST, relative
    if near_zero and not typical:
        return ParameterVerdict.ZERO, relative
    known = ParameterVerdict.SHARP if relative < SHARP_ERROR else ParameterVerdict.USABLE
    return (known if relative < USABLE_ERROR else ParameterVerdict.WEAK), relative


def parameter_accuracy(
    model: Model, name: str, estimated: Sequence[str], correlation: Array
) -> ParameterAccuracy:
    """Accuracy of one parameter; correlation: (p, p) of the p estimated ones."""
    value, error, unit = (
        model.parameter_values[name],
        model.standard_errors[name],
        model.units[name],
    )
    share, axis = _thrust_share(model, name)
    verdict, relative = verdict_of(name, value, error, (share or 0.0) * error)
    if verdict is ParameterVerdict.GIVEN and name in model.at_bounds:
        verdict = ParameterVerdict.BOUND
    row = correlation[estimated.index(name)] if name in estimated else np.zeros(0)
    order = [int(i) for i in np.argsort(-np.abs(row)) if estimated[i] != name]
    partners = tuple((estimated[i], float(row[i])) for i in order[:3])
    reach = None if share is None else share * (abs(value) + SIGNIFICANT * error)
    return ParameterAccuracy(name, value, error, unit, relative, verdict, partners, reach, axis)


def reach_text(found: ParameterAccuracy) -> str:
    """The upper limit of an insignificant parameter; empty: unknown."""
    if found.verdict is not ParameterVerdict.ZERO or found.reach is None:
        return ""
    of = f" in {found.thrust_axis}" if found.thrust_axis else ""
    return f"at most {percent(found.reach)} of full thrust{of}"


def full_thrust(model: Model, axis: int, *, along: bool = False) -> float:
    """Largest acceleration that one force gave the axis, [m/s^2] or [rad/s^2]; 0: none does.

    along: of the forces that act along this axis; the yaw moment of two thrusters may push sideways, too.
    """
    axis_of = {force.name: force.axis for force in model.structure.forces}
    found = [
        abs(t.number * model.values[t.coefficient]) * (_largest(model, t) or 0.0)
        for t in model.structure.terms
        if t.axis == axis and t.coefficient and is_force_term(model, t)
        and (not along or axis_of[t.factors[0]] == axis)
    ]  # fmt: skip
    return max(found, default=0.0)


def _thrust_share(model: Model, name: str) -> tuple[float | None, str]:
    """Acceleration by a coefficient of 1 at the envelope's edge, in full thrusts; None: unknown.

    A boat without sway thrust has a thrust in surge to compare with: then the second is that axis.
    """
    shares: list[tuple[float, str]] = []
    for term in model.structure.terms:
        largest = _largest(model, term)
        if term.coefficient != name or largest is None:
            continue
        own = full_thrust(model, term.axis, along=True)
        axis = term.axis if own > 0 else {0: 1, 1: 0}.get(term.axis, term.axis)
        thrust = full_thrust(model, axis, along=True)
        if thrust > 0:
            of = AXES[axis] if axis != term.axis else ""
            shares.append((largest * abs(term.number) / thrust, of))
    return max(shares, default=(None, ""))


def is_force_term(model: Model, term: Term) -> bool:
    """Whether a term is a force times a coefficient."""
    forces = [f.name for f in model.structure.forces]
    return len(term.factors) == 1 and term.factors[0] in forces and term.acceleration is None


def _largest(model: Model, term: Term) -> float | None:
    """Largest product of a term's factors within the envelope; None where it has none."""
    ranges = {**model.envelope.speeds, **model.envelope.forces}
    if any(factor.strip("|") not in ranges for factor in term.factors):
        return None
    sizes = [max(map(abs, ranges[factor.strip("|")])) for factor in term.factors]
    size = float(np.prod(sizes))
    return size if term.acceleration is None else size * full_thrust(model, term.acceleration)
