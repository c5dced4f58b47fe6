# SPDX-License-Identifier: MIT
"""A boat with a rudder or a steered thruster, from its autopilot's log to a model."""

import re

import init_tools
import numpy as np
import pytest
import survey_boat
import yaml
from autopilot_logs import ARMED, DISARMED, ardupilot
from mavlink_logs import telemetry
from px4_logs import px4
from sheets import two_sheets
from steered_logs import ARM, FULL_ANGLE, steered_boat, steered_trial
from survey_boat import both

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.inspection.proposal.propose import init
from seatrial.io.reader import read

FRD = "forward-right-down"
WRITERS = {"run.BIN": ardupilot, "run.tlog": telemetry, "run.ulg": px4}


def proposed(path, axes=FRD, **choices):
    found, vehicle = init_tools.proposed(path, axes=axes, **choices)
    return found.text, vehicle


def commands_read(path, vehicle, run):
    """Commands read, and those of the trial at their stamps; the first position is 0.031 s after its begin."""
    recording = read(path, vehicle)
    held = recording.commands
    t = (held.stamps - recording.stamps[0]) * 1e-9 + 0.031
    driven = (t > ARMED + 1.0) & (t < run.seconds - DISARMED)
    return held.values[driven], run.command_at(t + 2e-3)[driven]


@pytest.mark.parametrize("axes", [FRD, "forward-left-up"])
@pytest.mark.parametrize("name", WRITERS)
def test_the_angle_is_proposed_as_one(tmp_path, name, axes):
    """A positive angle pushes the stern to the file's second axis: against the file's yaw."""
    run = steered_trial(steered_boat(), 120.0)
    path = WRITERS[name](tmp_path / name, run)
    text, vehicle = proposed(path, axes)
    thrust = "motor_1" if name == "run.ulg" else "throttle"
    assert vehicle.inputs == (thrust, "steering")
    (entry,) = (group.steered for group in vehicle.file.chain if group.steered is not None)
    assert entry.of == [(thrust, "steering")]
    assert entry.angle_deg == "estimate"
    assert set(vehicle.file.forces) == {"F_u", "F_v"}
    assert "which input drives" not in text
    found, given = commands_read(path, vehicle, run)
    starboard = -1.0 if axes == FRD else 1.0  # a stern pushed to port turns the boat to starboard
    share = np.mean(np.abs(found - given * [1.0, starboard]).max(axis=1) < 2e-3)
    assert share > 0.97  # but for ticks within a millisecond of a step


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("turned", [False, True])
def test_the_sense_is_that_of_the_motion_whatever_the_parameters_say(tmp_path, turned, sense):
    run = steered_trial(steered_boat(turned=turned), 120.0, sense=sense)
    path = ardupilot(tmp_path / "run.BIN", run)
    _, vehicle = proposed(path)
    found, given = commands_read(path, vehicle, run)
    assert np.mean(np.abs(found[:, 1] + sense * given[:, 1]) < 2e-3) > 0.97


def test_the_angle_of_vectored_thrust_is_the_parameters(tmp_path):
    boat = steered_boat(trim=1450, MOT_VEC_ANGLEMAX=35.0)
    path = ardupilot(tmp_path / "run.BIN", steered_trial(boat, 120.0))
    text, vehicle = proposed(path)
    assert [g.steered.angle_deg for g in vehicle.file.chain if g.steered] == [35.0]
    c = vehicle.file.commands.inputs["steering"]
    assert (c.offset, c.scale, c.off) == (1450.0, 450.0, 0.0)  # the longer side is full command
    assert "scale: {signal: battery, power: 2}, in chain at throttle" in text


def uncommented(text):
    """The vehicle file with the lines that a comment proposes in place of inputs and forces."""
    own, proposal = text.split("Then in place of inputs and forces:\n")
    lines = [line[2:] for line in proposal.split("\n\n")[0].splitlines()]
    content, added = yaml.safe_load(own), yaml.safe_load("\n".join(["commands:", *lines]))
    content["commands"]["inputs"] = added.pop("commands")["inputs"]
    return vehicle_from(content | added | {"structure": "auto"}, "vehicle.yaml")


@pytest.mark.parametrize("axes", [FRD, "forward-left-up"])
def test_an_angle_by_its_motion_alone_is_proposed_as_a_comment(tmp_path, axes):
    path = ardupilot(tmp_path / "run.BIN", steered_trial(steered_boat(), 120.0))
    text, vehicle = proposed(path, axes, commands="a=RCOU/C3,b=RCOU/C1")
    assert vehicle.inputs == ("F_u", "F_r")
    assert "# check: is b the angle of a rudder or thruster?" in text
    found = uncommented(text)
    sure = proposed(path, axes)[1]
    assert found.inputs == ("a", "b")
    assert found.input_signs.tolist() == sure.input_signs.tolist()
    assert [g.steered.of for g in found.file.chain if g.steered] == [[("a", "b")]]


def test_a_stick_of_two_thrusters_that_is_called_steering_is_a_stick(tmp_path):
    """By its name it may be an angle; the boat turns without thrust, too."""
    _, recording = survey_boat.driven({}, [both] * 2)
    left, right = recording.commands.values.T
    values = np.column_stack([left + right, right - left]) / 2.0
    two_sheets(tmp_path, recording, "throttle", "steering", values=values)
    text = init(tmp_path).text
    assert "F_r: {column: steering" in text
    assert re.search(r"^# +- \{name: steering.*steered", text, re.MULTILINE)
    assert uncommented(text).inputs == ("throttle", "steering")


@pytest.mark.system
def test_the_model_of_the_proposed_file_has_the_true_angle(tmp_path):
    """By Newton's second law: X_F and the moment over the angle are those of the thruster."""
    boat = steered_boat()
    path = ardupilot(tmp_path / "run.BIN", steered_trial(boat, 240.0))
    _, vehicle = proposed(path)
    model = seatrial.identify([read(path, vehicle)], vehicle)
    values = dict(zip(model.parameters, [*model.coefficients, *model.constants], strict=True))
    truth = {
        "steer_angle.steering": np.degrees(FULL_ANGLE),
        "X_F": boat.full / boat.mass[0],
        "Y_F": boat.full / boat.mass[1],
        "N_Fv": ARM * boat.full / boat.mass[2],
    }
    for name, value in truth.items():
        assert abs(values[name] - value) < 3.5 * model.standard_errors[name], name
        assert values[name] == pytest.approx(value, rel=0.05)
