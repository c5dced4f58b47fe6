# SPDX-License-Identifier: MIT
"""Effects between boat and sensor, or of a recording: lever arm, delays, current, trim, wind."""

from collections.abc import Iterator

from seatrial.boat.earth_effects import earth_effects
from seatrial.boat.finding_kinds import UNMODELLED_EFFECTS
from seatrial.boat.findings import Finding, FindingKind, finding_text
from seatrial.boat.model import Model
from seatrial.boat.physics import SIGNIFICANT
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.sections.base import Section
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Number, Text, Unit, between, known
from seatrial.report.text.markup import listing
from seatrial.report.text.names import names_in, sentence
from seatrial.report.text.table import Table
from seatrial.util.format import plus_minus
from seatrial.util.statistics import NORMAL_95

EFFECT_WORDS = {  # of the names in a model file
    "current_x": ("current along x", "m/s"),
    "current_y": ("current along y", "m/s"),
    "trim_u": ("trim in surge", "m/s^2"),
    "trim_v": ("trim in sway", "m/s^2"),
    "trim_r": ("trim in yaw", "rad/s^2"),
    "wind_x": ("wind along x", "m/s^2"),
    "wind_y": ("wind along y", "m/s^2"),
    "wind_turn_x": ("turning by wind along x", "rad/s^2"),
    "wind_turn_y": ("turning by wind along y", "rad/s^2"),
    "wind_side_x": ("wind in sway beyond that in surge, along x", "m/s^2"),
    "wind_side_y": ("wind in sway beyond that in surge, along y", "m/s^2"),
}
TRIMS = ("trim_u", "trim_v", "trim_r")
Row = tuple[str, str, float, float, str]  # effect, where, value, standard error (0: stated), unit


def section(evidence: Evidence) -> Section | None:
    """Only where an effect is stated, estimated, or significant and not modelled."""
    table, model = effects(evidence.model), evidence.model
    missing = [
        sentence(finding_text(f), names_in(model))
        for f in model.findings_of(*UNMODELLED_EFFECTS.values())
    ]
    if not table.rows and not missing:
        return None
    shown = table.html() if table.rows else f"<p>{prose.NO_EFFECTS}</p>"
    body = f"""<p class="note">{prose.EFFECTS}</p>
{shown}{listing(missing) if missing else ""}"""
    return Section("effects", "Effects", body, tables=(table,) if table.rows else ())


def effects(model: Model) -> Table:
    """A row for each, with its 95 % interval."""
    head = ("effect", "of", "value", "± (95 %)", "95 % interval", "unit", "verdict")
    rows: list[list[Cell]] = []
    for effect, where, value, error, unit in [*_lever(model), *_delays(model), *_recorded(model)]:
        width = NORMAL_95 * error
        interval = (value - width, value + width) if error > 0 else None
        rows.append(
            [
                Text(effect), Text(where), Number(value, 3), known(width if error > 0 else None, 2),
                between(interval), Unit(unit), Text(_verdict(value, error)),
            ]
        )  # fmt: skip
    return Table("effects", "Effects", head, rows)


def _verdict(value: float, error: float) -> str:
    if error == 0.0:
        return "stated"
    return "significant" if abs(value) >= SIGNIFICANT * error else "not distinguishable from zero"


def _lever(model: Model) -> list[Row]:
    if not any(model.vehicle.lever) and not any(model.lever_errors):
        return []
    sides = zip(("ahead", "to port"), model.vehicle.lever, model.lever_errors, strict=True)
    return [(f"lever arm {side}", "sensor", value, error, "m") for side, value, error in sides]


def _delays(model: Model) -> list[Row]:
    errors: dict[str, Finding] = {}
    for finding in model.findings_of(FindingKind.DELAY):
        errors[finding.part("part")] = finding
    apart = model.findings_of(FindingKind.DELAY_DIFFERENCE)
    rows: list[Row] = []
    for part, delay in zip(("position", "heading"), model.vehicle.delays, strict=True):
        found = errors.get(part)
        if found is not None:
            rows.append(
                (f"delay of {part}", "sensor", found.number("delay"), found.number("error"), "s")
            )
        elif delay and not apart:
            rows.append((f"delay of {part}", "sensor", delay, 0.0, "s"))
    for one in apart:
        what = f"delay of {one.part('older')} after {one.part('newer')}"
        rows.append((what, "sensor", one.number("delay"), one.number("error"), "s"))
    return rows


def _recorded(model: Model) -> list[Row]:
    rows: list[Row] = []
    for entry in model.recordings:
        for name, value in entry.effects.items():
            words, unit = EFFECT_WORDS.get(name, (name, "-"))
            rows.append((words, entry.name, value, entry.errors.get(name, 0.0), unit))
        rows += [
            (f"{one.kind} toward {one.direction}", entry.name, one.size, one.error, one.unit)
            for one in earth_effects(model.vehicle, entry)
        ]
    return rows


def in_short(model: Model) -> str:
    """Lever arm, delays, current, wind and trim with 95 % half-widths, on one line; empty: none was estimated."""
    parts = [
        _sized(effect, value, error, unit)
        for effect, _, value, error, unit in [*_lever(model), *_delays(model)]
        if error > 0.0
    ]
    return "; ".join([*parts, *_of_recordings(model)])


def _sized(effect: str, value: float, error: float, unit: str) -> str:
    return f"{effect} {plus_minus(value, NORMAL_95 * error)} {unit.replace('^2', '²')}"


def _of_recordings(model: Model) -> Iterator[str]:
    """Significant effects of each recording; of several recordings the range of sizes."""
    found: dict[str, list[tuple[str, float, float, str]]] = {}
    for entry in model.recordings:
        for one in earth_effects(model.vehicle, entry):
            found.setdefault(one.kind, []).append((one.direction, one.size, one.error, one.unit))
        for name in set(entry.effects) & set(TRIMS):
            words, unit = EFFECT_WORDS[name]
            row = ("", entry.effects[name], entry.errors.get(name, 0.0), unit)
            found.setdefault(words, []).append(row)
    for words, rows in sorted(found.items()):
        several = [row for row in rows if abs(row[1]) >= SIGNIFICANT * row[2]]
        if len(several) == 1:
            direction, value, error, unit = several[0]
            yield _sized(words, value, error, unit) + (f" toward {direction}" if direction else "")
        elif several:
            sizes = [value for _, value, _, _ in several]
            unit = several[0][3].replace("^2", "²")
            yield f"{words} {min(sizes):.2g} to {max(sizes):.2g} {unit} in {len(several)} recordings"
