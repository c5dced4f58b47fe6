# SPDX-License-Identifier: MIT
"""A rudder is known by the motion of the boat: it turns with the thrust beside it, a stick of yaw by itself."""

from dataclasses import replace

import numpy as np
import pytest
import steered_boat
import survey_boat
import yaml
from conftest import at_length, make_model
from sheets import two_sheets

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.proposal.sources import Choices
from seatrial.inspection.proposal.vehicle_file import FLOW_STRUCTURE
from seatrial.recording.signal import Signal

ANGLE = "is it the angle of a rudder or thruster? Then write 'steered' below chain"


def sticks(names):
    """The vehicle file of a boat with a stick for surge and one for yaw."""
    content = survey_boat.boat().to_mapping()
    thrust, turn = names
    content["commands"]["inputs"] = {name: {"column": name} for name in names}
    content["forces"] = {
        "F_u": {"axis": "surge", "of": {thrust: 1.0}},
        "F_r": {"axis": "yaw", "of": {turn: 1.0}},
    }
    return vehicle_from(content, "v.yaml")


def said(recording, vehicle, words=ANGLE):
    return [text for text in check_consistency([recording], vehicle).text if words in text]


@pytest.mark.parametrize("least", [0.1, -1.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_rudder_that_the_file_has_as_a_stick_is_named(seed, least):
    """Also with thrust both ways, where the rudder alone turns the boat neither way on average."""
    recording = steered_boat.driven(steered_boat.known(), seed=seed, least=least)
    (text,) = said(recording, sticks(("motor", "helm")))
    assert text.startswith("helm: turns the boat only with the thrust of motor: is it")


def test_a_model_of_a_rudder_as_a_stick_is_doubted():
    """Its noise in yaw is large, and a lever arm that is none explains part of it."""
    recording = steered_boat.driven(steered_boat.known(), seed=1)
    model = seatrial.identify([recording], sticks(("motor", "helm")))
    assert any(ANGLE in doubt for doubt in model.warnings)


def test_a_rudder_that_the_file_has_as_one_is_not():
    recording = steered_boat.driven(steered_boat.known(), seed=1)
    assert said(recording, steered_boat.outboard()) == []


@pytest.mark.parametrize(
    "most", [pytest.param(-1.0, id="both ways"), pytest.param(0.0, id="ahead")]
)
def test_a_stick_of_yaw_is_no_rudder(most):
    """The same boat by its two thrusters, and by the sticks that drive them."""
    sizes = [lambda g: g.uniform(most, 1.0)] * 2
    vehicle, recording = survey_boat.driven({}, sizes)
    left, right = recording.commands.values.T
    values = np.column_stack([left + right, right - left]) / 2.0
    stick = Signal(("thrust", "turn"), recording.commands.stamps, values)
    assert said(replace(recording, commands=stick), sticks(stick.names)) == []
    assert said(recording, vehicle) == []


def test_a_bow_thruster_is_no_rudder():
    """It turns the boat little, and whatever the thrusters astern do."""
    vehicle, recording = survey_boat.driven({}, [lambda g: g.uniform(-1, 1)] * 3, bow=True)
    assert said(recording, vehicle) == []


@pytest.mark.parametrize("axes", ["forward-left-up", "forward-right-down"])
@pytest.mark.parametrize("turned", [(1, 1), (1, -1), (-1, 1)])
@pytest.mark.parametrize("least", [0.1, -1.0])
def test_init_states_a_rudder_and_its_sense(least, turned, axes, tmp_path):
    """Of a table in which throttle or rudder count the other way, or with y to starboard."""
    recording = steered_boat.driven(steered_boat.known(), seed=1, least=least)
    own = recording.commands
    poses = recording.raw * (1.0 if axes == "forward-left-up" else [1.0, -1.0, -1.0])
    values = own.values * turned
    two_sheets(tmp_path, recording, "throttle", "rudder", poses=poses, values=values)
    file = yaml.safe_load(seatrial.init(tmp_path, choices=Choices(axes=axes)).text)
    assert [group.get("steered", {}).get("of") for group in file["chain"]] == [
        None, [["throttle", "rudder"]],
    ]  # fmt: skip
    signs = {name: column.get("sign", 1) for name, column in file["commands"]["inputs"].items()}
    # true angles push to port at the stern; in axes to starboard a positive angle does that to starboard
    mirrored = 1 if axes == "forward-left-up" else -1
    assert signs == {"throttle": turned[0], "rudder": turned[1] * mirrored}


FLOW = {  # a rudder whose force grows with the square of the speed, and the free added mass of every axis
    "X_u": -0.25, "X_uu": -0.5, "X_F": 1.2, "X_vr": 0.4, "Y_v": -0.6, "Y_vv": -1.2, "Y_ur": 0.3, "Y_d": -0.6,
    "N_r": -0.8, "N_rr": -0.5, "N_uv": -1.0, "N_d": 2.5,
}  # fmt: skip


@pytest.mark.parametrize("axes", ["forward-left-up", at_length("forward-right-down")])
@pytest.mark.parametrize("sign", [at_length(1), -1])
def test_a_rudder_in_the_flow_is_known_and_its_model_is_right(sign, axes, tmp_path):
    """Before, it was proposed as one in the race, or as a stick; all of sway and yaw was off without a word."""
    content = sticks(("motor", "helm")).to_mapping()
    content["structure"] = yaml.safe_load("\n".join(FLOW_STRUCTURE))["structure"]
    truth = make_model(vehicle_from(content, "truth"), FLOW)
    recording = steered_boat.driven(truth, seed=1, duration=400.0)
    (text,) = said(recording, sticks(("motor", "helm")), "helm: turns the boat")
    assert text.startswith("helm: turns the boat only at speed: is it a rudder in the flow?")
    assert said(recording, truth.vehicle, "helm: turns the boat") == []
    poses = recording.raw * (1.0 if axes == "forward-left-up" else [1.0, -1.0, -1.0])
    turned_values = recording.commands.values * [1, sign]
    two_sheets(tmp_path, recording, "throttle", "rudder", poses=poses, values=turned_values)
    file = yaml.safe_load(seatrial.init(tmp_path, choices=Choices(axes=axes)).text)
    turned = (
        sign if axes == "forward-left-up" else -sign
    )  # positive turns to positive psi of the file
    assert file["commands"]["inputs"]["rudder"].get("sign", 1) == turned
    vehicle = vehicle_from(file, "v.yaml")
    model = seatrial.identify([seatrial.read(tmp_path, vehicle)], vehicle)
    assert not model.warnings
    assert survey_boat.as_stated(model, FLOW) == {}


@pytest.mark.parametrize("pulses", [False, True])
def test_init_asks_of_a_rudder_without_a_telling_name(pulses, tmp_path):
    """Also of pulse widths, which are not 0 at rest."""
    recording = steered_boat.driven(steered_boat.known(), seed=1)
    own = recording.commands.values
    values = 1500.0 + 400.0 * own if pulses else own
    two_sheets(tmp_path, recording, "ch1", "ch3", values=values)
    (line,) = (text for text in seatrial.init(tmp_path).text.splitlines() if ANGLE in text)
    assert "column: ch3" in line
    assert "turns the boat only with the thrust of ch1" in line
