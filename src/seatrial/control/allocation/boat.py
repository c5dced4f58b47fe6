# SPDX-License-Identifier: MIT
"""A model or a vehicle from its file."""

from pathlib import Path

from seatrial.boat.model import Model
from seatrial.boat.model_file import load
from seatrial.boat.vehicle import Vehicle, load_vehicle
from seatrial.util.errors import VehicleError
from seatrial.util.files import read_yaml


def load_boat(path: str | Path, vehicle: str | None = None) -> tuple[Model | Vehicle, Vehicle]:
    """A model or a vehicle from its file, and the vehicle that reads its recordings.

    `vehicle` replaces a model's signals and allocation. Raises SeatrialError.
    """
    given = Path(path)
    if not given.exists() or not str(read_yaml(given).get("seatrial", "")).startswith("model"):
        if vehicle is not None:
            raise VehicleError(
                f"{path}: is a vehicle itself; --vehicle {vehicle} needs a model; leave one out"
            )
        found = load_vehicle(given)
        return found, found
    model = load(given)
    if vehicle is not None:
        model = model.with_vehicle(load_vehicle(vehicle))
    return model, model.vehicle
