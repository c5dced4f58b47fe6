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
CAR = 5  # CA_AIRFRAME of PX4 with Ackermann steering: one motor, and a servo that steers
SERVOS = {4: "rudder", 16: "steering"}  # CA_SV_CSn_TYPE of PX4
PX4_MOTOR, PX4_SERVO = 101, 201  # PWM_MAIN_FUNCn of the first motor and of the first servo
USUAL = {"MIN": 1100.0, "MAX": 1900.0, "TRIM": 1500.0, "REVERSED": 0.0}  # of ArduPilot
PX4_USUAL = {"MIN": 1000.0, "MAX": 2000.0, "DIS": 0.0}
OFF = 0.0  # [us] pulse of an output that is not driven
# [deg] of ArduPilot's vectored thrust from its middle to its limit; 0: none
VECTORED = "MOT_VEC_ANGLEMAX"
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
    if topic.type == "actuator_servos":
        return list(_px4_servos(log.parameters, topic))
    if topic.type == "actuator_outputs":
        return list(_px4_outputs(log.parameters, topic))
    return []


def full_angle(log: Log) -> float | None:
    """Angle [deg] of a steered thruster at full command, where a parameter states it."""
    return log.parameters.get(VECTORED) or None


def _ardupilot(parameters: Mapping[str, float], topic: LogTopic) -> Iterator[Motor]:
    """Output n has the function SERVOn_FUNCTION."""
    for field in topic.fields:
        digits = digits_of(field)
        key = f"SERVO{digits}"
        function = parameters.get(f"{key}_FUNCTION")
        if not digits or function not in FUNCTIONS or field == "port":
            continue
        least, most, trim, turned = (
            parameters.get(f"{key}_{name}", usual) for name, usual in USUAL.items()
        )
        column, range_ = _pulse(least, most, trim, turned=bool(turned))
        why = f"{key}_FUNCTION {function:.0f}, {range_}{', reversed' if turned else ''}"
        yield Motor(FUNCTIONS[int(function)], {"field": field, **column}, why)


def digits_of(field: str) -> str:
    """The digits of a field's name."""
    return "".join(c for c in field if c.isdecimal())


def _pulse(least: float, most: float, trim: float, *, turned: bool) -> tuple[dict[str, Any], str]:
    """Offset and scale of pulse widths [us], of no thrust at `trim`; the longer side of it is the scale.

    A motor that does not reverse has its trim at an end of its range.
    """
    if not least < most:
        least, most = USUAL["MIN"], USUAL["MAX"]
    if not least <= trim <= most:
        trim = (least + most) / 2
    up, down = most - trim, trim - least
    uneven = min(up, down) > 0 and abs(up - down) > UNEVEN * (most - least)
    text = f"{least:.0f} to {most:.0f} us, trim {trim:.0f}"
    if uneven:
        text += "; check: the trim is not in the middle, so the two directions differ in scale"
    column = {"offset": trim, "scale": max(up, down), "off": OFF}
    return column | ({"sign": -1} if turned else {}), text


def _px4_motors(parameters: Mapping[str, float], topic: LogTopic) -> Iterator[Motor]:
    """Thrust from -1 or 0 to 1, of as many motors as CA_ROTOR_COUNT states."""
    count = 1 if _is_car(parameters) else int(parameters.get("CA_ROTOR_COUNT", 0))
    reverse = int(parameters.get("CA_R_REV", 0))
    for i in range(count):
        field = f"control[{i}]"
        if field in topic.fields:
            sides = "-1 to 1" if reverse >> i & 1 else "0 to 1"
            yield Motor(f"motor_{i + 1}", {"field": field}, f"{sides}{_place(parameters, i)}")


def _px4_servos(parameters: Mapping[str, float], topic: LogTopic) -> Iterator[Motor]:
    """Angles from -1 to 1, of as many servos as CA_SV_CS_COUNT states; a car has one at least."""
    count = max(int(parameters.get("CA_SV_CS_COUNT", 0)), _is_car(parameters))
    for i in range(count):
        field = f"control[{i}]"
        if field in topic.fields:
            yield Motor(_servo_name(parameters, i), {"field": field}, "-1 to 1")


def _servo_name(parameters: Mapping[str, float], i: int) -> str:
    kind = int(parameters.get(f"CA_SV_CS{i}_TYPE", 0))
    return SERVOS.get(kind, "steering" if i == 0 and _is_car(parameters) else f"servo_{i + 1}")


def _is_car(parameters: Mapping[str, float]) -> bool:
    return int(parameters.get("CA_AIRFRAME", 0)) == CAR


def _place(parameters: Mapping[str, float], i: int) -> str:
    """Where the motor is and pushes, in PX4's axes forward-right-down."""
    keys = [f"CA_ROTOR{i}_{k}" for k in ("PX", "PY", "AX", "AY")]
    if not all(key in parameters for key in keys):
        return ""
    x, y, along, across = (parameters[key] for key in keys)
    return f", at x {x:.3g} m, y {y:.3g} m to starboard, thrust along ({along:.2g}, {across:.2g})"


def _px4_outputs(parameters: Mapping[str, float], topic: LogTopic) -> Iterator[Motor]:
    """Pulse widths of the outputs that PWM_MAIN_FUNCn gives to motors and servos.

    PX4 maps -1 to 1 to the range; of a motor without its bit in CA_R_REV, 0 to 1.
    """
    for i in range(16):
        key = f"PWM_MAIN_FUNC{i + 1}"
        function = int(parameters.get(key, 0))
        field = f"output[{i}]"
        if function // 100 not in (1, 2) or field not in topic.fields:
            continue
        least, most, idle = (
            parameters.get(f"PWM_MAIN_{name}{i + 1}", usual) for name, usual in PX4_USUAL.items()
        )
        turned = bool(int(parameters.get("PWM_MAIN_REV", 0)) >> i & 1)
        trim, name = (least + most) / 2, _servo_name(parameters, function - PX4_SERVO)
        if function < PX4_SERVO:
            name = f"motor_{function - PX4_MOTOR + 1}"
            if not int(parameters.get("CA_R_REV", 0)) >> (function - PX4_MOTOR) & 1:
                trim = most if turned else least
        column, range_ = _pulse(least, most, trim, turned=turned)
        # the pulse of a stopped or disarmed output, where no command has it
        if idle > OFF and not least <= idle <= most:
            column["off"] = idle
        yield Motor(name, {"field": field, **column}, f"{key} {function}, {range_}")
