# SPDX-License-Identifier: MIT
"""The second step of a guided path: the recordings, and whether the vehicle file is consistent with them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.guide.steps import Task
from seatrial.guide.vehicle_file import of_this_boat
from seatrial.inspection.consistency.inconsistencies import Inconsistency
from seatrial.inspection.console import inspection_text
from seatrial.inspection.overview import Inspection, inspect
from seatrial.io import read, read_each
from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.recording.recording import Recording
from seatrial.recording.undriven import undriven_motion
from seatrial.util.files import write_text
from seatrial.util.progress import stage


def driven_recordings(
    here: Task, vehicle: Vehicle, *, proposed_now: bool
) -> tuple[list[Recording], Inspection]:
    """The recordings while the boat is driven, and the inspection of all of them."""
    with stage("reading", 0.1), of_this_boat(here, proposed_now=proposed_now):
        recordings = read_each(here.logs, vehicle, salvage=here.salvage)
    here.log_of |= {r.sources: log for r, log in zip(recordings, here.logs, strict=True)}
    with stage("inspecting", 0.05):
        inspection = _inspect(here, recordings, vehicle)
        names = [recording.name for recording in recordings]
        weaker = [
            f for f in inspection.signs.findings
            if f.leave_out is not None and names.count(f.leave_out.recording) == 1
        ]  # fmt: skip
        whole = [_without_weaker(here, recording, weaker) for recording in recordings]
        return [while_driven(here, recording) for recording in whole], inspection


def _inspect(here: Task, recordings: Sequence[Recording], vehicle: Vehicle) -> Inspection:
    """State what is wrong with recordings and vehicle file; the model has it as a doubt."""
    found = inspect(recordings, vehicle)
    write_text(here.file("inspect.txt"), inspection_text(found) + "\n")
    length = sum(r.duration for r in recordings)
    usable = sum(r.usable * r.duration for r in recordings) / length
    wrong = [*found.vehicle.remarks, *(finding.text for finding in found.signs.findings)]
    verdict = wrong[0] if wrong else "units, signs and order are consistent"
    share = f"{100.0 * usable:.1f} % of the poses usable"
    here.say(f"inspect   {length:.0f} s, {share}; {verdict}  -> {here.file('inspect.txt')}")
    return found


def _without_weaker(here: Task, recording: Recording, found: Sequence[Inconsistency]) -> Recording:
    """Without the part in which an input has less effect than in the rest."""
    log = here.log_of.get(recording.sources)
    for one in found:
        part = one.leave_out
        if part is not None and part.recording == recording.name:
            if log is not None:
                here.left_out.setdefault(log, []).append(part.span)
            here.assumed.append(
                f"{part.span}, in seconds, is left out: {one.text.partition(': ')[0]}"
            )
            first, last = part.begin - recording.offset, part.end - recording.offset
            recording = recording.cut(last) if np.isfinite(last) else recording.cut(end=first)
    return recording


def while_driven(here: Task, recording: Recording) -> Recording:
    """Without stretches in which the boat is carried, towed or adrift."""
    start, end = None, None
    log = here.log_of.get(recording.sources)
    for found in undriven_motion(recording):
        if log is not None:
            here.left_out.setdefault(log, []).append(found.span(recording))
        which = f"from {found.start:.0f} s on,"
        if found.first or found.last:
            which = "the first" if found.first else "the last"
        here.assumed.append(
            f"{which} {found.end - found.start:.0f} s of {recording.name} are left out: the boat moves "
            f"{found.moved:.0f} m there without a command (carried, towed or adrift)"
        )
        if found.first:
            start = found.end
        elif found.last:
            end = found.start
        else:
            recording = recording.without(found.start, found.end)
    return recording if start is end is None else recording.cut(start, end)


def as_model_reads(
    here: Task, model: Model, vehicle: Vehicle, recordings: Sequence[Recording]
) -> list[Recording]:
    """The recordings as the model's vehicle reads them: with the lever arm and delays that were estimated."""
    if (model.vehicle.lever, model.vehicle.delays) == (vehicle.lever, vehicle.delays):
        return [*recordings]
    found = []
    for one in recordings:
        # two logs may have one name
        again = read(here.log_of[one.sources], model.vehicle, salvage=here.salvage)
        part = again.cut(one.offset or None, one.offset + one.duration + 0.5 * one.period)
        for fault in one.faults:
            if fault.kind is FaultKind.EXCLUDED:
                part = part.without(fault.start, fault.end)
        found.append(replace(part, name=one.name))
    return found
