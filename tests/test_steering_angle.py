# SPDX-License-Identifier: MIT
"""A rudder is known by the motion of the boat: it turns with the thrust beside it, a stick of yaw by itself."""

from dataclasses import replace

import numpy as np
import pytest
import steered_boat
import survey_boat
import yaml
from sheets import two_sheets

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.proposal.sources import Choices
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


def said(recording, vehicle):
    return [text for text in check_consistency([recording], vehicle).text if ANGLE in text]


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
