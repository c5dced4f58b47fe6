# SPDX-License-Identifier: MIT
"""Inputs and forces by the gains of the channels: thrusters, sticks, or a thrust and the angle that turns it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from seatrial.boat.vehicle import WRENCH
from seatrial.inspection.consistency.steering_angle import STEERED, angle_text
from seatrial.inspection.proposal.by_name import Parts
from seatrial.inspection.proposal.channels import LONGEST_LEVER, Channels
from seatrial.inspection.proposal.columns.names import steers
from seatrial.inspection.proposal.sources import Entries
from seatrial.util.frames import AXES, Array, Mask

EQUAL_GAINS = 0.05  # of their mean; gains within it are proposed as equal (identical thrusters)
EQUAL_GAINS_ERRORS = 2.0  # standard errors; the same


@dataclass(frozen=True)
class Steered:
    """Two inputs that seem to be a thrust and the angle that turns it: rudder, outboard, azimuth thruster."""

    thrust: str
    angle: str
    parts: Parts  # inputs, remarks and forces of them
    sure: bool  # by the motion of the boat and by the angle's name
    flow: bool = False  # a rudder in the flow: its force is that times |u| u


def thrusters(found: Channels) -> Parts:
    """Each channel an input; forces as sums of them, weighted by their gains."""
    forces: Entries = {}
    for axis, clear in enumerate(found.clear):
        if clear.any():
            own = weights(axis, found.clear, found.gains, found.t)
            of = {n: round(float(w), 3) for n, w in zip(found.names, own, strict=True) if w}
            forces[WRENCH[axis]] = {"axis": AXES[axis], "of": of}
    used = {name for force in forces.values() for name in force["of"]}
    if len(forces) > len(used):  # two thrusters astern: sway follows from yaw, no force drives it
        forces.pop(WRENCH[1], None)
        used = {name for force in forces.values() for name in force["of"]}
    inputs = {n: found.columns[n] for n in found.names if n in used}
    return inputs, {n: _thruster_remark(found, n) for n in inputs}, forces


def sticks(found: Channels) -> Parts:
    """One channel an axis."""
    inputs: Entries = {}
    remarks: dict[str, str] = {}
    forces: Entries = {}
    for a in sorted(found.assigned, key=lambda a: a.axis):
        name = WRENCH[a.axis]
        inputs[name] = _ahead(found, a.channel, a.axis)
        doubt = _angle_remark(found, a.channel)
        if not (a.trusted or found.lever):
            doubt = f"; check: another channel moves it with a similar t{doubt}"
        remarks[name] = f"moves {AXES[a.axis]} (t {abs(a.t):.0f}){doubt}"
        forces[name] = {"axis": AXES[a.axis], "of": {name: 1.0}}
    return inputs, remarks, forces


def steered(found: Channels) -> Steered | None:
    """The thrust and the angle of a boat that has no other input; None: it has no angle, or others.

    The angle is that of a push from astern: a positive one turns the boat against the file's yaw. Its force
    across turns the boat, too, so no force of yaw is proposed. A rudder in the flow is a force of yaw by itself.
    """
    assigned = {a.axis: a.channel for a in found.assigned}
    thrust = assigned.pop(0, None)
    turned = [name for name, angle in found.angles.items() if angle.thrust == thrust]
    by_motion = len(turned) == 1 and set(assigned.values()) <= set(turned)
    by_name = set(assigned) == {2} and steers(assigned[2])
    if found.shared or thrust is None or not (by_motion or by_name):
        return None
    angle = turned[0] if by_motion else assigned[2]
    k, j = found.names.index(thrust), found.names.index(angle)
    flow = by_motion and found.angles[angle].flow
    # a gain of the angle alone is that of its product with a thrust ahead
    t = found.t[2, j]
    if by_motion:
        t = found.angles[angle].t * (1.0 if flow else np.sign(found.t[0, k]))
    inputs = {
        thrust: _ahead(found, thrust, 0),
        angle: _turned(found.columns[angle], against=t < 0.0 if flow else t > 0.0),
    }
    how = "at speed: a rudder in the flow, below structure"
    if not flow:
        how = f"with the thrust of {thrust}: an angle, below chain"
    remarks = {
        thrust: f"moves surge (t {abs(found.t[0, k]):.0f})",
        angle: f"turns the boat (t {abs(t):.0f}) {how}",
    }
    axis = 2 if flow else 1
    forces = {
        WRENCH[0]: {"axis": AXES[0], "of": {thrust: 1.0}},
        WRENCH[axis]: {"axis": AXES[axis], "of": {angle: 1.0}},
    }
    return Steered(thrust, angle, (inputs, remarks, forces), by_motion and steers(angle), flow)


def _ahead(found: Channels, channel: str, axis: int) -> dict[str, Any]:
    """The column with the sign by which a positive command moves the axis forward."""
    t = found.t[axis, found.names.index(channel)]
    return _turned(found.columns[channel], against=t <= 0.0)


def _turned(column: dict[str, Any], *, against: bool) -> dict[str, Any]:
    """A column, with the other sign where it counts `against`."""
    if not against:
        return column
    kept = {key: value for key, value in column.items() if key != "sign"}
    return kept if column.get("sign", 1) < 0 else kept | {"sign": -1}


def _thruster_remark(found: Channels, name: str) -> str:
    k = found.names.index(name)
    text = _moved_axes(found.t[:, k], found.effects[:, k] > 0.0)
    if other := found.twin(name):
        text += (
            f"; check: acts as {other} does, never at the same time: two sources of one command? --commands "
            "chooses one"
        )
    return text + _angle_remark(found, name)


def _angle_remark(found: Channels, name: str) -> str:
    """That a channel looks like an angle, by the motion of the boat or by its name."""
    if name in found.angles:
        return f"; check: {angle_text(found.angles[name])}"
    return f"; check: {STEERED}" if steers(name) else ""


def _moved_axes(t: Array, moved: Mask) -> str:
    parts = [f"{AXES[i]} (t {t[i]:+.0f})" for i in range(3) if moved[i]]
    return f"moves {', '.join(parts)}" if parts else "moves no axis significantly"


def weights(axis: int, clear: Mask, gains: Array, t: Array) -> Array:
    """Weights (n,) whose magnitudes sum to 1, in the force of an axis; 0 where a thruster does not drive it.

    clear: (3, n) whether a thruster drives an axis; gains: (3, n) [m/s^2], [rad/s^2] per full command, with t.
    """
    own = np.where(clear, gains, 0.0)
    errors = np.abs(own / np.where(clear, t, 1.0))
    return _equalised(_without_lever(axis, clear, own, errors), errors[axis])


def _without_lever(axis: int, clear: Mask, gains: Array, errors: Array) -> Array:
    """Gains (n,) in an axis without what the measured point's lever arm adds, where that explains them.

    Thrusters that turn the boat equally are identical. Then surge and sway gains are equal, and a lever arm a adds
    a times the yaw gain: yaw accelerates the measured point.
    """
    mine: Array = gains[axis]
    own = clear[axis]
    turn = np.where(own, gains[2], 0.0)
    if axis == 2 or not clear[2][own].all() or not _alike(turn, errors[2]):
        return mine
    design = np.column_stack([np.sign(mine), turn])[own]
    (size, lever), *_ = np.linalg.lstsq(design, mine[own], rcond=None)
    left = np.abs(mine[own] - design @ [size, lever]).max()
    if abs(lever) > LONGEST_LEVER or left > EQUAL_GAINS * abs(size):
        return mine
    return np.asarray(np.where(own, np.sign(mine) * size, 0.0))


def _alike(gains: Array, errors: Array) -> bool:
    """Whether magnitudes of the gains (n,) that are not 0 do not differ, by `EQUAL_GAINS` or their errors (n,)."""
    sizes, own = np.abs(gains), gains != 0.0
    mean = float(sizes[own].mean())
    near = np.abs(sizes - mean) < np.maximum(EQUAL_GAINS * mean, EQUAL_GAINS_ERRORS * errors)
    return bool(near[own].all())


def _equalised(gains: Array, errors: Array) -> Array:
    """Weights (n,): equal where the gains do not differ significantly, as thrusters are usually identical."""
    mean = float(np.abs(gains[gains != 0.0]).mean())
    even = np.sign(gains) * mean if _alike(gains, errors) else gains
    return np.asarray(even / np.abs(even).sum())
