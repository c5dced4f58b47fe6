# SPDX-License-Identifier: MIT
"""`structure: auto`: the recordings choose the terms; a given structure stays, and its missing term is named."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import on_request
from survey_boat import TRUTH, as_stated, driven, even

import seatrial
from seatrial.boat.findings import FindingKind
from seatrial.boat.physical_library import base_terms, library_tiers
from seatrial.commands import identify as identify_command
from seatrial.commands.cli import main
from seatrial.identification import term_choice
from seatrial.identification.estimator import fit
from seatrial.identification.selection.significance import enough_blocks, least_length, usable_time
from seatrial.identification.selection.terms import choose_structure, given_candidates
from seatrial.identification.selection.terms.block_prediction import BlockPrediction
from seatrial.identification.selection.terms.candidates import aliases, with_usual_terms
from seatrial.identification.selection.terms.held_out import folds
from seatrial.identification.selection.terms.select_terms import estimated_parameters
from seatrial.identification.term_choice import TermChoice, choose_terms
from seatrial.io.trial_files import write_setting, write_trial
from seatrial.recording.from_poses import make_recording
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model, simulate
from seatrial.util.errors import VehicleError
from seatrial.util.files import dump_yaml
from tests.boats import hulls
from tests.boats.plans import planned

SIX = ("S1", "S2", "S3", "S4", "S5", "S6")
BASE = {"X_u", "X_uu", "X_F", "Y_v", "Y_vv", "Y_F", "N_r", "N_rr", "N_F"}
LIFT = -0.4  # Y_ur beside -u r: an added mass in surge of 0.4 of that in sway
# terms of the plant where a plan has their coefficients
FURTHER = ("Y_ur * u * r", "X_aFu * |u| * F_u")


def plan_of(length=60.0, **coefficients):
    """Trials of a boat without the paper's asymmetry, N_uu and N_ud."""
    own = {"N_uu": 0.0, "N_ud": 0.0, **coefficients}
    return planned("paper-like", *SIX, seconds=length, seed=4, coefficients=own)


def recordings(plan, vehicle):
    own = [line for line in FURTHER if line.partition(" ")[0] in plan.plant.coefficients]
    more = given_candidates(vehicle, own) if own else ()
    driven = vehicle.with_terms((*vehicle.structure.terms, *more))
    return [t.recording for t in simulate(plan, driven, plant_model(plan, driven))]


@pytest.fixture(scope="module")
def lifted(mp):
    return recordings(plan_of(Y_ur=LIFT), mp)


@pytest.fixture(scope="module")
def as_given(mp, lifted):
    """The model of the structure in the vehicle file, which lacks a term."""
    return seatrial.identify(lifted, mp)


def test_axes_that_are_driven_one_after_another_in_one_recording_lose_no_term():
    """Neither half of it drives all axes: parts of it that do are held against each other."""
    vehicle, found = hulls.driven(
        hulls.MIDDLE, {"latency": 0.06, "lag": 0.15}, seed=3, white=2e-3, rate=10.0, seconds=350.0, drives=1,
        pattern=hulls.one_after_another,
    )  # fmt: skip
    odd, even = folds(vehicle, found)
    assert len(odd.recordings) == len(even.recordings) > 1
    model = seatrial.identify(found, vehicle.with_automatic_structure())
    truth = hulls.MIDDLE.coefficients
    assert set(model.values) >= BASE
    for name in sorted(BASE):
        assert model.values[name] == pytest.approx(
            truth[name], abs=3.5 * model.standard_errors[name]
        ), name


def test_the_choice_begins_with_what_every_boat_has(mp):
    auto = mp.with_automatic_structure()
    assert auto.automatic
    assert set(auto.structure.coefficients) == BASE
    assert [t.text() for t in auto.structure.terms if not t.coefficient] == ["v * r", "-1 * u * r"]
    assert auto.to_mapping()["structure"] == "auto"


def test_no_term_of_the_library_is_a_combination_of_others(mp):
    for vehicle, explicit in ((mp, False), (seatrial.load_vehicle("data/cse1/pair.yaml"), True)):
        base = base_terms(vehicle.forces, explicit=explicit)
        more = [t for tier in library_tiers(vehicle.forces, explicit=explicit) for t in tier]
        names = [t.coefficient for t in (*base, *more) if t.coefficient]
        assert len(names) == len(set(names))
        assert aliases(base, more, vehicle.forces) == ()


def test_sway_thrust_of_unknown_lever_arm_turns_the_boat_from_the_start():
    ship = seatrial.load_vehicle("data/cse1/vehicle.yaml").with_automatic_structure()
    texts = {t.text() for t in ship.structure.terms}
    assert {"N_Fv * F_v", "N_Fb * F_b", "N_F * F_d", "Y_Fb * F_b", "X_F * F_u"} <= texts


def test_the_boats_own_terms_are_chosen_and_found_and_no_others(mp, lifted):
    model = seatrial.identify(lifted, mp.with_automatic_structure())
    assert set(model.values) == BASE | {"Y_ur"}
    assert model.values["Y_ur"] == pytest.approx(LIFT, abs=4 * model.standard_errors["Y_ur"])
    assert not model.vehicle.automatic


@pytest.mark.system
def test_a_centre_of_mass_beside_the_middle_is_an_acceleration_and_no_thrust(mp):
    """The paper's own boat: N_uu means what it means there only beside N_ud u_dot."""
    plan = plan_of(N_uu=0.63, N_ud=0.04)
    found = seatrial.identify(recordings(plan, mp), mp.with_automatic_structure())
    assert set(found.values) == BASE | {"N_uu", "N_ud"}
    for name, truth in (("N_uu", 0.63), ("N_ud", 0.04)):
        assert found.values[name] == pytest.approx(truth, abs=4 * found.standard_errors[name])


@pytest.mark.system
def test_thrust_that_falls_with_the_speed_of_advance_is_no_drag(mp):
    """By 40 % at the top speed: without its term drag and thrust are off by many standard errors."""
    plan = plan_of(X_aFu=-0.25)
    found = seatrial.identify(recordings(plan, mp), mp.with_automatic_structure())
    assert set(found.values) == BASE | {"X_aFu"}
    for name in ("X_u", "X_uu", "X_F", "X_aFu"):
        truth = plan.plant.coefficients[name]
        assert found.values[name] == pytest.approx(truth, abs=4 * found.standard_errors[name])


def drifting(size, memory, length, rate, rng):
    """Gauss-Markov errors (length,) at so many a second; memory [s]."""
    kept = np.exp(-1.0 / (rate * memory))
    errors = size * rng.normal(size=length)
    for k in range(1, length):
        errors[k] = kept * errors[k - 1] + np.sqrt(1.0 - kept**2) * errors[k]
    return errors


@pytest.mark.system
@pytest.mark.parametrize("seed", [3, on_request(1), on_request(4)])
def test_added_mass_that_a_plain_gnss_hardly_shows_stays(seed):
    """Receiver and compass drift by 0.8 m and 2 degrees: without it drag and thrust are off, by many errors."""
    vehicle, recording = driven(
        {}, [lambda g: g.uniform(0, 1)] * 2, seed=seed, seconds=400.0, stamps=even(5.0), noise=np.array([0.02, 0.02, 5e-3])
    )  # fmt: skip
    rng = np.random.default_rng(seed)
    sizes = ((0.8, 60.0), (0.8, 60.0), (0.03, 20.0))
    drift = [drifting(*of, len(recording.t), 5.0, rng) for of in sizes]
    recording = make_recording(
        "drive", recording.stamps, recording.raw + np.column_stack(drift), recording.commands
    )
    found = seatrial.identify([recording], vehicle.with_automatic_structure())
    assert {"X_vr", "Y_ur"} <= set(found.values)
    truth = {n: x for n, x in TRUTH.items() if n in ("X_u", "X_F", "Y_v", "N_F")}
    truth |= {"X_vr": TRUTH["X_vr"] - 1.0, "Y_ur": TRUTH["Y_ur"] + 1.0}
    assert as_stated(found, truth) == {}


@pytest.mark.system
def test_another_method_estimates_the_terms_that_output_error_chooses(mp, lifted):
    model = seatrial.identify(lifted, mp.with_automatic_structure(), method="weak-form")
    assert set(model.values) == BASE | {"Y_ur"}
    assert model.estimator.method == "weak-form"


def test_a_given_structure_stays_and_the_missing_term_is_named(mp, lifted, as_given):
    model = as_given
    assert model.structure.coefficients == mp.structure.coefficients
    (finding,) = model.findings_of(FindingKind.MISSING_TERM)
    assert finding.subject == ("sway", "u * r")
    assert finding.number("errors") > 5.0
    assert finding.number("improvement") > 0.01
    whole = mp.with_terms((*mp.structure.terms, *given_candidates(mp, ["Y_ur * u * r"])))
    assert not seatrial.identify(lifted, whole).findings_of(FindingKind.MISSING_TERM)


def test_short_recordings_leave_the_terms_of_every_boat(mp, lifted):
    short = [recording.cut(0.0, 35.0) for recording in lifted[:3]]
    assert choose_structure(short, mp.with_automatic_structure()) is None
    added_mass = {"X_vr", "Y_ur", "N_uv"}
    found = seatrial.identify(short, mp.with_automatic_structure())
    assert set(found.values) == BASE | added_mass
    # the length that `identify` asks for is enough, and no more
    fitted = estimated_parameters(mp.with_automatic_structure(), short)
    least = least_length(short, fitted)
    piece, count = lifted[0].cut(0.0, 20.0), round(least / 20.0)
    assert enough_blocks([piece] * count, fitted)
    assert not enough_blocks([piece] * (count - 1), fitted)


@pytest.mark.parametrize(
    ("seconds", "said"),
    [
        (330.0, "ask for more terms than 330 s tell apart"),
        (100.0, "100 s are too short to choose terms"),
    ],
)
def test_a_search_that_runs_out_of_data_does_not_ask_for_the_length_that_is_there(
    monkeypatch, seconds, said
):
    """Terms that stand in for a lever arm or a current are too many at any length: `record 340 s` was no advice."""
    vehicle, recording = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=seconds)
    chosen = TermChoice(with_usual_terms(vehicle.with_automatic_structure()), automatic=True)
    monkeypatch.setattr(term_choice, "choose_terms", lambda *_: chosen)
    args = SimpleNamespace(effect=(), verbose=False)
    text, _ = identify_command._terms(args, [recording], vehicle.with_automatic_structure(), None)
    assert said in text


def test_time_without_usable_poses_is_no_time_to_test_terms():
    """An interval that is left out: identify goes on with what remains, and names no missing term."""
    vehicle, recording = driven({}, [lambda g: g.uniform(-1, 1)] * 2, seconds=330.0)
    lacking = vehicle.with_terms([t for t in vehicle.structure.terms if t.coefficient != "X_vr"])
    assert enough_blocks([recording], 13)
    rest = recording.without(0.0, 165.0)
    assert usable_time([rest]) == pytest.approx(165.0, abs=10.0)
    assert not enough_blocks([rest], 13)
    found = seatrial.identify([rest], lacking)
    assert FindingKind.MISSING_TERM not in {f.kind for f in found.estimator.findings}


@pytest.mark.system
def test_terms_that_diverge_leave_those_of_every_boat_and_the_lever_arm_is_named():
    """Poses of an antenna 0.5 m ahead: drag in sway that stands in for it diverges in the model's own filter."""
    vehicle, recording = driven(
        {}, [lambda g: g.uniform(0, 1)] * 2, seed=5, stamps=even(5.0), noise=np.array([0.01, 0.01, 5e-5])
    )  # fmt: skip
    psi = recording.raw[:, 2]
    ahead = np.column_stack([np.cos(psi), np.sin(psi), np.zeros_like(psi)])
    poses = recording.raw + 0.5 * ahead
    recording = make_recording("drive", recording.stamps, poses, recording.commands)
    automatic = vehicle.with_automatic_structure()
    choice = choose_terms([recording], automatic)
    assert choice.diverges and choice.selection is None
    found = seatrial.identify([recording], automatic)
    assert list(found.values) == list(choice.vehicle.structure.coefficients)
    (lever,) = (f for f in found.estimator.findings if f.kind is FindingKind.UNMODELLED_LEVER_ARM)
    assert lever.number("size") == pytest.approx(0.5, abs=0.02)
    # no advice to do what could not be done
    assert FindingKind.MISSING_TERM not in {f.kind for f in found.estimator.findings}


def test_a_prior_has_terms_already(mp, lifted, as_given):
    old = as_given
    model = seatrial.identify(lifted[:3], mp.with_automatic_structure(), prior=old)
    assert model.structure.coefficients == old.structure.coefficients
    assert old.with_vehicle(mp.with_automatic_structure()).values == old.values


def test_a_vehicle_without_terms_is_not_simulated(mp):
    with pytest.raises(VehicleError, match=r"structure: auto has no terms before recordings"):
        plant_model(load_plan("paper-like"), mp.with_automatic_structure())


@pytest.mark.system
def test_the_command_prints_the_reasons_and_the_model_has_the_terms(mp, tmp_path, capsys):
    plan = plan_of(Y_ur=LIFT)
    driven = mp.with_terms((*mp.structure.terms, *given_candidates(mp, ["Y_ur * u * r"])))
    write_setting(plan, driven, plant_model(plan, driven), tmp_path)
    records = [str(write_trial(t, tmp_path)) for t in simulate(plan, driven)]
    given, auto = tmp_path / "vehicle-MP.yaml", tmp_path / "auto.yaml"
    auto.write_text(dump_yaml(seatrial.load_vehicle(given).with_automatic_structure().to_mapping()))
    assert main(["inspect", *records, "--vehicle", str(auto), "-q"]) == 0
    for vehicle, option in ((auto, []), (given, ["--structure", "auto"])):
        out = tmp_path / f"{vehicle.stem}-model.yaml"
        command = ["identify", *records, "--vehicle", str(vehicle), "-o", str(out), "-q", *option]
        capsys.readouterr()
        assert main(command) == 0
        shown = capsys.readouterr().out
        assert "Added: Y_ur. Removed: none." in shown
        assert "auto" not in out.read_text()
        assert "Y_ur * u * r" in out.read_text()


def test_blocks_left_out_are_predicted_worse_without_a_term_that_matters(mp, lifted):
    """Against a plain mean: squares of blocks without any fold are the model's own errors."""
    solved = fit(lifted[:3], mp)
    model = solved.model()
    blocks = BlockPrediction.of(model, solved.problem, 1.0)
    squares = [
        aim.squares(aim.predict(model, r)) for aim, r in zip(blocks.targets, lifted, strict=False)
    ]
    gain = blocks.gain(4.0 * np.concatenate(squares), np.concatenate(squares))
    assert gain.log == pytest.approx(3.0 * np.log(2.0))  # half the RMS error in three axes
    worse = replace(model, coefficients=0.5 * model.coefficients)
    other = [
        aim.squares(aim.predict(worse, r)) for aim, r in zip(blocks.targets, lifted, strict=False)
    ]
    assert blocks.gain(np.concatenate(other), np.concatenate(squares)).clear
    assert not blocks.gain(np.concatenate(squares), np.concatenate(other)).clear


@pytest.mark.system
def test_no_term_stands_in_for_thrusters_that_push_less_astern():
    """A turn on the spot then makes thrust ahead, which r^2 in surge would explain."""
    size = [lambda g: g.uniform(-1, 1)] * 2
    vehicle, recording = driven({"reverse_ratio": 0.7}, size, seconds=400.0)
    found = seatrial.identify([recording], vehicle.with_automatic_structure())
    assert set(found.values) == set(TRUTH) - {"Y_F", "N_b"}
    truth = {
        **TRUTH,
        "X_vr": TRUTH["X_vr"] - 1.0,
        "Y_ur": TRUTH["Y_ur"] + 1.0,
        "reverse_ratio": 0.7,
    }
    assert as_stated(found, {n: x for n, x in truth.items() if n not in ("Y_F", "N_b")}) == {}
