# SPDX-License-Identifier: MIT
"""Motors by the parameters of an autopilot: pulses, as the autopilot makes them, are read as the controls they were."""

from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from seatrial.boat.schema import Column
from seatrial.inspection.proposal.servo_parameters import motors
from seatrial.io.signals import scaled

FORWARD, BOTH = np.linspace(0.0, 1.0, 5), np.linspace(-1.0, 1.0, 9)


def read(parameters: dict, kind: str, fields: tuple[str, ...]) -> dict:
    """Each motor's name, and what turns its pulses [us] into commands."""
    found = motors(
        SimpleNamespace(parameters=parameters), SimpleNamespace(type=kind, fields=fields)
    )
    return {
        m.name: (lambda pulses, m=m: scaled(pulses, msgspec.convert(m.column, Column)))
        for m in found
    }


def px4(control, least, most, *, reversible, turned):
    """The pulse of an output, by `FunctionMotors::updateValues` and `MixingOutput::output_limit_calc_single`."""
    value = control if reversible else 2.0 * control - 1.0
    value = -value if turned else value
    return least + (value + 1.0) / 2.0 * (most - least)


@pytest.mark.parametrize("turned", [False, True])
def test_px4_pulses_of_motors_with_and_without_reverse(turned):
    outputs = {"FUNC1": 101, "MIN1": 1100, "MAX1": 1900, "DIS1": 1000}  # no reverse
    outputs |= {"FUNC2": 103, "MIN2": 1050, "MAX2": 1950, "DIS2": 1500}  # reverses
    outputs |= {"FUNC3": 201, "DIS3": 1500, "REV": 0b111 * turned}  # a servo, of the usual range
    parameters = {f"PWM_MAIN_{name}": float(value) for name, value in outputs.items()}
    commands = read(
        parameters | {"CA_R_REV": 4.0}, "actuator_outputs", ("output[0]", "output[1]", "output[2]")
    )
    assert list(commands) == ["motor_1", "motor_3", "servo_1"]
    for name, controls, *span, reversible in (
        ("motor_1", FORWARD, 1100, 1900, False),
        ("motor_3", BOTH, 1050, 1950, True),
        ("servo_1", BOTH, 1000, 2000, True),
    ):
        pulses = px4(controls, *span, reversible=reversible, turned=turned)
        np.testing.assert_allclose(commands[name](pulses), controls, atol=1e-12)
    assert commands["motor_1"](np.array([1000.0])) == 0.0  # disarmed


def ardupilot(control, least, most, trim, *, turned):
    """The pulse of an output, by `SRV_Channel::pwm_from_angle`; Rover sets it for each of its motors."""
    value = -control if turned else control
    return trim + np.where(value > 0, value * (most - trim), value * (trim - least))


@pytest.mark.parametrize("turned", [False, True])
def test_ardupilot_pulses_of_motors_with_and_without_reverse(turned):
    end = 1900.0 if turned else 1100.0  # the trim of a motor that does not reverse
    given = {"FUNCTION": 70.0, "MIN": 1100.0, "MAX": 1900.0, "REVERSED": float(turned)}
    for trim, controls in ((1500.0, BOTH), (end, FORWARD)):
        parameters = {f"SERVO3_{name}": value for name, value in (given | {"TRIM": trim}).items()}
        command = read(parameters, "RCOU", ("C3",))["throttle"]
        pulses = ardupilot(controls, 1100.0, 1900.0, trim, turned=turned)
        np.testing.assert_allclose(command(pulses), controls, atol=1e-12)
        assert command(np.array([0.0])) == 0.0
