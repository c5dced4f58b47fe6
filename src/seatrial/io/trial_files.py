# SPDX-License-Identifier: MIT
"""Simulated trials as tables or bags, and the truth in its own folder."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.model_file import save
from seatrial.boat.schema import (
    TO_SI,
    Column,
    CommandSource,
    PoseSource,
    ScaleSource,
    as_column,
)
from seatrial.boat.vehicle import WRENCH, Vehicle
from seatrial.io.bags.write import BagTopic, message_for, write_bag
from seatrial.io.digests import DIGESTS, edited, noted
from seatrial.io.kinds import TRUTH
from seatrial.io.poses import pose_columns
from seatrial.io.signals import field_path
from seatrial.io.tables.signals import COMMAND_FILE, POSE_FILE
from seatrial.io.tables.stamps import TO_NANOSECONDS
from seatrial.simulation.plan import PlanFile
from seatrial.simulation.trials import SUFFIX, Trial
from seatrial.util.errors import RecordingError
from seatrial.util.files import dump_yaml, write_text
from seatrial.util.frames import Array, Stamps

POSE_TOPIC, COMMAND_TOPIC = "/pose", "/commands"  # of boats whose own logs have other forms
BAG_EPOCH = 1_700_000_000 * 10**9  # [ns] time zero of a trial in its bag: ROS times are after 1970


def guard_trials(plan: PlanFile, vehicle: Vehicle, out: Path) -> None:
    """Refuse a folder with real recordings or an edited vehicle file under the names to be written.

    Simulated files have a truth file and are unedited. Raises RecordingError.
    """
    suffix = SUFFIX[vehicle.scheme]
    known = {out / f"vehicle{suffix}.yaml": out / TRUTH / "plan.yaml"}
    for name in (f"{trial}{suffix}" for trial in plan.trials):
        for path in (out / name, *out.glob(f"{name}.*")):
            known[path] = out / TRUTH / f"{name}.csv"
    for path, truth in known.items():
        if path.exists() and not truth.exists():
            raise RecordingError(
                f"{path}: exists, and was not simulated (there is no {truth}); give another folder"
            )
    for path in edited(out, out / TRUTH / DIGESTS):
        if path in known or path.parent in known:
            raise RecordingError(
                f"{path}: was edited since it was simulated; give another folder, or remove it"
            )


def of_trials(vehicle: Vehicle) -> Vehicle:
    """The vehicle that reads its simulated trials: itself, where its logs are a joypad's commands beside poses.

    Else with tables and topics of their own; lever arm and delays stay.
    """
    file = vehicle.file
    logged = file.pose.valid or file.pose.latitude or file.pose.yaw_rate or file.scales
    tables = set(_tables(vehicle))
    if set(vehicle.inputs) == set(WRENCH) and len(tables) == 2 and not logged:
        return vehicle
    stamp = Column(column="stamp" if "t" in (*vehicle.inputs, *vehicle.scales) else "t")
    names = (*vehicle.inputs, *vehicle.scales)
    columns = {name: Column(column=name, field=f"axes[{i}]") for i, name in enumerate(names)}
    x, y, psi = (Column(column=name) for name in ("x", "y", "psi"))
    pose = PoseSource(
        stamp, x, y, psi, file=POSE_FILE, topic=POSE_TOPIC,
        lever=file.pose.lever, delay=file.pose.delay, heading_delay=file.pose.heading_delay,
    )  # fmt: skip
    inputs: dict[str, str | Column] = {name: columns[name] for name in vehicle.inputs}
    commands = CommandSource(inputs, stamp, file=COMMAND_FILE, topic=COMMAND_TOPIC)
    scales = {n: ScaleSource(columns[n], s.reference) for n, s in file.scales.items()}
    file = msgspec.structs.replace(
        file, pose=pose, commands=commands, scales=scales, command_timeout=None
    )
    return replace(vehicle, file=file)


def write_trial(trial: Trial, out: Path, kind: str = "csv") -> Path:
    """One trial below `out`: a folder of tables or a bag; its truth in `out`/truth. Returns it."""
    path = out / (trial.name if kind == "csv" else f"{trial.name}.{kind}")
    tables = _tables(trial.vehicle)
    # the truth first: a folder that has it was simulated, also where it was interrupted
    _write_truth(trial, out / TRUTH / f"{trial.name}.csv")
    with noted(out, out / TRUTH / DIGESTS, [path / x for x in tables] if kind == "csv" else [path]):
        if kind == "csv":
            _write_tables(trial, path)
        else:
            _write_trial_bag(trial, path)
    return path


def _tables(vehicle: Vehicle) -> tuple[str, str]:
    """Names of the files with poses and with commands."""
    spec = vehicle.file
    return spec.pose.file or POSE_FILE, spec.commands.file or COMMAND_FILE


def _write_tables(trial: Trial, folder: Path) -> None:
    spec, commands = trial.vehicle.file.pose, trial.vehicle.file.commands
    poses, orders = _tables(trial.vehicle)
    stamp, *columns = as_column(spec.stamp), *spec.columns.values()
    rows = np.column_stack([_raw_stamps(trial.pose_stamps, stamp), _raw_pose(trial)])
    _write_table(folder / poses, [stamp.column, *(c.column for c in columns)], rows)
    stamp = as_column(commands.stamp)
    inputs = _command_columns(trial.vehicle)
    rows = np.column_stack([_raw_stamps(trial.command_stamps, stamp), _raw_commands(trial)])
    _write_table(folder / orders, [stamp.column, *(c.column for c in inputs)], rows)


def _write_trial_bag(trial: Trial, path: Path) -> None:
    """Poses as PoseStamped, commands as the message of their fields."""
    source = trial.vehicle.source
    topic = trial.vehicle.file.pose.topic
    if topic is None:
        raise RecordingError(f"{source}: pose: no topic to write to; name one")
    pose = _raw_pose(trial)
    turn = pose[:, 2] * TO_SI[pose_columns(trial.vehicle)[2].unit or "rad"]  # [rad]
    topics = [
        BagTopic(
            topic, "geometry_msgs/msg/PoseStamped", trial.pose_arrival + BAG_EPOCH,
            trial.pose_stamps + BAG_EPOCH,
            {
                "pose.position.x": pose[:, 0], "pose.position.y": pose[:, 1],
                "pose.orientation.z": np.sin(turn / 2),
                "pose.orientation.w": np.cos(turn / 2),
            },
            {"header.frame_id": "map"},
        )
    ]  # fmt: skip
    raw = _raw_commands(trial)
    for name, columns in _by_topic(trial.vehicle).items():
        paths = {field_path(column): raw[:, i] for i, column in columns}
        kind = message_for(next(iter(paths)), f"{source}: commands: inputs")
        arrival, stamps = trial.command_arrival + BAG_EPOCH, trial.command_stamps + BAG_EPOCH
        topics.append(BagTopic(name, kind, arrival, stamps, paths))
    write_bag(path, topics)


def _by_topic(vehicle: Vehicle) -> dict[str, list[tuple[int, Column]]]:
    found: dict[str, list[tuple[int, Column]]] = {}
    names = (*vehicle.inputs, *vehicle.scales)
    for i, (name, column) in enumerate(zip(names, _command_columns(vehicle), strict=True)):
        topic = column.topic or vehicle.file.commands.topic
        if not topic or not column.field:
            raise RecordingError(
                f"{vehicle.source}: commands: inputs: {name} has no topic and field"
            )
        found.setdefault(topic, []).append((i, column))
    return found


def _raw_pose(trial: Trial) -> Array:
    """x, y, psi (n, 3) in the vehicle file's axes and units."""
    return _raw_values(trial.pose * trial.vehicle.axes.signs, pose_columns(trial.vehicle))


def _raw_commands(trial: Trial) -> Array:
    """Commands and scales (m, inputs + scales) in the vehicle file's signs and units."""
    values = np.hstack([trial.command * trial.vehicle.input_signs, trial.scale])
    return _raw_values(values, _command_columns(trial.vehicle))


def _command_columns(vehicle: Vehicle) -> list[Column]:
    """Of the inputs, then of the scales."""
    scales = [scale.column for scale in vehicle.file.scales.values()]
    return [as_column(c) for c in (*vehicle.file.commands.inputs.values(), *scales)]


def _write_truth(trial: Trial, path: Path) -> None:
    vehicle = trial.vehicle
    names = ["t", "x", "y", "psi", "u", "v", "r", *(f"{f.name}_actual" for f in vehicle.forces)]
    truth = np.column_stack([trial.truth_t, trial.truth, trial.truth_force])
    truth[:, 1:4] *= vehicle.axes.signs
    truth[:, 4:7] *= vehicle.axes.signs
    truth[:, 7:] *= vehicle.axes.signs[[f.axis for f in vehicle.forces]]
    _write_table(path, names, truth)


def write_setting(plan: PlanFile, vehicle: Vehicle, truth: Model, out: Path) -> Path:
    """Vehicle file for the trials, the plan, and the true model."""
    suffix = SUFFIX[vehicle.scheme]
    path = out / f"vehicle{suffix}.yaml"
    content = {"seatrial": plan.seatrial, **msgspec.to_builtins(plan)}
    write_text(out / TRUTH / "plan.yaml", dump_yaml(content))
    with noted(out, out / TRUTH / DIGESTS, [path]):
        write_text(path, dump_yaml(vehicle.to_mapping()))
    save(truth, out / TRUTH / f"model{suffix}.yaml")
    return path


def _raw(value: Array | Stamps, column: Column, unit: float) -> Array:
    """The inverse of `table.scaled`."""
    return np.asarray(column.sign * value / unit * column.scale + column.offset)


def _raw_stamps(stamps: Stamps, column: Column) -> Array:
    return _raw(stamps, column, TO_NANOSECONDS[column.unit or "s"])


def _raw_values(values: Array, columns: Iterable[Column]) -> Array:
    """Values (n, columns) in the columns' units."""
    return np.column_stack(
        [_raw(x, c, TO_SI.get(c.unit or "-", 1.0)) for x, c in zip(values.T, columns, strict=True)]
    )


def _write_table(path: Path, names: list[str], rows: Array) -> None:
    body = "\n".join(f"{t:.12g}," + ",".join(f"{x:.7g}" for x in row) for t, *row in rows.tolist())
    write_text(path, ",".join(names) + "\n" + body + "\n")
