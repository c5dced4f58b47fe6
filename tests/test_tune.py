# SPDX-License-Identifier: MIT
"""Gains and margins: against closed forms, python-control, a Pade state space, and the law of margins."""

import dataclasses

import numpy as np
import pytest
from conftest import TABLE_II, make_model
from tune_tools import LAG, LATENCY, boat_by_hand, mallard, poles_by_pade, with_chain

from seatrial.control import tune
from seatrial.control.tuning.dead_zone import dead_zone
from seatrial.control.tuning.design import (
    SENSITIVITY_LIMIT,
    gains_for,
)
from seatrial.control.tuning.linear import linearise
from seatrial.control.tuning.loops import Feedback, frequencies, margins
from seatrial.control.tuning.robustness import drawn
from seatrial.control.tuning.rules import pd_gains, pid_gains
from seatrial.util.errors import ControlError

C = TABLE_II["AF"]
HOLD = 0.01  # [s]


@pytest.fixture(scope="module")
def model():
    return mallard()


@pytest.fixture(scope="module")
def boat(model):
    return linearise(model)


@pytest.fixture(scope="module")
def tuning(model):
    return tune(model, draws=20)


def taylor_poles(gains, delay, drag):
    """Poles of the loop whose delay is 1 - theta s."""
    p, i, d = gains.proportional, gains.integral, gains.derivative
    plant = np.array([1.0, drag, 0.0, 0.0])  # s times s (s + d)
    control = np.convolve([d, p, i], [-delay, 1.0])
    return np.roots(plant + control)


@pytest.mark.parametrize("drag", [0.0, 0.2, 1.5])
@pytest.mark.parametrize(("rule", "count"), [(pd_gains, 2), (pid_gains, 3)])
def test_every_gain_places_a_pole(rule, count, drag):
    knob, delay = 0.8, 0.15
    found = rule(knob, delay, drag)
    poles = taylor_poles(found, delay, drag)
    assert found.derivative > 0
    at_knob = np.sort(np.abs(poles + 1.0 / knob))[:count]
    assert (at_knob < 1e-3).all()  # a triple root is found to the cube root of the rounding


@pytest.mark.parametrize(("rule", "count"), [(pd_gains, 1), (pid_gains, 2)])
def test_where_drag_does_enough_there_is_no_derivative(rule, count):
    knob, delay, drag = 3.0, 0.15, 4.0
    found = rule(knob, delay, drag)
    assert found.derivative == 0.0 and found.proportional > 0
    poles = taylor_poles(found, delay, drag)
    poles = poles[np.abs(poles) > 1e-9] if count == 1 else poles
    assert (np.sort(np.abs(poles + 1.0 / knob))[:count] < 1e-3).all()
    assert (poles.real < -0.99 / knob).all()


@pytest.mark.parametrize("rule", [pd_gains, pid_gains])
def test_gains_have_no_jump_where_the_derivative_ends(rule):
    knob, delay = 2.0, 0.1
    low, high = 0.0, 100.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rule(knob, delay, middle).derivative > 0 else (low, middle)
    a, b = rule(knob, delay, low), rule(knob, delay, high)
    assert dataclasses.astuple(a) == pytest.approx(dataclasses.astuple(b), rel=1e-6, abs=1e-6)


def test_the_boat_is_linearised_as_by_hand(boat):
    for nu, A in zip(boat.speeds, boat.slopes, strict=True):
        by_hand, B = boat_by_hand(C, nu)
        np.testing.assert_allclose(A, by_hand, atol=2e-5)
        np.testing.assert_allclose(B @ boat.mix, np.diag(boat.authority), atol=1e-12)
    np.testing.assert_allclose(boat.authority, [C["X_F"], C["Y_F"], C["N_F"]])
    np.testing.assert_allclose(boat.actuators.delay, LAG + LATENCY)
    assert boat.steepest == pytest.approx(1.0 / 0.92, rel=1e-6)  # past the dead zone's edge


def test_without_an_envelope_the_fastest_motions_are_what_full_command_reaches(boat):
    a, b, f = C["X_uu"], C["X_u"], C["X_F"]
    assert boat.speeds[1, 0] == pytest.approx((-b - np.sqrt(b * b - 4 * a * f)) / (2 * a), rel=1e-3)


def test_margins_are_those_of_python_control(model, boat):
    control = pytest.importorskip("control")
    uncoupled = dataclasses.replace(
        boat, speeds=boat.speeds[:1], slopes=np.diag([C["X_u"], C["Y_v"], C["N_r"]])[None],
        actuators=dataclasses.replace(boat.actuators, push=_uncoupled(boat)),
    )  # fmt: skip
    gains = gains_for(boat, 0.4, HOLD, "pid")
    omega = frequencies(0.4, 0.14, 4000)
    found = margins(uncoupled, Feedback(gains, boat.speeds[:1], omega, HOLD))
    s = control.tf("s")
    for axis, (g, drag) in enumerate(zip(gains, (C["X_u"], C["Y_v"], C["N_r"]), strict=True)):
        delay = control.tf(*control.pade(LATENCY + HOLD, 5))
        pid = g.proportional + g.integral / s + g.derivative * s
        loop = pid * delay / ((LAG * s + 1) * s * (s - drag))
        gm, pm, sm, _, wc, _ = control.stability_margins(loop)
        assert found.gain_up[0, axis] == pytest.approx(gm, rel=2e-3)
        assert np.degrees(found.phase[0, axis]) == pytest.approx(pm, rel=2e-3)
        assert 1.0 / found.sensitivity[0, axis] == pytest.approx(sm, rel=2e-3)
        assert found.crossover[0, axis] == pytest.approx(wc, rel=2e-3)
        assert found.delay[0, axis] == pytest.approx(np.radians(pm) / wc, rel=2e-3)


def _uncoupled(boat):
    """Pushes without N_ud."""
    push = boat.actuators.push.copy()
    push[2] -= C["N_ud"] * push[0]
    return push


@pytest.mark.parametrize("knob", [0.08, 0.15, 0.3, 1.0, 4.0])
def test_poles_on_the_right_are_counted_as_a_state_space_has_them(boat, knob):
    pytest.importorskip("control")
    gains = gains_for(boat, knob, 0.0, "pid")
    table = np.array([dataclasses.astuple(g) for g in gains]) / boat.authority[:, None]
    found = margins(boat, Feedback(gains, boat.speeds, frequencies(knob, 0.13), 0.0)).stable
    expected = [poles_by_pade(C, nu, table, boat.mix).real.max() < 0 for nu in boat.speeds]
    assert found.tolist() == expected
    assert all(expected) == (knob >= 0.3)


@pytest.mark.parametrize("action", ["pid", "pd"])
def test_a_loop_bears_its_margins_and_no_more(boat, action):
    gains = gains_for(boat, 0.4, HOLD, action)
    still = dataclasses.replace(boat, speeds=boat.speeds[:1], slopes=boat.slopes[:1])
    omega = frequencies(0.4, 0.14, 2000)

    def stays(more=0.0, strength=1.0):
        feedback = Feedback(gains, still.speeds, omega, HOLD + more)
        return bool(margins(still, feedback, strength).stable.all())

    found = margins(still, Feedback(gains, still.speeds, omega, HOLD))
    delay, up, down = found.delay.min(), found.gain_up.min(), found.gain_down.max()
    assert stays(0.98 * delay) and not stays(1.02 * delay)
    assert stays(0.0, 0.98 * up) and not stays(0.0, 1.02 * up)
    if action == "pid":
        assert stays(0.0, 1.05 * down) and not stays(0.0, 0.95 * down)


def test_a_turning_boat_needs_the_integral_fixed_to_the_earth(boat):
    """Which is why the controller has it so, and what the margins are computed for."""
    pytest.importorskip("control")
    knob = 2.0
    gains = gains_for(boat, knob, 0.0, "pid")
    table = np.array([dataclasses.astuple(g) for g in gains]) / boat.authority[:, None]
    earth, body = (
        [poles_by_pade(C, nu, table, boat.mix, earth=e).real.max() < 0 for nu in boat.speeds]
        for e in (True, False)
    )
    assert all(earth) and not all(body)
    assert margins(boat, Feedback(gains, boat.speeds, frequencies(knob, 0.13), 0.0)).stable.all()


def test_gains_are_in_command_units(tuning):
    rule = pid_gains(1.0, LAG + LATENCY + 0.01, -C["X_u"])
    assert tuning.table()[0] == pytest.approx(
        np.array(dataclasses.astuple(rule))[[0, 1, 2]] / C["X_F"]
    )
    assert tuning.hold == pytest.approx(0.01)


def test_draws_are_as_the_covariance_says(model):
    drawn_once = np.array([m.coefficients for m in drawn(model, 2000, 7)])
    spread = np.sqrt(np.diag(model.covariance))[: len(model.coefficients)]
    np.testing.assert_allclose(
        drawn_once.mean(axis=0), model.coefficients, atol=4 * spread.max() / 44
    )
    np.testing.assert_allclose(drawn_once.std(axis=0), spread, rtol=0.08)
    again = np.array([m.coefficients for m in drawn(model, 3, 7)])
    assert (again == drawn_once[:3]).all()
    assert not (next(drawn(model, 1, 8)).coefficients == again[0]).all()


def test_the_worst_draw_is_no_better_than_the_model(tuning):
    assert (tuning.worst.sensitivity > tuning.nominal.sensitivity).all()
    assert (tuning.worst.phase < tuning.nominal.phase).all()
    assert tuning.worst.stable and (tuning.worst.sensitivity < SENSITIVITY_LIMIT).all()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"N_r": 0.3}, r"mallard: unstable in yaw: its drag at .* is -0\.3\S* 1/s, expected 0 or more"),
        ({"X_u": 0.01}, r"mallard: unstable in surge: its drag at rest is -0\.01 1/s"),
        ({"Y_vv": 1.0}, r"mallard: (unstable in sway: its drag at v|its speed at full command is unbounded)"),
    ],
)  # fmt: skip
def test_a_boat_that_drives_itself_on_is_refused(changes, said):
    with pytest.raises(ControlError, match=said):
        tune(mallard(**changes), draws=2)


@pytest.mark.parametrize("idle", ["surge", "yaw"])
def test_a_boat_without_surge_or_yaw_thrust_is_refused(idle):
    structure = {
        "surge": ["X_u * u", "X_F * F_u"], "sway": ["Y_v * v", "Y_F * F_v"], "yaw": ["N_r * r", "N_F * F_r"],
    }  # fmt: skip
    structure[idle].pop()
    values = {"X_u": -0.2, "X_F": 0.14, "Y_v": -0.2, "Y_F": 0.1, "N_r": -0.5, "N_F": 1.3}
    vehicle = with_chain("mallard-mp", structure=structure)
    model = make_model(vehicle, {n: values[n] for n in vehicle.structure.coefficients})
    with pytest.raises(
        ControlError,
        match=rf"mallard: no command actuates {idle}; the controller needs a force in surge",
    ):
        tune(model)


@pytest.mark.parametrize(
    "request_", [{"knob": 0.0}, {"knob": float("nan")}, {"knob": 1e3}, {"rate": 0.0}, {"extra": -1.0}]
)  # fmt: skip
def test_odd_requests_are_refused(model, request_):
    with pytest.raises(ControlError, match="expected"):
        tune(model, **request_)


def test_the_dead_zone_is_seen_through_allocation(model, boat):
    """Under MP each thruster gets half a surge command; under AF they idle beyond their edges."""
    np.testing.assert_allclose(dead_zone(model, boat), 0.16, atol=2e-3)
    always = mallard("AF")
    np.testing.assert_allclose(dead_zone(always, linearise(always)), 0.0, atol=2e-3)


def test_latency_below_zero_counts_as_none():
    early = mallard(chain=[{"latency": -0.03, "lag": LAG}])
    np.testing.assert_allclose(linearise(early).actuators.delay, LAG)


def test_a_model_without_covariance_has_no_draws():
    found = tune(mallard(spread=0.0))
    assert found.draws == 0
