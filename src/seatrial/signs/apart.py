# SPDX-License-Identifier: MIT
"""Whether one recording of several was made another way: its commands reversed, its axes exchanged.

Taken together, recordings that contradict each other say something in between. So each is asked alone, too.
"""

from collections.abc import Sequence
from dataclasses import replace

from seatrial.recording import Recording
from seatrial.signs.check import SignReport, check_signs
from seatrial.signs.findings import Finding, Wrong
from seatrial.vehicle import Vehicle


def check_apart(recordings: Sequence[Recording], vehicle: Vehicle) -> SignReport:
    """`check_signs` of all together; where the file is right for the others, what is wrong in those for which it
    is not, by name.
    """
    together = check_signs(recordings, vehicle)
    if len(recordings) < 2:
        return together
    apart = [check_signs([recording], vehicle) for recording in recordings]
    others = [r for r, own in zip(recordings, apart, strict=True) if not own.findings]
    if not 0 < len(others) < len(recordings) or check_signs(others, vehicle).findings:
        return together
    if all(_said(own) == _said(together) for own in apart if own.findings):
        return together  # of what the others do not tell
    findings = [
        Finding(
            finding.kind,
            f"{recording.name} contradicts the vehicle file, the others do not; leave it out, or correct its "
            f"columns: {finding.text}",
        )
        for recording, own in zip(recordings, apart, strict=True)
        for finding in own.findings
    ]
    return replace(together, findings=tuple(findings))


def _said(report: SignReport) -> tuple[object, set[Wrong]]:
    return report.repair, {finding.kind for finding in report.findings}
