# SPDX-License-Identifier: MIT
"""A heading that turns away with the time is named as such, with its rate, and not as an offset."""

import numpy as np
import pytest
from conftest import at_length
from survey_boat import driven, even, past_idle

from seatrial.boat.findings import FindingKind
from seatrial.identification.estimator import output_error
from seatrial.recording.from_poses import make_recording

NOISE = np.array([0.02, 0.02, 0.02])  # [m], [m], [rad]
FAULTS = (FindingKind.HEADING_DRIFT, FindingKind.HEADING_OFFSET)


def turned(recording, degrees, *, a_minute):
    """The recording with headings off by an angle at its begin, and by so much more a minute."""
    eta = np.array(recording.eta)
    eta[:, 2] += np.radians(degrees + a_minute * recording.t / 60.0)
    return make_recording(recording.name, recording.stamps, eta, recording.commands)


@pytest.fixture(scope="module")
def boat():
    return driven({}, [past_idle] * 2, seconds=480.0, seed=1, stamps=even(5.0), noise=NOISE)


@pytest.mark.parametrize(
    ("degrees", "a_minute"), [(0.0, 2.0), at_length(0.0, -2.0), at_length(-4.0, 3.0)]
)
def test_a_drift_is_named_with_its_rate(boat, degrees, a_minute):
    vehicle, drive = boat
    off = turned(drive, degrees, a_minute=a_minute)
    (finding,) = output_error([off], vehicle).findings_of(*FAULTS)
    assert finding.kind is FindingKind.HEADING_DRIFT
    assert np.degrees(finding.number("rate")) == pytest.approx(abs(a_minute), rel=0.05)


@pytest.mark.parametrize("degrees", [0.0, at_length(7.0)])
def test_neither_a_right_heading_nor_an_offset_is_one(boat, degrees):
    vehicle, drive = boat
    model = output_error([turned(drive, degrees, a_minute=0.0)], vehicle)
    assert not model.findings_of(FindingKind.HEADING_DRIFT)
