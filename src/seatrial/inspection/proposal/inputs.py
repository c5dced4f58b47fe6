# SPDX-License-Identifier: MIT
"""Which channel drives what, and by how much: asked of the data."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seatrial.boat.vehicle import WRENCH, Vehicle, vehicle_from
from seatrial.inspection.consistency import Assignment, Gain, SignReport, assignments, check_signs
from seatrial.inspection.proposal.sources import Sources
from seatrial.io.reader import read
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.frames import AXES, Array

SEEN = 6.0  # t from which on a channel is said to drive an axis,
ALIKE = 0.05  # of their mean, or so many standard errors: thrusters are taken to push alike
ALIKE_ERRORS = 2.0
SHARE = 0.3  # with at least this share of the effect of the strongest there
STICK = 0.1  # share of what turning does to a point off the origin that the axis' own stick does at least
LEAST_LEVER, MOST_LEVER = 0.02, 1.5  # [m] of the measured point that are proposed
MOST_CHANNELS = 8  # those that vary most: a vehicle has no more inputs
PWM = (900.0, 2100.0)  # [us]
PWM_CENTRE, PWM_SPAN = 1500.0, 400.0  # [us]
NEARLY_ONE = 1.05
FULL = (1.0, 100.0, 127.0, 255.0, 500.0, 1000.0, 32767.0)  # usual values of full command
USED = 0.5  # share of it that is reached, if it is one of them
ALONE = 0.01  # of the largest combination of inputs: what is driven less is driven with others only
NAMES = {
    "F_u": "F_u|surge|force_x|linear_x",
    "F_v": "F_v|sway|force_y|linear_y",
    "F_r": "F_r|yaw|torque_z|angular_z",
}
Parts = tuple[dict[str, dict[str, Any]], dict[str, str], dict[str, dict[str, Any]]]


@dataclass(frozen=True)
class Drive:
    """The inputs, and what is known of each."""

    inputs: dict[str, dict[str, Any]]  # by name: the column
    remarks: dict[str, str]  # by name: what was seen
    forces: dict[str, dict[str, Any]]  # empty: the inputs are F_u, F_v, F_r, and all are there
    thrusters: bool  # that several channels drive an axis together
    undriven: tuple[str, ...]  # axes that nothing is seen to drive
    pose: dict[str, Any]  # as found, units put right
    lever: (
        tuple[float, float] | None
    )  # [m] of the measured point, in the file's axes, as far as seen
    findings: tuple[str, ...]  # what was put right
    on_change: bool


@dataclass(frozen=True)
class Channels:
    """What each channel does to each axis, in the axes of the file."""

    names: tuple[str, ...]
    columns: dict[str, dict[str, Any]]  # with offset and scale
    t: Array  # (3, n)
    gains: Array  # (3, n) [m/s^2], [rad/s^2] per full command
    spread: Array  # (n,) standard deviation of the command

    @cached_property
    def assigned(self) -> tuple[Assignment, ...]:
        """For each axis the channel that moves it most clearly, none twice."""
        t = self.t.copy()
        if self.lever is not None:
            t[:2, self.turning] = 0.0
        return tuple(a for a in assignments(self.names, t) if abs(a.t) > SEEN)

    @property
    def turning(self) -> int:
        """The channel that turns the boat most."""
        return int(np.argmax(self.effects[2]))

    @property
    def effects(self) -> Array:
        """How much (3, n) each channel does to each axis, where that is seen."""
        return np.where(np.abs(self.t) > SEEN, np.abs(self.gains) * self.spread, 0.0)

    @property
    def clear(self) -> NDArray[np.bool_]:
        """Channels (3, n) that drive an axis visibly, and not only by the way.

        What turns the boat moves a point off its origin aside: that is no drive of surge or sway.
        """
        seen = self.effects
        if self.lever is not None:
            seen[:2, self.turning] = 0.0
        return np.asarray((seen > 0) & (seen >= SHARE * seen.max(axis=1, keepdims=True)))

    @cached_property
    def lever(self) -> tuple[float, float] | None:
        """The measured point [m] from the origin, if the one channel that turns the boat seems to push it, too.

        Others must drive surge and sway as well: else the same is seen of a single thruster at the bow.
        """
        seen = self.effects
        k = self.turning
        if np.count_nonzero(seen[2] >= max(SHARE * seen[2].max(), 1e-12)) != 1:
            return None
        aside = seen[:2, k] > 0.0
        others = np.delete(seen[:2], k, axis=1).max(axis=1, initial=0.0) >= STICK * seen[:2, k]
        if not aside.any() or not others[aside].all():
            return None
        along, across = np.where(aside, self.gains[:2, k], 0.0) / self.gains[2, k]
        ahead, second = round(float(across), 2) + 0.0, round(float(-along), 2) + 0.0
        return (ahead, second) if LEAST_LEVER < np.hypot(ahead, second) < MOST_LEVER else None

    @property
    def shared(self) -> bool:
        """Whether several channels drive an axis together: thrusters rather than sticks."""
        together = bool((self.clear.sum(axis=1) > 1).any())
        return together and not all(a.trusted for a in self.assigned)


def find_drive(sources: Sources, *, salvage: bool) -> Drive:
    """Inputs, signs, scales and units from the recording itself."""
    names = _varied(sources, salvage=salvage)
    pose, said, report = _units(sources, names, salvage=salvage)
    draft = _draft(sources, pose, names)
    recordings = _read(sources, draft, salvage=salvage)
    channels = _channels(sources, draft, recordings, report.table)
    parts = (_thrusters if channels.shared else _sticks)(channels)
    inputs, remarks, forces = parts if parts[0] else _by_name(recordings, channels)
    driven = {f["axis"] for f in forces.values()}
    on_change = any(s.on_change for r in recordings for s in r.streams if s.role == "commands")
    return Drive(
        inputs, remarks, forces if channels.shared or len(driven) < len(AXES) else {},
        channels.shared, tuple(axis for axis in AXES if axis not in driven), pose, channels.lever,
        tuple(said), on_change,
    )  # fmt: skip


def _units(
    sources: Sources, names: Sequence[str], *, salvage: bool
) -> tuple[dict[str, Any], list[str], SignReport]:
    """The poses' columns with units put right, what was found, and the check that found it."""
    pose = dict(sources.pose)
    draft = _draft(sources, pose, names)
    report = check_signs(_read(sources, draft, salvage=salvage), draft)
    said = []
    for key, unit in zip(("x", "y", "psi"), report.repair.units, strict=True):
        if unit is not None:
            pose[key] = dict(pose.get(key, {})) | {"unit": unit}
            said.append(f"{key} is in {unit}, by the way that the boat moves")
    if said:
        draft = _draft(sources, pose, names)
        report = check_signs(_read(sources, draft, salvage=salvage), draft)
    return pose, said, report


def _read(sources: Sources, draft: Vehicle, *, salvage: bool) -> list[Recording]:
    return [read(path, draft, salvage=salvage) for path in (sources.path, *sources.more)]


def _draft(sources: Sources, pose: Mapping[str, Any], names: Sequence[str]) -> Vehicle:
    """A vehicle that can read the channels."""
    content = {
        "seatrial": "vehicle 1",
        "name": sources.name,
        "axes": sources.axes,
        "pose": dict(pose),
        "commands": {**sources.commands, "inputs": {n: sources.channels[n] for n in names}},
        "forces": {"F_u": {"axis": "surge", "of": {names[0]: 1.0}}},
        "structure": {"surge": ["X_u * u", "X_F * F_u"], "sway": ["Y_v * v"], "yaw": ["N_r * r"]},
    }
    return vehicle_from(content, f"the draft for {sources.path}")


def _varied(sources: Sources, *, salvage: bool) -> list[str]:
    """Channels that change, those that change most often."""
    changes: dict[str, int] = {}
    names = [*sources.channels]
    for i in range(0, len(names), MOST_CHANNELS):
        part = _draft(sources, sources.pose, names[i : i + MOST_CHANNELS])
        for recording in _read(sources, part, salvage=salvage):
            steps = (np.diff(recording.commands.values, axis=0) != 0).sum(axis=0)
            for name, count in zip(part.inputs, steps.tolist(), strict=True):
                changes[name] = changes.get(name, 0) + count
    kept = sorted((n for n in names if changes[n]), key=lambda n: -changes[n])[:MOST_CHANNELS]
    if not kept:
        raise RecordingError(
            f"{sources.path}: no command ever changes; record while the boat is driven"
        )
    return [name for name in names if name in kept]


def _channels(
    sources: Sources, draft: Vehicle, recordings: Sequence[Recording], table: Sequence[Gain]
) -> Channels:
    signals = [recording.commands for recording in recordings]
    names = signals[0].names
    values = np.concatenate([signal.values for signal in signals])
    raw = values * draft.input_signs
    scales = [_scale(raw[:, i], sources.full) for i in range(len(names))]
    t, gains = np.zeros((3, len(names))), np.zeros((3, len(names)))
    for gain in table:
        i = names.index(gain.input)
        turn = -1.0 if sources.axes == "forward-right-down" and gain.axis > 0 else 1.0
        t[gain.axis, i] = turn * gain.t
        gains[gain.axis, i] = turn * gain.value
    columns = {n: sources.channels[n] | s for n, s in zip(names, scales, strict=True)}
    sizes = np.array([s.get("scale", 1.0) for s in scales])
    spread = values.std(axis=0) / sizes
    return Channels(names, columns, t, gains * sizes, spread)


def _scale(values: Array, full: float | None = None) -> dict[str, float]:
    """Offset and scale with which full command is 1; `full` where the message says what it is."""
    least, most = float(values.min()), float(values.max())
    if PWM[0] <= least and most <= PWM[1]:
        return {"offset": PWM_CENTRE, "scale": PWM_SPAN}
    largest = max(abs(least), abs(most))
    usual = next((x for x in FULL if x > largest / NEARLY_ONE), 0.0)
    if full is None and largest < USED * usual and largest > NEARLY_ONE:
        decade = 10.0 ** np.floor(np.log10(largest))
        full = float(np.ceil(largest / NEARLY_ONE / decade) * decade)
    scale = full or usual or largest
    return {} if scale == 1.0 else {"scale": scale}


def _thrusters(found: Channels) -> Parts:
    """Each channel an input; forces as sums of them, weighted by the gains seen."""
    forces: dict[str, dict[str, Any]] = {}
    for axis, clear in enumerate(found.clear):
        mine = np.where(clear, found.gains[axis], 0.0)
        if clear.any():
            weights = _evened(mine, np.abs(mine / np.where(clear, found.t[axis], 1.0)))
            of = {n: round(float(w), 3) for n, w in zip(found.names, weights, strict=True) if w}
            forces[WRENCH[axis]] = {"axis": AXES[axis], "of": of}
    used = {name for force in forces.values() for name in force["of"]}
    if len(forces) > len(used):  # two astern: it sways as it turns, but nothing pushes it aside
        forces.pop(WRENCH[1], None)
        used = {name for force in forces.values() for name in force["of"]}
    inputs = {n: found.columns[n] for n in found.names if n in used}
    return inputs, {n: _seen(found.t[:, found.names.index(n)]) for n in inputs}, forces


def _evened(gains: Array, errors: Array) -> Array:
    """Weights (n,) whose sizes sum to 1, alike where gains with these errors (n,) do not differ.

    Thrusters of one kind push alike; by how much they seem not to depends on the drive. Sizes count as one where
    they are a few per cent apart, or no more than their errors explain.
    """
    sizes, own = np.abs(gains), gains != 0.0
    mean = float(sizes[own].mean())
    alike = np.abs(sizes - mean) < np.maximum(ALIKE * mean, ALIKE_ERRORS * errors)
    even = np.sign(gains) * mean if alike[own].all() else gains
    return np.asarray(even / np.abs(even).sum())


def _sticks(found: Channels) -> Parts:
    """One channel an axis."""
    inputs: dict[str, dict[str, Any]] = {}
    remarks: dict[str, str] = {}
    forces: dict[str, dict[str, Any]] = {}
    for a in sorted(found.assigned, key=lambda a: a.axis):
        positive = found.t[a.axis, found.names.index(a.channel)] > 0
        name = WRENCH[a.axis]
        inputs[name] = found.columns[a.channel] | ({} if positive else {"sign": -1})
        doubt = (
            ""
            if a.trusted or found.lever
            else "; check: another channel moves it nearly as clearly"
        )
        remarks[name] = f"seen to move {AXES[a.axis]} (t {abs(a.t):.0f}){doubt}"
        forces[name] = {"axis": AXES[a.axis], "of": {name: 1.0}}
    return inputs, remarks, forces


def _by_name(recordings: Sequence[Recording], found: Channels) -> Parts:
    """Where nothing is seen to move the boat: what the channels' names say."""
    inputs: dict[str, dict[str, Any]] = {}
    for force, words in NAMES.items():
        like = [n for n in found.names if re.search(rf"(^|_)({words})$", n, re.IGNORECASE)]
        if len(like) == 1:
            inputs[force] = found.columns[like[0]]
    if not inputs:
        names = ", ".join(recording.name for recording in recordings)
        length = sum(recording.duration for recording in recordings)
        count = _combinations(recordings)
        if 0 < count < len(found.names):
            raise RecordingError(
                f"{names}: {', '.join(found.names)} are always driven in the same {count} combinations, as an "
                "allocation does: what one of them does alone can't be seen. Write the vehicle file with "
                "thrusters: and where they are (docs/vehicle.md)"
            )
        raise RecordingError(
            f"{names}: {length:.0f} s do not show which of {', '.join(found.names)} move the boat; record "
            "some minutes in which it is driven, or write the vehicle file by hand (docs/vehicle.md)"
        )
    remarks = dict.fromkeys(inputs, "check: by its name; nothing was seen to move")
    axes = dict(zip(WRENCH, AXES, strict=True))
    return inputs, remarks, {n: {"axis": axes[n], "of": {n: 1.0}} for n in inputs}


def _combinations(recordings: Sequence[Recording]) -> int:
    """How many independent combinations of the inputs are driven."""
    values = np.concatenate([r.commands.values for r in recordings])
    size = np.linalg.svd(values - values.mean(axis=0), compute_uv=False)
    return int((size > ALONE * size[0]).sum()) if size[0] > 0 else 0


def _seen(t: Array) -> str:
    parts = [f"{AXES[i]} (t {t[i]:+.0f})" for i in range(3) if abs(t[i]) > SEEN]
    return f"seen to move {', '.join(parts)}" if parts else "not seen to move anything"
