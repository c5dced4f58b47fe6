# SPDX-License-Identifier: MIT
"""What a model is fit for: every criterion at both sides of its limits."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import TABLE_II, make_model

from seatrial.boat.physics import axis_physics
from seatrial.boat.schema import ChainGroup, EnvelopeEntry
from seatrial.evaluation.scores import AxisScore, PooledScore, RecordingScore, Scores
from seatrial.report.evidence.verdict import use_text
from seatrial.util.statistics import NORMAL_95
from seatrial.workflow.fitness import Criterion, Level, Reason, Use, fitness, resolved_excess

FLOOR, STILL = 0.01, 0.1  # [m/s]


def axis(excess, expected=1.0, floor=FLOOR):
    """A score whose excess over the floor is this share of constant velocity's; `expected`: RMS over it."""
    own = excess * np.sqrt(STILL**2 - floor**2)
    rms = float(np.hypot(own, floor))
    return AxisScore(
        rms, STILL, rms / STILL, floor, rms / expected, 0.0, float(own), 0.0, 3.0, None, None, None, None, 0.0,
    )  # fmt: skip


def scores(near=None, far=None, *, seen=False):
    good = dict.fromkeys("uvr", axis(0.2))
    rows = [(1.0, good | (near or {})), (5.0, good | (far or {}))]
    one = RecordingScore("S7", 100.0, 9, 1.0, seen, None, rows[0][1])
    pooled = [PooledScore(h, 10, "filter", 1, 9, s) for h, s in rows]
    return Scores("scores 6", "boat", "output-error", 1.0, [one], None, pooled, "", "smoothed")


def known(vehicle, errors):
    """A model whose coefficients have these relative standard errors; the others one of 1 %."""
    model = make_model(vehicle, TABLE_II["MP"])
    names = model.structure.coefficients
    sizes = np.array([errors.get(n, 0.01) * abs(model.values[n]) for n in names])
    covariance = np.zeros_like(model.covariance)
    covariance[: len(names), : len(names)] = np.diag(sizes**2)
    return replace(model, covariance=covariance)


def of(use, model, found):
    return next(one for one in fitness(model, found) if one.use is use)


@pytest.fixture
def good(mp):
    return known(mp, {})


@pytest.fixture
def delayed(mp):
    return mp.with_chain([ChainGroup(latency=0.1, lag=0.1)])


@pytest.mark.parametrize(
    ("excess", "level"), [(0.49, Level.FIT), (0.51, Level.LIMITED), (0.81, Level.NOT_FIT)]
)
def test_a_simulation_is_judged_by_error_growth_at_the_longest_horizon(good, excess, level):
    one = of(Use.SIMULATION, good, scores(far={"v": axis(excess)}))
    assert one.level is level
    assert (one.reason.criterion, one.reason.subject) == (Criterion.GROWTH, "sway")
    assert one.reason.value == pytest.approx(excess)
    assert one.reason.horizon == 5.0
    assert of(Use.SIMULATION, good, scores(near={"v": axis(excess)})).level is Level.FIT


def test_an_unstable_model_is_fit_for_nothing_that_integrates_it(mp):
    unstable = make_model(mp, TABLE_II["MP"] | {"X_u": 2.0, "X_uu": 5.0})
    for use in (Use.SIMULATION, Use.CONTROL):
        one = of(use, unstable, scores())
        assert (one.level, one.reason.criterion) == (Level.NOT_FIT, Criterion.UNSTABLE)


@pytest.mark.parametrize(
    ("width", "level"), [(0.24, Level.FIT), (0.26, Level.LIMITED), (0.51, Level.NOT_FIT)]
)
def test_a_controller_needs_the_gains_and_the_damping(delayed, width, level):
    one = of(Use.CONTROL, known(delayed, {"Y_F": width / NORMAL_95}), scores())
    assert one.level is level
    assert (one.reason.criterion, one.reason.subject) == (Criterion.GAIN, "sway gain")
    assert one.reason.value == pytest.approx(width, rel=1e-6)


@pytest.mark.parametrize(
    ("share", "level"), [(0.09, Level.FIT), (0.11, Level.LIMITED), (0.31, Level.NOT_FIT)]
)
def test_a_controller_needs_the_delay(delayed, share, level):
    """Latency and lag, of opposite errors: only their sum counts."""
    model = known(delayed, {})
    rise = min(one.rise_time for one in axis_physics(model))
    error = share * rise / NORMAL_95
    covariance, n = model.covariance.copy(), len(model.coefficients)
    covariance[n:, n:] = np.array([[5.0, -4.0], [-4.0, 4.0]]) * error**2  # of the sum: error^2
    one = of(Use.CONTROL, replace(model, covariance=covariance), scores())
    assert (one.level, one.reason.criterion) == (level, Criterion.DELAY)
    assert one.reason.value == pytest.approx(share, rel=1e-6)


def test_two_uncertain_drag_terms_may_make_a_certain_damping(delayed):
    """X_u and X_uu are 60 % off each, their sum at the envelope's speed 2 %."""
    model = replace(known(delayed, {}), envelope=EnvelopeEntry({"u": (-0.2, 0.3)}, {}))
    names = model.parameters
    speed = max(map(abs, model.envelope.speeds["u"]))
    weights = {"X_u": 1.0, "X_uu": speed}
    total = sum(w * model.values[n] for n, w in weights.items())
    covariance = model.covariance.copy()
    i, j = names.index("X_u"), names.index("X_uu")
    a, b = 0.6 * abs(model.values["X_u"]), 0.6 * abs(model.values["X_u"]) / speed
    error = 0.02 * abs(total)
    mixed = (error**2 - a**2 - (speed * b) ** 2) / (2.0 * speed)
    covariance[i, i], covariance[j, j] = a**2, b**2
    covariance[i, j] = covariance[j, i] = mixed
    correlated = replace(model, covariance=covariance)
    apart = replace(model, covariance=np.diag(np.diag(covariance)))
    assert of(Use.CONTROL, correlated, scores()).level is Level.FIT
    one = of(Use.CONTROL, apart, scores())
    assert (one.reason.criterion, one.reason.subject) == (Criterion.GAIN, "surge damping")
    assert one.reason.value == pytest.approx(NORMAL_95 * np.hypot(a, speed * b) / abs(total))


def test_a_model_without_a_delay_is_limited_for_control(mp):
    one = of(Use.CONTROL, known(mp, {}), scores())
    assert (one.level, one.reason.criterion) == (Level.LIMITED, Criterion.NO_DELAY)


@pytest.mark.parametrize(
    ("ratio", "level"), [(1.2, Level.FIT), (1.3, Level.LIMITED), (2.1, Level.NOT_FIT)]
)
def test_odometry_needs_a_filter_that_is_consistent(good, ratio, level):
    one = of(Use.ODOMETRY, good, scores(near={"r": axis(0.2, expected=ratio)}))
    assert one.level is level
    if level is not Level.FIT:
        assert (one.reason.criterion, one.reason.subject) == (Criterion.CONSISTENCY, "yaw")
    assert one.reason.limit == (1.25 if one.reason.criterion is Criterion.CONSISTENCY else 0.8)


@pytest.mark.parametrize(
    ("interval", "parameters", "level"),
    [
        # few blocks have the error: by chance it may be the expected one
        ((0.006, 0.05), 0.0, Level.LIMITED),
        ((0.015, 0.05), 0.0, Level.NOT_FIT),
        # coefficients that are off by two standard errors explain it
        ((0.015, 0.05), 0.012, Level.LIMITED),
    ],
)
def test_an_error_that_may_be_the_expected_one_does_not_contradict_a_filter(
    good, interval, parameters, level
):
    row = msgspec.structs.replace(
        axis(0.2, expected=2.5), rms_interval=interval, parameter_rms=parameters
    )
    found = of(Use.ODOMETRY, good, scores(near={"r": row}))
    assert found.level is level
    assert found.reason.value == pytest.approx(2.5, rel=0.01)  # it is shown as it is


def test_odometry_is_judged_by_predictions_with_the_disturbance(good):
    found = scores(near={"r": axis(0.2, expected=2.5)})
    with_disturbance = [
        msgspec.structs.replace(one, start="odometry", scores=dict.fromkeys("uvr", axis(0.1)))
        for one in found.pooled
    ]
    found = msgspec.structs.replace(found, pooled=[*found.pooled, *with_disturbance])
    assert of(Use.ODOMETRY, good, found).level is Level.FIT
    far = scores(far={"u": axis(0.9)})
    far = msgspec.structs.replace(far, pooled=[*far.pooled, *with_disturbance])
    assert of(Use.SIMULATION, good, far).level is Level.NOT_FIT


def test_odometry_needs_a_prediction_that_beats_constant_velocity(good):
    one = of(Use.ODOMETRY, good, scores(near={"u": axis(1.1)}))
    assert (one.level, one.reason.criterion) == (Level.NOT_FIT, Criterion.BASELINE)
    assert (
        "surge: error 1 s ahead is 1.10 of constant velocity's (fit: up to 0.8)"
        in one.reason.text()
    )


def test_a_filter_without_process_noise_states_no_error(good):
    none = msgspec.structs.replace(axis(0.2), expected_rms=None, parameter_rms=None)
    one = of(Use.ODOMETRY, good, scores(near={"u": none}))
    assert (one.level, one.reason.criterion) == (Level.LIMITED, Criterion.NO_EXPECTED)


def test_scores_on_the_identification_data_are_no_proof(good):
    for use in (Use.SIMULATION, Use.ODOMETRY):
        one = of(use, good, scores(seen=True))
        assert (one.level, one.reason.criterion) == (Level.LIMITED, Criterion.SEEN)


def test_without_a_prediction_nothing_is_proved(good):
    none = msgspec.structs.replace(scores(), pooled=[])
    for use in (Use.SIMULATION, Use.ODOMETRY):
        assert of(use, good, none).reason.criterion is Criterion.NOT_PREDICTED
        assert of(use, good, none).level is Level.NOT_FIT


def test_at_the_floor_there_is_no_excess():
    assert resolved_excess(axis(0.0)) == 0.0
    assert resolved_excess(axis(0.3)) == pytest.approx(0.3)


def test_thrust_that_is_backwards_is_not_fit_for_control(good):
    """As with mirrored thrusters: everything else is known as well as before."""
    assert of(Use.CONTROL, good, scores()).reason.criterion is not Criterion.BACKWARD
    turned = good.coefficients.copy()
    turned[good.structure.coefficients.index("N_F")] *= -1.0
    found = of(Use.CONTROL, replace(good, coefficients=turned), scores())
    assert found.level is Level.NOT_FIT
    assert found.reason.criterion is Criterion.BACKWARD
    assert found.reason.subject == "N_F"
    assert found.reason.text() == "N_F is negative: signs, thruster angles or axes are wrong"


@pytest.mark.parametrize(
    ("criterion", "value", "words"),
    [
        (Criterion.GROWTH, 0.0034, "surge: error grows to 0.0034 of constant velocity's 5 s ahead (fit: up to 0.25)"),
        (Criterion.GROWTH, 0.357, "surge: error grows to 0.36 of constant velocity's 5 s ahead (fit: up to 0.25)"),
        (Criterion.GROWTH, 0.0, "surge: the error 5 s ahead is pose noise alone; a perfect model has the same"),
        (Criterion.GAIN, 0.0034, "surge is known to ± 0.34 % (95 %; fit: up to 25 %)"),
        (Criterion.GAIN, 0.357, "surge is known to ± 36 % (95 %; fit: up to 25 %)"),
    ],
)  # fmt: skip
def test_only_what_is_0_is_shown_as_0(criterion, value, words):
    assert Reason(criterion, "surge", value, 0.25, 5.0).text() == words


def test_what_is_not_fit_says_what_lifts_it(good):
    """Errors 1.3 times the stated ones are covered by a covariance of 1.3² times; the use that is fit asks nothing."""
    one = of(Use.ODOMETRY, good, scores(near={"r": axis(0.2, expected=1.3)}))
    assert one.action == (
        "identify also from recordings like this one, so that the process noise covers such errors, or "
        "multiply the covariance that the filter states by 1.7"
    )
    assert of(Use.SIMULATION, good, scores()).action == ""
    for criterion in Criterion:
        said = Reason(criterion, "sway", 1.5, 1.0, 1.0).action()
        assert said and "{" not in said and not said.endswith(".")


@pytest.mark.parametrize(
    ("ratio", "expected"),
    [(1.0, "Use it within the speeds"), (1.3, "For odometry (limited): identify also"),
     (2.5, "For odometry (not fit): identify also")],
)  # fmt: skip
def test_a_model_is_to_be_used_only_for_what_it_is_fit_for(delayed, ratio, expected):
    good = known(delayed, {})
    covariance = good.covariance.copy()
    covariance[-2:, -2:] = np.diag([1e-10, 1e-10])
    good = replace(good, covariance=covariance)
    found = fitness(good, scores(near={"r": axis(0.2, expected=ratio)}))
    said = use_text(found)
    assert expected in said
    assert ("Use it for simulation and control within the speeds" in said) == (ratio > 1.25)


def test_a_model_that_is_fit_for_nothing_is_not_to_be_used(mp):
    unstable = make_model(mp, TABLE_II["MP"] | {"X_u": 2.0, "X_uu": 5.0})
    said = use_text(fitness(unstable, scores(near={"r": axis(0.2, expected=2.5)})))
    assert "se it" not in said and said.startswith("For simulation (not fit): check the vehicle")
