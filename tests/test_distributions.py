# SPDX-License-Identifier: MIT
"""Tails against SciPy; Holm's correction against its definition."""

import numpy as np
import pytest
from scipy import stats

from seatrial.util.distributions import chi2_sf, holm, normal_two_sided, student_two_sided


@pytest.mark.parametrize("freedom", [1, 2, 3, 7, 15, 60, 400])
def test_chi_squares_tail_is_scipys(freedom):
    for share in (1e-6, 0.01, 0.3, 0.9, 1.0, 1.1, 2.0, 5.0, 20.0):
        x = share * freedom
        assert chi2_sf(x, freedom) == pytest.approx(
            stats.chi2.sf(x, freedom), rel=1e-10, abs=1e-300
        )
    assert chi2_sf(0.0, freedom) == chi2_sf(-1.0, freedom) == 1.0
    assert chi2_sf(1e7, freedom) == 0.0


def test_two_degrees_of_freedom_are_an_exponential():
    assert chi2_sf(5.0, 2) == pytest.approx(np.exp(-2.5), rel=1e-13)


def test_no_degrees_of_freedom_are_refused():
    with pytest.raises(ValueError, match="0 degrees"):
        chi2_sf(1.0, 0)


@pytest.mark.parametrize("z", [0.0, 0.5, -1.959964, 4.0, 30.0])
def test_the_normal_tail_is_scipys(z):
    assert normal_two_sided(z) == pytest.approx(2 * stats.norm.sf(abs(z)), rel=1e-12)


@pytest.mark.parametrize("freedom", [3.0, 8.0, 10.0, 45.0, 100.0, 200.0])
def test_students_tail_is_nearly_scipys(freedom):
    for t, most in (
        (0.5, 1.01),
        (2.0, 1.01),
        (4.0, 1.03 if freedom > 8 else 1.05),
        (5.0, 1.08),
        (12.0, 1.26),
    ):
        ratio = student_two_sided(t, freedom) / (2.0 * stats.t.sf(t, freedom))
        assert 0.99 < ratio < most


def test_holms_steps():
    """The smallest counts n times, the next n - 1 times; never less than the one before, never over 1."""
    got = holm([0.04, 0.01, 0.03, 0.9])
    assert got.tolist() == pytest.approx([0.09, 0.04, 0.09, 0.9])
    assert holm([0.6, 0.7]).tolist() == [1.0, 1.0]
    assert holm([]).tolist() == []
