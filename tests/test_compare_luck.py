# SPDX-License-Identifier: MIT
"""Verdicts of `compare` that luck, a bound, or another method would make false."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import TABLE_II, make_model
from estimates import estimated
from scipy import stats

from seatrial.boat.findings import FindingKind, finding_of
from seatrial.boat.schema import EstimatorEntry, Integration, RecordingEntry, SourceEntry
from seatrial.evaluation.comparison.compare import compare
from seatrial.evaluation.comparison.console import comparison_text
from seatrial.evaluation.comparison.parameters import pairs, views
from seatrial.evaluation.comparison.prediction import beyond_same_boat
from seatrial.evaluation.comparison.significance import same_boat_errors
from seatrial.simulation.trials import plant_model
from tests.boats.motions import recorded, states_at
from tests.boats.plans import driven_by, planned

TRUTH = TABLE_II["AF"]


def test_what_one_of_two_estimates_of_a_boat_predicts_better_is_as_expected(mp):
    """e_A' Q e_A - e_B' Q e_B of errors drawn, against mean and variance by the difference alone."""
    rng = np.random.default_rng(5)
    root = rng.normal(size=(11, 4))
    form = root @ root.T
    truth = make_model(mp, TRUTH).coefficients
    scores = []
    for _ in range(500):
        a, b = estimated(mp, TRUTH, rng, 0.02), estimated(mp, TRUTH, rng, 0.05)
        seen = views(a, b)
        mean, variance = same_boat_errors(a, b, seen, pairs(a, b, seen, {})).difference(
            (form, form)
        )
        own, other = a.coefficients - truth, b.coefficients - truth
        scores.append((own @ form @ own - other @ form @ other - mean) / np.sqrt(variance))
    assert stats.kstest(scores, "norm").pvalue > 0.001


def test_given_models_leave_nothing_to_luck(mp):
    a, b = (unsure(make_model(mp, {**TRUTH, "X_u": x}), 0.0) for x in (-0.2, -0.3))
    seen = views(a, b)
    found = same_boat_errors(a, b, seen, pairs(a, b, seen, {})).difference((np.eye(11), np.eye(11)))
    assert found == (0.0, 0.0)


@pytest.fixture(scope="module")
def drive(mp):
    """A boat, and one with a tenth less drag and thrust; a recording of the latter."""
    plan = planned("paper-like", "S7")
    other = planned(plan, coefficients={n: 0.9 * v for n, v in plan.plant.coefficients.items()})
    (recording,) = driven_by(other, mp)
    step = Integration("runge-kutta", 1 / 30)
    a, b = (replace(plant_model(one, mp), integration=step) for one in (plan, other))
    return a, b, recording


def unsure(model, size):
    """As if all of it were known to `size` of itself."""
    both = np.concatenate([model.coefficients, model.constants])
    return replace(model, covariance=np.diag(np.square(size * both)))


@pytest.mark.system
def test_a_better_prediction_within_the_estimates_errors_is_no_change(drive):
    a, b, record = drive
    found = compare(unsure(a, 0.1), unsure(b, 0.1), [record])
    assert set(found.better["1"].values()) == {"B"}
    assert beyond_same_boat(found.ahead[-1].axes) == set()
    text = comparison_text(found)
    assert "two estimates of one unchanged boat may differ as much, so this shows no change" in text
    assert "matters" not in text
    sharp = compare(unsure(a, 1e-3), unsure(b, 1e-3), [record])
    assert beyond_same_boat(sharp.ahead[-1].axes) == {"u", "v", "r"}
    assert "=> the change matters for prediction: B is better in surge" in comparison_text(sharp)


def test_a_difference_that_a_bound_hides_is_named_in_the_verdict(mp):
    a = b = estimated(mp, TRUTH, 1)
    said = np.array([0.0 if name == "X_uu" else 1.0 for name in a.values])
    ended = finding_of(FindingKind.AT_BOUND, "X_uu", bound=0.0)
    entry = EstimatorEntry("output-error", findings=[ended])
    a = replace(
        a, coefficients=np.where(said > 0, a.coefficients, 0.0), covariance=a.covariance * np.outer(said, said),
        estimator=entry,
    )  # fmt: skip
    text = comparison_text(compare(a, b))
    assert "No significant difference in what can be tested; jointly" in text
    (line,) = [
        t for t in text.splitlines() if t.startswith("Not tested, and may differ: X_uu (0 in A")
    ]
    assert line.endswith("at its bound, where B is 49 of its standard errors away).")


def test_models_of_the_same_recordings_tell_of_no_change(mp):
    """Half of all drag and thrust by another method is no other mass."""
    a = unsure(make_model(mp, TRUTH), 0.01)
    b = unsure(make_model(mp, {n: 0.5 * v for n, v in TRUTH.items()}), 0.01)
    entries = tuple(
        (RecordingEntry(n, 60.0, 0.0, [SourceEntry(f"{n}.bag", n)]),) for n in ("S1", "S2")
    )
    a = replace(a, recordings=entries[0])
    text = comparison_text(compare(a, replace(b, recordings=entries[1])))
    assert "as 100 % more mass" in text
    found = compare(a, replace(b, recordings=entries[0]))
    assert found.same_data
    text = comparison_text(found)
    assert "any difference comes from how they were identified" in text
    for claim in ("mass", "drag or thrust", "significant differences are real"):
        assert claim not in text


def test_an_axis_that_both_predict_exactly_is_no_change(mp):
    """A boat that only surges, without noise: of sway and yaw both are right, by as much as nothing."""
    straight = {**TRUTH, "N_ud": 0.0, "N_uu": 0.0}
    a, b = (unsure(make_model(mp, {**straight, "X_u": x}), 0.02) for x in (-0.2, -0.4))
    begin = np.arange(0.0, 120.0, 0.5)
    values = np.zeros((len(begin), 3))
    values[:, 0] = np.sign(np.sin(0.4 * begin)) * (1.0 + (begin > 60.0)) / 2.0
    t = np.arange(0.0, 119.0, 0.1)
    eta = states_at(a, t, begin, values)[:, :3]
    recording = recorded("line", mp, (t, eta), (begin, values))
    found = compare(a, b, [recording])
    assert found.better["1"] == {"u": "A", "v": None, "r": None}


def test_what_is_sure_but_next_to_nothing_hardly_matters(drive):
    """Two models that are known exactly: a hundredth of drag and thrust is no reason to identify again."""
    _, boat, recording = drive
    a, b = (unsure(replace(boat, coefficients=boat.coefficients * f), 1e-9) for f in (1.03, 1.02))
    found = compare(a, b, [recording])
    assert "B" in found.better["1"].values()
    said = comparison_text(found)
    assert "significant, but less than 0.5 % of the error, which is negligible" in said
    assert "the change matters" not in said
