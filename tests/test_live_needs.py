# SPDX-License-Identifier: MIT
"""What each use needs to know, and the verdict."""

from dataclasses import replace

import numpy as np
import pytest
from live_advice_boat import known_boat

from seatrial.identification.experiment_design.simulated_drive import simulated_drive
from seatrial.poolside.enough import STEADY_SECONDS, Enough
from seatrial.poolside.needs import Need, needs_of, parameter_states, reference_drive
from seatrial.poolside.state import PredictionState
from seatrial.util.statistics import NORMAL_95
from seatrial.workflow.fitness import GAIN_KNOWN, Use

ALL = tuple(Use)


def named(needs, subject):
    return next(need for need in needs if need.subject == subject)


def test_control_needs_gain_and_damping_to_a_quarter_and_delays_to_a_tenth_of_the_rise_time():
    model = known_boat(0.05)
    needs = needs_of(model, [Use.CONTROL])
    gain = named(needs, "sway gain")
    assert gain.allowed == pytest.approx(GAIN_KNOWN * 0.20)
    assert gain.width(model.covariance) == pytest.approx(NORMAL_95 * 0.05 * 0.20)
    damping = named(needs, "surge damping")  # -0.20 u - 1.74 |u| u at 0.2 m/s
    parts = np.array([0.05 * 0.20 * 0.2, 0.05 * 1.74 * 0.04])
    assert damping.width(model.covariance) == pytest.approx(NORMAL_95 * np.hypot(*parts))
    assert damping.allowed == pytest.approx(GAIN_KNOWN * (0.20 * 0.2 + 1.74 * 0.04))
    delay = named(needs, "latency and lag")
    assert delay.width(model.covariance) == pytest.approx(NORMAL_95 * 0.001 * np.sqrt(2.0))


@pytest.mark.parametrize(("use", "horizon"), [(Use.ODOMETRY, 1.0), (Use.SIMULATION, 5.0)])
def test_the_width_of_a_prediction_is_that_of_models_drawn_from_the_covariance(use, horizon):
    model = known_boat(0.02)
    needs, drive = needs_of(model, [use]), reference_drive(model)
    commands, period = drive.recording.commands, 0.1
    held = commands.stamps[1:] * 1e-9
    rng, errors = np.random.default_rng(4), []
    starts = np.arange(0, len(drive.states) - round(horizon / period), 50)
    for _ in range(40):
        moved = model.coefficients + rng.normal(size=11) * np.sqrt(np.diag(model.covariance))[:11]
        other = replace(model, coefficients=moved)
        for k in starts:
            times = period * np.array([k, k + round(horizon / period)], dtype=float)
            near = held > times[0] - 5.0
            sticks = held[near], commands.values[1:][near]
            first, last = (
                simulated_drive(one, drive.states[k], sticks, times).states[-1, 3:]
                for one in (model, other)
            )
            errors.append(last - first)
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    # the chain's constants have errors of a millisecond or a thousandth: they add little
    found = [need.width(model.covariance) / NORMAL_95 for need in needs]
    assert found == pytest.approx(rms, rel=0.25)


def test_parts_are_what_exact_knowledge_takes_away():
    rng = np.random.default_rng(2)
    root = rng.normal(size=(4, 4))
    covariance = root @ root.T
    need = Need(Use.CONTROL, "sum", rng.normal(size=(3, 4)), 1.0)
    known = covariance - np.outer(covariance[:, 1], covariance[1]) / covariance[1, 1]
    expected = 1.0 - (need.width(known) / need.width(covariance)) ** 2
    assert need.parts(covariance)[1] == pytest.approx(expected)


def test_parameters_of_a_need_that_is_not_met_are_not_known():
    model = known_boat(0.01, Y=0.4)
    needs = needs_of(model, ALL)
    states = {one.name: one for one in parameter_states(model, needs)}
    worst = max(need.ratio(model.covariance) for need in needs)
    assert worst > 1.0
    assert not states["Y_F"].known
    assert NORMAL_95 * states["Y_F"].error / worst == pytest.approx(states["Y_F"].needed, rel=0.2)
    assert states["X_F"].known
    assert states["X_F"].needed <= GAIN_KNOWN * 0.14 + 1e-12


def test_every_parameter_of_a_sharp_model_is_known():
    model = known_boat(0.001)
    assert all(one.known for one in parameter_states(model, needs_of(model, ALL)))


def test_without_a_model_nothing_is_enough():
    verdict = Enough()
    assert {one.level for one in verdict.update(3.0, None)} == {"not fit"}
    assert [one.share for one in verdict.states] == [0.0, 0.0, 0.0]
    assert not verdict.enough


def test_it_is_enough_when_all_uses_are_fit_for_some_updates():
    verdict, model = Enough(), known_boat(0.01)
    verdict.update(20.0, model)
    assert {one.level for one in verdict.states} == {"fit"}
    assert [one.share for one in verdict.states] == [1.0, 1.0, 1.0]
    verdict.update(25.0, model)
    assert not verdict.enough
    verdict.update(20.0 + STEADY_SECONDS, model)
    assert verdict.enough
    verdict.update(31.0, known_boat(0.01, N=0.5))
    assert not verdict.enough
    verdict.update(32.0, model)
    assert not verdict.enough  # it begins anew


def test_it_is_not_enough_before_the_drive_gives_a_model():
    verdict, model = Enough(), known_boat(0.002)
    for t in (1.0, 6.0, 12.0):
        states = verdict.update(t, model, whole=False)
        assert not verdict.enough
        assert all(one.level == "limited" and "too short" in one.reason for one in states)
    verdict.update(13.0, model)
    assert verdict.enough


def test_a_use_that_was_not_chosen_does_not_matter():
    model = known_boat(0.01, X=0.3)
    odometry, control = Enough([Use.ODOMETRY]), Enough([Use.CONTROL])
    assert [one.level for one in odometry.update(1.0, model)] == ["fit"]
    assert [one.level for one in control.update(1.0, model)] == ["not fit"]
    assert "surge" in control.states[0].reason
    assert 0.4 < control.states[0].share < 1.0


def test_predictions_that_are_worse_than_expected_are_not_enough():
    model, verdict = known_boat(0.01), Enough([Use.ODOMETRY])
    for rms, level in [(0.010, "fit"), (0.015, "limited"), (0.030, "not fit")]:
        wrong = PredictionState("surge", rms, 0.010, 0.05)
        assert verdict.update(1.0, model, [wrong])[0].level == level
    assert "errors 1 s ahead are 3.00 times those that the model states" in verdict.states[0].reason


def test_errors_that_are_tiny_beside_the_motion_need_no_comparison():
    verdict = Enough((Use.ODOMETRY,))
    verdict.update(0.0, known_boat(0.01), [PredictionState("surge", 3e-5, 1e-6, 0.1)])
    assert verdict.states[0].level == "fit"
    verdict.update(1.0, known_boat(0.01), [PredictionState("surge", 3e-3, 1e-4, 0.1)])
    assert verdict.states[0].level == "not fit"


def test_an_unstable_model_is_fit_for_nothing():
    model = known_boat(0.01)
    pushed = np.where(np.arange(11) == model.parameters.index("X_uu"), 5.0, model.coefficients)
    states = Enough().update(1.0, replace(model, coefficients=pushed))
    assert {one.level for one in states} == {"not fit"}
    assert "unstable" in states[0].reason


def test_disturbances_beyond_the_limit_are_stated_and_no_reason_to_drive_on():
    process = replace_process(known_boat(0.01), 3.0)
    needs = needs_of(process, [Use.SIMULATION])
    assert any(need.beyond for need in needs)
    state = Enough([Use.SIMULATION]).update(1.0, process)[0]
    assert state.level == "limited"
    assert "more driving does not help" in state.reason


def replace_process(model, disturbance):
    """The model with a disturbance force [m/s^2, rad/s^2] of this size."""
    from msgspec import structs

    process = structs.replace(
        model.noise.process, disturbance_linear=disturbance, disturbance_yaw=disturbance, memory=2.0
    )
    return replace(model, noise=structs.replace(model.noise, process=process))
