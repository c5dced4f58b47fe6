# SPDX-License-Identifier: MIT
"""The vehicle file that is proposed, with comments."""

from collections.abc import Mapping
from typing import Any

from seatrial.init.drive import Drive
from seatrial.init.sources import Sources
from seatrial.vehicle import WRENCH

COLUMN = 34  # where comments begin
AXES_SAID = {
    "forward-left-up": "positive: forward, to port, counter-clockwise (ROS, REP-103)",
    "forward-right-down": "positive: forward, to starboard, clockwise (SNAME, Fossen)",
}
WITHOUT = {"surge": "X_F * F_u", "sway": "Y_F * F_v", "yaw": "N_F * F_r"}
TERMS = {  # the structure `mallard`, spelled out where a force is missing
    "surge": ["v * r", "X_u * u", "X_uu * |u| * u", "X_F * F_u"],
    "sway": ["-1 * u * r", "Y_v * v", "Y_vv * |v| * v", "Y_F * F_v"],
    "yaw": ["N_ud * u_dot", "N_r * r", "N_rr * |r| * r", "N_uu * |u| * u", "N_F * F_r"],
}


def vehicle_text(sources: Sources, drive: Drive) -> str:
    """`vehicle.yaml` as text."""
    length = f" ({sources.length:.0f} s)" if sources.length else ""
    lines = [
        f"# Proposed by 'seatrial init' from {sources.path.name}{length}. Look at every line marked 'check'.",
        "seatrial: vehicle 1",
        _line("name", sources.name),
        _commented(
            f"axes: {sources.axes}", f"check: {AXES_SAID[sources.axes]}; the data can't tell"
        ),
        "",
        *_pose(sources, drive),
        "",
        *_commands(sources, drive),
        "",
        *_timeout(drive),
        *_geometry(drive),
        *_structure(drive),
    ]
    return "\n".join(lines) + "\n"


def _pose(sources: Sources, drive: Drive) -> list[str]:
    lines = [_commented("pose:", *sources.notes.get("pose", [])[:1])]
    lines += [f"  # {note}" for note in sources.notes.get("pose", [])[1:]]
    lines += [f"  # {text}" for text in drive.findings]
    return lines + [f"  {_line(key, value)}" for key, value in drive.pose.items()]


def _commands(sources: Sources, drive: Drive) -> list[str]:
    lines = [_commented("commands:", *sources.notes.get("commands", [])[:1])]
    lines += [f"  # {note}" for note in sources.notes.get("commands", [])[1:]]
    lines += [f"  {_line(key, value)}" for key, value in sources.commands.items()]
    lines.append(
        _commented("  inputs:", "value = sign (raw - offset) / scale, so that full command is 1")
    )
    for name, column in drive.inputs.items():
        lines.append(_commented(f"    {_line(name, column)}", drive.remarks[name]))
    missing = () if drive.forces else drive.undriven
    for axis in missing:
        force = WRENCH[("surge", "sway", "yaw").index(axis)]
        lines.append(
            f"    # {force}: {{...}}  check: nothing is seen to drive {axis}; name it if something does, and "
            f"write {WITHOUT[axis]} below"
        )
    used = list(drive.inputs.values())
    spare = [n for n, column in sources.channels.items() if not any(_same(column, c) for c in used)]
    if spare:
        lines.append(f"    # not used: {', '.join(spare)}")
    return lines


def _timeout(drive: Drive) -> list[str]:
    if drive.on_change:
        return [
            "# Commands are written only when they change: the last one holds. If the boat stops its",
            "# thrusters after a while without any, say after how long:",
            "# command_timeout: 0.5          # [s]",
            "",
        ]
    return [
        "# command_timeout: 0.5          # [s] check: when does the boat stop for lack of commands?",
        "",
    ]


def _geometry(drive: Drive) -> list[str]:
    if drive.forces:
        lines = [
            "# check: each force as a weighted sum of the inputs, by what was seen; if you know where the",
            "# thrusters are, write thrusters: {NAME: {x: , y: , angle_deg: }} instead (docs/vehicle.md)",
            "forces:",
        ]
        return [*lines, *(f"  {_line(n, force)}" for n, force in drive.forces.items()), ""]
    return [
        "# check: how the boat's software makes thruster commands of F_u, F_v and F_r; only needed where",
        "# dead zones or limits of the thrusters are to be modelled (docs/vehicle.md):",
        "# thrusters: {F_1: {x: 0.2, y: 0.2, angle_deg: 135}, ...}   # [m], [deg]",
        "# allocation: {scheme: moore-penrose, limit: 1.0}",
        "",
    ]


def _structure(drive: Drive) -> list[str]:
    if not drive.undriven:
        return [_commented("structure: mallard", "the paper's terms, Eq. (12); or list your own")]
    lines = [
        "structure:                       # the paper's terms, Eq. (12), as far as they are driven"
    ]
    for axis, terms in TERMS.items():
        kept = [t for t in terms if axis not in drive.undriven or t != WITHOUT[axis]]
        lines.append(f"  {axis}: [{', '.join(kept)}]")
    return lines


def _same(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    return all(a.get(key) == b.get(key) for key in ("column", "field", "topic"))


def _commented(text: str, *comments: str) -> str:
    return f"{text:<{COLUMN - 1}}  # {comments[0]}" if comments else text


def _line(key: str, value: object) -> str:
    return f"{key}: {_flow(value)}"


def _flow(value: object) -> str:
    """YAML on one line; words are quoted where YAML would read them otherwise."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{k}: {_flow(v)}" for k, v in value.items()) + "}"
    if isinstance(value, float):
        return f"{value:g}" if value != int(value) else f"{int(value)}"
    if isinstance(value, str):
        plain = value and all(c.isalnum() or c in "/_.-" for c in value) and not value[0].isdigit()
        return value if plain and value not in ("true", "false", "null") else f'"{value}"'
    return str(value)
