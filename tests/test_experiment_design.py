# SPDX-License-Identifier: MIT
"""What more driving would tell: held against what it does tell, and against closed forms."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
import steered_boat
from conftest import TABLE_II, make_model
from steered_boat import ACROSS, BOW_THRUSTER, RUDDER

import seatrial
from seatrial.boat.schema import EnvelopeEntry
from seatrial.boat.vehicle import vehicle_from
from seatrial.identification.experiment_design import (
    information_by_recording,
    manoeuvre_gains,
    next_drive,
    reference_point,
)
from seatrial.identification.experiment_design.gain import (
    ErrorDecay,
    ManoeuvreGain,
    drive_time,
    trial,
)
from seatrial.identification.experiment_design.manoeuvres import MANOEUVRE_LENGTH, manoeuvres
from seatrial.identification.uncertainty.identifiability import identifiability
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import simulate
from seatrial.util.errors import ModelError
from seatrial.util.statistics import pseudo_inverse, root_of

NOISE = np.array([4e-3, 4e-3, 4e-3])  # [m, m, rad] as in `hard`


@pytest.fixture(scope="module")
def runs(mp):
    """Half a minute of surge, sway and yaw each."""
    return [t.recording.cut(0.0, 60.0) for t in islice(simulate(load_plan("hard"), mp), 3)]


@pytest.fixture(scope="module")
def model(mp, runs):
    return seatrial.identify(runs, mp)


def test_errors_fall_as_the_inverse_of_all_information_says():
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(2, 4, 4))
    covariance, rate = a @ a.T, b @ b.T
    rate[:, 3] = rate[3, :] = 0.0
    fall = ErrorDecay.of(covariance, rate)
    for seconds in (0.0, 0.7, 30.0):
        expected = np.sqrt(np.diag(np.linalg.inv(np.linalg.inv(covariance) + seconds * rate)))
        assert fall.errors(np.full(4, seconds)) == pytest.approx(expected)
    for k in range(4):
        seconds = fall.halved()[k]
        if np.isfinite(seconds):
            after = fall.errors(np.full(4, seconds))[k]
            assert after == pytest.approx(0.5 * fall.errors(np.zeros(4))[k])


def test_one_number_is_halved_by_three_times_what_is_known():
    fall = ErrorDecay.of(np.array([[0.25]]), np.array([[2.0]]))  # 4 known, 2 more a second
    assert fall.halved() == pytest.approx(3 * 4 / 2)
    assert ErrorDecay.of(np.array([[0.25]]), np.array([[0.0]])).halved() == np.inf


def test_what_is_not_told_of_has_no_inverse():
    inverse, known = pseudo_inverse(np.array([[4.0, 0, 0], [0, 1.0, 1.0], [0, 1.0, 1.0]]))
    assert known.tolist() == [True, False, False]
    assert inverse[0, 0] == pytest.approx(0.25)
    assert not pseudo_inverse(np.zeros((2, 2)))[1].any()


def test_a_root_of_a_covariance_gives_it_back_where_it_is_singular():
    covariance = np.array([[4.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    root = root_of(covariance)
    np.testing.assert_allclose(root @ root.T, covariance, atol=1e-12)


def test_a_step_from_all_recordings_leads_back_to_what_they_say(model, runs):
    moved = replace(model, coefficients=model.coefficients * 1.003)
    point = reference_point(moved, runs)
    each = information_by_recording(point, runs)
    information = np.sum([one.information for one in each], axis=0)
    gradient = np.sum([one.gradient for one in each], axis=0)
    step = np.linalg.solve(information, gradient)[: len(model.coefficients)]
    away = moved.coefficients - model.coefficients
    error = np.sqrt(np.diag(np.linalg.inv(information)))[: len(away)]
    assert np.all(np.abs(step + away) < np.maximum(0.2 * np.abs(away), 0.5 * error))


def test_a_recording_of_surge_alone_knows_surge_best(model, runs):
    point = reference_point(model, runs)
    surge, sway, yaw = information_by_recording(point, runs)
    x, y = point.names.index("X_F"), point.names.index("Y_F")
    assert surge.errors[x] < 0.7 * sway.errors[x]
    assert sway.errors[y] < 0.7 * surge.errors[y]
    assert surge.errors[x] < yaw.errors[x]


def test_a_given_model_has_nothing_to_gain(af, runs):
    model = make_model(af, TABLE_II["AF"])
    with pytest.raises(ModelError, match="values were given"):
        reference_point(replace(model, covariance=np.zeros_like(model.covariance)), runs)


def test_every_manoeuvre_stays_within_what_was_recorded_and_says_what_it_is(model):
    found = manoeuvres(model)
    assert len({one.text for one in found}) == len(found)
    sway = next(one for one in found if one.text.startswith("sway pulses to the right at"))
    at = model.vehicle.inputs.index("F_v")
    assert sway.commands[:, at].min() < 0.0 == sway.commands[:, at].max()
    assert not np.delete(sway.commands, at, axis=1).any()
    for one in found:
        assert np.abs(one.commands).max() <= 1.0
        assert one.commands.shape == (len(one.t), len(model.vehicle.inputs))
    largest = max(abs(x) for x in model.envelope.forces["F_v"])
    assert max(np.abs(o.commands[:, at]).max() for o in found if o.effort < 3) == pytest.approx(
        largest
    )


def test_a_boat_of_propellers_gets_manoeuvres_for_each_of_its_forces(cse1, cse1_vehicle):
    model = make_model(cse1_vehicle, dict.fromkeys(cse1_vehicle.structure.coefficients, 0.0))
    found = manoeuvres(model)
    bow = next(one for one in found if one.text.startswith("sway (F_b) pulses to the left"))
    moved = [n for n, c in zip(model.vehicle.inputs, bow.commands.T, strict=True) if c.any()]
    assert moved == ["bow"]
    ahead = next(one for one in found if one.text.startswith("surge pulses ahead"))
    forces = ahead.commands @ model.vehicle.mix.T
    names = [force.name for force in model.vehicle.forces]
    assert forces[:, names.index("F_u")].max() > 0.3
    assert np.abs(np.delete(forces, names.index("F_u"), axis=1)).max() < 1e-12


@pytest.mark.parametrize(
    "kind", ["outboard", "with a bow thruster", "rudder", "by its thrust across", "at the bow"]
)
def test_an_angle_is_driven_at_a_held_thrust_and_every_manoeuvre_moves_the_boat_as_it_says(kind):
    """By the simulated boat: yaw to the named side, and no manoeuvre that makes no force."""
    across = {"by its thrust across": ACROSS, "at the bow": ACROSS}
    changed = {"outboard": {}, "with a bow thruster": BOW_THRUSTER, "rudder": RUDDER, **across}[
        kind
    ]
    model = steered_boat.known({"offset_deg": 0.0}, **changed)
    if kind == "at the bow":
        turned = [-c if n == "N_Fv" else c for n, c in model.values.items()]
        model = replace(model, coefficients=np.array(turned))
    found = manoeuvres(model)
    motor, helm = (model.vehicle.inputs.index(name) for name in ("motor", "helm"))
    for one in found:
        assert np.ptp(trial(model, one, 0.1).eta, axis=0).max() > 0.05, one.text
        if "pulses" in one.text and one.effort < 3 and one.commands[:, helm].any():
            assert one.text.endswith("motor held at 50 %") and (one.commands[:, motor] == 0.5).all()
    for word, sign in (("left", 1.0), ("right", -1.0)):
        turn = f"yaw pulses turning {word} at 100 % command, motor held at 50 %"
        (one,) = (m for m in found if m.text == turn)
        gain = -1.0 if kind == "rudder" else 1.0  # the sign of its N_ud
        assert gain * sign * trial(model, one, 0.1).eta[-1, 2] > 1.0
    sways = [one.text for one in found if one.text.startswith("sway pulses")]
    assert bool(sways) == (kind == "with a bow thruster")


def test_what_was_promised_comes_true_when_it_is_driven(model, runs, mp):
    """The manoeuvre is driven with the poses' noise, and identified together with the rest."""
    each = information_by_recording(reference_point(model, runs), runs)
    found = manoeuvre_gains(
        reference_point(model, runs), runs[0].period, each, [r.name for r in runs]
    )
    promised = next(g for g in found if g.parameter == "N_uu")
    one = next(m for m in manoeuvres(model) if m.text == promised.manoeuvre)
    driven = trial(model, one, runs[0].period)
    noise = NOISE * np.random.default_rng(5).normal(size=driven.eta.shape)
    more = replace(driven, name="more", eta=driven.eta + noise, raw=driven.eta + noise)
    after = seatrial.identify([*runs, more], mp)
    assert driven.duration == pytest.approx(MANOEUVRE_LENGTH + 1.0, abs=0.1)
    before, now = model.standard_errors["N_uu"], after.standard_errors["N_uu"]
    assert promised.error == pytest.approx(before)
    assert now / before == pytest.approx(promised.after / before, abs=0.15)
    assert promised.after < 0.9 * before


def made(name: str, seconds: float, manoeuvre: str = "sway pulses") -> ManoeuvreGain:
    return ManoeuvreGain(name, 1.0, 0.3, manoeuvre, seconds, 0.2)


def test_sentences_join_what_one_manoeuvre_does_and_end_with_what_none_does(model):
    errors = np.sqrt(np.diag(model.covariance))
    names = ("X_u", "Y_v", "N_r", "N_ud")
    for name, share in zip(names, (0.3, 0.25, 0.4, 0.5), strict=True):
        errors[model.parameters.index(name)] = share * abs(model.values[name])
    known = identifiability(replace(model, covariance=np.diag(errors**2)))
    said = next_drive(
        known,
        [made("X_u", 28.0), made("Y_v", 31.0), made("N_r", 1e9), made("N_ud", 200.0, "turns")],
    )
    assert (
        said[0]
        == "3.5 min more of turns would halve the 95 % interval of N_ud (0.412 to 1.59 rad/m)."
    )
    assert said[1] == (
        "35 s more of sway pulses would halve the 95 % intervals of X_u (0.412 to 1.59 1/s) and "
        "Y_v (0.412 to 1.59 1/s)."
    )
    assert said[2].startswith(
        "No manoeuvre that was tried halves within 30 minutes the interval of N_r (0.412 to 1.59 1/s): fix"
    )


def test_a_usable_parameter_that_no_drive_improves_asks_for_nothing(model):
    """`auto` ended with it where all else was sharp, in place of what to use the model for."""
    errors = np.sqrt(np.diag(model.covariance))
    for share, sentences in ((0.1, 0), (0.4, 1)):  # usable; weak
        errors[model.parameters.index("N_r")] = share * abs(model.values["N_r"])
        known = identifiability(replace(model, covariance=np.diag(errors**2)))
        assert len(next_drive(known, [made("N_r", 1e9)])) == sentences


@pytest.mark.parametrize(
    ("seconds", "expected"),
    [(1.0, "5 s"), (28.0, "30 s"), (90.0, "90 s"), (91.0, "2 min"), (400.0, "7 min"), (7300.0, "2.0 h"),
     (float("inf"), "no time")],
)  # fmt: skip
def test_times_are_rounded_up_to_what_people_drive(seconds, expected):
    assert drive_time(seconds) == expected


def test_direct_thrusters_are_driven_to_the_largest_force_that_was_recorded(mp):
    """Half of every thruster makes a whole force of four at 45 degrees: its command is half, not full."""
    inputs = {name: {"column": name} for name in mp.file.thrusters}
    content = {**mp.to_mapping(), "commands": {"inputs": inputs}, "allocation": {}}
    vehicle = vehicle_from(content, "direct")
    forces = {"F_u": (-0.9, 0.8), "F_v": (-0.5, 0.5), "F_r": (-0.3, 0.3)}
    model = make_model(vehicle, TABLE_II["AF"])
    found = manoeuvres(replace(model, envelope=EnvelopeEntry({}, forces)))
    for name, label in (("F_u", "surge"), ("F_v", "sway"), ("F_r", "yaw")):
        made = [m for m in found if m.text.startswith(f"{label} pulses to both sides")]
        j = [f.name for f in vehicle.forces].index(name)
        largest = max(float(np.abs(m.commands @ vehicle.mix[j]).max()) for m in made)
        assert largest == pytest.approx(max(map(abs, forces[name])))
        command = max(float(np.abs(m.commands).max()) for m in made)
        assert any(f"at {100 * command:.0f} % command" in m.text for m in made)
