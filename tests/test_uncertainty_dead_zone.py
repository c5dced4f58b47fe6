# SPDX-License-Identifier: MIT
"""Dead-zone edges are as uncertain as the likelihood says, not as its curvature at the best ones."""

from types import SimpleNamespace

import numpy as np
import pytest

from seatrial.identification.estimator import OutputErrorSettings, fit
from seatrial.identification.likelihood.linearised import Point
from seatrial.identification.uncertainty import dead_zone as kinks
from seatrial.identification.uncertainty.covariance import sandwich_covariance, with_lag_by_square
from seatrial.identification.uncertainty.profile import profile
from seatrial.util.statistics import NORMAL_95
from tests.boats.scenes import scenes, true_parameters, vehicle_of

EDGES = "edge_forward", "edge_reverse"


def found(scene, seed):
    chosen = scenes()[scene]
    vehicle = vehicle_of(chosen.allocations[0])
    settings = OutputErrorSettings(select_stages=False)
    return fit([t.recording for t in chosen.trials(seed).values()], vehicle, settings=settings)


def wider(result):
    """Standard errors over those without a look at the edges, by name."""
    at = Point(result.theta, result.noise, result.runs)
    plain = with_lag_by_square(at, sandwich_covariance(at))
    ratio = np.sqrt(np.diag(result.covariance) / np.diag(plain))
    return dict(zip(result.names, ratio, strict=True))


@pytest.mark.system
def test_between_equal_edges_the_likelihood_rises_sooner_than_its_curvature_says():
    result = found("hard MP pushed", 1005)
    ratio = wider(result)
    assert ratio["edge_forward"] < 0.8
    assert all(0.9 < r < 1.1 for name, r in ratio.items() if name not in EDGES)
    k = result.names.index("edge_forward")
    said = 2.0 * NORMAL_95 * np.sqrt(result.covariance[k, k])
    true = profile(result, "edge_forward")
    assert said == pytest.approx(true.high - true.low, rel=0.1)


@pytest.mark.system
def test_where_it_has_two_summits_the_interval_holds_both():
    result = found("hard MP pushed", 1013)
    ratio = wider(result)
    truth = true_parameters(scenes()["hard MP pushed"].plan, result.names)
    off = (result.theta[list(result.problem.free)] - truth) / np.sqrt(np.diag(result.covariance))
    for name in EDGES:
        k = result.names.index(name)
        assert abs(off[k]) < 2.0
        assert ratio[name] > 2.5  # the curvature knows of one summit


def test_where_the_likelihood_is_a_parabola_nothing_changes(monkeypatch):
    monkeypatch.setattr(kinks, "UNPROBED_EDGE", 0.0)  # or it is not even looked at
    assert all(abs(r - 1.0) < 0.05 for r in wider(found("hard MP", 1002)).values())


def test_where_nothing_can_be_looked_at_the_sandwich_stands(monkeypatch):
    monkeypatch.setattr(kinks, "UNPROBED_EDGE", 0.0)
    monkeypatch.setattr(kinks, "_profile", lambda *_: iter(()))
    assert all(abs(r - 1.0) < 1e-9 for r in wider(found("hard MP", 1002)).values())


def test_groups_whose_edges_hang_together_keep_a_covariance(monkeypatch):
    """What one group's likelihood takes away is not there for the next to be taken away again."""
    monkeypatch.setattr(kinks, "_groups", lambda _: iter([[0], [1]]))
    monkeypatch.setattr(kinks, "_line", lambda *_: None)
    monkeypatch.setattr(kinks, "_error", lambda _, error: 0.3 * error)
    error, together = (
        np.array([0.1, 0.2, 0.05]),
        np.array([[1, 0.95, 0.3], [0.95, 1, 0.3], [0.3, 0.3, 1]]),
    )
    before = together * np.outer(error, error)
    after = kinks.with_dead_zone_profile(
        Point(np.zeros(3), np.zeros(11), SimpleNamespace(problem=None)), before
    )
    assert np.linalg.eigvalsh(after)[0] > 0.0
    assert (np.diag(after) <= np.diag(before)).all()
