# SPDX-License-Identifier: MIT
"""The figure of a kind of boats shows the numbers that the test and the table have."""

import numpy as np
import pytest
from test_many_boats import made_up

from seatrial.fleet.fleet import _together
from seatrial.fleet.kinds import centre_of
from seatrial.fleet.page import _picture


def test_a_boat_is_drawn_at_its_z(tmp_path):
    """Of few boats the error of the centre counts as well."""
    values, errors = np.array([1.0, 1.02, 0.98, 1.01, 0.99, 1.6]), np.full(6, 0.02)
    boats = [made_up(f"b{i}", *pair) for i, pair in enumerate(zip(values, errors, strict=True))]
    found = _together("fleet", boats, tmp_path)
    (odd,) = found.boats[5].differs
    drawn = {
        name: x
        for trace in _picture(found, "k")["data"]
        for name, x in zip(trace["text"], trace["x"], strict=True)
    }
    assert drawn["b5"] == pytest.approx(odd.z)
    centre = centre_of(values, errors)
    spread = np.sqrt(errors**2 + centre.between**2 + centre.error**2)
    expected = dict(zip(drawn, (values - centre.value) / spread, strict=True))
    assert drawn == pytest.approx(expected)
