# SPDX-License-Identifier: MIT
"""Simulated trials of any boat: its own inputs, a lake in place of the pool, a lever arm and delays of its file."""

from pathlib import Path

import numpy as np
import pytest
import steered_boat
from cli_tools import done
from conftest import make_model
from survey_boat import TRUTH, as_stated, boat

import seatrial
from seatrial.boat.model_file import save
from seatrial.boat.vehicle import vehicle_from
from seatrial.io.trial_files import write_trial
from seatrial.simulation.joypad import default_plan, joypad_of
from seatrial.simulation.plan import DropOuts, load_plan
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import VehicleError
from seatrial.util.frames import earth_offset
from tests.boats.plans import planned

LAKE = load_plan("lake")
TWIN = seatrial.load_vehicle("twin-thruster")


@pytest.fixture(scope="module")
def truth():
    return plant_model(LAKE, TWIN)


def test_sticks_are_mixed_as_a_radio_control_does(truth):
    joypad = joypad_of(truth)
    np.testing.assert_allclose(joypad.weights, [[1, 0, -1], [1, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(joypad.inputs(np.array([1.0, 0.5, 1.0])), [0.0, 1.0], atol=1e-12)
    assert not joypad.sway and default_plan(truth) == "lake"


def test_a_rudder_or_outboard_turns_with_the_yaw_stick():
    joypad = joypad_of(steered_boat.known())  # a positive angle of its helm turns it to starboard
    np.testing.assert_allclose(joypad.weights, [[1, 0, 0], [0, 0, -1]], atol=1e-12)


def test_thrusters_all_round_have_sway():
    ship = seatrial.load(Path(__file__).parent / "models" / "cse1-pair-model-2.yaml")
    assert joypad_of(ship).sway and default_plan(ship) == "paper-like"
    assert default_plan(None) == "paper-like"


def test_a_boat_that_can_not_turn_is_refused():
    file = TWIN.to_mapping()
    both = {"left": 0.5, "right": 0.5}
    file["forces"] = {"F_u": {"axis": "surge", "of": both}, "F_r": {"axis": "yaw", "of": both}}
    straight = vehicle_from(file, "straight")
    with pytest.raises(VehicleError, match="do not move the boat in surge and yaw"):
        simulate(LAKE, straight, make_model(straight, LAKE.plant.coefficients))


@pytest.mark.parametrize("known", [None, steered_boat.known()], ids=["twin", "outboard"])
def test_it_stays_on_the_lake_and_goes_round_its_courses(known, truth):
    model = known or truth
    surge, yaw, courses, _ = simulate(LAKE, model.vehicle, model)
    for trial in (surge, yaw, courses):
        assert np.all(np.abs(trial.truth[:, :2]) < [40.0, 30.0])
    assert surge.truth[:, 3].min() < -0.5 and surge.truth[:, 3].max() > 0.5
    assert yaw.truth[:, 5].min() < -0.15 and yaw.truth[:, 5].max() > 0.15
    assert np.ptp(courses.truth[:, 0]) > 30.0 and np.ptp(courses.truth[:, 1]) > 20.0


def test_the_boat_is_found_again(truth):
    trials = list(simulate(planned(LAKE, "L1", "L2", "L3", seconds=150.0), TWIN))
    model = seatrial.identify([trial.recording for trial in trials], TWIN)
    assert not as_stated(model, {n: truth.values[n] for n in model.values if n in truth.values})


def test_lever_arm_and_delays_of_the_file_are_the_sensors(tmp_path):
    vehicle = TWIN.with_lever((0.4, -0.2)).with_delays(0.4, 0.2)
    exact = {
        "position_noise": 0.0,
        "heading_noise": 0.0,
        "stamp_jitter": 0.0,
        "drop_outs": DropOuts(0.0),
    }
    (trial,) = simulate(planned(LAKE, "L2", seconds=60.0, pose=exact), vehicle)
    x = trial.truth
    late = {
        by: np.column_stack(
            [np.interp(trial.truth_t - by, trial.truth_t, column) for column in x.T]
        )
        for by in vehicle.delays
    }
    position, heading = (late[by][trial.arrived] for by in vehicle.delays)
    point = position[:, :2] + earth_offset(position[:, 2], *vehicle.lever)
    np.testing.assert_allclose(trial.pose[:, :2], point, atol=2e-3)  # interpolation of the truth
    np.testing.assert_allclose(np.unwrap(trial.pose[:, 2]), heading[:, 2], atol=2e-3)
    # as from its files, the poses are of the origin again
    read = seatrial.read(write_trial(trial, tmp_path), vehicle)
    np.testing.assert_allclose(read.eta, trial.recording.eta, atol=1e-5)
    np.testing.assert_allclose(read.t, trial.recording.t, atol=1e-9)
    np.testing.assert_allclose(read.eta[:, :2], position[:, :2], atol=5e-3)


@pytest.mark.parametrize("name", ["cse1-pair-model-2.yaml", "outboard"])
def test_a_model_of_any_log_is_simulated_and_identified_again(name, tmp_path, capsys):
    """Whatever its logs are: the ship's have a column of valid poses and the propellers' speed, the outboard's one table."""
    path = Path(__file__).parent / "models" / name
    if name == "outboard":
        path = tmp_path / "outboard.yaml"
        save(steered_boat.known(), path)
    out = tmp_path / "trials"
    done(capsys, "simulate", "--plan", "lake", "--model", path, "-o", out)
    model, vehicle = seatrial.load(path), seatrial.load_vehicle(out / "vehicle.yaml")
    estimated = {n for n, error in model.standard_errors.items() if error > 0.0}
    assert set(vehicle.estimated) == estimated & set(vehicle.constants.names)
    assert (vehicle.file.forces, vehicle.structure.terms) == (
        model.vehicle.file.forces, model.structure.terms,
    )  # fmt: skip
    surge = seatrial.read(out / "L1", vehicle)
    (trial, *_) = simulate(LAKE, vehicle, model)
    np.testing.assert_allclose(surge.eta, trial.recording.eta, atol=1e-5)
    np.testing.assert_allclose(surge.commands.values, trial.recording.commands.values, atol=1e-6)
    if vehicle.scales:
        assert np.all(surge.scales.values == vehicle.file.scales["propeller_speed"].reference)


def test_a_model_drives_its_own_inputs_on_the_lake(tmp_path, capsys):
    save(make_model(boat(), TRUTH), tmp_path / "boat.yaml")
    done(capsys, "simulate", "--model", tmp_path / "boat.yaml", "-o", tmp_path / "trials")
    vehicle = seatrial.load_vehicle(tmp_path / "trials" / "vehicle.yaml")
    assert vehicle.inputs == boat().inputs
    assert {p.name for p in (tmp_path / "trials").glob("L*")} == set(LAKE.trials)
    assert seatrial.read(tmp_path / "trials" / "L1", vehicle).commands.names == vehicle.inputs
