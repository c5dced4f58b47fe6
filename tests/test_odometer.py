# SPDX-License-Identifier: MIT
"""The odometer: what a program gets that asks for odometry, without lines or files."""

import numpy as np
import pytest

import seatrial
from seatrial.onboard.odometer import Odometer
from seatrial.onboard.predictor import Health, Taken
from tests.boats.drives import drive, model

SCENE = "hard, pushed"
IDENTIFIED = 6  # the seed of the drives that the model is identified with


@pytest.fixture(scope="module")
def known() -> seatrial.Model:
    return model(SCENE, IDENTIFIED)


def test_odometry_counts_and_looks(paper_mp_model):
    odometer = Odometer(paper_mp_model, lever=(0.3, 0.0))
    assert odometer.newest == 0
    assert not odometer.at(10).known
    assert odometer.command(10, [0, 0, 0]) is Taken.USED
    assert odometer.pose(20, [1.0, 2.0, np.pi / 2]) is Taken.USED
    assert odometer.pose(20, [np.nan, 0, 0]) is Taken.NOT_A_NUMBER
    out = odometer.at(20)
    assert out.known
    np.testing.assert_allclose(out.motion.pose[:2], [1.0, 1.7], atol=1e-9)
    np.testing.assert_allclose(out.map_to_odom, [1.0, 1.7, np.pi / 2], atol=1e-9)
    assert odometer.count("pose", Taken.USED) == 1
    assert odometer.count("pose", Taken.NOT_A_NUMBER) == 1
    assert odometer.newest == 20
    assert Health.DEAD_RECKONING in odometer.look(2_000_000_000).health
    assert "dead reckoning" in odometer.look(2_000_000_000).health.names
    with pytest.raises(seatrial.SeatrialError, match=r"3 numbers: F_u, F_v, F_r"):
        odometer.command(0, [1.0])


@pytest.mark.system
def test_the_heading_in_odom_is_as_far_off_as_it_says(known):
    off, said = [], []
    for seed in (5, 6):
        course, odometer = drive(SCENE, seed), Odometer(known, lever=(0, 0))
        events = iter([*course.inputs.events(), (np.inf, "", 0.0, None)])
        arrival, kind, stamp, values = next(events)
        rows = []
        for t in np.arange(course.inputs.pose_t[0], course.inputs.pose_t[-1], 0.02):
            while arrival <= t:
                getattr(odometer, kind)(round(stamp * 1e9), values)
                arrival, kind, stamp, values = next(events)
            out = odometer.at(round(t * 1e9))
            rows.append((t, out.pose[2], out.covariance[2, 2]))
        t, psi, variance = np.array(rows).T
        truth = np.interp(t, course.inputs.pose_t, np.unwrap(course.truth[:, 2]))
        step = 250  # 5 s
        at = np.arange(500, len(t) - step, step)
        # between poses that are missing for long the interpolated truth is no truth
        longest = [
            np.diff(
                [
                    a,
                    *course.inputs.pose_t[(course.inputs.pose_t > a) & (course.inputs.pose_t < b)],
                    b,
                ]
            ).max()
            for a, b in zip(t[at], t[at + step], strict=True)
        ]
        at = at[np.array(longest) < 0.3]
        wrong = np.unwrap(psi) - truth
        off.append(wrong[at + step] - wrong[at])
        said.append(variance[at + step] - variance[at])
    off, said = np.concatenate(off), np.concatenate(said)
    assert len(off) > 80
    assert 0.7 < np.sqrt(np.mean(off**2) / np.mean(said)) < 1.15
