# SPDX-License-Identifier: MIT
"""The first step of a guided path: the vehicle file, proposed once, then the user's."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from seatrial.boat.model_file import load
from seatrial.boat.vehicle import Vehicle, load_vehicle
from seatrial.guide.answers import assumptions, choices_of, proposed
from seatrial.guide.steps import Task
from seatrial.inspection.proposal.sources import Choices
from seatrial.io.reader import recording_names
from seatrial.util.errors import FileError, RecordingError, VehicleError
from seatrial.util.files import write_text
from seatrial.util.format import joined


def vehicle_of(here: Task, choices: Choices) -> tuple[Vehicle, bool]:
    """The vehicle, and whether its file was proposed now."""
    path = here.file("vehicle.yaml")
    proposed_now = not path.exists()
    if proposed_now:
        _propose(here, choices)
    else:
        unused = (
            "; options on the boat are not used: change the file"
            if replace(choices, name=None) != Choices()
            else ""
        )
        here.say(f"vehicle   {path}, as it is{unused}")
        here.assumed += _other_logs(here)
    return load_vehicle(path), proposed_now


def _propose(here: Task, choices: Choices) -> None:
    """Write the file from the logs and what is answered or assumed."""
    if here.file("model.yaml").exists():
        raise FileError(
            f"{here.folder}: has a model but no vehicle.yaml; give another folder, or remove it"
        )
    path = here.file("vehicle.yaml")
    chosen = choices_of(here.logs[0], choices, here.ask)
    proposal, chosen = proposed(here.logs, chosen, here.ask, salvage=here.salvage)
    here.assumed += assumptions(here.logs[0], proposal, chosen, here.ask)
    write_text(path, proposal.text)
    inputs = joined([*proposal.drive.inputs])
    axes = joined(
        [force["axis"] for force in proposal.drive.forces.values()] or ["surge, sway, yaw"]
    )
    for found in proposal.sources.notes.get("clock", []):
        here.say(f"vehicle   {found}")
    here.say(f"vehicle   {inputs} drive {axes}  -> {path}")


def _other_logs(here: Task) -> list[str]:
    """What is assumed where the folder has a model of other recordings, none of them given."""
    path = here.file("model.yaml")
    before = [entry.name for entry in load(path).recordings] if path.exists() else []
    if not before or set(before) & {*recording_names(here.logs)}:
        return []
    return [
        f"these logs are of the boat in {here.file('vehicle.yaml')}, whose model was of {joined(before)} and "
        "is replaced (-o for another boat)"
    ]


@contextmanager
def of_this_boat(here: Task, *, proposed_now: bool) -> Iterator[None]:
    """Refuses logs that a vehicle file that was there does not describe: the folder may be another boat's."""
    try:
        yield
    except (RecordingError, VehicleError) as error:
        if proposed_now:
            raise
        logs = joined([str(log) for log in here.logs])
        raise RecordingError(
            f"{here.folder} has a vehicle file that does not describe {logs}: {error}. "
            "If it is another boat's folder, give another one with -o; else change the file, or remove it"
        ) from error
