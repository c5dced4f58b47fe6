# SPDX-License-Identifier: MIT
"""Forces that the commands drive and the vehicle file does not name."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import CSE1

import seatrial
from seatrial.boat.findings import FindingKind, finding_text, of_kinds
from seatrial.identification.selection.unnamed_forces import added_forces, with_unnamed_forces
from seatrial.recording.signal import Signal


@pytest.fixture(scope="module")
def ship():
    vehicle = seatrial.load_vehicle(CSE1 / "vehicle.yaml").with_automatic_structure()
    return vehicle, seatrial.read(CSE1 / "csv" / "CSE1_data_run1.csv", vehicle)


def with_commands(recording, values):
    known = recording.commands
    return replace(recording, commands=Signal(known.names, known.stamps, values))


def test_two_propellers_across_have_a_difference_beside_their_sum(ship):
    """Five actuators and four forces: sum and difference ahead, sum across, bow."""
    vehicle, recording = ship
    found = with_unnamed_forces(vehicle, [recording])
    assert [f.name for f in found.forces] == ["F_u", "F_v", "F_b", "F_d", "F_v_d"]
    entry = found.file.forces["F_v_d"]
    assert (entry.axis, entry.of) == ("sway", {"port_sway": 0.5, "starboard_sway": -0.5})
    assert np.linalg.matrix_rank(found.mix) == 5
    assert with_unnamed_forces(found, [recording]).forces == found.forces  # it has them all
    (told,) = added_forces(vehicle, found)
    assert finding_text(told) == (
        "force F_v_d: the commands drive a combination of port_sway and starboard_sway for which the vehicle file has "
        "no force. The model has it as F_v_d, a force in sway, and its terms may use it. To keep it, copy F_v_d from "
        "forces: in the model file to the vehicle file"
    )
    assert told.part("axis") == "sway"


def test_what_is_not_driven_is_not_added(ship):
    vehicle, recording = ship
    values = recording.commands.values.copy()
    values[:, 3] = values[:, 1]
    assert with_unnamed_forces(vehicle, [with_commands(recording, values)]).forces == vehicle.forces


def test_a_name_that_is_taken_is_left_alone(ship):
    vehicle, recording = ship
    forces = {("F_v_d" if n == "F_b" else n): entry for n, entry in vehicle.file.forces.items()}
    renamed = replace(vehicle, file=msgspec.structs.replace(vehicle.file, forces=forces))
    assert [f.name for f in with_unnamed_forces(renamed, [recording]).forces][-1] == "F_v_dd"


def test_thrusters_and_forces_as_commands_have_no_more(mp, paper_mp):
    recording = paper_mp["S1"].recording
    assert with_unnamed_forces(mp, [recording]) is mp


@pytest.mark.system
def test_a_model_with_such_a_force_is_a_prior_of_the_file_that_names_none(ship):
    vehicle, recording = ship
    part = [recording.cut(0.0, 120.0)]
    before = seatrial.identify(part, vehicle)
    assert "F_v_d" in before.vehicle.file.forces
    assert len(of_kinds(before.estimator.findings, FindingKind.FORCE_ADDED)) == 1
    assert "Y_Fvd" in before.values or any("F_v_d" in t.factors for t in before.structure.terms)
    again = seatrial.identify(part, vehicle, prior=before)
    assert list(again.values) == list(before.values)
