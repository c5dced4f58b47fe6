# SPDX-License-Identifier: MIT
"""Provenance: version, method, settings, noise, files, envelope."""

from html import escape
from importlib.metadata import version

from seatrial.boat.model import Model
from seatrial.boat.schema import SourceEntry
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.sections.base import Section
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Name, Number, Text
from seatrial.report.text.markup import NOT_A_NUMBER, number
from seatrial.report.text.numbers import minutes
from seatrial.report.text.table import Table
from seatrial.util.frames import SPEED_UNITS, SYMBOLS


def section(evidence: Evidence) -> Section:
    """Version, method, settings, noise, files, envelope."""
    model = evidence.model
    lines = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in facts(evidence))
    tables = (files(evidence), envelope(model))
    body = f"""<dl class="facts">{lines}</dl>
<h3>Files</h3>{tables[0].html()}
<h3>Envelope</h3><p class="note">{prose.ENVELOPE}</p>{tables[1].html()}"""
    return Section("provenance", "Provenance", body, tables=tables)


def facts(evidence: Evidence) -> list[tuple[str, str]]:
    """Names and values."""
    return [*facts_of(evidence.model), ("horizon", f"{evidence.horizon:g} s")]


def facts_of(model: Model) -> list[tuple[str, str]]:
    """Names and values that describe a model."""
    noise, step, process = model.noise, model.integration, model.noise.process
    settings = {k: v for k, v in model.estimator.settings.items() if f"{v}"}
    chosen = ", ".join(f"{k} = {v}" for k, v in settings.items()) or "none"
    position, heading = number(1e3 * noise.position, 2), number(1e3 * noise.heading, 2)
    found = [
        ("seatrial", version("seatrial")),
        ("method", f"{model.estimator.method} (settings: {chosen})"),
        ("structure", model.structure.name),
        ("allocation", model.vehicle.scheme.value),
        ("axes", f"files {model.vehicle.axes.value}; in this report forward-left-up"),
        ("integration", f"{step.scheme}, step {number(step.step)} s"),
        ("pose noise", f"{position} mm, {heading} mrad"),
    ]
    if noise.correlated is not None:
        c = noise.correlated
        sizes = f"{number(1e3 * c.position, 2)} mm, {number(1e3 * c.heading, 2)} mrad"
        found.append(("correlated pose noise", f"{sizes}, over {c.memory_text}"))
    text = "none estimated"
    if process is not None:
        walks = f"{number(1e3 * process.walk_linear, 2)} mm/s, {number(1e3 * process.walk_yaw, 2)} mrad/s"
        forces = f"{number(process.disturbance_linear, 2)} m/s², {number(process.disturbance_yaw, 2)} rad/s²"
        memory = number(process.memory, 2)
        text = f"velocity random walk {walks} per √s; disturbance force {forces}, correlation time {memory} s"
        if process.sway_ratio != 1.0:
            text += f"; in sway {number(process.sway_ratio, 2)} times those of surge"
    return [*found, ("process noise", text)]


def files(evidence: Evidence) -> Table:
    """The files behind the model and behind the scores, with SHA-256."""
    uses: dict[tuple[str, str, str, str], list[str]] = {}
    none = SourceEntry(NOT_A_NUMBER, NOT_A_NUMBER)  # made in memory
    for entry in evidence.model.recordings:
        for file in entry.files or [none]:
            key = (entry.name, minutes(entry.length), file.name, file.sha256)
            uses.setdefault(key, []).append("identified from")
    for run in evidence.runs:
        for source in run.recording.sources or [none]:
            length = minutes(run.recording.duration)
            key = (run.name, length, source.name, source.sha256)
            uses.setdefault(key, []).append("predicted" if run.tested else "not predicted")
    rows = [
        [Text(name), Text(length), Text(", ".join(use)), Text(file), Text(digest)]
        for (name, length, file, digest), use in uses.items()
    ]
    head = ("recording", "length", "use", "file", "SHA-256")
    return Table("files", "Files", head, rows, numbers=False)


def envelope(model: Model) -> Table:
    """Ranges of speeds and forces in the identification data, forward-left-up."""
    rows: list[list[Cell]] = [
        [Name(n), Number(low, 3), Number(high, 3), Text(SPEED_UNITS[SYMBOLS.index(n)])]
        for n, (low, high) in model.envelope.speeds.items()
    ]
    rows += [
        [Name(n), Number(low, 3), Number(high, 3), Text("command units")]
        for n, (low, high) in model.envelope.forces.items()
    ]
    return Table("envelope", "Envelope", ("", "from", "to", "unit"), rows)
