# SPDX-License-Identifier: MIT
"""Simulated trials as files: CSV folders as a robot would leave them, the truth beside them."""

from pathlib import Path

import msgspec
import numpy as np

from seatrial.files import dump_yaml, write_text
from seatrial.frames import POSE_SIGNS, Array, Axes, Stamps
from seatrial.io.read import COMMAND_FILE, POSE_FILE
from seatrial.io.table import TO_NANOSECONDS, TO_SI
from seatrial.model import Model, save
from seatrial.plan import PlanFile
from seatrial.schema import Column
from seatrial.simulate import SUFFIX, Trial
from seatrial.vehicle import Vehicle, as_column

TRUTH = "truth"  # folder of what a real boat would not tell


def write_trial(trial: Trial, out: Path) -> Path:
    """One trial as a folder recording below `out`; its truth in `out`/truth. Returns the folder."""
    vehicle, folder = trial.vehicle, out / trial.name
    frd = vehicle.axes is Axes.FRD
    spec, commands = vehicle.file.pose, vehicle.file.commands
    pose = trial.pose * POSE_SIGNS if frd else trial.pose
    columns = [as_column(c) for c in (spec.stamp, spec.x, spec.y, spec.psi)]
    rows = np.column_stack(
        [_raw_stamps(trial.pose_stamps, columns[0])]
        + [_raw(pose[:, i], columns[i + 1]) for i in range(3)]
    )
    _write_table(folder / (spec.file or POSE_FILE), [c.column for c in columns], rows)
    inputs = [as_column(c) for c in commands.inputs.values()]
    stamp = as_column(commands.stamp)
    values = trial.command * vehicle.input_signs
    rows = np.column_stack(
        [_raw_stamps(trial.command_stamps, stamp)]
        + [_raw(values[:, i], c) for i, c in enumerate(inputs)]
    )
    _write_table(
        folder / (commands.file or COMMAND_FILE), [stamp.column, *(c.column for c in inputs)], rows
    )
    names = ["t", "x", "y", "psi", "u", "v", "r", *(f"{f.name}_actual" for f in vehicle.forces)]
    truth = np.column_stack([trial.truth_t, trial.truth, trial.truth_force])
    if frd:
        truth[:, [2, 3, 5, 6]] *= -1.0
        truth[:, 7:] *= [-1.0 if f.axis > 0 else 1.0 for f in vehicle.forces]
    _write_table(out / TRUTH / f"{trial.name}.csv", names, truth)
    return folder


def write_setting(plan: PlanFile, vehicle: Vehicle, truth: Model, out: Path) -> Path:
    """Vehicle file for the trials, the plan as it was run, and the true model."""
    suffix = SUFFIX[vehicle.scheme]
    path = out / f"vehicle{suffix}.yaml"
    write_text(path, dump_yaml(vehicle.to_mapping()))
    write_text(
        out / TRUTH / "plan.yaml",
        dump_yaml({"seatrial": plan.seatrial, **msgspec.to_builtins(plan)}),
    )
    save(truth, out / TRUTH / f"model{suffix}.yaml")
    return path


def _raw(value: Array, column: Column) -> Array:
    """The inverse of `table.scaled`."""
    return np.asarray(
        column.sign * value / TO_SI.get(column.unit or "-", 1.0) * column.scale + column.offset
    )


def _raw_stamps(stamps: Stamps, column: Column) -> Array:
    return np.asarray(
        column.sign * stamps / TO_NANOSECONDS[column.unit or "s"] * column.scale + column.offset
    )


def _write_table(path: Path, names: list[str], rows: Array) -> None:
    body = "\n".join(f"{t:.12g}," + ",".join(f"{x:.7g}" for x in row) for t, *row in rows.tolist())
    write_text(path, ",".join(names) + "\n" + body + "\n")
