# SPDX-License-Identifier: MIT
"""The identified model: coefficients with covariance, thrusters, provenance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from seatrial import _core
from seatrial.boat.actuators import ESTIMATE, STAGES
from seatrial.boat.findings import Finding, FindingKind, of_kinds
from seatrial.boat.schema import (
    EnvelopeEntry,
    EstimatorEntry,
    Integration,
    NoiseEntry,
    RecordingEntry,
)
from seatrial.boat.structure import Structure
from seatrial.boat.vehicle import SAME_POINT, Vehicle
from seatrial.util.above import above, text_by
from seatrial.util.arguments import expect
from seatrial.util.errors import ModelError, VehicleError
from seatrial.util.frames import Array, Stamps, freeze
from seatrial.util.frozen import ByFields

if TYPE_CHECKING:
    from seatrial.util.above import Figure

FIT_HORIZON = "belief"  # a setting [s]: horizon of a fit under model mismatch; 0: no mismatch
STATED_LEVER = "lever_stated"  # a setting: what the vehicle file had, where another was found
STATED_DELAYS = "delays_stated"  # the same of the delays of position and heading
SURELY = 3.0  # standard errors from which on two lever arms are two
GIVEN = EstimatorEntry("given")  # coefficients from elsewhere
INTEGRATORS = ("runge-kutta", "forward-euler")  # in the order of the core's codes


class Signals(Protocol):
    """Samples of several signals."""

    @property
    def stamps(self) -> Stamps: ...  # noqa: D102  (n,) [ns]
    @property
    def values(self) -> Array: ...  # noqa: D102  (n, m)


class Driven(Protocol):
    """What the model needs of a recording: the commands, the scales, and its clock."""

    @property
    def commands(self) -> Signals: ...  # noqa: D102
    @property
    def scales(self) -> Signals | None: ...  # noqa: D102
    @property
    def command_period(self) -> float: ...  # noqa: D102
    @property
    def command_sampled(self) -> bool: ...  # noqa: D102
    def seconds(self, stamps: Stamps) -> Array: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Model(ByFields):
    """A boat in forward-left-up axes, per unit mass and inertia.

    vehicle: axes, inputs, actuators and terms
    coefficients: (n,) in the order of structure.coefficients
    covariance: (n + m, n + m) of coefficients and constants; (n, n): constants are given
    constants: (m,) of the actuator chain, in the order of vehicle.constants.names
    integration: method and step of the simulation
    noise: of poses and of the process, as identified
    envelope: speeds and commands that the recordings reach, forward-left-up
    recordings: what it was identified from
    estimator: method, version, and findings
    warnings: what makes it doubtful, in words
    """

    vehicle: Vehicle
    coefficients: Array
    covariance: Array
    constants: Array
    integration: Integration
    noise: NoiseEntry
    envelope: EnvelopeEntry
    recordings: tuple[RecordingEntry, ...] = ()
    estimator: EstimatorEntry = GIVEN
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n, m = len(self.structure.coefficients), len(self.vehicle.constants.names)
        if self.covariance.shape == (n, n):
            object.__setattr__(self, "covariance", np.pad(self.covariance, (0, m)))
        freeze(self, "coefficients", "covariance", "constants")
        if self.coefficients.shape != (n,) or self.covariance.shape != (n + m, n + m):
            raise ModelError(
                f"{n} coefficients expected, got {self.coefficients.shape} and covariance "
                f"{self.covariance.shape}"
            )
        if self.constants.shape != (len(self.vehicle.constants.names),):
            raise ModelError("one value for each constant of the vehicle's chain expected")
        if not (np.isfinite(self.coefficients).all() and np.isfinite(self.constants).all()):
            raise ModelError("a coefficient or constant is not a finite number")

    @property
    def name(self) -> str:
        """The vehicle's name."""
        return self.vehicle.name

    @property
    def structure(self) -> Structure:
        """Structure in forward-left-up axes."""
        return self.vehicle.structure

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """Names of coefficients and constants, in the covariance's order."""
        return (*self.structure.coefficients, *self.vehicle.constants.names)

    @cached_property
    def values(self) -> dict[str, float]:
        """Coefficients by name, forward-left-up."""
        return dict(zip(self.structure.coefficients, self.coefficients.tolist(), strict=True))

    @cached_property
    def parameter_values(self) -> dict[str, float]:
        """Coefficients and constants of the actuator chain by name, as `standard_errors` has their errors."""
        values = [*self.coefficients.tolist(), *self.constants.tolist()]
        return dict(zip(self.parameters, values, strict=True))

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each parameter by name; "-" for a number."""
        return self.vehicle.units

    @cached_property
    def standard_errors(self) -> dict[str, float]:
        """Standard errors of coefficients and constants by name; 0 where a value was given."""
        errors = np.sqrt(np.diag(self.covariance)).tolist()
        return dict(zip(self.parameters, errors, strict=True))

    def findings_of(self, *kinds: FindingKind) -> tuple[Finding, ...]:
        """The estimator's findings of some kinds."""
        return of_kinds(self.estimator.findings, *kinds)

    @cached_property
    def at_bounds(self) -> frozenset[str]:
        """Names of parameters that ended at the bound of their range: the data say no more of them."""
        kinds = FindingKind.AT_BOUND, FindingKind.BEYOND_RANGE
        names = [finding.part("parameter") for finding in self.findings_of(*kinds)]
        return frozenset(name for name in names if self.standard_errors.get(name) == 0.0)

    @property
    def unidentified(self) -> Vehicle:
        """The vehicle with what was estimated of its thrusters left to the estimator again; their gains stay."""
        sought = {
            name for name, error in self.standard_errors.items() if error > 0.0
        } | self.at_bounds
        again = [
            n for n in self.vehicle.constants.names if n in sought and not n.startswith("gain.")
        ]
        return self.vehicle.with_stated(dict.fromkeys(again, ESTIMATE))

    @cached_property
    def lever_errors(self) -> tuple[float, float]:
        """Standard errors [m] of the lever arm, ahead and aside, where it was found; 0 where it was given."""
        for finding in self.findings_of(FindingKind.LEVER_ARM_ERRORS):
            return finding.number("ahead"), finding.number("aside")
        return 0.0, 0.0

    def about_origin(self, vehicle: Vehicle) -> Vehicle:
        """A vehicle with the model's lever arm and delays, if the poses are of the same sensor.

        So they are where the vehicle states none, or what was stated before this model's were found.
        """
        settings = self.estimator.settings
        if vehicle.stated_delays in (None, settings.get(STATED_DELAYS)):
            vehicle = vehicle.with_delays(*self.vehicle.delays)
        same = vehicle.stated_lever in (None, settings.get(STATED_LEVER))
        other = same and vehicle.lever != self.vehicle.lever
        return vehicle.with_lever(self.vehicle.lever) if other else vehicle

    def same_origin(self, other: Model) -> bool:
        """Whether the two are about one point of the boat, as far as it is known."""
        apart = np.abs(np.subtract(self.vehicle.lever, other.vehicle.lever))
        errors = np.hypot(self.lever_errors, other.lever_errors)
        return bool((apart < np.maximum(SAME_POINT, SURELY * errors)).all())

    @cached_property
    def known_vehicle(self) -> Vehicle:
        """The vehicle with the constants of its chain as they were found."""
        names = self.vehicle.constants.names
        return self.vehicle.with_stated(dict(zip(names, self.constants.tolist(), strict=True)))

    @cached_property
    def boat(self) -> _core.Boat:
        """The core's model."""
        code = INTEGRATORS.index(self.integration.scheme)
        return _core.Boat(self.structure.compiled, self.coefficients, code, self.integration.step)

    def trace(
        self,
        recording: Driven,
        *,
        initial: bool = False,
        coefficients: Sequence[int] = (),
        tangents: Sequence[int] = (),
    ) -> _core.ThrustTrace:
        """`thrust_trace` with the model's own constants."""
        return thrust_trace(
            self.vehicle, self.constants, recording,
            initial=initial, coefficients=coefficients, tangents=tangents,
        )  # fmt: skip

    def with_vehicle(self, vehicle: Vehicle) -> Model:
        """The same boat and actuator chain with another vehicle's signals and allocation.

        Where that vehicle states no lever arm, or that which this model's was sought from, the poses' point
        is still the model's.
        """
        expect(vehicle, Vehicle, "vehicle")
        if vehicle.automatic:
            vehicle = vehicle.with_terms(self.structure.terms)
        own, new = self.structure, vehicle.structure
        if set(own.terms) != set(new.terms) or len(own.terms) != len(new.terms):
            raise ModelError(
                f"vehicle {vehicle.name} has other terms than the model: its coefficients are "
                f"{', '.join(new.coefficients)}; the model has {', '.join(own.coefficients)}; "
                "give a vehicle file with the model's terms, --vehicle"
            )
        self.check_sides(vehicle)
        order = [own.coefficients.index(name) for name in new.coefficients]
        places = [*order, *range(len(order), len(self.covariance))]
        return replace(
            self,
            vehicle=self.about_origin(vehicle.with_chain(self.vehicle.file.chain)),
            coefficients=self.coefficients[order],
            covariance=self.covariance[np.ix_(places, places)],
        )

    def check_sides(self, vehicle: Vehicle) -> None:
        """Raise VehicleError where the edges of a dead zone exchange in a vehicle's axes.

        The same force has opposite signs in forward-left-up and forward-right-down axes.
        """
        own = self.vehicle
        ahead, astern = (STAGES.index(stage) for stage in ("edge_forward", "edge_reverse"))
        index = own.constants.index
        for k in np.flatnonzero(index[:, ahead] != index[:, astern]).tolist():
            name = own.actuators[k]
            if name in vehicle.actuators and (
                vehicle.actuator_signs[vehicle.actuators.index(name)] != own.actuator_signs[k]
            ):
                raise VehicleError(
                    f"the dead zone of {name} has two edges, whose names are exchanged between the "
                    f"model's {own.axes.value} axes and the {vehicle.axes.value} axes of vehicle {vehicle.name}; "
                    "give a vehicle file in the model's axes"
                )

    def plot(self, figure: Figure | None = None) -> Figure:
        """Relative 95 % intervals of the parameters, thrust curves and step responses, with Matplotlib.

        Draws on `figure` where one is given. Raises SeatrialError where Matplotlib is not installed.
        """
        drawn: Figure = above("display.model_plot", "plot_model")(self, figure)
        return drawn

    def __repr__(self) -> str:
        made = ", ".join([self.estimator.method, *(one.name for one in self.recordings)])
        return f"<Model {self.name}: {len(self.parameters)} parameters; {made}>"

    __str__ = text_by("identification.console", "summary")
    _repr_html_ = text_by("display.tables", "model_html")

    def same_signals(self, other: Model) -> None:
        """Raises ModelError where another model has other inputs or scales."""
        for what in ("inputs", "scales"):
            own, new = getattr(self.vehicle, what), getattr(other.vehicle, what)
            if own != new:
                raise ModelError(
                    f"{other.name} has {what} {', '.join(new) or 'none'}; expected "
                    f"{', '.join(own) or 'none'} as before"
                )


def sampling_period(vehicle: Vehicle, recording: Driven) -> float:
    """Time [s] between samples of the commands; 0: every change has its own stamp.

    A change is at any time between two samples, and counts as halfway. What the vehicle file states has priority.
    """
    stated = vehicle.file.commands.sampled
    sampled = stated if isinstance(stated, bool) else recording.command_sampled
    return recording.command_period if sampled else 0.0


def thrust_trace(
    vehicle: Vehicle,
    constants: Array,
    recording: Driven,
    *,
    initial: bool = False,
    coefficients: Sequence[int] = (),
    tangents: Sequence[int] = (),
) -> _core.ThrustTrace:
    """What the thrusters did along a recording, in its seconds.

    The tangents' columns: initial state (6), chosen coefficients, chosen chain constants.
    """
    commands, scales = recording.commands, recording.scales
    empty = np.zeros((0, len(vehicle.scales)))
    return _core.ThrustTrace(
        vehicle.chain,
        constants,
        recording.seconds(commands.stamps) - 0.5 * sampling_period(vehicle, recording),
        commands.values,
        np.zeros(0) if scales is None else recording.seconds(scales.stamps),
        empty if scales is None else scales.values,
        initial,
        list(coefficients),
        list(tangents),
    )
