# SPDX-License-Identifier: MIT
"""Tracks of a boat without sway thrust: corners, speeds, legs that are too short."""

import numpy as np
import pytest

from seatrial.control import ByLength, Eight, Track, at_speed, lawn_mower, rounded_square
from seatrial.util.errors import ControlError


@pytest.mark.parametrize(
    ("shape", "apart"),
    [(rounded_square(4.0, 0.8, 2), 0.0), (lawn_mower(6.0, 3.0, 4, 0.7), 9.0), (ByLength(Eight(3.0, 1.2)), 0.0)],
    ids=["square", "lawn-mower", "eight"],
)  # fmt: skip
def test_tracks_are_smooth_bow_first_and_at_a_steady_speed(shape, apart):
    course = at_speed(shape, 0.4, 4.0)
    h = 1e-4
    for t in np.linspace(0.3, course.duration - 0.3, 83):
        before, now, after = (course.at(float(x)) for x in (t - h, t, t + h))
        rate = after.eta - before.eta
        rate[2] = np.angle(np.exp(1j * rate[2]))
        np.testing.assert_allclose(now.rate, rate / (2 * h), atol=2e-3)
        np.testing.assert_allclose(
            now.acceleration, (after.rate - before.rate) / (2 * h), atol=4e-3
        )
        nu, _ = now.body()
        assert abs(nu[1]) < 1e-6
        if 4.0 < t < course.duration - 4.0:
            assert nu[0] == pytest.approx(0.4, rel=1e-3)
    ends = [course.at(t).eta[:2] for t in (0.0, course.duration)]
    assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(apart, abs=1e-6)


def test_a_corner_is_as_tight_as_its_radius_and_a_short_leg_is_refused():
    track = rounded_square(4.0, 0.8)
    bends = [abs(track.at(float(s))[1, 2]) for s in np.linspace(0.0, track.length, 4000)]
    assert max(bends) == pytest.approx(1.0 / 0.8, rel=1e-3)
    with pytest.raises(ControlError, match="leg 2 is shorter than its corners of 2 m"):
        lawn_mower(10.0, 4.0, 3, 2.0)
    with pytest.raises(ControlError, match="a corner of 180 degrees"):
        Track(((0.0, 0.0), (5.0, 0.0), (0.0, 0.0)), 0.5)


@pytest.mark.parametrize(("speed", "ramp"), [(0.0, 6.0), (-1.0, 6.0), (np.nan, 6.0), (0.5, 0.0)])
def test_a_course_needs_a_speed(speed, ramp):
    with pytest.raises(ControlError, match="expected a speed and ramps above 0"):
        at_speed(lawn_mower(25.0, 10.0, 4, radius=2.5), speed, ramp)


def test_a_track_says_by_how_much_a_leg_is_too_short():
    with pytest.raises(ControlError, match=r"leg 2 is shorter than its corners of 2 m, by 1\.9 m;"):
        lawn_mower(15.0, 5.0, 3, radius=2.0)
