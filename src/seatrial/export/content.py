# SPDX-License-Identifier: MIT
"""The content of every export: a model as plain numbers and names, in its vehicle's axes.

Inside seatrial all is forward-left-up; an export is in the axes of the vehicle file.
"""

from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version

import numpy as np

from seatrial.boat.actuators import SHORTEST_LAG, STAGES, USES
from seatrial.boat.allocation import Scheme
from seatrial.boat.model import Model
from seatrial.boat.structure import Structure
from seatrial.export.chain import Actuator, Allocation, Shape, SteadyCurve, allocation_of, curves_of
from seatrial.export.spelling import line
from seatrial.util.frames import Array, Axes

MATRIX_DECIMALS = 14  # of matrices with entries of about 1


@dataclass(frozen=True)
class Content:
    """A model in the axes of its vehicle file, or in others."""

    model: Model
    other_axes: Axes | None = None

    @property
    def vehicle_name(self) -> str:
        """The vehicle's name, on one line."""
        return line(self.model.name)

    @property
    def axes(self) -> Axes:
        """Axes of states, commands and forces."""
        return self.model.vehicle.axes if self.other_axes is None else self.other_axes

    @cached_property
    def structure(self) -> Structure:
        """The terms in these axes."""
        own = self.model.structure
        return own.flipped() if self.axes is Axes.FRD else own

    @cached_property
    def values(self) -> dict[str, float]:
        """Coefficients, then constants of the actuator chain, by name."""
        found = np.concatenate([self.model.coefficients, self.model.constants]) * self._signs
        return dict(zip(self.model.parameters, found.tolist(), strict=True))

    @property
    def sources(self) -> dict[str, str]:
        """The parameter behind each name; a constant of two stages, as equal edges are, has both names."""
        return {name: name for name in self.values} | self.model.vehicle.constants.shared

    @cached_property
    def covariance(self) -> Array:
        """Of these values, in their order."""
        return np.asarray(self.model.covariance * np.outer(self._signs, self._signs))

    @cached_property
    def units(self) -> dict[str, str]:
        """SI unit of every value."""
        return self.model.units

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors by name; 0: the value was given."""
        return self.model.standard_errors

    @property
    def inputs(self) -> tuple[str, ...]:
        """Commands to the boat."""
        return self.model.vehicle.inputs

    @property
    def forces(self) -> tuple[str, ...]:
        """Generalised forces F."""
        return tuple(force.name for force in self.structure.forces)

    @property
    def scales(self) -> dict[str, float]:
        """Reference of each known scale signal."""
        return {name: s.reference for name, s in self.model.vehicle.file.scales.items()}

    @property
    def scheme(self) -> Scheme:
        """How commands become actuator commands."""
        return self.model.vehicle.scheme

    @cached_property
    def inverse(self) -> Array:
        """T+ (actuators, inputs) from commands in these axes to actuator commands."""
        vehicle = self.model.vehicle
        turned = self.axes is Axes.FRD
        return _rounded(vehicle.inverse * (vehicle.input_signs if turned else 1.0))

    @cached_property
    def mix(self) -> Array:
        """T (forces, actuators): F = T f in these axes."""
        return _rounded(self.model.vehicle.mix * self._force_signs)

    @cached_property
    def deflection(self) -> Array:
        """D (forces, actuators): F += D sin(angle) in these axes."""
        return _rounded(self.model.vehicle.deflection * self._force_signs)

    @cached_property
    def allocation(self) -> Allocation:
        """Commands to the boat into actuator commands."""
        return allocation_of(self.inverse, self.scheme, self.limit, self.offset)

    @cached_property
    def curves(self) -> tuple[SteadyCurve, ...]:
        """The level that each actuator tends to."""
        return curves_of(self.actuators)

    @property
    def helpers(self) -> set[str]:
        """Functions that curves, rate limits and known signals of this boat need."""
        found = {curve.shape.value for curve in self.curves} - {Shape.LINE.value}
        found |= {"limited"} if any(map(self.limited, self.actuators)) else set()
        return found | (
            {"multiplier"} if any(a.scale is not None for a in self.actuators) else set()
        )

    @property
    def offset(self) -> float:
        """F_os, which always-forward adds to every thruster; 0 in other schemes."""
        return self.model.vehicle.file.allocation.F_os if self.scheme is Scheme.AF else 0.0

    @property
    def limit(self) -> float | None:
        """Largest actuator command."""
        return self.model.vehicle.file.allocation.limit

    @cached_property
    def actuators(self) -> tuple[Actuator, ...]:
        """In the order of T's columns."""
        vehicle, found = self.model.vehicle, []
        for name, row in zip(vehicle.actuators, vehicle.stages.tolist(), strict=True):
            own = {
                s: vehicle.constants.names[i] for s, i in zip(STAGES, row, strict=False) if i >= 0
            }
            use = dict(zip(USES, row[len(STAGES) :], strict=True))
            scale, partner, steers = (
                use[w] if use[w] >= 0 else None for w in ("scale", "partner", "steers")
            )
            flags = (use[w] == 1 for w in ("tabulated", "across", "mirrored"))
            tabulated, across, mirrored = flags
            found.append(Actuator(name, own, scale, tabulated, partner, across, mirrored, steers))
        return tuple(found)

    def latency(self, actuator: Actuator) -> float:
        """[s]; 0 where a clock offset makes it negative."""
        own = actuator.constants.get("latency")
        return 0.0 if own is None else max(0.0, self.values[own])

    def lagged(self, actuator: Actuator) -> bool:
        """Whether its thrust follows its target with a lag."""
        own = actuator.constants.get("lag")
        return own is not None and self.values[own] > SHORTEST_LAG

    def limited(self, actuator: Actuator) -> bool:
        """Whether its level has a rate limit."""
        return "slew_rate" in actuator.constants

    @property
    def angles(self) -> tuple[tuple[int, int], ...]:
        """Numbers of each angle and of the thrust that it turns."""
        turned = enumerate(a.steers for a in self.actuators)
        return tuple((k, thrust) for k, thrust in turned if thrust is not None)

    @property
    def angle_notes(self) -> list[str]:
        """A sentence for each angle."""
        named = ((self.actuators[k].name, self.actuators[thrust].name) for k, thrust in self.angles)
        return [
            f"{angle}: angle [rad] of the thrust f of {thrust}, which gives f cos and f sin."
            for angle, thrust in named
        ]

    @property
    def table(self) -> list[tuple[float, float]]:
        """Points (command, thrust) of the tabulated curve; empty without one."""
        return next((g.table for g in self.model.vehicle.file.chain if g.table), [])

    @property
    def longest_step(self) -> float:
        """[s] of the Runge-Kutta integrator, as in the simulator."""
        return self.model.integration.step

    @property
    def source(self) -> str:
        """Version and method, on one line."""
        return line(f"seatrial {version('seatrial')}, {self.model.estimator.method}")

    @property
    def _force_signs(self) -> Array:
        flips = self.axes is Axes.FRD
        signs = [-1.0 if flips and f.axis > 0 else 1.0 for f in self.structure.forces]
        return np.array(signs)[:, None]

    @property
    def _signs(self) -> Array:
        flipped = self.model.structure.flipped_coefficients if self.axes is Axes.FRD else ()
        return np.array([-1.0 if name in flipped else 1.0 for name in self.model.parameters])


def _rounded(matrix: Array) -> Array:
    """Without rounding errors and minus zero."""
    return np.round(matrix, MATRIX_DECIMALS) + 0.0
