# SPDX-License-Identifier: MIT
"""Whether one recording of several was made another way: its commands reversed, its axes exchanged.

Taken together, recordings that contradict each other say something in between. So each is asked alone, too.
"""

from collections.abc import Sequence
from dataclasses import replace

from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.check import SignReport, check_signs
from seatrial.inspection.consistency.findings import Finding, Wrong
from seatrial.inspection.consistency.hypotheses import LONG, nearest_arm
from seatrial.recording.recording import Recording
from seatrial.util.format import shortened


def check_apart(recordings: Sequence[Recording], vehicle: Vehicle) -> SignReport:
    """`check_signs` of all together; where the file is right for the others, what is wrong in those for which it
    is not, by name.
    """
    together = check_signs(recordings, vehicle)
    if len(recordings) < 2:
        return together
    apart = [check_signs([recording], vehicle) for recording in recordings]
    one = together.repair.edits == 1 and not together.repair.pose_edits
    if one and all(
        own.search and own.search.fits(together.repair) and _timed_as(together, own)
        for own in apart
    ):
        return together  # one mistake in the file makes all of them wrong
    others = [r for r, own in zip(recordings, apart, strict=True) if not own.findings]
    if not 0 < len(others) < len(recordings) or check_signs(others, vehicle).findings:
        return together
    if all(_said(own) == _said(together) for own in apart if own.findings):
        return together  # of what the others do not tell
    fits = _of_one_point(apart)
    if all(fit for fit, own in zip(fits, apart, strict=True) if own.findings):
        return together
    right = [
        r.name
        for r, own, fit in zip(recordings, apart, fits, strict=True)
        if fit or not own.findings
    ]
    said = f"{shortened(right)} {'does' if len(right) == 1 else 'do'} not"
    findings = [
        Finding(
            finding.kind,
            f"{recording.name} contradicts the vehicle file, {said}; leave it out, or correct its columns: "
            f"{finding.text}",
        )
        for recording, own, fit in zip(recordings, apart, fits, strict=True)
        for finding in (() if fit else own.findings)
    ]
    return replace(together, findings=tuple(findings))


def _of_one_point(apart: Sequence[SignReport]) -> list[bool]:
    """For which of them the file is right if the poses are of a point off the origin, the same for all."""
    searches = [own.search for own in apart]
    if any(s is None or s.mirrored for s in searches) or any(
        any(own.repair.units) for own in apart
    ):
        return [False] * len(apart)
    known = [s for s in searches if s is not None]
    arm = nearest_arm(known, LONG)
    return [
        not _clocked(own) and s.moved(arm).misfit(s.as_is) < s.price
        for own, s in zip(apart, known, strict=True)
    ]


def _clocked(report: SignReport) -> bool:
    """Whether its commands are of another clock; all else that it says is of those put right."""
    return any(finding.kind is Wrong.CLOCK for finding in report.findings)


def _timed_as(together: SignReport, own: SignReport) -> bool:
    return _clocked(together) or not _clocked(own)


def _said(report: SignReport) -> tuple[object, set[Wrong]]:
    return report.repair, {finding.kind for finding in report.findings}
