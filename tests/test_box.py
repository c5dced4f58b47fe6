# SPDX-License-Identifier: MIT
"""Quadratic minimisation within a box."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from seatrial.util.box import box_minimum

SIZES = st.floats(-3.0, 3.0, allow_subnormal=False)


@st.composite
def boxes(draw):
    """A convex quadratic, often with parameters that are hardly told apart, and a box around 0."""
    n = draw(st.integers(1, 7))
    rows = draw(arrays(float, (n, n), elements=SIZES))
    near = draw(st.sampled_from([1e-6, 1e-3, 1.0]))
    low, high = (draw(arrays(float, n, elements=st.floats(0.0, 2.0))) for _ in range(2))
    return rows.T @ rows + near * np.eye(n), draw(arrays(float, n, elements=SIZES)), -low, high


@given(boxes())
def test_the_lowest_place_in_a_box_is_where_every_way_down_leads_out_of_it(box):
    matrix, pull, low, high = box
    x = box_minimum(matrix, pull, low, high)
    assert np.all((low <= x) & (x <= high))
    slope = pull - matrix @ x
    small = 1e-7 * (1.0 + np.abs(matrix).max() * np.abs(x).max() + np.abs(pull).max())
    assert np.all(slope[x > low] > -small)
    assert np.all(slope[x < high] < small)


def test_what_another_parameter_drags_to_its_bound_is_let_go_again():
    """Two that are nearly one: the first stops at once, the second is free to go its own way."""
    matrix = np.array([[1.0, 0.9999], [0.9999, 1.0]])
    x = box_minimum(matrix, np.array([-1.0, 0.2]), np.array([0.0, -1.0]), np.array([9.0, 1.0]))
    assert x == pytest.approx([0.0, 0.2])
