# SPDX-License-Identifier: MIT
"""A model's file: written in the axes of its vehicle file, read into forward-left-up axes, and checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np

from seatrial.boat.model import Model
from seatrial.boat.older_files.notes import with_findings
from seatrial.boat.schema import ChainGroup, CoefficientEntry, EnvelopeEntry, ModelFile
from seatrial.boat.structure import Structure
from seatrial.boat.vehicle import Vehicle, vehicle_from
from seatrial.util.arguments import expect
from seatrial.util.errors import ModelError
from seatrial.util.files import convert, dump_yaml, expect_format, read_yaml, write_text
from seatrial.util.frames import SYMBOLS, Array, Axes

MODEL_FORMAT: Final = "model 3"
NOTES_FORMAT: Final = "model 2"  # the same with sentences in place of findings; read, not written
ROUNDED = 1e-6  # share of a variance that numbers in a file may be off by


def save(model: Model, path: str | Path) -> None:
    """Write `model.yaml` in the vehicle's own axes, whole or not at all."""
    expect(model, Model, "model")
    write_text(Path(path), dump_yaml(_content_of(model)))


def load(path: str | Path) -> Model:
    """A model from its file, in forward-left-up axes. Raises SeatrialError."""
    content = expect_format(read_yaml(Path(path)), MODEL_FORMAT, path, earlier=(NOTES_FORMAT,))
    if content["seatrial"] == NOTES_FORMAT:
        content = {**content, "seatrial": MODEL_FORMAT}
        content["estimator"] = with_findings(content.get("estimator"), f"{path}: estimator")
    return _from_file(convert(content, ModelFile, path), str(path))


def model_of(model: Model | str | Path) -> Model:
    """A model as given, or that of a file. Raises SeatrialError."""
    expect(model, (Model, str, Path), "model")
    return model if isinstance(model, Model) else load(model)


def _signs(vehicle: Vehicle) -> Array:
    """What turns coefficients and constants from one kind of axes into the other."""
    flipped = vehicle.structure.flipped_coefficients
    names = (*vehicle.structure.coefficients, *vehicle.constants.names)
    return np.array([-1.0 if name in flipped else 1.0 for name in names])


def _content_of(model: Model) -> dict[str, Any]:
    vehicle, frd = model.vehicle, model.vehicle.axes is Axes.FRD
    structure = model.structure.flipped() if frd else model.structure
    sign = _signs(model.vehicle) if frd else np.ones(len(model.parameters))
    values = (np.concatenate([model.coefficients, model.constants]) * sign).tolist()
    covariance = (model.covariance * np.outer(sign, sign)).tolist()
    entries = [
        CoefficientEntry(value, float(f"{model.standard_errors[name]:.6g}"), vehicle.units[name])
        for name, value in zip(model.parameters, values, strict=True)
    ]
    size = len(structure.coefficients)
    mapping = vehicle.to_mapping()
    del mapping["structure"]
    file = ModelFile(
        MODEL_FORMAT,
        version("seatrial"),
        model.name,
        vehicle.axes.value,
        structure.lines(),
        dict(zip(structure.coefficients, entries[:size], strict=True)),
        dict(zip(vehicle.constants.names, entries[size:], strict=True)),
        covariance,
        model.integration,
        model.noise,
        _flip_envelope(model.envelope, structure) if frd else model.envelope,
        list(model.recordings),
        model.estimator,
        list(model.warnings),
        mapping,
    )
    content: dict[str, Any] = msgspec.to_builtins(file)
    return {"seatrial": MODEL_FORMAT, **content}


def _from_file(file: ModelFile, path: str) -> Model:
    vehicle = vehicle_from({**file.vehicle, "structure": file.structure}, f"{path}: vehicle")
    if vehicle.axes.value != file.axes:
        raise ModelError(f"{path}: axes are {file.axes} but its vehicle's are {vehicle.axes.value}")
    structure, frd = vehicle.structure, vehicle.axes is Axes.FRD
    _same_names(path, "coefficients", file.coefficients, structure.coefficients)
    _same_names(path, "constants", file.constants, vehicle.constants.names)
    n = len(structure.coefficients) + len(vehicle.constants.names)
    matrix = _covariance_of(file.covariance, n, path)
    _check_constants(path, file, vehicle)
    sign = _signs(vehicle) if frd else np.ones(n)
    values = np.array([file.coefficients[name].value for name in structure.coefficients])
    return Model(
        vehicle,
        values * sign[: len(values)],
        matrix * np.outer(sign, sign),
        np.array([file.constants[name].value for name in vehicle.constants.names]),
        file.integration,
        file.noise,
        _flip_envelope(file.envelope, structure) if frd else file.envelope,
        tuple(file.recordings),
        file.estimator,
        tuple(file.warnings),
    )


def _covariance_of(covariance: Sequence[Sequence[float]], n: int, path: str) -> Array:
    """The matrix (n, n). Raises ModelError where it is not the covariance of anything."""
    if len(covariance) != n or any(len(row) != n for row in covariance):
        raise ModelError(
            f"{path}: covariance must be {n} x {n}, as there are {n} coefficients and constants"
        )
    matrix = np.array(covariance)
    if not np.allclose(matrix, matrix.T, rtol=1e-6, atol=0) or np.any(np.diag(matrix) < 0):
        raise ModelError(f"{path}: covariance must be symmetric with variances >= 0")
    size = np.sqrt(np.diag(matrix))
    own = size > 0
    if np.any(
        np.linalg.eigvalsh(matrix[np.ix_(own, own)] / np.outer(size[own], size[own])) < -ROUNDED
    ):
        raise ModelError(
            f"{path}: covariance has a negative eigenvalue; it must be positive semidefinite"
        )
    return matrix


def _check_constants(path: str, file: ModelFile, vehicle: Vehicle) -> None:
    """Raise ModelError for a parameter in another unit, or a constant out of its range."""
    units = vehicle.units
    for name, entry in {**file.coefficients, **file.constants}.items():
        if entry.unit and entry.unit != units[name]:
            raise ModelError(f"{path}: {name} is in '{entry.unit}'; it must be in '{units[name]}'")
        if name in file.constants:
            _in_range(path, vehicle, name, entry.value)


def _in_range(path: str, vehicle: Vehicle, name: str, value: float) -> None:
    """Raise ModelError where a constant is what no vehicle file may state."""
    chain = msgspec.to_builtins(vehicle.with_stated({name: value}).file.chain)
    try:
        msgspec.convert(chain, list[ChainGroup])
    except msgspec.ValidationError as error:
        expected = str(error).partition(" - at")[0].replace("`float`", "a number")
        expected = expected[:1].lower() + expected[1:]
        raise ModelError(f"{path}: {name} is {value:g}; {expected}") from None


def _same_names(path: str, what: str, got: Mapping[str, object], expected: Sequence[str]) -> None:
    if set(got) != set(expected):
        odd = sorted(set(got) ^ set(expected))
        raise ModelError(
            f"{path}: {what} and structure disagree on {', '.join(odd)}; "
            f"expected {', '.join(expected) or 'none'}"
        )


def _flip_envelope(envelope: EnvelopeEntry, structure: Structure) -> EnvelopeEntry:
    def flip(
        ranges: dict[str, tuple[float, float]], odd: frozenset[str]
    ) -> dict[str, tuple[float, float]]:
        return {n: ((-b, -a) if n in odd else (a, b)) for n, (a, b) in ranges.items()}

    return EnvelopeEntry(
        flip(envelope.speeds, frozenset(SYMBOLS[1:])), flip(envelope.forces, structure.odd_forces)
    )
