# SPDX-License-Identifier: MIT
"""Searches with part of the poses end where those with all of them do."""

from dataclasses import replace

import numpy as np
import pytest

import seatrial
from seatrial.identification import pose_rate
from seatrial.identification.estimator import OutputErrorSettings, fit
from seatrial.identification.guided import identify_guided
from seatrial.identification.likelihood import optimiser
from seatrial.identification.likelihood.fit_horizon import noise_floor
from tests.boats.plans import driven_by, planned

RATE = 40.0  # [Hz] of a motion capture


@pytest.fixture(scope="module")
def dense(mp) -> list[seatrial.Recording]:
    return driven_by(planned("paper-like", "S1", "S2", "S3", seconds=60.0, pose={"rate": RATE}), mp)


def test_a_thinned_recording_keeps_its_time_and_commands(dense):
    whole = dense[0]
    part = whole.thinned(10.0)
    assert part.period == pytest.approx(0.1, rel=0.1)
    assert part.origin == whole.origin
    assert part.commands is whole.commands
    kept = np.isin(whole.stamps, part.stamps)
    np.testing.assert_array_equal(whole.eta[kept], part.eta)
    np.testing.assert_array_equal(whole.segment[kept], part.segment)


def test_recordings_with_hardly_more_poses_stay(dense):
    assert dense[0].thinned(0.6 * RATE) is dense[0]


def test_only_usable_poses_count(dense):
    """A table at 40 Hz whose receiver gives a position at every fourth row has 10 Hz."""
    whole = dense[0]
    fresh = np.arange(len(whole.stamps)) % 4 == 3
    held = replace(whole, valid=whole.valid & fresh)
    assert held.thinned(10.0) is held
    assert held.thinned(5.0).valid.sum() == pytest.approx(held.valid.sum() / 2, abs=1)


def test_poses_in_bursts_are_not_taken_for_fast_ones(dense):
    """Two poses a millisecond apart, ten times a second, are no thousand a second."""
    whole = dense[0]
    pairs = np.repeat(np.arange(0, len(whole.stamps) // 8), 2)
    stamps = whole.origin + pairs * 100_000_000 + np.tile([0, 1_000_000], len(pairs) // 2)
    size = len(stamps)
    bursts = replace(
        whole, stamps=stamps, eta=whole.eta[:size], raw=whole.raw[:size],
        valid=np.ones(size, dtype=bool), segment=np.zeros(size, dtype=np.int64),
    )  # fmt: skip
    assert bursts.thinned(10.0).valid.sum() >= size / 4


def test_the_solution_is_that_of_all_poses(dense, mp, monkeypatch):
    passes = []
    monkeypatch.setattr(
        optimiser,
        "full_pass",
        lambda p, *a, real=optimiser.full_pass: passes.append(p) or real(p, *a),
    )
    found = fit(dense, mp)
    few = [p for p in passes if len(p.recordings[0].t) < 0.3 * len(dense[0].t)]
    assert len(few) > 0.5 * len(passes)
    monkeypatch.setattr(pose_rate, "SEARCH_RATE", 1e3)
    whole = fit(dense, mp)
    assert found.names == whole.names
    assert all(a is b for a, b in zip(found.problem.recordings, dense, strict=True))
    errors = np.sqrt(np.diag(whole.covariance))
    apart = (found.theta - whole.theta)[list(whole.problem.free)]
    assert np.abs(apart[errors > 0.0] / errors[errors > 0.0]).max() < 0.1
    np.testing.assert_allclose(np.sqrt(np.diag(found.covariance)), errors, rtol=0.05)


def test_a_second_of_poses_counts_as_much_at_any_rate_under_a_fit_horizon(dense, mp):
    whole = fit(dense, mp, settings=OutputErrorSettings(select_stages=False)).problem
    few = pose_rate.with_fewer_poses(whole)
    floors = [noise_floor(p, 0.8)[:2] * np.sqrt(p.period) for p in (whole, few)]
    np.testing.assert_allclose(*floors, rtol=0.05)


def test_the_guided_path_ends_with_all_poses(dense, mp):
    found = identify_guided(dense, mp)
    assert all(a is b for a, b in zip(found.solution.problem.recordings, dense, strict=True))
