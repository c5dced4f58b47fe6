# SPDX-License-Identifier: MIT
"""A drive along one line does not tell exchanged x and y from another zero of the heading: `inspect` says so."""

import numpy as np
import pytest
from conftest import make_model
from survey_boat import LAG, LATENCY, NOISE, TRUTH, boat, both, pulses

from seatrial.inspection.consistency.check import check_consistency
from tests.boats.motions import recorded, states_at

ALIKE = "on one line exchanged x and y, another zero of the heading and another sign of an input look alike"
EXCHANGED = "x and y are exchanged"


def checked(degrees, turning, *, exchanged=True, seconds=120.0):
    """The report on pulses ahead and astern from this heading on, with some turning, x and y exchanged."""
    rng = np.random.default_rng(1)
    truth = make_model(boat([{"latency": LATENCY, "lag": LAG}]), TRUTH)
    ahead, turn = (pulses(rng, seconds, both, 0.3) for _ in range(2))
    values = np.column_stack([ahead - turning * turn, ahead + turning * turn])
    begin = np.arange(len(values)) / 20.0
    t = np.arange(0.0, seconds, 0.1)
    start = np.array([0.0, 0.0, np.radians(degrees), 0.0, 0.0, 0.0])
    poses = states_at(truth, t, begin, values, start)[:, :3]
    poses = (poses + rng.normal(size=poses.shape) * NOISE)[:, [1, 0, 2] if exchanged else [0, 1, 2]]
    vehicle = boat()
    recording = recorded("line", vehicle, (t, poses), (begin, values))
    return check_consistency([recording], vehicle)


@pytest.mark.parametrize("degrees", [0.0, 20.0, 45.0, 110.0, 135.0])
def test_a_line_does_not_show_what_is_exchanged(degrees):
    """Along the diagonal an exchange changes nothing: then there is no finding, and the remark remains."""
    report = checked(degrees, 0.0)
    (said,) = [text for text in report.text if ALIKE in text]
    assert float(said.split()[4]) < 2.0  # [deg] of the noise of the heading alone
    assert bool(report.findings) == (degrees != 45.0)
    assert not any(EXCHANGED in finding.text for finding in report.findings)


@pytest.mark.parametrize("degrees", [20.0, 45.0])
def test_some_turns_show_it(degrees):
    report = checked(degrees, 0.15)
    assert [finding.text.split(":")[0] for finding in report.findings] == [EXCHANGED]
    assert not any(ALIKE in text for text in report.text)


def test_a_right_file_says_what_the_line_does_not_show():
    report = checked(20.0, 0.0, exchanged=False)
    assert report.findings == ()
    assert any(ALIKE in text for text in report.text)
