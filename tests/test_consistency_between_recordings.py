# SPDX-License-Identifier: MIT
"""One recording of several that was made another way is named; a wrong file is wrong for all of them."""

from dataclasses import replace

import pytest
from conftest import at_length
from recording_tools import stamped, turned

from seatrial.identification.methods import identify
from seatrial.inspection.consistency.between_recordings import check_each_recording
from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.recording.recording import Recording
from seatrial.simulation.plan import load_plan, with_seed
from seatrial.simulation.trials import simulate


def exchanged(recording: Recording) -> Recording:
    """x and y in each other's columns."""
    places = [1, 0, 2]
    return replace(recording, eta=recording.eta[:, places], raw=recording.raw[:, places])


@pytest.fixture(scope="module")
def driven(mp) -> dict[str, Recording]:
    plan = with_seed(load_plan("hard"), 33)
    return {t.name[:2]: t.recording for t in simulate(plan, mp)}


@pytest.mark.parametrize("odd", ["S1", at_length("S2"), at_length("S3")])
@pytest.mark.parametrize(
    ("made", "kinds"),
    [
        (lambda r: turned(r, -1, -1, -1), {InconsistencyKind.NEGATED, InconsistencyKind.HANDED}),
        (exchanged, {InconsistencyKind.EXCHANGED, InconsistencyKind.MIRRORED}),
    ],
)
def test_the_odd_one_is_named_and_what_is_wrong_with_it(mp, driven, odd, made, kinds):
    recordings = [made(driven[k]) if k == odd else driven[k] for k in ("S1", "S2", "S3", "S5")]
    found = check_each_recording(recordings, mp).findings
    assert found
    for finding in found:
        assert finding.text.startswith(f"{odd}-MP contradicts the vehicle file, ")
    assert {finding.kind for finding in found} <= kinds


@pytest.mark.parametrize("later", [-3.0, at_length(-1.5), 2.0])
@pytest.mark.parametrize("names", [("S3", "S5"), ("S1", "S2", "S5")])
def test_the_one_whose_commands_are_of_another_clock_is_named(mp, driven, names, later):
    """It fits the file once its stamps are put right, which must not make it right as it is."""
    *right, odd = names
    recordings = [*(driven[k] for k in right), stamped(driven[odd], later)]
    (finding,) = check_each_recording(recordings, mp).findings
    assert finding.kind is InconsistencyKind.CLOCK
    assert finding.text.startswith(f"{odd}-MP contradicts the vehicle file, ")


def test_recordings_of_one_kind_have_no_odd_one(mp, driven):
    assert check_each_recording([driven[k] for k in ("S1", "S2", "S3")], mp).findings == ()


def test_a_file_that_is_wrong_for_all_is_said_to_be_wrong_once(mp, driven):
    recordings = [turned(driven[k], 1, -1, 1) for k in ("S1", "S2", "S3")]
    assert check_each_recording(recordings, mp) == check_consistency(recordings, mp)
    assert [f.kind for f in check_each_recording(recordings, mp).findings] == [
        InconsistencyKind.NEGATED
    ]


def test_what_only_one_recording_tells_is_said_of_the_file(mp, driven):
    """S1 and S2 hardly turn: that the file has yaw reversed is seen in S3 only."""
    still = [turned(driven[k], 1, 1, 0) for k in ("S1", "S2")]
    recordings = [*still, turned(driven["S3"], 1, 1, -1)]
    report = check_each_recording(recordings, mp)
    assert [f.kind for f in report.findings] == [InconsistencyKind.NEGATED]
    assert "at odds" not in report.findings[0].text


@pytest.mark.system
def test_identify_names_it(mp, driven):
    model = identify([driven["S1"], driven["S2"], turned(driven["S3"], -1, -1, -1)], mp)
    assert any("S3-MP contradicts" in said for said in model.warnings)
