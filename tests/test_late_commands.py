# SPDX-License-Identifier: MIT
"""Commands that are stamped after they act: a negative latency, which no thruster has."""

import numpy as np
import pytest
from recording_tools import beside_poses, stamped
from survey_boat import LATENCY, boat, driven

import seatrial
from seatrial.boat.findings import FindingKind, finding_text
from seatrial.boat.vehicle import vehicle_from
from seatrial.workflow.next_step import after_identify

LATE = 0.2  # [s]


@pytest.fixture(scope="module")
def drive():
    return driven({}, [lambda g: g.uniform(-1, 1)] * 2)


@pytest.mark.parametrize("method", ["output-error", "weak-form"])
def test_they_are_named_with_their_lead_and_its_error(drive, method):
    vehicle, recording = drive
    model = seatrial.identify([stamped(recording, LATE)], vehicle, method=method)
    (found,) = model.findings_of(FindingKind.LATE_COMMANDS)
    error = found.number("error")
    assert found.number("lead") == pytest.approx(LATE - LATENCY, abs=4.0 * error)
    assert error == model.standard_errors["latency"] < 0.02
    assert f"'offset: {found.number('lead'):.2f}' at commands: stamp" in finding_text(found)
    assert after_identify(model).do.startswith("Stamp commands where they are sent")


@pytest.mark.parametrize("late", [0.0, LATENCY + 0.01])
def test_a_latency_of_about_none_is_no_finding(drive, late):
    vehicle, recording = drive
    model = seatrial.identify([stamped(recording, late)], vehicle)
    assert not model.findings_of(FindingKind.LATE_COMMANDS)


def test_samples_of_a_logger_are_late_too(drive):
    """As long as nobody states that they are none, the doubt of it stands for the finding."""
    vehicle, recording = drive
    rows = beside_poses(stamped(recording, LATE), 0.2)
    model = seatrial.identify([rows], vehicle)
    assert not model.findings_of(FindingKind.LATE_COMMANDS)
    assert any("If a logger sampled them" in doubt for doubt in model.warnings)


def test_with_the_offset_that_it_names_it_is_gone(drive, tmp_path):
    _, recording = drive
    late = stamped(recording, LATE).commands
    tables = {
        "poses": ("t,x,y,psi", np.column_stack([recording.t, recording.raw])),
        "commands": ("t,left,right", np.column_stack([recording.seconds(late.stamps), late.values])),
    }  # fmt: skip
    for name, (head, rows) in tables.items():
        lines = [",".join(f"{value:.7f}" for value in row) for row in rows]
        (tmp_path / f"{name}.csv").write_text("\n".join([head, *lines]) + "\n")
    content = boat().to_mapping()
    content["pose"]["file"], content["commands"]["file"] = "poses.csv", "commands.csv"

    def leads():
        own = vehicle_from(content, "v.yaml")
        model = seatrial.identify([seatrial.read(tmp_path, own)], own)
        return [f.number("lead") for f in model.findings_of(FindingKind.LATE_COMMANDS)]

    (lead,) = leads()
    content["commands"]["stamp"] = {"column": "t", "offset": round(lead, 2)}
    assert leads() == []
