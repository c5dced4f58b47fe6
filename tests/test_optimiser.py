# SPDX-License-Identifier: MIT
"""The search's steps within bounds."""

import numpy as np
import pytest
from conftest import CSE1
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import seatrial
from seatrial.boat.actuators import ESTIMATE
from seatrial.boat.schema import ChainGroup
from seatrial.identification.estimator import OutputErrorSettings, output_error
from seatrial.identification.likelihood.optimiser import box_minimum
from seatrial.identification.selection.actuator_stages import actuator_groups

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


def test_latencies_of_the_real_ship_are_found_beside_a_lag_at_its_bound():
    """The lag ends at its bound, and drags none of the latencies along: they are those without a lag."""
    vehicle = seatrial.load_vehicle(CSE1 / "vehicle.yaml")
    kinds = actuator_groups(vehicle)
    asked = [ChainGroup(name=n, actuators=of, latency=ESTIMATE) for n, of in kinds.items()]
    runs = ("run1", "random_run1", "random_run3")
    recordings = [seatrial.read(CSE1 / "csv" / f"CSE1_data_{run}.csv", vehicle) for run in runs]
    free, without = (
        output_error(
            recordings,
            vehicle.with_chain([*vehicle.file.chain, *asked, *lag]),
            settings=OutputErrorSettings(select_stages=False),
        )
        for lag in ([], [ChainGroup(lag=0.0)])
    )
    found, none = (
        dict(zip(m.vehicle.constants.names, m.constants.tolist(), strict=True))
        for m in (free, without)
    )
    assert found["lag"] < 0.005
    for force in kinds:
        name = f"latency.{force}"
        assert found[name] == pytest.approx(none[name], abs=0.005), name
