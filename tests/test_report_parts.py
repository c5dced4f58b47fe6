# SPDX-License-Identifier: MIT
"""What the report computes for itself: pooling, curves, agreement, intervals."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import steered_boat
from conftest import TABLE_II, make_model

import seatrial
from seatrial.boat.actuators import STARTS
from seatrial.boat.physics import axis_physics, driven
from seatrial.boat.schema import RecordingEntry
from seatrial.evaluation.pooled_scores import pooled, together
from seatrial.evaluation.prediction import predict
from seatrial.identification.uncertainty.identifiability import identifiability
from seatrial.report.evidence import advice
from seatrial.report.evidence import homogeneity as agreement
from seatrial.report.evidence.actuators import angle_curves, curves, step_responses
from seatrial.report.evidence.model_evidence import collect
from seatrial.report.evidence.physics import physics
from seatrial.report.evidence.runs import judged, thinned
from seatrial.report.figures.base import CYCLE, colour_of
from seatrial.report.figures.embed import decode, encode
from seatrial.report.figures.recorded import cells, timeline, tracks
from seatrial.report.sections.recorded import summary
from seatrial.simulation.plan import load_plan
from seatrial.simulation.trials import plant_model, simulate


@pytest.fixture(scope="module")
def trials(paper_mp):
    return {name: trial.recording for name, trial in paper_mp.items()}


@pytest.fixture(scope="module")
def model(paper_mp_model):
    return paper_mp_model


@pytest.fixture(scope="module")
def evidence(model, trials):
    return collect(model, [trials[n] for n in ("S1", "S2", "S3", "S7")], 1.0)


def test_recordings_together_score_as_all_their_errors_do(model, trials):
    parts = [predict(model, trials[n]) for n in ("S4", "S6", "S7")]
    whole = together(parts)
    errors = np.concatenate([p.errors for p in parts])
    assert np.array_equal(whole.errors, errors)
    assert np.all(np.diff(whole.index) > 0)
    weights = [len(p.t) for p in parts]
    squares = np.average([p.floor**2 for p in parts], axis=0, weights=weights)
    assert whole.floor == pytest.approx(np.sqrt(squares))
    ends = np.cumsum(weights)[:-1]
    assert np.all(np.diff(whole.index)[ends - 1] > whole.steps)  # no block reaches over


@pytest.mark.system
def test_horizons_are_those_of_validate(evidence, model, trials):
    fresh = judged(evidence.runs)
    assert [run.name for run in fresh] == ["S7-MP"]
    found = {
        (row.horizon, row.start): row.scores for row in pooled([run.assessment for run in fresh])
    }
    expected = seatrial.validate(model, [trials["S7"]]).recordings[0].horizons
    assert {(h.horizon, h.start) for h in expected} == set(found)
    for row in expected:
        assert found[row.horizon, row.start] == row.scores
    assert evidence.scores == seatrial.validate(
        model, [trials[n] for n in ("S1", "S2", "S3", "S7")], 1.0
    )


def test_a_straight_curve_past_its_edges_is_drawn_as_one(model):
    (curve,) = curves(model)
    assert curve.names == ("F_1", "F_2", "F_3", "F_4")
    edges = [
        model.constants[model.vehicle.constants.names.index(f"edge_{e}")]
        for e in ("forward", "reverse")
    ]
    x = curve.x
    expected = np.where(x > edges[0], (x - edges[0]) / (1 - edges[0]), 0.0)
    ratio = dict(zip(model.vehicle.constants.names, model.constants.tolist(), strict=True)).get(
        "reverse_ratio", 1.0
    )
    expected += np.where(x < -edges[1], ratio * (x + edges[1]) / (1 - edges[1]), 0.0)
    assert curve.y == pytest.approx(expected, abs=1e-9)
    assert np.all(curve.low <= curve.y + 1e-6)
    assert np.all(curve.y <= curve.high + 1e-6)
    assert (curve.high - curve.low).max() > 1e-5


def test_the_answer_to_a_step_has_its_latency_and_its_lag(mp):
    chain = plant_model(load_plan("paper-like"), mp)
    names = chain.vehicle.constants.names
    lag = chain.constants[names.index("lag")]
    latency = chain.constants[names.index("latency")] if "latency" in names else 0.0
    (found,) = step_responses(chain)
    assert found.names == ("F_u", "F_v", "F_r")
    expected = np.where(found.x > latency, 1.0 - np.exp(-(found.x - latency) / lag), 0.0)
    expected = np.clip(expected, 0.0, 1.0)
    assert found.y == pytest.approx(expected / expected[-1], abs=2e-3)
    assert np.array_equal(found.low, found.high)  # nothing was estimated
    assert STARTS["lag"] > 0


def test_an_angle_is_drawn_in_degrees_and_steps_at_full_thrust():
    """By hand: 35 deg with a trim of -4 and a dead zone of 0.08, which turns at 40 deg/s after 0.1 s."""
    model = steered_boat.known()
    ((thrust,), (angle,)) = curves(model), angle_curves(model)
    assert (thrust.names, angle.names) == (("motor",), ("helm",))
    assert thrust.y == pytest.approx(thrust.x)
    beyond = np.sign(angle.x) * np.maximum(np.abs(angle.x) - 0.08, 0.0) / 0.92
    assert angle.y == pytest.approx(-4.0 + 35.0 * beyond)
    motor, helm = step_responses(model)
    assert (motor.names, helm.names) == (("motor",), ("helm",))
    late = np.maximum(motor.x - 0.1, 0.0)
    assert motor.y == pytest.approx((1.0 - np.exp(-late / 0.3)) / (1.0 - np.exp(-late[-1] / 0.3)))
    angles = np.radians(-4.0 + np.minimum(40.0 * late, 35.0))
    start, end = np.sin(np.radians([-4.0, 31.0]))
    assert helm.y == pytest.approx((np.sin(angles) - start) / (end - start), abs=1e-9)


def test_a_step_response_shows_the_whole_stroke_of_a_slow_rudder():
    _, helm = step_responses(steered_boat.known({"rate_deg": 2.0}))
    assert helm.x[-1] > 0.1 + 35.0 / 2.0 and helm.y[helm.x < 17.5].max() < 0.999


def test_recordings_that_agree_are_not_told_apart_and_others_are():
    rng = np.random.default_rng(2)
    errors = np.full(8, 0.1)
    alike = agreement._row("X_u", 2.0, 2.0 * 0.1 * rng.normal(size=8), 2.0 * errors)
    assert alike.p > 0.05
    apart = agreement._row("X_u", 2.0, np.array([-1.0, 1.0] * 4), 2.0 * errors)
    assert apart.shifts[0] == pytest.approx(-0.5)
    assert apart.spread == pytest.approx(0.5)
    # Cochran's Q: 8 (0.5 / 0.1)^2 = 200 with 7 degrees of freedom
    assert apart.p < 1e-30
    silent = agreement._row("X_u", 2.0, np.array([0.1, np.nan]), np.array([0.1, np.inf]))
    assert silent.p is None
    assert np.isinf(silent.errors[1])


def test_recordings_of_one_boat_agree_and_one_of_another_does_not(evidence, model, trials, mp):
    found = agreement.homogeneity(evidence)
    assert found.recordings == ("S1-MP", "S2-MP", "S3-MP", "S7-MP")
    assert not found.inhomogeneous
    plan = load_plan("paper-like")
    plant = plant_model(plan, mp)
    heavy = replace(plant, coefficients=plant.coefficients / 1.2)
    other = next(iter(simulate(plan, mp, heavy))).recording
    odd = collect(model, [trials["S1"], replace(other, name="heavier")], 1.0)
    assert "X_F" in agreement.homogeneity(odd).inhomogeneous
    row = next(r for r in agreement.homogeneity(odd).rows if r.name == "X_F")
    assert row.shifts[1] == pytest.approx(1 / 1.2 - 1, abs=0.01)
    assert abs(row.shifts[0]) < 0.01


def test_intervals_of_the_boat_are_as_wide_as_its_coefficients_are_uncertain(mp):
    model = make_model(mp, TABLE_II["MP"], step=1 / 12)
    small = replace(model, covariance=model.covariance / 100.0)  # 1 % each
    surge = physics(small).axes[0]
    gain, drag, more = (model.values[n] for n in ("X_F", "X_u", "X_uu"))
    top = (drag + np.sqrt(drag**2 - 4 * more * gain)) / (-2 * more)
    assert surge.found.top_speed == pytest.approx(top, rel=1e-4)
    slope = -1.0 / (drag + 2 * more * top)  # of the top speed, by a change of the force
    change = slope * np.hypot(0.01 * gain, np.hypot(0.01 * drag * top, 0.01 * more * top**2))
    low, high = surge.top_speed
    assert (high - low) / 2 == pytest.approx(1.96 * change, rel=0.3)
    assert low < top < high
    assert physics(replace(model, covariance=0.0 * model.covariance)).axes[0].top_speed is None


def test_values_of_the_boat_are_within_their_own_intervals(mp):
    model = make_model(mp, TABLE_II["MP"], step=0.07713871722)
    known = replace(model, covariance=model.covariance / 1e4)  # 0.1 % each
    for one in physics(known).axes:
        for name in ("top_speed", "rise_time", "coast"):
            low, high = getattr(one, name)
            value = getattr(one.found, name)
            assert low < value < high and high - low < 0.01 * value


def test_how_often_drawn_coefficients_make_no_boat_is_told(mp):
    model = make_model(mp, TABLE_II["MP"], step=1 / 12)
    wide = np.diag(np.where(np.array(model.structure.coefficients) == "X_uu", 3.0, 1e-9) ** 2)
    found = physics(replace(model, covariance=wide))
    assert 0.1 < found.unstable_share < 0.45  # X_uu = -1.67 +- 3 is positive in 29 %
    assert not found.unstable


def test_start_and_stop_is_what_the_sanity_line_says(model):
    for one in axis_physics(model):
        t, v = driven(model, one.axis)
        on = t <= 120.0
        assert v[on][-1] == pytest.approx(one.top_speed)
        assert v[on][np.searchsorted(t[on], one.rise_time)] == pytest.approx(
            0.632 * one.top_speed, rel=0.05
        )
        coast = np.trapezoid(v[~on], t[~on])
        assert coast == pytest.approx(one.coast, rel=0.05)


def test_cells_count_every_second(evidence, model):
    runs = evidence.runs
    seconds = 0.0
    for trace in cells(model, runs, 0)["data"]:
        seconds += sum(float(text.removesuffix(" s")) for text in trace["text"])
    expected = sum(np.isfinite(r.measured[:, 0]).sum() * r.recording.period for r in runs)
    assert seconds == pytest.approx(expected, rel=0.02)
    assert [t["name"] for t in cells(model, runs, 0)["data"]] == ["identified from", "not seen"]


def test_the_timeline_has_every_gap_where_it_is(evidence):
    figure = timeline(evidence.runs)
    recorded = figure["data"][0]
    assert np.nanmax(recorded["x"]) == pytest.approx(
        max(r.recording.duration for r in evidence.runs)
    )
    gaps = next(t for t in figure["data"] if t["name"] == "no poses")
    begins = gaps["x"].reshape(-1, 3)[:, 0]
    expected = [
        f.start for r in evidence.runs for f in r.recording.faults if "no poses" in f.kind.value
    ]
    assert sorted(begins) == pytest.approx(sorted(expected))
    assert figure["layout"]["yaxis"]["ticktext"][0] == "S1-MP"


def test_up_to_twenty_one_tracks_look_different(evidence):
    looks = [colour_of(i) for i in range(3 * len(CYCLE))]
    assert len(set(looks)) == len(looks)
    assert len(tracks(evidence.runs)["data"]) == 4


def test_thinned_rows_keep_where_samples_begin_and_end():
    there = np.ones(100, dtype=bool)
    there[[33, 34, 71]] = False
    kept = thinned(there, 10)
    assert {0, 10, 32, 33, 34, 35, 70, 71, 72, 99} <= set(kept.tolist())
    assert len(kept) < 20
    assert np.array_equal(thinned(there, 1), np.arange(100))


def test_a_recording_that_is_too_short_is_kept_with_the_reason(model, trials):
    short = trials["S1"].cut(0.0, 0.8)
    found = collect(model, [trials["S7"].cut(0.0, 60.0), short], 1.0)
    runs = found.runs
    assert [run.tested for run in runs] == [True, False]
    assert "no two usable velocities 1 s apart" in runs[1].failure
    assert len(summary(found).rows) == 2


def test_the_verdict_counts_what_is_known(evidence, model):
    from seatrial.report.evidence.verdict import identified

    said = identified(evidence)
    names = identifiability(model).names
    constants = sum(n in model.vehicle.constants.names for n in names)
    assert f"{len(model.values)} coefficients and {constants} constants of the thrusters" in said
    assert "of these" in said


def test_a_column_over_decades_keeps_the_digits_of_its_small_numbers():
    """On a logarithmic axis they are as wide as the large ones."""
    wide = np.geomspace(0.05, 50.0, 200)
    np.testing.assert_allclose(decode(encode(wide)), wide, rtol=1e-3)
    narrow = np.linspace(-1.0, 1.0, 201)
    np.testing.assert_allclose(decode(encode(narrow)), narrow, atol=0.5e-4)
    assert encode(narrow)[0] == -4


def test_a_bias_is_no_open_issue_where_the_model_has_its_wind(model):
    """The model alone predicts without it: `auto` asked for the wind that it had estimated."""
    score = SimpleNamespace(bias=0.8, rms=1.0)
    run = SimpleNamespace(
        name="S1", tested=True, score=SimpleNamespace(scores=dict.fromkeys("uvr", score))
    )
    (said,) = advice._biased(model, run)
    assert said.startswith(
        "S1: the errors in surge, sway and yaw are biased. Possible causes: wind"
    )
    for effects, sentences in (({"wind_x": 0.03, "wind_y": 0.0}, 0), ({"current_x": 0.1}, 1)):
        known = replace(model, recordings=(RecordingEntry("S1", 100.0, effects=effects),))
        assert len(advice._biased(known, run)) == sentences
