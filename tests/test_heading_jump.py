# SPDX-License-Identifier: MIT
"""A heading that is off after an estimator has reset its yaw is told; a map that is turned as a whole is not."""

import numpy as np
import pytest
import steered_boat
from conftest import at_length

from seatrial.boat.findings import FindingKind, finding_text
from seatrial.identification.estimator import output_error
from seatrial.recording.from_poses import make_recording
from tests.boats.hulls import MIDDLE, driven

CHAIN = {"latency": 0.1, "lag": 0.1}
AT = 65.0  # [s]


def jumped(recording, turn: float, *, map_too: bool):
    """The recording with headings, or with the whole map, turned by an angle [rad] from `AT` on."""
    eta = np.array(recording.eta)
    after = recording.t >= AT
    eta[after, 2] += turn
    if map_too:
        c, s = np.cos(turn), np.sin(turn)
        eta[after, :2] = eta[after, :2] @ np.array([[c, s], [-s, c]]) + [1.0, 0.5]
    return make_recording("run", recording.stamps, eta, recording.commands)


@pytest.fixture(scope="module")
def boat():
    vehicle, (drive,) = driven(MIDDLE, CHAIN, seed=3, white=2e-3, seconds=130, drives=1)
    return vehicle, drive


@pytest.mark.parametrize("degrees", [8.0, at_length(-4.0)])
def test_a_heading_that_is_off_after_its_jump_is_told(boat, degrees):
    vehicle, drive = boat
    model = output_error([jumped(drive, np.radians(degrees), map_too=False)], vehicle)
    (finding,) = model.findings_of(FindingKind.HEADING_JUMP)
    assert np.degrees(finding.number("size")) == pytest.approx(abs(degrees), abs=0.6)
    assert finding.number("at") == pytest.approx(AT, abs=drive.period)
    assert f"--without run=0-{finding.number('at'):.10g}" in finding_text(finding)


def test_a_map_that_is_turned_as_a_whole_is_no_error_of_the_heading(boat):
    """As where SLAM closes a loop: the course turns with the heading."""
    vehicle, drive = boat
    model = output_error([jumped(drive, np.radians(8.0), map_too=True)], vehicle)
    assert not model.findings_of(FindingKind.HEADING_JUMP)
    assert any("jumped for good" in f.kind.value for f in jumped(drive, 0.14, map_too=True).faults)


@pytest.mark.parametrize("map_too", [False, True])
def test_a_jump_that_makes_the_fit_one_of_a_mismatch_is_told_of_a_rudder_too(map_too):
    """The jump itself enlarges the noise by which its own gain is judged."""
    boat = steered_boat.known({"offset_deg": 0.0})
    drive = steered_boat.driven(boat, 1, 130.0, least=-0.5)
    model = output_error([jumped(drive, np.radians(-28.0), map_too=map_too)], boat.vehicle)
    found = model.findings_of(FindingKind.HEADING_JUMP)
    assert bool(found) != map_too
    if found:
        assert model.findings_of(FindingKind.MODEL_MISMATCH)
        assert np.degrees(found[0].number("size")) == pytest.approx(28.0, abs=2.0)
