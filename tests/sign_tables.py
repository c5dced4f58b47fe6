# SPDX-License-Identifier: MIT
"""Tables of good recordings, and vehicle files with units, signs and order put wrong."""

from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations

import msgspec
import numpy as np

import seatrial
from seatrial.boat.allocation import Scheme, inverse_for, thruster_matrix
from seatrial.boat.schema import AllocationEntry, as_column
from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.consistency.repair import ANGLES, LENGTHS, Repair, apply_repair
from seatrial.recording.from_poses import make_recording
from seatrial.recording.recording import Recording
from seatrial.recording.signal import Signal
from tests.boats.plans import driven_by, planned

UNITS = {**LENGTHS, **ANGLES, None: 1.0}
OTHER = {"mm": "m", "deg": "rad", None: None}


@dataclass(frozen=True)
class Table:
    """A good recording's columns as its file has them."""

    recording: Recording
    columns: dict[str, np.ndarray]
    marked: np.ndarray

    def read(self, vehicle: Vehicle) -> Recording:
        """As the vehicle file says, right or wrong."""
        record = self.recording
        commands = Signal(vehicle.inputs, record.commands.stamps, self.inputs(vehicle))
        return make_recording(
            record.name, record.stamps, self.poses(vehicle), commands,
            scales=record.scales, marked_valid=self.marked,
        )  # fmt: skip

    def poses(self, vehicle: Vehicle) -> np.ndarray:
        pose, signs = vehicle.file.pose, vehicle.axes.signs
        return np.column_stack([self._column(e) for e in (pose.x, pose.y, pose.psi)]) * signs

    def inputs(self, vehicle: Vehicle) -> np.ndarray:
        columns = [self._column(e) for e in vehicle.file.commands.inputs.values()]
        return np.column_stack(columns) * vehicle.input_signs

    def _column(self, entry):
        column = as_column(entry)
        raw = self.columns[column.column]
        return column.sign * UNITS[column.unit] * (raw - column.offset)

    def in_units(self, x: float, y: float, psi: float) -> "Table":
        scaled = {"x": x, "y": y, "psi": psi}
        columns = {n: c / scaled.get(n, 1.0) for n, c in self.columns.items()}
        return replace(self, columns=columns)


def tabulated(recording: Recording, vehicle: Vehicle, marked=None) -> Table:
    signs = vehicle.axes.signs
    columns = dict(zip(("x", "y", "psi"), (recording.raw * signs).T, strict=True))
    values = (recording.commands.values * vehicle.input_signs).T
    for entry, column in zip(vehicle.file.commands.inputs.values(), values, strict=True):
        columns[as_column(entry).column] = column
    usable = np.ones(len(recording.t), dtype=bool) if marked is None else marked
    return Table(recording, columns, usable)


def untouched(vehicle: Vehicle) -> Repair:
    n = len(vehicle.inputs)
    return Repair(order=tuple(range(n)), input_signs=(1,) * n)


def inputs_edited(vehicle: Vehicle, cycle=(), negated=()) -> Repair:
    n = len(vehicle.inputs)
    order = list(range(n))
    for a, b in zip(cycle, (*cycle[1:], *cycle[:1]), strict=True):
        order[a] = b
    return Repair(
        order=tuple(order), input_signs=tuple(-1 if i in negated else 1 for i in range(n))
    )


def faults(vehicle: Vehicle) -> dict[str, Repair]:
    """By name what is put wrong in the file."""
    n, none = len(vehicle.inputs), untouched(vehicle)
    found = {f"-{vehicle.inputs[i]}": inputs_edited(vehicle, negated=(i,)) for i in range(n)}
    for i, j in combinations(range(n), 2):
        found[f"{vehicle.inputs[i]}<>{vehicle.inputs[j]}"] = inputs_edited(vehicle, (i, j))
    if n == 3:
        found["cycle"] = inputs_edited(vehicle, (0, 1, 2))
        found["cycle back"] = inputs_edited(vehicle, (0, 2, 1))
    found["degrees"] = replace(none, units=(None, None, "deg"))
    found["millimetres"] = replace(none, units=("mm", "mm", None))
    found["x in mm"] = replace(none, units=("mm", None, None))
    found["-x"] = replace(none, pose_signs=(-1, 1, 1))
    found["-y"] = replace(none, pose_signs=(1, -1, 1))
    found["-psi"] = replace(none, pose_signs=(1, 1, -1))
    found["other hand"] = replace(none, pose_signs=(1, -1, -1))
    found["compass"] = replace(none, pose_signs=(1, 1, -1), turn=1)
    found["heading + 90 deg"] = replace(none, turn=1)
    found["heading - 90 deg"] = replace(none, turn=3)
    found["x<>y"] = replace(none, exchanged=True)
    one = inputs_edited(vehicle, negated=(1,))
    found["degrees, negated"] = replace(one, units=(None, None, "deg"))
    found["millimetres, swapped"] = replace(
        inputs_edited(vehicle, (0, 1)), units=("mm", "mm", None)
    )
    found["-y, negated"] = replace(inputs_edited(vehicle, negated=(0,)), pose_signs=(1, -1, 1))
    found["degrees, mm, negated"] = replace(one, units=("mm", "mm", "deg"))
    return found


def put_wrong(tables, vehicle, fault):
    """Tables in the units of the fault, the vehicle file that reads them well, and one that doesn't."""
    x, y, psi = (1.0 if u is None else UNITS[u] for u in fault.units)
    good = apply_repair(vehicle, replace(untouched(vehicle), units=fault.units))
    wrong = apply_repair(good, replace(fault, units=tuple(OTHER[u] for u in fault.units)))
    return [t.in_units(x, y, psi) for t in tables], good, wrong


def read_all(tables, vehicle):
    return [t.read(vehicle) for t in tables]


def assert_found(tables, vehicle, name, fault):
    """The findings, put right in the wrong file, give the good one back."""
    given, good, wrong = put_wrong(tables, vehicle, fault)
    report = check_consistency(read_all(given, wrong), wrong)
    assert report.findings, name
    repaired = report.repaired(wrong)
    for table in given:
        np.testing.assert_allclose(table.poses(repaired), table.poses(good), err_msg=name)
        np.testing.assert_allclose(table.inputs(repaired), table.inputs(good), err_msg=name)


def direct(table: Table, mp: Vehicle) -> tuple[Table, Vehicle]:
    """The same trial with the thrusters' own commands recorded: f = T+ F."""
    f = table.recording.commands.values @ inverse_for(Scheme.MP, thruster_matrix(mp.thrusters)[0]).T
    names = tuple(mp.file.thrusters)
    inputs = msgspec.structs.replace(mp.file.commands, inputs={n: n for n in names})
    file = msgspec.structs.replace(mp.file, allocation=AllocationEntry(), commands=inputs)
    columns = {n: table.columns[n] for n in ("x", "y", "psi")} | dict(zip(names, f.T, strict=True))
    return replace(table, columns=columns), Vehicle(file)


@cache
def simulated(plan: str, trial: str, name: str) -> tuple[Table, Vehicle]:
    """One trial of a plan, and the vehicle that drove it."""
    vehicle = seatrial.load_vehicle(name)
    (recording,) = driven_by(planned(plan, trial), vehicle)
    return tabulated(recording, vehicle), vehicle
