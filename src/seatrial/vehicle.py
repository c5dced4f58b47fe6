# SPDX-License-Identifier: MIT
"""The vehicle: which signal is what, its thrusters, its allocation, its model structure."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from seatrial import _core, structure
from seatrial.allocation import Scheme, Thruster, inverse_for, thruster_matrix
from seatrial.errors import VehicleError
from seatrial.files import convert, expect_format, read_yaml
from seatrial.frames import AXES, Array, Axes
from seatrial.schema import VEHICLE_FORMAT, ChainGroup, Column, ForceEntry, VehicleFile
from seatrial.structure import Force, Structure

WRENCH = ("F_u", "F_v", "F_r")  # generalised forces of Eq. (9), one an axis
STAGES = (
    "latency", "edge_forward", "edge_reverse", "reverse_ratio", "power", "lag", "scale_power", "gain",
)  # in the order of the core's Actuator  # fmt: skip
CONSTANT_UNITS = {"latency": "s", "lag": "s"}  # all others have none


@dataclass(frozen=True)
class Constants:
    """Constants of the actuator chain: names, values, and where each actuator finds its own."""

    names: tuple[str, ...]
    values: Array  # (n,)
    index: NDArray[np.int32]  # (actuators, 8): STAGES -> place in `values`, -1: stage absent

    def unit(self, name: str) -> str:
        """SI unit of a constant; a suffix after the dot is its group."""
        return CONSTANT_UNITS.get(name.partition(".")[0], "-")


@dataclass(frozen=True)
class Vehicle:
    """A vehicle in forward-left-up axes; `file` is what was written, in the file's own axes."""

    file: VehicleFile
    source: str = field(default="vehicle", compare=False)

    def __post_init__(self) -> None:
        _ = self.chain  # validates inputs, thrusters, forces and groups
        _ = self.structure

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

    @cached_property
    def forces(self) -> tuple[Force, ...]:
        """The generalised forces that terms may use."""
        if self.file.forces:
            return tuple(Force(n, AXES.index(f.axis)) for n, f in self.file.forces.items())
        direct = self.scheme is Scheme.DIRECT and not self.file.thrusters
        given = [name for name in WRENCH if name in self.inputs or not direct]
        return tuple(Force(name, WRENCH.index(name)) for name in given or WRENCH)

    @cached_property
    def mix(self) -> Array:
        """T (forces, actuators): F = T f."""
        if self.file.forces and self.file.thrusters:
            raise VehicleError(f"{self.source}: give thrusters or forces, not both")
        if self.file.forces:
            return self._explicit_mix(self.file.forces)
        if self.file.thrusters:
            return thruster_matrix(self.thrusters)[0]
        if not set(self.inputs) <= set(WRENCH):
            raise VehicleError(
                f"{self.source}: inputs are {', '.join(self.inputs)}; without thrusters or forces "
                f"they must be {', '.join(WRENCH)}, or those of them that there are"
            )
        return np.array([[float(i == f.name) for i in self.inputs] for f in self.forces])

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
        sign = -1.0 if self.axes is Axes.FRD else 1.0
        return tuple(
            Thruster(n, given[n].x, sign * given[n].y, sign * np.deg2rad(given[n].angle_deg))
            for n in self.actuators
        )

    @cached_property
    def structure(self) -> Structure:
        """Model structure in forward-left-up axes."""
        lines = self.file.structure
        name = lines if isinstance(lines, str) else self.name
        parsed = structure.parse(
            name, structure.named(lines) if isinstance(lines, str) else lines, self.forces
        )
        # a named structure is written in forward-left-up axes, a vehicle's own in the vehicle's
        flip = self.axes is Axes.FRD and not isinstance(lines, str)
        return parsed.flipped() if flip else parsed

    @cached_property
    def constants(self) -> Constants:
        """Known constants of the actuator chain."""
        names: list[str] = []
        values: list[float] = []
        index = np.full((len(self.actuators), len(STAGES)), -1, dtype=np.int32)
        for group in self.file.chain:
            suffix = f".{group.name}" if group.name else ""
            members = [
                self._actuator(n, f"chain group '{group.name}'")
                for n in group.actuators or self.actuators
            ]
            for stage, value in _stage_values(group).items():
                if np.any(index[members, STAGES.index(stage)] >= 0):
                    raise VehicleError(
                        f"{self.source}: chain: two groups give an actuator's {stage}"
                    )
                index[members, STAGES.index(stage)] = len(values)
                names.append(stage + suffix)
                values.append(value)
            gains = group.gains or {}
            if gains and not np.isclose(np.mean(list(gains.values())), 1.0):
                raise VehicleError(
                    f"{self.source}: chain: the gains' mean is {np.mean(list(gains.values())):.4g}; "
                    "it must be 1, the coefficients carry the rest"
                )
            for name, value in gains.items():
                index[self._actuator(name, "gains"), STAGES.index("gain")] = len(values)
                names.append(f"gain.{name}")
                values.append(value)
        if len(set(names)) != len(names):
            raise VehicleError(
                f"{self.source}: chain: two groups with the same name; name them apart"
            )
        return Constants(tuple(names), np.array(values, dtype=float), index)

    @cached_property
    def chain(self) -> _core.Chain:
        """The core's actuator chain."""
        if max(len(self.inputs), len(self.actuators)) > _core.MAX_ACTUATORS:
            raise VehicleError(
                f"{self.source}: {len(self.inputs)} inputs and {len(self.actuators)} actuators; at most "
                f"{_core.MAX_ACTUATORS} of each"
            )
        limit = self.file.allocation.limit
        scheme = self.scheme
        direct = scheme is Scheme.DIRECT
        inverse = np.eye(len(self.inputs)) if direct else self._inverse(scheme)
        offset = self.file.allocation.F_os
        if scheme is Scheme.AF and limit is not None and offset >= limit:
            raise VehicleError(
                f"{self.source}: F_os {offset:g} leaves no room under the limit {limit:g}"
            )
        tables = [g.table for g in self.file.chain if g.table]
        if len(tables) > 1:
            raise VehicleError(f"{self.source}: chain: one table at most, for one group")
        return _core.Chain(
            scheme.code,
            np.ascontiguousarray(inverse),
            offset,
            float("inf") if limit is None else limit,
            np.ascontiguousarray(self.mix),
            self._actuator_rows(),
            len(self.constants.names),
            np.array([s.reference for s in self.file.scales.values()], dtype=float),
            np.array(tables[0] if tables else [], dtype=float).reshape(-1, 2),
        )

    def with_chain(self, groups: list[ChainGroup]) -> "Vehicle":
        """The same vehicle with another actuator chain."""
        return replace(self, file=msgspec.structs.replace(self.file, chain=groups))

    def to_mapping(self) -> dict[str, Any]:
        """The file's content, as stored inside a model."""
        content = msgspec.to_builtins(self.file)
        return {"seatrial": self.file.seatrial, **content}

    def _inverse(self, scheme: Scheme) -> Array:
        if not self.file.thrusters or set(self.inputs) != set(WRENCH):
            raise VehicleError(
                f"{self.source}: allocation {scheme.value} needs thrusters, and inputs named "
                f"{', '.join(WRENCH)}; got inputs {', '.join(self.inputs)}"
            )
        order = [WRENCH.index(name) for name in self.inputs]
        return inverse_for(scheme, thruster_matrix(self.thrusters)[0])[:, order]

    def _explicit_mix(self, forces: Mapping[str, ForceEntry]) -> Array:
        mix = np.zeros((len(forces), len(self.actuators)))
        for row, (name, force) in zip(mix, forces.items(), strict=True):
            if not name.startswith("F_"):
                raise VehicleError(f"{self.source}: force '{name}': names begin with F_")
            flip = -1.0 if self.axes is Axes.FRD and force.axis != "surge" else 1.0
            for actuator, weight in force.of.items():
                k = self._actuator(actuator, f"force {name}")
                # a wrench input has been flipped itself when it was read
                row[k] = flip * weight * (1.0 if self.file.thrusters else self.input_signs[k])
        return mix

    def _actuator(self, name: str, where: str) -> int:
        if name not in self.actuators:
            raise VehicleError(
                f"{self.source}: {where} names '{name}'; the actuators are {', '.join(self.actuators)}"
            )
        return self.actuators.index(name)

    def _actuator_rows(self) -> NDArray[np.int32]:
        rows = np.full((len(self.actuators), 10), -1, dtype=np.int32)
        rows[:, :8] = self.constants.index
        rows[:, 9] = 0
        for group in self.file.chain:
            members = [self._actuator(n, "chain") for n in group.actuators or self.actuators]
            if group.scale is not None:
                if group.scale.signal not in self.scales:
                    raise VehicleError(
                        f"{self.source}: chain uses scale '{group.scale.signal}'; "
                        f"scales has {', '.join(self.scales) or 'none'}"
                    )
                rows[members, 8] = self.scales.index(group.scale.signal)
            if group.table is not None:
                rows[members, 9] = 1
        return rows


def load_vehicle(path: str | Path) -> Vehicle:
    """A vehicle from a file, or by the name of one that comes with seatrial."""
    bundled = resources.files("seatrial") / "vehicles" / f"{path}.yaml"
    given = Path(path)
    if not given.exists() and bundled.is_file():
        return vehicle_from(read_yaml(bundled), str(path))
    return vehicle_from(expect_format(read_yaml(given), VEHICLE_FORMAT, given), str(path))


def vehicle_from(content: dict[str, Any], source: str) -> Vehicle:
    """A vehicle from a file's content."""
    return Vehicle(convert(content, VehicleFile, source), source)


def as_column(entry: str | Column) -> Column:
    """The long form of a column: a bare name is a table's column and a message's field."""
    return Column(column=entry, field=entry) if isinstance(entry, str) else entry


def _stage_values(group: ChainGroup) -> dict[str, float]:
    """The constants that a group sets."""
    if group.table is not None:
        _check_table(group)
    edges = group.dead_zone
    values = {
        "latency": group.latency,
        "edge_forward": edges.forward if edges else None,
        "edge_reverse": edges.reverse if edges else None,
        "reverse_ratio": group.reverse_ratio,
        "power": group.power,
        "lag": group.lag,
        "scale_power": group.scale.power if group.scale else None,
    }
    return {stage: value for stage, value in values.items() if value is not None}


def _check_table(group: ChainGroup) -> None:
    table = np.array(group.table, dtype=float)
    if group.dead_zone or group.power or group.reverse_ratio:
        raise VehicleError("chain: a table stands instead of dead_zone, power and reverse_ratio")
    if len(table) < 2 or len(table) > _core.MAX_TABLE or np.any(np.diff(table[:, 0]) <= 0):
        raise VehicleError(
            f"chain: a table needs 2 to {_core.MAX_TABLE} points with rising commands"
        )
    if abs(np.interp(1.0, table[:, 0], table[:, 1]) - 1.0) > 1e-9:
        raise VehicleError(
            "chain: a table must give thrust 1 at command 1; divide it by that value"
        )
