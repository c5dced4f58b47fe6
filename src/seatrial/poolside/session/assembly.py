# SPDX-License-Identifier: MIT
"""A session of a boat and a source, with all its parts."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from seatrial.boat.model import Model
from seatrial.boat.vehicle import Vehicle
from seatrial.monitoring.change_detector import ChangeDetector
from seatrial.poolside.area import Area
from seatrial.poolside.coverage import Coverage
from seatrial.poolside.live_estimator import LiveEstimator
from seatrial.poolside.live_prediction import LivePrediction
from seatrial.poolside.recorder import Recorder
from seatrial.poolside.session.guide import DriveGuide
from seatrial.poolside.session.live_session import RECORDING, Session
from seatrial.poolside.session.parts import Parts
from seatrial.poolside.session.saving import save_drive, save_mcap
from seatrial.poolside.signal_health import SignalHealth
from seatrial.poolside.sources import EventSource
from seatrial.util.errors import FileError, ModelError
from seatrial.workflow.fitness import Use


@dataclass(frozen=True)
class Wishes:
    """What a user may choose."""

    area: Area | None = None  # in the vehicle's own axes
    uses: tuple[Use, ...] = tuple(Use)
    effects: Sequence[str] = ()
    mcap: bool = False  # the recording as .mcap, too


def make_session(
    boat: Vehicle | Model, source: EventSource, folder: Path, wishes: Wishes | None = None
) -> Session:
    """A session that writes into a new folder. With a model, a change of the boat is tested for.

    Raises FileError where the folder has files.
    """
    wishes = wishes or Wishes()
    if folder.is_dir() and any(folder.iterdir()):
        raise FileError(f"{folder}: is not empty; give another folder with -o")
    model = boat if isinstance(boat, Model) else None
    vehicle = boat.vehicle if isinstance(boat, Model) else boat
    coverage, prediction = Coverage(vehicle), LivePrediction()
    if model is not None:
        prediction.reload(model)
    parts = Parts(
        source=source,
        estimator=LiveEstimator(vehicle, start=model, effects=wishes.effects),
        health=SignalHealth(vehicle, by_columns=source.by_columns),
        recorder=Recorder(folder / RECORDING, vehicle),
        prediction=prediction,
        coverage=coverage,
        guide=DriveGuide(vehicle, coverage, wishes.area, wishes.uses),
        detector=None if model is None else _detector(model),
    )
    corners = () if wishes.area is None else tuple((x, y) for x, y in wishes.area.corners.tolist())
    save = partial(save_drive, folder=folder, effects=wishes.effects)
    copy = partial(save_mcap, folder=folder) if wishes.mcap else None
    return Session(vehicle, parts, folder, walls=corners, save=save, copy=copy)


def _detector(model: Model) -> ChangeDetector | None:
    """The test for a change of the boat; None where the model allows none."""
    try:
        return ChangeDetector(model)
    except ModelError:
        return None
