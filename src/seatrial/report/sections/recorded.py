# SPDX-License-Identifier: MIT
"""Recordings: tracks, gaps, coverage of speeds and commands."""

from collections.abc import Sequence
from string import Template

from seatrial.recording.faults.pose_faults import FaultKind
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.runs import Run
from seatrial.report.figures import recorded as draw
from seatrial.report.figures.base import driven_axes
from seatrial.report.sections.base import (
    ALL,
    Section,
    fine,
    first_of,
    foldable,
    plot,
    recorded_plots,
    store_of,
    three,
)
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Number, Text
from seatrial.report.text.markup import number
from seatrial.report.text.numbers import minutes
from seatrial.report.text.table import Table
from seatrial.util.frames import AXES, SYMBOLS


def section(evidence: Evidence) -> Section:
    """All recordings together, then each."""
    model, runs = evidence.model, evidence.runs
    driven = driven_axes(model)
    parts = "\n".join(
        _one(run, i, driven, opened=i == first_of(runs)) for i, run in enumerate(runs)
    )
    note = Template(prose.RECORDED_NOTE).substitute(scatter=draw.SCATTER)
    body = f"""<p class="note">{note}</p>
{recorded_plots()}
{summary(evidence).html()}
<h3>Speeds against commands</h3>
{three(ALL, "cells", "time at each speed and command", axes=driven)}
{parts}"""
    figures = {
        ALL: {
            "tracks": draw.tracks(runs),
            "timeline": draw.timeline(runs),
            **{f"cells-{SYMBOLS[i]}": draw.cells(model, runs, i) for i in driven},
        }
    }
    for i, run in enumerate(runs):
        cover = {f"coverage-{SYMBOLS[a]}": draw.coverage(model, run, a) for a in driven}
        figures[store_of(i)] = {"track": draw.track(run), **cover}
    return Section("recorded", "Recordings", body, figures, (summary(evidence), excitations(runs)))


def summary(evidence: Evidence) -> Table:
    """A row for each recording."""
    head = ("recording", "length [s]", "poses", "rate [Hz]", "excluded [%]", "faults", "use")
    rows: list[list[Cell]] = []
    for run in evidence.runs:
        recording = run.recording
        rows.append(
            [
                Text(recording.name), Number(recording.duration, 4), Text(f"{len(recording.t)}"),
                Number(1.0 / recording.period, 3), Number(run.excluded, 2, 100.0),
                Text(f"{len(recording.faults)}"), Text("not seen" if run.unseen else "identified from"),
            ]
        )  # fmt: skip
    return Table("recordings", "Recordings", head, rows)


def excitations(runs: tuple[Run, ...]) -> Table:
    """Excitation of every recording."""
    rows: list[Sequence[Cell]] = []
    for run in runs:
        rows += [[Text(run.name)], *excited(run).rows]
    return Table("excitations", "Excitation", excited(runs[0]).head, rows)


def excited(run: Run) -> Table:
    """Excitation by axis."""
    found = run.excitation
    rows: list[list[Cell]] = [
        [
            Text(name),
            Number(float(found.rms[i]), 2),
            Number(float(found.largest[i]), 2),
            Text(f"{100 * found.share[i]:.0f} %"),
            Text("yes" if found.both_signs[i] else "no"),
        ]
        for i, name in enumerate(AXES)
    ]
    head = ("commands in", "RMS", "largest", "share of effort", "both signs")
    return Table("excitation", f"Excitation of {run.name}", head, rows)


def fault_kinds(run: Run) -> Table:
    """Faults of a recording by kind."""
    rows: list[list[Cell]] = []
    for kind in FaultKind:
        found = [f for f in run.recording.faults if f.kind is kind]
        if found:
            seconds = sum(f.end - f.start for f in found)
            samples = sum(f.samples for f in found)
            cells = (kind.value, f"{len(found)}", f"{samples}", f"{seconds:.1f}")
            rows.append([Text(cell) for cell in cells])
    head = ("fault", "times", "poses", "seconds")
    return Table("fault-kinds", f"Faults of {run.name}", head, rows)


def faults(run: Run) -> Table:
    """Every fault of a recording."""
    rows = [
        [Text(f.kind.value), Text(f"{f.start:.2f}"), Text(f"{f.end:.2f}"), Text(f"{f.samples}")]
        for f in run.recording.faults
    ]
    return Table("faults", f"Faults of {run.name}", ("fault", "from [s]", "to [s]", "poses"), rows)


def _one(run: Run, place: int, driven: Sequence[int], *, opened: bool) -> str:
    recording, store = run.recording, store_of(place)
    facts = (
        f"{minutes(recording.duration)}, {len(recording.t)} poses at "
        f"{number(1.0 / recording.period, 3)} Hz, {100 * run.excluded:.1f} % excluded"
    )
    broken = "<p>No faults found.</p>"
    if recording.faults:
        every = fine(f"every fault ({len(recording.faults)})", faults(run).html())
        broken = fault_kinds(run).html() + every
    inside = f"""<div class="pair">{plot(store, "track", "track of the boat", "square")}
<div>{excited(run).html()}{broken}</div></div>
{three(store, "coverage", "speed against command", axes=driven)}"""
    return foldable(recording.name, facts, inside, opened=opened)
