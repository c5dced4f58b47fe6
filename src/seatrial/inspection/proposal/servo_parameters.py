# SPDX-License-Identifier: MIT
"""Motors of a boat by the parameters of its autopilot: which output, which trim and range, which sense."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from seatrial.io.log import Log, LogTopic

FUNCTIONS = {  # SERVOn_FUNCTION of ArduPilot
    26: "steering", 70: "throttle", 73: "throttle_left", 74: "throttle_right",
    **{32 + i: f"motor_{i}" for i in range(1, 9)}, **{73 + i: f"motor_{i}" for i in range(9, 13)},
}  # fmt: skip
PX4_SERVO = 201  # PWM_MAIN_FUNCn of the first servo; motors begin at 101
USUAL = {"MIN": 1100.0, "MAX": 1900.0, "TRIM": 1500.0, "REVERSED": 0.0}  # of ArduPilot
OFF = 0.0  # [us] pulse of an output that is not driven
UNEVEN = 0.02  # of the range: a trim that is further from the middle


@dataclass(frozen=True)
class Motor:
    """An output that drives a motor, a steered thruster or a rudder."""

    name: str
    column: dict[str, Any]  # of the vehicle file
    why: str


def motors(log: Log, topic: LogTopic) -> list[Motor]:
    """Motors of an output topic by the log's parameters; empty where these do not state any."""
    if topic.type in ("RCOU", "RCO2", "SERVO_OUTPUT_RAW"):
        return list(_ardupilot(log.parameters, topic))
    if topic.type == "actuator_motors":
        return list(_px4_motors(log.parameters, topic))
    if topic.type == "actuator_outputs":
        return list(_px4_outputs(log.parameters, topic))
    return []


def _ardupilot(parameters: Mapping[str, float], topic: LogTopic) -> Iterator[Motor]:
    """Output n has the function SERVOn_FUNCTION."""
    for field in topic.fields:
        digits = "".join(c for c in field if c.isdecimal())
        key = f"SERVO{digits}"
        function = parameters.get(f"{key}_FUNCTION")
        if not digits or function not in FUNCTIONS or field == "port":
            continue
        least, most, trim, turned = (
            parameters.get(f"{key}_{name}", usual) for name, usual in USUAL.items()
        )
        column, range_ = _pulse(least, most, trim)
        if turned:
            column["sign"] = -1
        why = f"{key}_FUNCTION {function:.0f}, {range_}{', reversed' if turned else ''}"
        yield Motor(FUNCTIONS[int(function)], {"field": field, **column}, why)


def _pulse(least: float, most: float, trim: float) -> tuple[dict[str, Any], str]:
    """Offset and scale of pulse widths [us]; of an uneven trim the longer side is the scale."""
    if not least < most:
        least, most = USUAL["MIN"], USUAL["MAX"]
    if not least <= trim < most:
        trim = (least + most) / 2
    up, down = most - trim, trim - least
    uneven = down > 0 and abs(up - down) > UNEVEN * (most - least)
    text = f"{least:.0f} to {most:.0f} us, trim {trim:.0f}"
    if uneven:
        text += "; check: the trim is not in the middle, so forward and reverse differ in scale"
    return {"offset": trim, "scale": max(up, down), "off": OFF}, text


def _px4_motors(parameters: Mapping[str, float], topic: LogTopic) -> Iterator[Motor]:
    """Thrust from -1 or 0 to 1, of as many motors as CA_ROTOR_COUNT states."""
    count = int(parameters.get("CA_ROTOR_COUNT", 0))
    reverse = int(parameters.get("CA_R_REV", 0))
    for i in range(count):
        field = f"control[{i}]"
        if field in topic.fields:
            sides = "-1 to 1" if reverse >> i & 1 else "0 to 1"
            yield Motor(f"motor_{i + 1}", {"field": field}, f"{sides}{_place(parameters, i)}")


def _place(parameters: Mapping[str, float], i: int) -> str:
    """Where the motor is and pushes, in PX4's axes forward-right-down."""
    keys = [f"CA_ROTOR{i}_{k}" for k in ("PX", "PY", "AX", "AY")]
    if not all(key in parameters for key in keys):
        return ""
    x, y, along, across = (parameters[key] for key in keys)
    return f", at x {x:.3g} m, y {y:.3g} m to starboard, thrust along ({along:.2g}, {across:.2g})"


def _px4_outputs(parameters: Mapping[str, float], topic: LogTopic) -> Iterator[Motor]:
    """Pulse widths of the outputs that PWM_MAIN_FUNCn gives to motors and servos."""
    for i in range(16):
        key = f"PWM_MAIN_FUNC{i + 1}"
        function = int(parameters.get(key, 0))
        name = {True: f"motor_{function - 100}", False: f"servo_{function - 200}"}[
            function < PX4_SERVO
        ]
        field = f"output[{i}]"
        if function // 100 not in (1, 2) or field not in topic.fields:
            continue
        least = parameters.get(f"PWM_MAIN_MIN{i + 1}", 1000.0)
        most = parameters.get(f"PWM_MAIN_MAX{i + 1}", 2000.0)
        column, range_ = _pulse(least, most, (least + most) / 2)
        if int(parameters.get("PWM_MAIN_REV", 0)) >> i & 1:
            column["sign"] = -1
        yield Motor(name, {"field": field, **column}, f"{key} {function}, {range_}")
