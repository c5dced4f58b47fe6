# SPDX-License-Identifier: MIT
"""The export formats. A new one is a function here that calls its own file."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from seatrial.export import c, casadi, fmu, json, latex, octave, ros, sdf
from seatrial.export.content import Content
from seatrial.export.hull import Hull
from seatrial.export.spelling import identifier
from seatrial.util.errors import ExportError


@dataclass(frozen=True)
class Request:
    """A model to export, with the user's options."""

    content: Content
    out: Path
    model_path: Path | None = None  # of model.yaml, for programs that read it themselves
    hull: Hull | None = None  # mass and size, for dimensional formats
    ros: int = 2  # ROS 1 or ROS 2

    @property
    def name(self) -> str:
        """The file's name as a name in a program."""
        return identifier(self.out.stem)


@dataclass(frozen=True)
class Format:
    """One format."""

    about: str
    suffix: str  # of its files
    begins: str  # first characters of its files, so that no other file is overwritten
    runs: bool  # it simulates a boat: an unstable model is refused
    write: Callable[[Request], bytes | str]
    lacks: Callable[[], str] = str  # what a file that is made here lacks, and why

    @property
    def made_here(self) -> str:
        """What it is, and what it lacks."""
        return "; ".join(filter(None, (self.about, self.lacks())))


def _octave(request: Request) -> str:
    name = octave.function_name(request.name)
    if request.out.stem != name:
        raise ExportError(
            f"{request.out}: MATLAB and Octave call a function by its file's name; name it {name}.m"
        )
    return octave.function(request.content, name)


FORMATS = {
    "c": Format(
        "self-contained C99 header", ".h", "/* ", True, lambda r: c.header(r.content, r.name)
    ),
    "octave": Format("MATLAB and Octave function", ".m", "function", True, _octave),
    "fmu": Format(
        "Functional Mock-up Unit, FMI 2.0 for co-simulation",
        ".fmu",
        "PK",
        True,
        lambda r: fmu.unit(r.content, r.name),
        fmu.sources_only,
    ),
    "sdf": Format(
        "Gazebo model", ".sdf", "<?xml", True, lambda r: sdf.text(r.content.model, r.name, r.hull)
    ),
    "casadi": Format(
        "serialized CasADi functions", ".casadi", "jhpnn", True, lambda r: casadi.write(r.content)
    ),
    "ros": Format(
        "ROS parameters",
        ".yaml",
        "# ROS",
        False,
        lambda r: ros.text(r.content, r.model_path, r.ros),
    ),
    "latex": Format(
        "LaTeX equations and table", ".tex", "%", False, lambda r: latex.text(r.content)
    ),
    "json": Format("JSON, the whole model", ".json", "{", False, lambda r: json.text(r.content)),
}


def format_of(name: str) -> Format:
    """A format by its name. Raises ExportError."""
    if name not in FORMATS:
        raise ExportError(f"no format '{name}'; there are {', '.join(FORMATS)}")
    return FORMATS[name]
