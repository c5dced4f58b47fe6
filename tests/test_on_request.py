# SPDX-License-Identifier: MIT
"""Bootstrap, profile likelihood, accuracy against length: against the sandwich and closed forms."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import survey_boat
from survey_boat import both

import seatrial
from seatrial.boat.findings import FindingKind, finding_of, of_kinds
from seatrial.identification.estimator import OutputErrorSettings, fit
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.methods import identify_with_fit
from seatrial.identification.on_request import accuracy_tables, profile_text
from seatrial.identification.uncertainty import profile as profile_module
from seatrial.identification.uncertainty import record_length as minutes_module
from seatrial.identification.uncertainty.bootstrap import bootstrap, intervals
from seatrial.identification.uncertainty.covariance import at_bounds, sandwich_covariance
from seatrial.identification.uncertainty.profile import profile
from seatrial.identification.uncertainty.record_length import accuracy_by_length, record_length_text
from seatrial.util.errors import IdentificationError
from tests.boats.plans import driven_by, planned

SETTINGS = OutputErrorSettings(block=5.0, select_stages=False)  # 48 blocks


@pytest.fixture(scope="module")
def boat():
    vehicle = seatrial.load_vehicle("mallard-af")
    return vehicle, driven_by(planned("hard", "S7"), vehicle)[0].cut(None, 240.0)


@pytest.fixture(scope="module")
def whole(boat):
    return fit([boat[1]], boat[0], settings=SETTINGS)


@pytest.mark.system
def test_the_bootstrap_spreads_as_the_sandwich_says(whole):
    """From 80 replicates a spread is known to 8 %, from 48 blocks either to 10 % or worse."""
    draws = bootstrap(whole, 80, seed=1)
    assert draws.shape == (80, len(whole.names))
    own = np.sqrt(np.diag(whole.covariance))
    ratio = draws.std(axis=0, ddof=1) / own
    assert np.median(ratio) == pytest.approx(1.0, abs=0.2)
    assert 0.6 < ratio.min() < ratio.max() < 1.6
    found = whole.theta[list(whole.problem.free)]
    assert (np.abs(draws.mean(axis=0) - found) < 0.6 * own).all()
    low, high = intervals(draws).T
    assert ((low < found) & (found < high)).all()


@pytest.mark.parametrize("replicates", [40, 60, 200])
def test_percentile_intervals_hold_a_further_draw_as_often_as_they_say(replicates):
    rng = np.random.default_rng(2)
    found = intervals(rng.normal(size=(replicates, 4000)))
    further = rng.normal(size=4000)
    held = np.mean((found[:, 0] < further) & (further < found[:, 1]))
    assert held == pytest.approx(0.95, abs=0.012)  # 3.5 standard errors


def test_the_bootstrap_is_the_same_for_the_same_seed_whatever_the_threads_do(whole):
    first, again = bootstrap(whole, 4, seed=3), bootstrap(whole, 4, seed=3)
    np.testing.assert_array_equal(first, again)
    assert not np.allclose(first, bootstrap(whole, 4, seed=4), rtol=1e-6)


def test_variances_of_a_tied_constant_are_large_and_those_of_others_as_without_it():
    """A constant of the chain that only scales a coefficient, as a power does at one speed."""
    rng = np.random.default_rng(6)
    scores = rng.normal(size=(60, 3)) * [1.0, 30.0, 0.2]
    tied = np.column_stack([scores, -0.37 * scores[:, 2]])

    def covariance(scores):
        p = scores.shape[1]
        problem = SimpleNamespace(
            prior=None, free=tuple(range(p)), n_coefficients=3, bounds=(np.full(p, -9.0), np.full(p, 9.0)),
            names=tuple("abcd"[:p]),
        )  # fmt: skip
        runs = SimpleNamespace(problem=problem, scores=scores, information=scores.T @ scores)
        return sandwich_covariance(SimpleNamespace(theta=np.zeros(p), runs=runs))

    alone, both = covariance(scores), covariance(tied)
    np.testing.assert_allclose(both[:2, :2], alone[:2, :2], rtol=0.1)  # other shares of the scatter
    assert (np.diag(both)[2:] > 1e4 * alone[2, 2]).all()
    sum_of_both = np.array([0.0, 0.0, 1.0, -0.37])  # what the data do know
    assert sum_of_both @ both @ sum_of_both == pytest.approx(alone[2, 2], rel=0.1)
    least, *_, most = np.linalg.eigvalsh(both)
    assert least > -1e-12 * most


def test_minutes_are_not_said_of_what_ended_at_a_bound(whole, monkeypatch):
    names = list(whole.names)
    lag = np.array([name == "lag" for name in names])
    monkeypatch.setattr(minutes_module, "at_bounds", lambda _: lag)
    found = accuracy_by_length(replace(whole, covariance=np.where(lag, 0.0, whole.covariance)))
    assert found.names == tuple(name for name in names if name != "lag")
    own = np.sqrt(np.diag(whole.covariance))[~lag]
    np.testing.assert_allclose(found.errors[-1], own, rtol=1e-9)


def test_a_nearly_quadratic_profile_is_the_normal_interval(whole):
    found = profile(whole, "Y_F")
    width = 1.96 * whole.model().standard_errors["Y_F"]
    assert found.value == pytest.approx(whole.model().values["Y_F"])
    assert found.high - found.value == pytest.approx(width, rel=0.1)
    assert found.value - found.low == pytest.approx(width, rel=0.1)


def test_a_lopsided_profile_gives_a_lopsided_interval(whole, monkeypatch):
    """Root of the cost's rise d / (1 + d / 4) upwards, 1.96 at 3.84; downwards it stays below 1.5."""

    def rise(fit, k, scale, distance):
        far = abs(distance)
        return far / (1 + far / 4) if distance > 0 else 1.5 * np.tanh(far)

    monkeypatch.setattr(profile_module, "_rise", rise)
    found = profile(whole, "N_rr")
    end = 1.96 / (1 - 1.96 / 4)
    assert (found.high - found.value) / found.error == pytest.approx(end, rel=0.03)
    assert found.low == -np.inf


def test_a_profile_ends_at_the_bound_within_which_is_sought(whole, monkeypatch):
    monkeypatch.setattr(
        profile_module, "_rise", lambda fit, k, scale, distance: 0.001 * abs(distance)
    )
    found = profile(whole, "lag")
    assert found.low == pytest.approx(0.002)
    assert found.high == np.inf or found.high == pytest.approx(3.0)


@pytest.fixture(scope="module")
def quick():
    """A boat without lag: it ends at its bound."""
    return [
        f
        for seed in (6, 8, 14)
        if "lag" in at_bound(f := fit([without_lag(seed)], survey_boat.boat(NO_EDGES, bow=True)))
    ]


NO_EDGES = [{"dead_zone": {"forward": 0.0, "reverse": 0.0}}]


def without_lag(seed):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(survey_boat, "LAG", 0.002)
        return survey_boat.driven({}, [both, both, both], bow=True, seconds=120.0, seed=seed)[1]


def at_bound(found):
    held = at_bounds(Point(found.theta, found.noise, found.runs))
    return [name for name, there in zip(found.names, held, strict=True) if there]


def test_a_profile_beside_a_bound_is_as_wide_as_the_others_let_it_be(quick):
    """Latency may fall as far as the lag may rise, though that ended at its least."""
    assert quick
    for found in quick:
        latency = profile(found, "latency")
        assert latency.low < 0.04 < survey_boat.LATENCY < latency.high
        # the standard error, which has no sides, is between the two
        assert latency.high - latency.value < 0.2 * latency.error
        assert latency.error == pytest.approx(0.5 * (latency.value - latency.low), rel=0.15)


def test_what_ended_a_rounding_off_its_bound_is_at_it(quick):
    """A step of all parameters into their bounds may end so."""
    assert quick
    for found in quick:
        theta = found.theta.copy()
        lag = found.problem.free[found.names.index("lag")]
        theta[lag] = np.nextafter(theta[lag], np.inf)
        beside = sandwich_covariance(Point(theta, found.noise, found.runs))
        there = sandwich_covariance(Point(found.theta, found.noise, found.runs))
        np.testing.assert_allclose(beside, there, rtol=1e-6, atol=1e-15)


def test_the_note_of_a_bound_names_the_bound(quick):
    """What ended a ten-thousandth of its range off counts as at it, too."""
    assert quick
    ended = [f for found in quick for f in of_kinds(found.findings, FindingKind.AT_BOUND)]
    assert finding_of(FindingKind.AT_BOUND, "lag", bound=0.002) in ended
    limits = {end for found in quick for ends in found.problem.bounds for end in ends}
    assert {finding.number("bound") for finding in ended} <= limits


def test_a_profile_of_what_ended_at_its_bound_goes_from_there(quick):
    for found in quick:
        lag = profile(found, "lag")
        assert lag.error == 0.0
        assert lag.low == lag.value == pytest.approx(0.002)
        assert 0.005 < lag.high < 0.05
        assert "at its bound" in profile_text([lag])


def test_accuracy_against_length_is_that_of_a_shorter_recording(boat, whole):
    """After half of it: as the information of that half alone, searched anew, has it."""
    found = accuracy_by_length(whole)
    half = boat[1].cut(None, boat[1].duration / 2)
    alone = fit([half], boat[0], settings=OutputErrorSettings(block=2.5, select_stages=False))
    assert alone.names == found.names
    np.testing.assert_allclose(found.errors[-1], np.sqrt(np.diag(whole.covariance)), rtol=1e-6)
    excess = found.errors[-1] / np.sqrt(np.diag(np.linalg.inv(whole.runs.information)))
    shorter = np.sqrt(np.diag(np.linalg.inv(alone.runs.information)))
    np.testing.assert_allclose(found.errors[1] / excess, shorter, rtol=0.35)
    assert (np.diff(found.errors, axis=0) < 0).all()


def test_with_one_recording_half_the_error_takes_three_times_as_long_more(whole):
    found = accuracy_by_length(whole)
    np.testing.assert_allclose(found.more[0], 3 * found.lengths[-1], rtol=1e-3)
    text = record_length_text(found)
    assert all(name in text for name in found.names)
    assert text.count("12.0 min like these") == len(found.names)


def test_the_tables_that_identify_shows_on_request(whole):
    text = accuracy_tables(whole, profiled=["lag"], lengths=True)
    assert text.splitlines()[0].split()[:3] == ["standard", "error", "after"]
    assert "profile likelihood" in text


def test_the_last_column_of_the_minutes_is_what_the_model_states(whole):
    wider = replace(whole, covariance=1.44 * whole.covariance)  # as other choices may find it
    lines = accuracy_tables(wider, lengths=True).splitlines()[1:]
    shown = {line.split()[0]: float(line.split()[4]) for line in lines}
    assert shown == {n: pytest.approx(wider.errors[n], rel=0.05) for n in whole.names}


def test_what_can_not_be_shown_is_refused_in_words(boat, whole):
    vehicle, recording = boat
    with pytest.raises(
        IdentificationError, match="--profile X_q: not an estimated parameter; estimated are X_u, "
    ):
        accuracy_tables(whole, profiled=["X_q"])
    with pytest.raises(IdentificationError, match="--bootstrap 5: an interval needs 40"):
        accuracy_tables(whole, replicates=5)
    _, none = identify_with_fit([recording], vehicle, method="equation-error")
    with pytest.raises(IdentificationError, match="belong to output-error; add --method"):
        accuracy_tables(none, lengths=True)


def test_the_solution_is_the_one_that_the_model_came_from(boat):
    """Nothing is searched again: its numbers are the model's to the last digit."""
    vehicle, recording = boat
    model, solution = identify_with_fit([recording], vehicle)
    assert solution is not None
    np.testing.assert_array_equal(solution.model().coefficients, model.coefficients)
    np.testing.assert_array_equal(solution.model().covariance, model.covariance)
