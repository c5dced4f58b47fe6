# SPDX-License-Identifier: MIT
"""Writing a model in one of the export formats."""

from pathlib import Path

from seatrial.boat.model import Model
from seatrial.boat.physics import axis_physics
from seatrial.export.content import Content
from seatrial.export.formats import Request, format_of
from seatrial.export.hull import Hull
from seatrial.util.arguments import expect
from seatrial.util.errors import ExportError
from seatrial.util.files import write_bytes


def export(
    model: Model,
    to: str,
    out: str | Path,
    *,
    model_path: str | Path | None = None,
    hull: Hull | None = None,
    ros: int = 2,
) -> None:
    """Write a model for another program, in the axes of its vehicle file, atomically.

    `to`: one of FORMATS; programs and functions in the file are named after it. `hull`: mass and size,
    for sdf. `model_path`: of the model's file, for ros. Raises ExportError for a model that a format
    can't represent, and ModelError for an unstable one.
    """
    expect(model, Model, "model")
    chosen, path = format_of(to), Path(out)
    if path.suffix != chosen.suffix:
        raise ExportError(f"{path}: expected a name that ends in {chosen.suffix}: {chosen.about}")
    if chosen.runs:
        axis_physics(model)
    source = None if model_path is None else Path(model_path)
    made = chosen.write(Request(Content(model), path, source, hull, ros))
    write_bytes(path, made.encode() if isinstance(made, str) else made)
