# SPDX-License-Identifier: MIT
"""A Functional Mock-up Unit, FMI 2.0 for co-simulation: with the C header, and a binary for this platform."""

import io
import os
import platform
import shlex
import shutil
import subprocess
import tempfile
import uuid
import zipfile
from pathlib import Path
from xml.etree import ElementTree as Xml

from seatrial.export import c
from seatrial.export.content import Content
from seatrial.export.spelling import c_comment, identifiers, line
from seatrial.export.template import fill, template
from seatrial.export.terms import number
from seatrial.util.errors import ExportError

STATE_UNITS = (("x", "m"), ("y", "m"), ("psi", "rad"), ("u", "m/s"), ("v", "m/s"), ("r", "rad/s"))
BASE_UNITS = {
    "m": {"m": 1},
    "rad": {"rad": 1},
    "m/s": {"m": 1, "s": -1},
    "rad/s": {"rad": 1, "s": -1},
}
PLATFORMS = {("Linux", "x86_64"): ("linux64", ".so"), ("Darwin", "arm64"): ("darwin64", ".dylib"),
             ("Darwin", "x86_64"): ("darwin64", ".dylib")}  # fmt: skip
ARCHIVE_DATE = (1980, 1, 1, 0, 0, 0)  # of the archive's files: makes its bytes reproducible


def sources_only() -> str:
    """Why a unit that is made here has sources only; empty: it has a library."""
    if _target() is None:
        platforms = " and ".join(" ".join(each) for each in PLATFORMS)
        here = f"{platform.system()} {platform.machine()}"
        return f"sources only: libraries are made on {platforms}, not on {here}"
    command = _compiler()
    if shutil.which(command[0]) is None:
        return (
            f"sources only: there is no C compiler '{command[0]}'; install it, or set CC to another"
        )
    return ""


def unit(content: Content, name: str) -> bytes:
    """The archive's bytes, with a library where `sources_only` has no reason against it. Raises ExportError."""
    header = c.header(content, name)
    guid = f"{{{uuid.uuid5(uuid.NAMESPACE_OID, header)}}}"
    source = _source(content, name, guid)
    files = {
        "modelDescription.xml": description(content, name, guid),
        f"sources/{name}.h": header.encode(),
        "sources/fmu.c": source.encode(),
        **_binary(name, header, source),
    }
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as zipped:
        for path, data in files.items():
            zipped.writestr(zipfile.ZipInfo(path, ARCHIVE_DATE), data, zipfile.ZIP_DEFLATED)
    return archive.getvalue()


def _source(content: Content, name: str, guid: str) -> str:
    starts = [
        f"own->real[SCALE + {i}] = {number(v)};" for i, v in enumerate(content.scales.values())
    ]
    inputs = [f"own->boat.scale[{i}] = own->real[SCALE + {i}];" for i in range(len(starts))]
    words = {
        "name": name,
        "NAME": name.upper(),
        "source": c_comment(content.source),
        "guid": guid,
        "SCALES": str(len(starts)),
        "scale_starts": "".join(f"  {line}\n" for line in starts),
        "scale_inputs": "".join(f"  {line}\n" for line in inputs),
    }
    return fill(template("fmu.c"), words)


def _binary(name: str, header: str, source: str) -> dict[str, bytes]:
    """The library for this platform, where one can be made. Raises ExportError where the compiler fails."""
    target = _target()
    if target is None or sources_only():
        return {}
    folder_name, suffix = target
    compiler = _compiler()
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / f"{name}{suffix}"
        (Path(folder) / f"{name}.h").write_text(header, encoding="utf-8")
        (Path(folder) / "fmu.c").write_text(source, encoding="utf-8")
        command = [
            *compiler, "-std=c99", "-O2", "-fPIC", "-shared", "-o", str(library), "fmu.c", "-lm",
        ]  # fmt: skip
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            first = (done.stderr.strip() or "no message").splitlines()[0]
            raise ExportError(
                f"{shlex.join(compiler)} can't compile the unit: {first}; set CC to another compiler"
            )
        return {f"binaries/{folder_name}/{library.name}": library.read_bytes()}


def _target() -> tuple[str, str] | None:
    """Folder and suffix of this platform's libraries."""
    return PLATFORMS.get((platform.system(), platform.machine()))


def _compiler() -> list[str]:
    """CC as a shell reads it: a program, which may be a wrapper, and its options. Raises ExportError."""
    given = os.environ.get("CC", "")
    try:
        return shlex.split(given) or ["cc"]
    except ValueError as error:
        raise ExportError(f"CC is no command: {given} ({error})") from None


def description(content: Content, name: str, guid: str) -> bytes:
    """modelDescription.xml: inputs, known signals, start values, state and forces, in this order."""
    root = Xml.Element(
        "fmiModelDescription", fmiVersion="2.0", modelName=content.vehicle_name, guid=guid,
        description=f"Surge, sway and yaw of {content.vehicle_name}, axes {content.axes.value}",
        generationTool=content.source, variableNamingConvention="flat", numberOfEventIndicators="0",
    )  # fmt: skip
    unit = Xml.SubElement(
        root, "CoSimulation", modelIdentifier=name, canHandleVariableCommunicationStepSize="true",
        canGetAndSetFMUstate="true",
    )  # fmt: skip
    Xml.SubElement(Xml.SubElement(unit, "SourceFiles"), "File", name="fmu.c")
    units = Xml.SubElement(root, "UnitDefinitions")
    for text, powers in BASE_UNITS.items():
        base = {key: str(power) for key, power in powers.items()}
        Xml.SubElement(Xml.SubElement(units, "Unit", name=text), "BaseUnit", base)
    step = number(content.longest_step)
    Xml.SubElement(root, "DefaultExperiment", startTime="0.0", stepSize=step)
    outputs = _variables(content, Xml.SubElement(root, "ModelVariables"))
    structure = Xml.SubElement(root, "ModelStructure")
    for kind in ("Outputs", "InitialUnknowns"):
        listed = Xml.SubElement(structure, kind)
        for place in outputs:
            known = {"dependencies": ""} if kind == "Outputs" else {}
            Xml.SubElement(listed, "Unknown", {"index": str(place), **known})
    Xml.indent(root)
    return bytes(Xml.tostring(root, encoding="utf-8", xml_declaration=True))


def _variables(content: Content, into: Xml.Element) -> list[int]:
    """Every variable in the order of its value reference; the indices of the outputs, from 1."""
    outputs = []
    taken = {f"{name}{end}" for name, _ in STATE_UNITS for end in ("", "_start")}
    inputs = identifiers(content.inputs, taken)
    taken |= {*inputs.values()}
    scales = identifiers(content.scales, taken)
    taken |= {*scales.values()}
    given = identifiers([f"{force}_given" for force in content.forces], taken)

    def add(name: str, about: str, real: dict[str, str], **kind: str) -> None:
        place = len(into)
        entry = {"name": name, "valueReference": str(place), "description": line(about), **kind}
        Xml.SubElement(Xml.SubElement(into, "ScalarVariable", entry), "Real", real)
        if kind["causality"] == "output":
            outputs.append(place + 1)

    held = {"causality": "input", "variability": "discrete"}
    for name in content.inputs:
        add(inputs[name], f"command {name}, holds until the next one", {"start": "0.0"}, **held)
    for name, reference in content.scales.items():
        known = {"start": number(reference)}
        add(scales[name], f"known signal {name} that scales thrust", known, **held)
    for name, measure in STATE_UNITS:
        real = {"unit": measure, "start": "0.0"}
        add(
            f"{name}_start", "at time 0", real, causality="parameter", variability="fixed", initial="exact",
        )  # fmt: skip
    computed = {"causality": "output", "variability": "continuous", "initial": "calculated"}
    for name, measure in STATE_UNITS:
        add(name, "of the boat", {"unit": measure}, **computed)
    for name in content.forces:
        add(given[f"{name}_given"], f"generalised force {name}, in command units", {}, **computed)
    return outputs
