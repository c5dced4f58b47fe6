# SPDX-License-Identifier: MIT
"""The vehicle: its signals, thrusters, allocation and model structure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from seatrial import _core
from seatrial.boat import structure
from seatrial.boat.actuators import ESTIMATE, ChainReader, Constants, stated
from seatrial.boat.allocation import Scheme, Thruster, angle_remarks, inverse_for, thruster_matrix
from seatrial.boat.core_limits import check_offset, check_sizes
from seatrial.boat.force_weights import ForceWeights
from seatrial.boat.names import check_vehicle_names
from seatrial.boat.physical_library import base_terms
from seatrial.boat.schema import VEHICLE_FORMAT, ChainGroup, Estimate, VehicleFile
from seatrial.boat.steering import angle_names
from seatrial.boat.structure import Force, Structure, Term
from seatrial.util.errors import VehicleError
from seatrial.util.files import convert, expect_format, read_yaml
from seatrial.util.frames import AXES, Array, Axes

AUTO = "auto"  # structure that the recordings choose
SAME_POINT = 1e-3  # [m] difference of two lever arms
WRENCH = ("F_u", "F_v", "F_r")  # generalised forces of Eq. (9), one an axis


@dataclass(frozen=True)
class Vehicle:
    """A vehicle in forward-left-up axes; `file` has the file's content, in its own axes.

    file: content of the file, in its own axes
    source: path or name, for messages
    """

    file: VehicleFile
    source: str = field(default="vehicle", compare=False)

    def __post_init__(self) -> None:
        check_vehicle_names(self.file, self.source)
        _ = self.chain  # validates inputs, thrusters, forces and groups
        _ = self.structure

    def __reduce__(self) -> tuple[Any, ...]:
        """Copies and pickles are made of the file's content."""
        return vehicle_from, (self.to_mapping(), self.source)

    def __repr__(self) -> str:
        return f"<Vehicle {self.name}: {self.axes.value}, inputs {', '.join(self.inputs)}>"

    @property
    def name(self) -> str:
        """The vehicle's name."""
        return self.file.name

    @property
    def axes(self) -> Axes:
        """Axes that the file and its recordings are in."""
        return Axes(self.file.axes)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the recorded commands, in order."""
        return tuple(self.file.commands.inputs)

    @property
    def scales(self) -> tuple[str, ...]:
        """Names of the known scale signals, in order."""
        return tuple(self.file.scales)

    @property
    def lever(self) -> tuple[float, float]:
        """Lever arm of the measured point from the origin, ahead and to port [m]."""
        ahead, aside = self.file.pose.lever or (0.0, 0.0)
        return ahead, self.axes.lateral_sign * aside

    @property
    def point(self) -> str:
        """The lever arm as text."""
        ahead, left = self.lever
        return f"{ahead:.3f} m ahead and {left:.3f} m to port"

    @property
    def stated_lever(self) -> str | None:
        """The lever where the file states one, forward-left-up, as a model file's settings have it."""
        if self.file.pose.lever is None:
            return None
        return ", ".join(f"{end + 0.0:g}" for end in self.lever)

    @property
    def delays(self) -> tuple[float, float]:
        """Delays of position and heading [s]; of two of which one is estimated, the other's."""
        pose = self.file.pose
        own = None if isinstance(pose.delay, str) else pose.delay
        heading = None if isinstance(pose.heading_delay, str) else pose.heading_delay
        position = (heading if pose.delay == ESTIMATE else own) or 0.0
        return position, position if heading is None else heading

    @property
    def estimated_delays(self) -> tuple[bool, bool]:
        """Whether the file leaves the delays of position and heading to the estimator."""
        position, heading = self.file.pose.delay, self.file.pose.heading_delay
        both = position == ESTIMATE and heading is None
        return position == ESTIMATE, heading == ESTIMATE or both

    @property
    def stated_delays(self) -> str | None:
        """The delays where the file states any and leaves none open, as a model file's settings have them."""
        pose = self.file.pose
        if any(self.estimated_delays) or (pose.delay is None and pose.heading_delay is None):
            return None
        return ", ".join(f"{delay + 0.0:g}" for delay in self.delays)

    def same_origin(self, other: Vehicle) -> bool:
        """Whether both have the same origin."""
        pairs = zip(self.lever, other.lever, strict=True)
        return all(abs(own - its) < SAME_POINT for own, its in pairs)

    @property
    def actuators(self) -> tuple[str, ...]:
        """Names of the actuators: thrusters that are allocated to, or the inputs themselves."""
        direct = self.scheme is Scheme.DIRECT or not self.file.thrusters
        return self.inputs if direct else tuple(self.file.thrusters)

    @property
    def scheme(self) -> Scheme:
        """Allocation scheme."""
        return Scheme(self.file.allocation.scheme)

    @cached_property
    def input_signs(self) -> Array:
        """Signs (inputs,) that turn recorded commands into forward-left-up ones."""
        flips = self.axes is Axes.FRD
        return np.array([-1.0 if flips and name in WRENCH[1:] else 1.0 for name in self.inputs])

    @property
    def actuator_signs(self) -> Array:
        """Signs (actuators,): -1 where the command is negated to forward-left-up."""
        return np.ones(len(self.actuators)) if self.file.thrusters else self.input_signs

    @cached_property
    def forces(self) -> tuple[Force, ...]:
        """The generalised forces that terms may use."""
        if self.file.forces:
            return tuple(Force(n, AXES.index(f.axis)) for n, f in self.file.forces.items())
        direct = self.scheme is Scheme.DIRECT and not self.file.thrusters
        given = [name for name in WRENCH if name in self.inputs or not direct]
        return tuple(Force(name, WRENCH.index(name)) for name in given or WRENCH)

    def forces_of(self, axis: int) -> list[int]:
        """Which of the forces act along an axis: 0 surge, 1 sway, 2 yaw."""
        return [i for i, force in enumerate(self.forces) if force.axis == axis]

    @cached_property
    def mix(self) -> Array:
        """T (forces, actuators): F = T f."""
        if self.file.forces and self.file.thrusters:
            raise VehicleError(f"{self.source}: give thrusters or forces, not both")
        if self.file.forces:
            return self._weights.mix(self.actuator_signs)
        if self.file.thrusters:
            return thruster_matrix(self.thrusters, self.source, self.axes.lateral_sign)[0]
        if not set(self.inputs) <= set(WRENCH):
            raise VehicleError(
                f"{self.source}: inputs are {', '.join(self.inputs)}; without thrusters or forces "
                f"they must be {', '.join(WRENCH)}, or some of these; 'seatrial init' proposes forces"
            )
        return np.array([[float(i == f.name) for i in self.inputs] for f in self.forces])

    @cached_property
    def deflection(self) -> Array:
        """D (forces, actuators): F += D sin(angle), of a rudder in the flow."""
        if not self.file.forces:
            return np.zeros((len(self.forces), len(self.actuators)))
        return self._weights.deflection(angle_names(self.file.chain))

    @cached_property
    def thrusters(self) -> tuple[Thruster, ...]:
        """Thrusters in forward-left-up axes, in the order of `actuators`."""
        given = self.file.thrusters
        if set(self.actuators) != set(given):
            raise VehicleError(
                f"{self.source}: allocation is direct, so the inputs must be the thrusters "
                f"{', '.join(given)}; got {', '.join(self.inputs)}. For a joypad's "
                f"{', '.join(WRENCH)} write allocation: {{scheme: moore-penrose}}"
            )
        sign = self.axes.lateral_sign
        return tuple(
            Thruster(n, given[n].x, sign * given[n].y, sign * np.deg2rad(given[n].angle_deg))
            for n in self.actuators
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """Warnings about the file: angles that are round in radians, not in degrees."""
        return angle_remarks([t.angle_deg for t in self.file.thrusters.values()])

    @property
    def automatic(self) -> bool:
        """Whether the recordings choose the terms: `structure: auto`."""
        return self.file.structure == AUTO

    @cached_property
    def units(self) -> dict[str, str]:
        """SI unit of each coefficient, and of each constant of the actuator chain."""
        constants = self.constants
        return {**self.structure.units, **{n: constants.unit(n) for n in constants.names}}

    @cached_property
    def structure(self) -> Structure:
        """Model structure in forward-left-up axes; of `structure: auto` the terms that the choice begins with."""
        if self.automatic:
            explicit = bool(self.file.forces)
            return Structure(self.name, base_terms(self.forces, explicit=explicit), self.forces)
        lines = self.file.structure
        name = lines if isinstance(lines, str) else self.name
        parsed = structure.parse(
            name,
            structure.named(lines, self.source) if isinstance(lines, str) else lines,
            self.forces,
        )
        # a named structure is written in forward-left-up axes, a vehicle's own in the vehicle's
        flip = self.axes is Axes.FRD and not isinstance(lines, str)
        return parsed.flipped() if flip else parsed

    @cached_property
    def constants(self) -> Constants:
        """Constants of the actuator chain."""
        return self._reader.constants()

    @property
    def estimated(self) -> tuple[str, ...]:
        """Names of the constants that the file leaves to the estimator."""
        return self.constants.estimated

    @cached_property
    def inverse(self) -> Array:
        """T+ (actuators, inputs) of the allocation; the identity where it is direct."""
        if self.scheme is Scheme.DIRECT:
            return np.eye(len(self.inputs))
        if not self.file.thrusters or set(self.inputs) != set(WRENCH):
            raise VehicleError(
                f"{self.source}: allocation {self.scheme.value} needs thrusters, and inputs named "
                f"{', '.join(WRENCH)}; got inputs {', '.join(self.inputs)}"
            )
        order = [WRENCH.index(name) for name in self.inputs]
        return inverse_for(self.scheme, self.mix)[:, order]

    @cached_property
    def stages(self) -> NDArray[np.int32]:
        """Rows (actuators, 20): which constant each stage of the chain uses, as `ChainReader.rows`."""
        return self._reader.rows(self.constants, self.scales, self.actuator_signs)

    @cached_property
    def chain(self) -> _core.Chain:
        """The core's actuator chain."""
        limit, offset = self.file.allocation.limit, self.file.allocation.F_os
        sizes = (len(self.inputs), len(self.actuators), len(self.scales), len(self.constants.names))
        check_sizes(*sizes, self.source)
        check_offset(self.scheme, offset, limit, self.source)
        tables = [g.table for g in self.file.chain if g.table]
        if len(tables) > 1:
            raise VehicleError(f"{self.source}: chain: one table at most, for one group")
        return _core.Chain(
            self.scheme.code,
            np.ascontiguousarray(self.inverse),
            offset,
            float("inf") if limit is None else limit,
            np.ascontiguousarray(self.mix),
            self.stages,
            len(self.constants.names),
            np.array([s.reference for s in self.file.scales.values()], dtype=float),
            np.array(tables[0] if tables else [], dtype=float).reshape(-1, 2),
            np.ascontiguousarray(self.deflection),
        )

    def with_chain(self, groups: list[ChainGroup]) -> Vehicle:
        """The same vehicle with another actuator chain."""
        return replace(self, file=msgspec.structs.replace(self.file, chain=groups))

    def with_terms(self, terms: Sequence[Term]) -> Vehicle:
        """The same vehicle with other terms, given forward-left-up, written in the axes of its file."""
        ordered = sorted(terms, key=lambda term: term.axis)
        found = Structure(self.structure.name, tuple(ordered), self.forces)
        lines = (found.flipped() if self.axes is Axes.FRD else found).lines()
        return replace(self, file=msgspec.structs.replace(self.file, structure=lines))

    def with_automatic_structure(self) -> Vehicle:
        """The same vehicle with `structure: auto`."""
        return replace(self, file=msgspec.structs.replace(self.file, structure=AUTO))

    def with_sampled_commands(self) -> Vehicle:
        """The same vehicle with commands that are a logger's samples."""
        commands = msgspec.structs.replace(self.file.commands, sampled=True)
        return replace(self, file=msgspec.structs.replace(self.file, commands=commands))

    def with_lever(self, lever: tuple[float, float]) -> Vehicle:
        """The same vehicle with this lever arm, ahead of the origin and to port [m]."""
        ahead, left = lever
        own = (ahead, self.axes.lateral_sign * left)
        pose = msgspec.structs.replace(self.file.pose, lever=own)
        return replace(self, file=msgspec.structs.replace(self.file, pose=pose))

    def with_delays(self, position: float, heading: float) -> Vehicle:
        """The same vehicle with these delays [s] of position and heading."""
        if (position, heading) == self.delays and not any(self.estimated_delays):
            return self
        pose = msgspec.structs.replace(self.file.pose, delay=position, heading_delay=heading)
        return replace(self, file=msgspec.structs.replace(self.file, pose=pose))

    def with_stated(self, values: Mapping[str, float | Estimate]) -> Vehicle:
        """The same vehicle with these values of constants, by name, or left to the estimator."""
        return self.with_chain(stated(self.file.chain, values))

    def to_mapping(self) -> dict[str, Any]:
        """The file's content, as stored inside a model."""
        content = msgspec.to_builtins(self.file)
        return {"seatrial": self.file.seatrial, **content}

    @cached_property
    def _reader(self) -> ChainReader:
        return ChainReader(self.file.chain, self.actuators, self.source)

    @property
    def _weights(self) -> ForceWeights:
        return ForceWeights(self.file.forces, self._reader, self.axes, self.source)


def load_vehicle(path: str | Path) -> Vehicle:
    """A vehicle from a file, or by the name of one that comes with seatrial."""
    folder, given = resources.files("seatrial") / "data" / "vehicles", Path(path)
    bundled = {file.name.removesuffix(".yaml"): file for file in folder.iterdir()}
    if str(path) in bundled and not given.exists():
        return vehicle_from(read_yaml(bundled[str(path)]), str(path))
    return vehicle_from(expect_format(read_yaml(given), VEHICLE_FORMAT, given), str(path))


def vehicle_from(content: dict[str, Any], source: str) -> Vehicle:
    """A vehicle from a file's content."""
    return Vehicle(convert(content, VehicleFile, source), source)
