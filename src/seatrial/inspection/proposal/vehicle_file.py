# SPDX-License-Identifier: MIT
"""The text of the proposed vehicle file, with comments."""

import re
from collections.abc import Mapping
from typing import Any

import yaml

from seatrial.boat.vehicle import WRENCH
from seatrial.inspection.proposal.actuation import Steered
from seatrial.inspection.proposal.columns.names import is_propeller_speed
from seatrial.inspection.proposal.inputs import Drive
from seatrial.inspection.proposal.sources import Choices, Sources, place_of
from seatrial.util.errors import printable
from seatrial.util.frames import AXES

COMMENT_COLUMN = 34  # [characters] where comments begin
AXES_MEANING = {
    "forward-left-up": "x forward, y to port, psi counter-clockwise (ROS, REP-103)",
    "forward-right-down": "x forward, y to starboard, psi clockwise (SNAME, Fossen)",
}
FORCE_OF_AXIS = dict(zip(AXES, WRENCH, strict=True))
ORIGIN = (
    "origin: the middle of thrusters around the boat; of thrusters astern only, the centre of mass"
)
THRUSTERS_TO_CHECK = (
    "# check: the allocation from F_u, F_v and F_r to thruster commands in the boat's software. Most",
    "# thrusters have a dead zone. Without these lines structure: auto takes the usual layout that",
    "# explains the recordings best; where none does, force and drag are biased (docs/vehicle.md):",
    "# thrusters:                    # positions [m]; directions of thrust [deg] from forward",
    "#   F_1: {x: 0.2, y: 0.2, angle_deg: 135}",
    "#   F_2: {x: 0.2, y: -0.2, angle_deg: -135}",
    "#   F_3: {x: -0.2, y: 0.2, angle_deg: 45}",
    "#   F_4: {x: -0.2, y: -0.2, angle_deg: -45}",
    "# allocation: {scheme: moore-penrose, limit: 1.0}",
)
NO_DRIVER_FOUND = "No channel moves it"


def vehicle_text(sources: Sources, drive: Drive, choices: Choices) -> str:
    """`vehicle.yaml` as text; what the user chose needs no check."""
    length = f" ({sources.length:.0f} s)" if sources.length else ""
    first = f"{printable(sources.path.name, keep='')}{length}"
    others = [printable(path.name, keep="") for path in sources.more]
    axes = [f"check: {AXES_MEANING[sources.axes]}? The data do not show it"]
    if choices.axes_answered:
        axes = [f"{AXES_MEANING[sources.axes]}, as answered"]
    if "known axes" in sources.notes:
        axes = [AXES_MEANING[sources.axes], *sources.notes["known axes"]]
    lines = [
        f"# Proposed by 'seatrial init' from {', '.join([first, *others])}.",
        "# Check every line marked 'check'.",
        "seatrial: vehicle 1",
        _commented(_line("name", sources.name), "the boat's name, also the model's"),
        _commented(f"axes: {sources.axes}", *axes),
        "",
        *_pose(sources, drive, choices),
        "",
        *_commands(sources, drive, choices),
        "",
        *_timeout(drive),
        "",
        *_forces(drive, choices),
        *_steered(drive, sources),
        "",
        *_scales(drive, sources),
        *_structure(drive),
    ]
    return "\n".join(lines) + "\n"


STEERED_CHAIN = [
    "chain:                             # angle_deg: [deg] at command 1; beside it, where the gear has a rate",
    "                                   # limit [deg/s], rate_deg: estimate",
]
# drag and free added mass of every axis, and the rudder
FLOW_STRUCTURE = [
    "structure:                         # the rudder's force grows with |u| * u",
    "  surge: [v * r, X_u * u, X_uu * |u| * u, X_F * F_u, X_vr * v * r]",
    "  sway: [-1 * u * r, Y_v * v, Y_vv * |v| * v, Y_ur * u * r, Y_d * |u| * u * F_r]",
    "  yaw: [N_r * r, N_rr * |r| * r, N_uv * u * v, N_d * |u| * u * F_r]",
]


def _pose(sources: Sources, drive: Drive, choices: Choices) -> list[str]:
    lines = [_commented("pose:", *sources.notes.get("pose", []))]
    lines += [f"  # {text}" for text in drive.findings]
    lines += [f"  {_line(key, value)}" for key, value in drive.pose.items()]
    if "yaw_rate" in sources.notes:
        entry, why = sources.notes["yaw_rate"]
        lines.append(_commented(f"  # {entry}", why))
    return [*lines, *_lever(drive, choices)]


def _lever(drive: Drive, choices: Choices) -> list[str]:
    """Position of the measured point."""
    where = "check: position of the sensor (or SLAM frame) from the boat's origin [m]"
    axes = "ahead, and along the file's second axis;"
    text = "  # lever: [0, 0]"
    comments: tuple[str, ...] = (f"{where}:", axes, ORIGIN)
    if found := choices.lever or drive.lever:
        text = f"  lever: [{found[0]:g}, {found[1]:g}]"
        measure = f"{axes} measure it, or add --effect lever to identify"
        comments = (f"{where}, estimated:", measure)
    if choices.lever is not None:
        comments = ("position of the sensor [m], as given",)
    return [_commented(text, *comments)]


def _commands(sources: Sources, drive: Drive, choices: Choices) -> list[str]:
    notes = [*sources.notes.get("clock", []), *sources.notes.get("commands", []), *drive.sources]
    lines = [_commented("commands:", *notes)]
    lines += [f"  {_line(key, value)}" for key, value in sources.commands.items()]
    scale = "value = sign (raw - offset) / scale; full command is 1"
    lines.append(_commented("  inputs:", scale, "t: gain over its standard error"))
    lines += [_commented(f"    {_line(n, c)}", drive.remarks[n]) for n, c in drive.inputs.items()]
    for axis in () if drive.thrusters or choices.thrusters else drive.undriven:
        force = FORCE_OF_AXIS[axis]
        lines.append(_commented(f"    # {force}: {{...}}", _which_drives(axis, drive)))
    used = list(drive.inputs.values())
    spare = [n for n, column in sources.channels.items() if not any(_same(column, c) for c in used)]
    if spare or sources.spare:
        fields = [*(" ".join(place_of(sources.channels[n])) for n in spare), *sources.spare]
        listed = printable(", ".join(fields), keep="")
        lines.append(f"    # not used: {listed}; a signal that scales thrust goes under scales:")
    return lines


def _timeout(drive: Drive) -> list[str]:
    if drive.on_change:
        return [
            "# Commands are recorded only when they change, so the last one holds. If the boat stops its",
            "# thrusters after some time without commands, check after how long:",
            "# command_timeout: 0.5          # [s]",
        ]
    return [
        "# command_timeout: 0.5          # [s] check: time without commands after which the thrusters stop"
    ]


def _forces(drive: Drive, choices: Choices) -> list[str]:
    if choices.thrusters and not drive.forces:
        return _thrusters(drive, choices)
    if not drive.forces:
        return [*THRUSTERS_TO_CHECK]
    comments = _on_forces(drive, choices)
    lines = [*(comments if drive.thrusters else ()), "forces:"]
    lines += [f"  {_line(name, force)}" for name, force in drive.forces.items()]
    for axis in drive.undriven:
        of = "..." if drive.thrusters else f"{FORCE_OF_AXIS[axis]}: 1"
        why = _which_drives(axis, drive) if drive.thrusters else "with its input above"
        entry = f"  # {FORCE_OF_AXIS[axis]}: {{axis: {axis}, of: {{{of}}}}}"
        lines.append(_commented(entry, why))
    return lines


def _steered(drive: Drive, sources: Sources) -> list[str]:
    """An angle and its thrust: as lines where it is sure, else as a comment."""
    found = drive.steered
    if found is None:
        return []
    chain = _chain_of(found, sources)
    if found.sure:
        return chain
    if found.flow:
        chain = [*chain, *FLOW_STRUCTURE]
    inputs, _, forces = found.parts
    lines = ["  inputs:", *(f"    {_line(name, column)}" for name, column in inputs.items())]
    lines += ["forces:", *(f"  {_line(name, force)}" for name, force in forces.items()), *chain]
    return [
        "",
        f"# check: is {found.angle} the angle of a rudder or thruster? Then in place of inputs and forces:",
        *(f"# {line}" for line in lines),
    ]


def _chain_of(found: Steered, sources: Sources) -> list[str]:
    """The stages of a thrust and its angle; a rudder in the flow is an input of its own."""
    own = {"latency": "estimate", "lag": "estimate"}
    thrust: dict[str, Any] = {"name": found.thrust, "actuators": [found.thrust], **own}
    if is_propeller_speed(found.thrust):  # thrust grows with about its square
        thrust["power"] = "estimate"
    angle: dict[str, Any] = {"name": found.angle, "actuators": [found.angle], **own}
    head = ["chain:"]
    if not found.flow:
        full = "estimate" if sources.full_angle is None else sources.full_angle
        angle["steered"] = {"of": [[found.thrust, found.angle]], "angle_deg": full}
        head = STEERED_CHAIN
    return [*head, f"  - {_flow(thrust)}", f"  - {_flow(angle)}"]


def _scales(drive: Drive, sources: Sources) -> list[str]:
    """A signal that scales thrust, and the stage that uses it; an angle has no such stage."""
    lines = sources.notes.get("scales", [])
    if not lines:
        return []
    stage = "{scale: {signal: battery, power: 2}}"
    use = f"chain: [{stage}]"
    if drive.steered is not None and drive.steered.sure:
        use = f"scale: {{signal: battery, power: 2}}, in chain at {drive.steered.thrust}"
    ask = "# check: to use it, add this stage, or 'power: estimate' where the voltage changes much:"
    return [*lines, ask, f"# {use}", ""]


def _which_drives(axis: str, drive: Drive) -> str:
    """An axis may move with the inputs of another: a boat that turns sways."""
    moves = any(f"{axis} (t " in remark for remark in drive.remarks.values())
    found = "It moves with the inputs of other axes only" if moves else NO_DRIVER_FOUND
    return f"check: which input drives {axis}? {found}"


def _thrusters(drive: Drive, choices: Choices) -> list[str]:
    """Thrusters at the places that the user gave."""
    direct = len(choices.thrusters) == len(drive.inputs) and not set(drive.inputs) & set(WRENCH)
    names = [*drive.inputs] if direct else [f"T_{i + 1}" for i in range(len(choices.thrusters))]
    places = [{"x": x, "y": y, "angle_deg": angle} for x, y, angle in choices.thrusters]
    return [
        _commented("thrusters:", "positions [m] and directions of thrust [deg], as given"),
        *(f"  {_line(name, place)}" for name, place in zip(names, places, strict=True)),
        *([] if direct else [f"allocation: {{scheme: {choices.scheme}, limit: 1.0}}"]),
    ]


def _on_forces(drive: Drive, choices: Choices) -> list[str]:
    if choices.thrusters:
        return [
            "# each force as a weighted sum of the inputs, by the places [m] of the thrusters as given"
        ]
    estimated = "# check: each force as a weighted sum of the inputs, estimated from the recording"
    if drive.undriven:  # `thrusters` needs a force in every axis
        return [estimated]
    return [
        f"{estimated}. Where the",
        "# thrusters are known write thrusters: {NAME: {x: , y: , angle_deg: }} instead (docs/vehicle.md)",
    ]


def _structure(drive: Drive) -> list[str]:
    if drive.steered is not None and drive.steered.sure and drive.steered.flow:
        return FLOW_STRUCTURE
    choice = "the recordings choose the terms; or list your own, or 'mallard', the paper's"
    return [_commented("structure: auto", choice)]


def _same(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    return all(a.get(key) == b.get(key) for key in ("column", "field", "topic", "file"))


def _commented(text: str, *comments: str) -> str:
    """The text with comments, the first beside it, others below."""
    first, *others = [printable(comment, keep="") for comment in comments] or [""]
    lines = [f"{text:<{COMMENT_COLUMN - 1}}  # {first}" if first else text]
    return "\n".join([*lines, *(f"{'':<{COMMENT_COLUMN - 1}}  # {other}" for other in others)])


def _line(key: str, value: object) -> str:
    return f"{_word(key)}: {_flow(value)}"


def _flow(value: object) -> str:
    """YAML on one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(_line(k, v) for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, float):
        if value == int(value):
            return f"{int(value)}"
        return f"{value:g}" if float(f"{value:g}") == value else repr(value)
    return _word(value) if isinstance(value, str) else str(value)


def _word(text: str) -> str:
    """A YAML scalar that reads back as this text: quoted where needed."""
    if re.fullmatch(r"[A-Za-z/][\w/.-]*", text, re.ASCII) and yaml.safe_load(text) == text:
        return text
    return '"' + "".join(map(_escaped, text)) + '"'


def _escaped(c: str) -> str:
    if c in '"\\':
        return f"\\{c}"
    if c.isprintable():
        return c
    return f"\\u{ord(c):04x}" if ord(c) < 0x10000 else f"\\U{ord(c):08x}"
