# SPDX-License-Identifier: MIT
"""Consistency of each recording by itself: one whose commands are reversed, whose axes are exchanged.

Recordings that contradict each other average out in a joint check. So each is also checked alone.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from seatrial.boat.vehicle import Vehicle
from seatrial.inspection.consistency.check import ConsistencyReport, check_consistency
from seatrial.inspection.consistency.hypotheses import LEVER_ALLOWED, nearest_lever
from seatrial.inspection.consistency.inconsistencies import Inconsistency, InconsistencyKind
from seatrial.inspection.consistency.repair import Repair
from seatrial.recording.recording import Recording
from seatrial.util.errors import RecordingError
from seatrial.util.format import shortened
from seatrial.util.parallel import spread


def contradictions(recordings: Sequence[Recording], vehicle: Vehicle) -> list[str]:
    """What contradicts the vehicle file, in words; none where recordings can't be checked."""
    with suppress(RecordingError):
        return [finding.text for finding in check_each_recording(recordings, vehicle).findings]
    return []


def check_each_recording(recordings: Sequence[Recording], vehicle: Vehicle) -> ConsistencyReport:
    """`check_consistency` of all recordings; with some of them inconsistent, only those, by name."""
    # 1. All recordings jointly, then each by itself.
    alone = [[recording] for recording in recordings] if len(recordings) > 1 else []
    together, *apart = spread(lambda own: check_consistency(own, vehicle), [recordings, *alone], "")
    if not apart:
        return together
    # 2. One edit that explains every recording is a mistake of the vehicle file.
    if _one_edit_explains_all(together, apart):
        return together
    # 3. The file must be right for some recordings, jointly, or none of them can be singled out.
    others = [r for r, own in zip(recordings, apart, strict=True) if not own.findings]
    if not 0 < len(others) < len(recordings) or check_consistency(others, vehicle).findings:
        return together
    # 4. The inconsistent ones agree with the joint check: the others do not excite that input.
    if all(_conclusion(own) == _conclusion(together) for own in apart if own.findings):
        return together
    # 5. One lever arm of the measured point may explain all of them.
    by_lever = _explained_by_one_lever(apart)
    if all(fit for fit, own in zip(by_lever, apart, strict=True) if own.findings):
        return together
    # 6. What is left contradicts the vehicle file that is right for the others.
    left = [() if fit else own.findings for own, fit in zip(apart, by_lever, strict=True)]
    right = [r.name for r, wrong in zip(recordings, left, strict=True) if not wrong]
    agree = f"{shortened(right)} {'agrees' if len(right) == 1 else 'agree'} with it"
    findings = [
        Inconsistency(
            finding.kind,
            f"{recording.name} contradicts the vehicle file, {agree}; leave it out, or correct its "
            f"columns: {finding.text}",
            finding.leave_out,
        )
        for recording, wrong in zip(recordings, left, strict=True)
        for finding in wrong
    ]
    return replace(together, findings=tuple(findings))


def _one_edit_explains_all(together: ConsistencyReport, apart: Sequence[ConsistencyReport]) -> bool:
    """Whether the joint repair is one edit of the inputs that fits every recording."""
    if together.repair.edits != 1 or together.repair.pose_edits:
        return False
    return all(
        own.search is not None
        and own.search.fits(together.repair)
        and (_has_clock_offset(together) or not _has_clock_offset(own))
        for own in apart
    )


def _explained_by_one_lever(apart: Sequence[ConsistencyReport]) -> list[bool]:
    """Recordings that the unedited file fits if all poses are of one point off the origin."""
    known = [own.search for own in apart if own.search is not None]
    other_unit = any(any(own.repair.units) for own in apart)
    if len(known) < len(apart) or other_unit or any(s.mirrored for s in known):
        return [False] * len(apart)
    lever = nearest_lever(known, LEVER_ALLOWED)
    return [
        not _has_clock_offset(own) and s.at_point(*lever).misfit(s.no_edit) < s.edit_penalty
        for own, s in zip(apart, known, strict=True)
    ]


def _has_clock_offset(report: ConsistencyReport) -> bool:
    """Whether the commands have another clock; all else in the report holds with that corrected."""
    return any(finding.kind is InconsistencyKind.CLOCK for finding in report.findings)


def _conclusion(report: ConsistencyReport) -> tuple[Repair, set[InconsistencyKind]]:
    return report.repair, {finding.kind for finding in report.findings}
