# SPDX-License-Identifier: MIT
"""Threads change no bit of a result, of a fit nor of scores; parallel runs of the tests have one core a worker."""

from threading import Barrier

import numpy as np
import pytest

import seatrial
from seatrial.util.parallel import spread


def test_items_are_worked_on_at_the_same_time(on_cores):
    """Each waits for all."""
    on_cores(3)
    met = Barrier(3, timeout=60.0)
    assert spread(lambda item: (met.wait(), item)[1], "abc") == ["a", "b", "c"]


@pytest.mark.parametrize("method", ["output-error", "equation-error"])
def test_a_model_and_its_scores_are_the_same_on_any_number_of_cores(on_cores, mp, paper_mp, method):
    recordings = [paper_mp[name].recording.cut(0.0, 60.0) for name in ("S1", "S2", "S3")]
    found = []
    for count in (1, 3):
        on_cores(count)
        model = seatrial.identify(recordings, mp, method=method)
        found.append((model, seatrial.validate(model, [paper_mp["S4"].recording.cut(0.0, 60.0)])))
    (model, scores), (other, others) = found
    np.testing.assert_array_equal(model.coefficients, other.coefficients)
    np.testing.assert_array_equal(model.covariance, other.covariance)
    assert model.noise == other.noise
    assert scores == others
