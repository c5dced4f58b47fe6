# SPDX-License-Identifier: MIT
"""The page of a fleet: what asks for attention, the table of all boats, each boat against its kind."""

from dataclasses import dataclass
from html import escape
from pathlib import Path
from urllib.parse import quote

import numpy as np

from seatrial.fleet.console import asks, change_words, first_line, headline, verdict_of
from seatrial.fleet.kinds import deviations
from seatrial.fleet.results import FleetResult
from seatrial.report.figures.base import BLUE, RED, Figure, figure, marks, named_rows
from seatrial.report.html import page
from seatrial.report.sections.base import ALL, Section, plot
from seatrial.report.text.cells import Cell, Name, Number, Text, Unit, known
from seatrial.report.text.table import Table
from seatrial.util.files import write_text
from seatrial.util.frames import AXES, SYMBOLS

ALL_HEAD = ("boat", "kind", "recordings read", *(f"{a} ratio" for a in AXES), "verdict", "why")
ALL_NOTE = (
    "Ratio: RMS error of the velocity one second ahead on what was held out, over that of constant velocity. "
    "Below 1 the model is worth having. Shaded boats ask for attention. A boat's name leads to its own report."
)
KIND_NOTE = (
    "Centre: robust mean over the boats. Between boats: standard deviation of the boats themselves, without the "
    "standard errors of their estimates. z: distance of a boat from the centre in standard deviations. "
    "A boat differs where chance does not explain its z, by Holm's correction over all boats and parameters."
)
CHANGE_NOTE = "Each boat against its previous model; significant by Holm's correction over parameters and boats."
RECORDING_NOTE = (
    "A recording that can't be read is left out; its boat is identified from the others. A recording is bad, too, "
    "where a finding on the model names it, or where few of its poses are usable."
)


@dataclass(frozen=True)
class Link(Text):
    """A boat, and the way to its page."""

    path: str | None

    def html(self) -> str:
        """Escaped both ways."""
        if self.path is None:
            return escape(self.text)
        return f'<a href="{escape(quote(self.path))}">{escape(self.text)}</a>'


def write_fleet_page(found: FleetResult, path: Path) -> None:
    """Write the page, atomically."""
    sections = [_verdict(found), _boats(found), *_kinds(found), *_changes(found), *_bad(found)]
    write_text(path, page(f"{found.name}: seatrial fleet", sections))


def _verdict(found: FleetResult) -> Section:
    above = f"""<header><h1>{escape(found.name)}</h1>
<p class="lead">{escape(headline(found))}</p></header>"""
    return Section("verdict", "", "", above=above)


def _boats(found: FleetResult) -> Section:
    rows: list[list[Cell]] = []
    marked = set()
    for place, boat in enumerate(found.boats):
        own = boat.result
        read = sum(r.error is None for r in own.recordings)
        rows.append([
            Link(own.name, boat.report), Text(own.kind), Text(f"{read} of {len(own.recordings)}"),
            *(known(own.ratios.get(symbol), 2) for symbol in SYMBOLS),
            Text(verdict_of(boat)), Text(first_line(boat)),
        ])  # fmt: skip
        if asks(boat):
            marked.add(place)
    table = Table("boats", "All boats", ALL_HEAD, rows, frozenset(marked))
    body = f"""<p class="note">{escape(ALL_NOTE)}</p>
{table.html()}"""
    return Section("boats", "All boats", body, tables=(table,))


def _kinds(found: FleetResult) -> list[Section]:
    """Each kind's parameters, and the boats that are far from them."""
    sections = []
    for place, (name, kind) in enumerate(found.kinds.items()):
        if not kind.parameters:
            continue
        rows: list[list[Cell]] = [
            [Name(p), Number(k.centre), Number(k.between, 2), Unit(k.unit), Text(str(k.boats))]
            for p, k in kind.parameters.items()
        ]
        head = ("parameter", "centre", "between boats", "unit", "boats")
        table = Table(f"kind-{place}", f"Parameters of {name}", head, rows)
        own = [boat for boat in found.boats if boat.result.kind == name and boat.differs]
        differing = Table(f"differing-{place}", f"Boats that differ from {name}", DIFFER_HEAD, [
            [Link(boat.result.name, boat.report), Name(d.parameter), Number(d.value), Number(d.centre),
             Number(d.z, 3), Number(d.p, 2)]
            for boat in own for d in boat.differs
        ])  # fmt: skip
        drawn = plot(ALL, f"kind-{place}", f"boats of {name} against their kind", "tall",
                     rows=len(kind.parameters))  # fmt: skip
        body = f"""<p class="note">{escape(KIND_NOTE)}</p>
{drawn}{differing.html() if own else "<p>No boat differs from its kind.</p>"}
{table.html()}"""
        figures = {ALL: {f"kind-{place}": _picture(found, name)}}
        sections.append(Section(f"kind-{place}", name, body, figures, (table, differing)))
    return sections


DIFFER_HEAD = ("boat", "parameter", "value", "centre", "z", "p")


def _picture(found: FleetResult, name: str) -> Figure:
    """A row for each parameter, a point for each boat: the z of its test."""
    parameters = found.kinds[name].parameters
    compared = [
        boat for boat in found.boats
        if boat.result.kind == name and not boat.not_compared and boat.result.error is None
    ]  # fmt: skip
    # by whether it differs
    points: dict[bool, list[tuple[float, float, str]]] = {False: [], True: []}
    for place, p in enumerate(parameters):
        own = [boat for boat in compared if p in boat.result.parameters]
        _, tested = deviations(p, [boat.result for boat in own])
        for boat, one in zip(own, tested, strict=True):
            far = p in {d.parameter for d in boat.differs}
            points[far].append((one.z, -float(place), escape(boat.result.name)))
    traces = []
    for far, colour, words in ((False, BLUE, "as its kind"), (True, RED, "differs")):
        if points[far]:
            z, rows_of, hover = zip(*points[far], strict=True)
            trace = marks(
                words, np.column_stack([z, rows_of]), colour, "diamond" if far else "circle"
            )
            traces.append(trace | {"text": [*hover], "hoverinfo": "text+x"})
    rows = named_rows([*parameters])[1]
    return figure(
        traces, "distance from the kind [standard deviations]", "", yaxis=rows, showlegend=True
    )


def _changes(found: FleetResult) -> list[Section]:
    rows: list[list[Cell]] = [
        [Link(boat.result.name, boat.report), Text("changed" if boat.changed else "no change"),
         Text(change_words(boat))]
        for boat in found.boats if boat.result.change is not None
    ]  # fmt: skip
    if not rows:
        return []
    table = Table("changes", "Since last time", ("boat", "verdict", "why"), rows, numbers=False)
    body = f"""<p class="note">{escape(CHANGE_NOTE)}</p>
{table.html()}"""
    return [Section("changes", "Since last time", body, tables=(table,))]


def _bad(found: FleetResult) -> list[Section]:
    rows: list[list[Cell]] = [
        [Link(boat.result.name, boat.report), Text(r.name), Text(r.error or " ".join(r.remarks))]
        for boat in found.boats for r in boat.result.recordings if r.bad
    ]  # fmt: skip
    if not rows:
        return []
    table = Table("recordings", "Bad recordings", ("boat", "recording", "why"), rows, numbers=False)
    body = f"""<p class="note">{escape(RECORDING_NOTE)}</p>
{table.html()}"""
    return [Section("recordings", "Bad recordings", body, tables=(table,))]
