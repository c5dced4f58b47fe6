# SPDX-License-Identifier: MIT
"""A vehicle file that reads, but can't be right: angles in radians, a neutral that is none."""

from dataclasses import replace

import pytest
from survey_boat import both, driven

import seatrial
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.console import summary
from seatrial.identification.estimator import output_error
from seatrial.inspection.console import inspection_text
from seatrial.inspection.overview import inspect
from seatrial.recording.excitation import beyond_full


def raft(*angles):
    content = seatrial.load_vehicle("mallard-mp").to_mapping()
    places = [(0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)]
    content["thrusters"] = {
        f"F_{i + 1}": {"x": x, "y": y, "angle_deg": angle}
        for i, ((x, y), angle) in enumerate(zip(places, angles, strict=True))
    }
    return vehicle_from(content, "raft")


def test_angles_in_radians_are_asked_about():
    (said,) = raft(2.356, -2.356, 0.785, -0.785).remarks
    assert said.startswith(
        "angle_deg is in degrees, but 2.356, -2.356, 0.785, -0.785 look like radians"
    )


@pytest.mark.parametrize(
    "angles",
    [(135, -135, 45, -45), (0, 0, 90, 22.5), (1.0, 2.0, 3.0, 0.0), (1.2, -1.2, 178.8, 0.3)],
)
def test_angles_in_degrees_are_not(angles):
    assert raft(*angles).remarks == ()


@pytest.mark.parametrize(
    ("least", "most", "asked"),
    [(-1.25, 0.74, True), (-0.7, 1.2, True), (-1.0, 0.6, False), (-1.2, 1.1, False), (0.0, 1.3, False)],
)  # fmt: skip
def test_a_command_that_passes_full_one_way_only_has_another_neutral(least, most, asked):
    said = beyond_full("F_u", least, most)
    assert [s for s in said if "check that offset is the neutral value" in s] == said
    assert bool(said) is asked


def test_a_boat_without_side_thrust_is_not_told_to_drive_sideways():
    vehicle, recording = driven({}, [both] * 2, seconds=60.0)
    text = inspection_text(inspect([recording], vehicle))
    assert "sway is not excited" not in text
    assert "surge" in text


def test_the_lever_of_a_file_with_y_to_starboard_is_said_as_it_is():
    vehicle, recording = driven({}, [both] * 2, seconds=60.0)
    model = output_error([recording], vehicle)
    content = model.vehicle.to_mapping()
    content["axes"] = "forward-right-down"
    content["pose"]["lever"] = [-0.1, 0.05]
    model = replace(model, vehicle=vehicle_from(content, "frd"))
    assert "the measured point is 0.100 m behind the origin, 0.050 m to its right" in summary(model)
