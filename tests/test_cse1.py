# SPDX-License-Identifier: MIT
"""The real recordings: a model ship, and the towing tests as independent truth."""

import csv

import numpy as np
import pytest
from conftest import CSE1

import seatrial
from benchmarks import cse1 as study
from seatrial.recording.faults.pose_faults import FaultKind


@pytest.fixture(scope="module")
def trained(cse1_paper_model):
    """The paper's structure, by the paper's method."""
    return cse1_paper_model


@pytest.fixture(scope="module")
def coupled():
    """A model from all runs but run1, and the runs."""
    vehicle = seatrial.load_vehicle(CSE1 / "coupled.yaml")
    runs = {
        n: seatrial.read(CSE1 / "csv" / f"CSE1_data_{n}.csv", vehicle)
        for n in ("random_run1", "random_run3", "run1")
    }
    known = [runs["random_run1"], runs["random_run3"]]
    return seatrial.identify(known, vehicle, method="equation-error"), runs


def test_lengths_rates_and_marked_samples_are_those_of_the_provenance(cse1):
    for name, length, marked in (
        ("random_run1", 705, 136),
        ("random_run3", 365, 84),
        ("run1", 248, 174),
    ):
        record = cse1[name]
        assert record.duration == pytest.approx(length, abs=0.5)
        assert record.period == pytest.approx(0.05)
        assert sum(f.samples for f in record.faults if f.kind is FaultKind.MARKED) == marked


def test_body_velocities_have_the_spread_that_the_provenance_states(cse1):
    for name, spread in (
        ("random_run1", (0.100, 0.045, 0.146)),
        ("random_run3", (0.047, 0.019, 0.055)),
    ):
        nu = seatrial.motion(cse1[name]).nu
        np.testing.assert_allclose(np.nanstd(nu, axis=0), spread, rtol=0.06)


def test_the_ship_is_read_into_forward_left_up_axes(cse1):
    table = np.genfromtxt(CSE1 / "csv" / "CSE1_data_run1.csv", delimiter=",", names=True)
    record = cse1["run1"]
    good = record.valid
    np.testing.assert_allclose(record.eta[good, 0], table["x"][good])
    np.testing.assert_allclose(record.eta[good, 1], -table["y"][good])
    np.testing.assert_allclose(np.cos(record.eta[good, 2]), np.cos(table["psi"][good]), atol=1e-12)


def test_every_thrust_gain_has_the_sign_of_the_ships_geometry(trained):
    """tau = [u1+u3, u2+u4+u5, ly (u1-u3) - lx (u2+u4) + lb u5], in the file's axes and through T."""
    c = trained.values
    assert c["X_F"] > 0
    assert c["Y_F"] > 0
    assert c["Y_b"] > 0
    assert c["N_F"] < 0  # the propellers are aft
    assert c["N_b"] > 0  # the bow thruster is not
    assert c["N_d"] > 0


@pytest.mark.system
def test_levers_of_propellers_and_bow_thruster_are_nearly_the_drawings(coupled):
    model, _ = coupled
    c = model.values
    lever = c["N_F"] / c["Y_F"] / (c["N_b"] / c["Y_b"])
    assert lever == pytest.approx(-0.425 / 0.415, rel=0.25)


def test_the_papers_method_beats_constant_velocity_on_the_run_it_has_not_seen(trained, cse1):
    scores = seatrial.validate(trained, [cse1["run1"]]).recordings[0].scores
    assert scores["u"].ratio < 0.45
    assert scores["v"].ratio < 0.85
    assert scores["r"].ratio < 0.65
    assert all(s.rms > s.floor for s in scores.values())


def test_coupled_terms_and_delay_predict_better_than_the_papers_structure(trained, cse1, coupled):
    model, runs = coupled
    before = seatrial.validate(trained, [cse1["run1"]]).recordings[0].scores
    after = seatrial.validate(model, [runs["run1"]]).recordings[0].scores
    assert after["u"].rms < before["u"].rms
    assert after["v"].rms < 0.75 * before["v"].rms


def test_thrust_of_the_bollard_pulls_moves_a_little_more_than_the_ships_mass(coupled):
    """Independent truth: 2 propellers' pull at full set-point over X_F is mass plus added mass."""
    rows = []
    with (CSE1 / "tow_and_bollard_summary.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["group"] == "VSPsurge"]
    x, y = np.array([(float(r["value"]), float(r["force_N"])) for r in rows]).T
    pull = 2 * float(np.polyfit(x, y, 1)[0])  # [N], per propeller 1.28 N in the thesis
    assert pull == pytest.approx(2.55, abs=0.03)
    model, _ = coupled
    mass = pull / model.values["X_F"]  # [kg]
    assert 14.1 < mass < 1.3 * 14.1  # a slender hull adds 5 to 20 % in surge


def test_a_model_of_the_ship_has_drag_in_the_right_direction(coupled):
    model, _ = coupled
    for name in ("X_u", "Y_v", "N_r"):
        assert model.values[name] < 0
        assert abs(model.values[name]) > 2 * model.standard_errors[name]


def test_the_ships_file_of_known_propellers_has_what_the_pulls_say():
    known = seatrial.load_vehicle(CSE1 / "bollard.yaml")
    constants = dict(zip(known.constants.names, known.constants.values, strict=True))
    assert not set(study.PAIR) & set(known.estimated)
    values, errors, pulls = study.pair_by_pulls()
    assert [constants[name] for name in study.PAIR] == pytest.approx(values, abs=5e-4)
    assert (errors < 0.03).all()
    assert pulls == 32
    whole = seatrial.load_vehicle(CSE1 / "pair.yaml")
    stated = whole.with_stated({name: constants[name] for name in study.PAIR})
    assert stated.estimated == known.estimated
    assert stated.file.structure == known.file.structure


@pytest.mark.system
def test_with_known_propellers_the_run_left_out_is_predicted_as_well_as_was_asked_for():
    """One second ahead, error over that of a velocity that stays, of random_run1."""
    known = seatrial.load_vehicle(CSE1 / "bollard.yaml")
    paths = [CSE1 / "csv" / f"CSE1_data_{n}.csv" for n in ("run1", "random_run3", "random_run1")]
    *others, unseen = (seatrial.read(path, known) for path in paths)
    model = seatrial.identify(others, known)
    truth = study.reference(unseen)
    for start in (truth, study.past(unseen)):
        assert (study.ratios(model, unseen, start, truth, 1.0) <= [0.34, 0.46, 0.48]).all()


@pytest.mark.system
def test_terms_that_two_runs_choose_predict_the_third():
    """With `structure: auto`, one second ahead, error over that of a velocity that stays, of random_run1."""
    vehicle = seatrial.load_vehicle(CSE1 / "vehicle.yaml")
    paths = [CSE1 / "csv" / f"CSE1_data_{n}.csv" for n in ("run1", "random_run3", "random_run1")]
    *others, unseen = (seatrial.read(path, vehicle) for path in paths)
    model = seatrial.identify(others, vehicle.with_automatic_structure())
    truth = study.reference(unseen)
    assert (study.ratios(model, unseen, truth, truth, 1.0) <= [0.37, 0.60, 0.57]).all()
