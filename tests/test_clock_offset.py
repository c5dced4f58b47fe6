# SPDX-License-Identifier: MIT
"""Commands by another clock than the poses: named as that, not as wrong signs."""

from dataclasses import replace

import pytest

from seatrial.inspection.consistency.check import check_consistency
from seatrial.inspection.consistency.inconsistencies import InconsistencyKind
from seatrial.recording.signal import Signal


def late(recording, offset):
    """The recording with commands stamped so much later [s]."""
    c = recording.commands
    return replace(recording, commands=Signal(c.names, c.stamps + round(1e9 * offset), c.values))


@pytest.mark.parametrize("offset", [-3.0, -1.2, 1.0, 2.0, 4.5])
@pytest.mark.parametrize("names", [("S1", "S2", "S3"), ("S7",)])
def test_another_clock_is_named_and_signs_are_seen_all_the_same(mp, paper_mp, offset, names):
    recordings = [paper_mp[name].recording for name in names]
    usual = check_consistency(recordings, mp)
    assert usual.findings == ()
    report = check_consistency([late(r, offset) for r in recordings], mp)
    (finding,) = report.findings
    assert finding.kind is InconsistencyKind.CLOCK
    said = float(finding.text.split()[3])
    side = "before" if offset > 0 else "after"
    assert (
        f"{said:g} s {side} their stamps" in finding.text or f"{said:.1f} s {side}" in finding.text
    )
    assert said == pytest.approx(abs(offset), abs=0.35)  # latency and lag are in it
    assert report.repair.input_signs == usual.repair.input_signs
    assert report.repair.pose_signs == usual.repair.pose_signs


@pytest.mark.parametrize("name", ["random_run1", "random_run3", "run1"])
def test_a_real_ship_has_one_clock(cse1, cse1_vehicle, name):
    (recording,) = [r for n, r in cse1.items() if n.endswith(name)][:1]
    assert not [
        f
        for f in check_consistency([recording], cse1_vehicle).findings
        if f.kind is InconsistencyKind.CLOCK
    ]
