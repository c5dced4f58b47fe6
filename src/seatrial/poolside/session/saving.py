# SPDX-License-Identifier: MIT
"""What a session leaves beside its recording: the model and its report."""

from collections.abc import Sequence
from pathlib import Path

from seatrial.boat.model_file import save
from seatrial.boat.vehicle import load_vehicle
from seatrial.identification.methods import identify
from seatrial.io import read
from seatrial.io.convert import convert
from seatrial.poolside.recorder import FILES
from seatrial.report import write_report
from seatrial.util.errors import RecordingError
from seatrial.util.progress import stage

VEHICLE, MODEL, REPORT = "vehicle.yaml", "model.yaml", "report.html"
MCAP = "recording.mcap"


def save_mcap(recording: Path, folder: Path) -> dict[str, str]:
    """The recording as an .mcap in `folder`, and its vehicle file; its path. Raises SeatrialError."""
    with stage("writing the .mcap"):
        convert(recording, folder / MCAP, load_vehicle(recording / VEHICLE))
    return {"mcap": str(folder / MCAP)}


def save_drive(recording: Path, folder: Path, effects: Sequence[str] = ()) -> dict[str, str]:
    """Model and report of a recording, as `identify` and `report` write them, into `folder`; their paths.

    recording: a folder with the vehicle file that reads it. A file appears when it is whole. Raises SeatrialError.
    """
    vehicle = load_vehicle(recording / VEHICLE)
    if not (recording / FILES["command"]).exists():
        raise RecordingError(
            f"no command has come: send commands of {', '.join(vehicle.inputs)} beside the poses"
        )
    with stage("reading", 0.05):
        read_back = read(recording, vehicle)
    with stage("identifying", 0.75):
        model = identify([read_back], vehicle, effects=effects)
    save(model, folder / MODEL)
    with stage("report"):
        write_report(model, [read_back], folder / REPORT)
    paths = {"vehicle": recording / VEHICLE, "model": folder / MODEL, "report": folder / REPORT}
    return {what: str(path) for what, path in paths.items()}
