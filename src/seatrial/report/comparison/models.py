# SPDX-License-Identifier: MIT
"""Sections on two models: verdict, accuracy, parameters, actuators, boat, provenance."""

from html import escape
from itertools import zip_longest

from seatrial.evaluation.comparison.cause_text import cause_text, probability_text
from seatrial.evaluation.comparison.console import changes_text
from seatrial.evaluation.comparison.parameters import Pair
from seatrial.evaluation.comparison.prediction_text import prediction_text
from seatrial.report.comparison import draw, first
from seatrial.report.comparison.two_models import LETTERS, ModelPair
from seatrial.report.evidence.actuators import angle_curves, curves, step_responses
from seatrial.report.evidence.advice import advice
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.figures.actuators import ANGLE, COMMANDS, THRUST
from seatrial.report.figures.base import Figure
from seatrial.report.sections.actuators import about, plots
from seatrial.report.sections.base import ALL, Section, plot, verdict_section
from seatrial.report.sections.known import share, verdict_text
from seatrial.report.sections.physics import PHYSICS_HEAD, physics_cells
from seatrial.report.sections.provenance import facts_of
from seatrial.report.text import prose
from seatrial.report.text.cells import NOTHING, Cell, Name, Number, Text, Unit, Worded
from seatrial.report.text.cells import known as number_or_dash
from seatrial.report.text.equations import equations
from seatrial.report.text.markup import NOT_A_NUMBER, listing
from seatrial.report.text.names import names_in, sentence
from seatrial.report.text.numbers import minutes
from seatrial.report.text.table import Table
from seatrial.util.format import chance
from seatrial.util.frames import AXES, SYMBOLS


def verdict(pair: ModelPair) -> Section:
    """The first screen; below it what is compared, what changed, whether it matters."""
    found = pair.found
    sides = "; ".join(
        f"{letter} is {side.label} ({side.vehicle}, {side.method}"
        + (f", {minutes(side.length)})" if side.recordings else ")")
        for letter, side in zip(LETTERS, (found.a, found.b), strict=True)
    )
    lines = [f"{sides}.", " ".join(map(_opened, changes_text(found)))]
    lines += [f"{name} s ahead, {prediction_text(found, name)}." for name in found.better]
    names = names_in(*pair.models)
    text = "".join(f"<p>{sentence(line, names)}</p>" for line in lines)
    notes = "".join(
        f'<p class="sanity">{sentence(_opened(note), names)}</p>' for note in found.notes
    )
    screen, figures = first.screen(pair)
    return verdict_section(screen, text, notes, figures)


def causes(pair: ModelPair) -> Section | None:
    """The probability of each cause of the difference."""
    if not pair.found.causes:
        return None
    rows: list[list[Cell]] = [
        [
            Text(one.cause), Worded(one.probability, probability_text(one.probability)),
            NOTHING if one.change is None else Number(one.change, 2, 100.0, " %"), Text(one.what or NOT_A_NUMBER),
        ]
        for one in pair.found.causes
    ]  # fmt: skip
    head = ("cause", "probability", "change that fits best", "of")
    table = Table("causes", "Probabilities of causes", head, rows)
    body = f"""<p>{escape(cause_text(pair.found.causes))}.</p>
{table.html()}<p class="note">{prose.CAUSES}</p>"""
    return Section("causes", "Causes", body, tables=(table,))


def known(pair: ModelPair) -> Section:
    """Accuracy of the parameters of both."""
    names = draw.estimated_names(pair.known)
    rows: list[list[Cell]] = []
    for name in names:
        row: list[Cell] = [Name(name)]
        for one in pair.known:
            own = {f.name: f for f in one.findings}.get(name)
            given = own is None or not own.verdict.estimated
            row += [NOTHING, NOTHING] if own is None or given else [
                share(own), Text(verdict_text(own))
            ]  # fmt: skip
        rows.append(row)
    head = ("parameter", "relative error A", "verdict A", "relative error B", "verdict B")
    table = Table("known", "How well each parameter is known", head, rows)
    body = f"""<p class="note">{prose.KNOWN}</p>
<div class="pair wider">{table.html()}
{plot(ALL, "known", "relative errors of both", "tall", rows=len(names))}</div>"""
    return Section(
        "known", "What is known", body, {ALL: {"known": draw.relative_errors(pair.known)}}, (table,)
    )


def parameters(pair: ModelPair) -> Section:
    """Every parameter of both, the difference, and the equations."""
    table = differences(pair)
    numbers = "".join(
        f"<h3>{letter}</h3>{equations(m.structure, m.values)}"
        for letter, m in zip(LETTERS, pair.models, strict=True)
    )
    tested = [p for p in pair.found.pairs if p.z is not None]
    drawn, figures = "", dict[str, Figure]()
    if tested:
        figures["differences"] = draw.differences(tested)
        label = "differences in standard errors"
        drawn = plot(ALL, "differences", label, "tall", rows=len(tested))
    body = f"""<p class="note">{prose.AXES_NOTE} {prose.DIFFERENCES}</p>
{drawn}{table.html()}
<h3>Equations with numbers</h3>{numbers}"""
    return Section("model", "What changed", body, {ALL: figures}, (table,))


def differences(pair: ModelPair) -> Table:
    """Values, difference, its size in standard errors, and the probability of chance."""
    found = pair.found
    head = (
        "parameter", "A", "± A (s.e.)", "B", "± B (s.e.)", "B − A", "in s.e.", "p (Holm)", "unit",
    )  # fmt: skip
    rows = [_difference(one) for one in found.pairs]
    marked = frozenset(i for i, one in enumerate(found.pairs) if one.differs)
    for place, rest in enumerate((found.only_a, found.only_b)):
        for only in rest:
            value: list[Cell] = [Number(only.value), number_or_dash(only.error or None, 2)]
            cells = [*value, NOTHING, NOTHING] if place == 0 else [NOTHING, NOTHING, *value]
            why = Text(only.why or f"only in {LETTERS[place]}")
            rows.append([Name(only.name), *cells, NOTHING, NOTHING, why, Unit(only.unit)])
    return Table("differences", "Parameters of both models", head, rows, marked)


def _difference(one: Pair) -> list[Cell]:
    return [
        Name(one.name), Number(one.a), number_or_dash(one.error_a or None, 2), Number(one.b),
        number_or_dash(one.error_b or None, 2), Number(one.difference, 2), number_or_dash(one.z, 2),
        Text("given" if one.p is None else chance(one.p)), Unit(one.unit),
    ]  # fmt: skip


def actuators(pair: ModelPair) -> Section:
    """Static curves and step responses of both."""
    static = draw.curves(
        [curves(m) for m in pair.models], COMMANDS, THRUST, {"xaxis": {"range": [-1.02, 1.02]}},
    )  # fmt: skip
    angles = [angle_curves(m) for m in pair.models]
    steered = any(angles)
    response = draw.curves(
        [step_responses(m) for m in pair.models], "time since the command [s]", "force [share of final value]",
        {"yaxis": {"range": [-0.05, 1.1]}},
    )  # fmt: skip
    body = f"""<p class="note">{about(steered=steered)}</p>
{plots(steered=steered)}"""
    figures = {"curve": static, "answer": response}
    if steered:
        figures["angle"] = draw.curves(angles, COMMANDS, ANGLE, {"xaxis": {"range": [-1.02, 1.02]}})
    return Section("actuators", "Actuators", body, {ALL: figures})


def boat(pair: ModelPair) -> Section:
    """Physics that both imply."""
    axes = [
        one.axis
        for one in pair.physics[0].axes
        if one.axis in {o.axis for o in pair.physics[1].axes}
    ]
    rows: list[list[Cell]] = []
    figures: dict[str, Figure] = {}
    for axis in axes:
        own = [next(o for o in side.axes if o.axis == axis) for side in pair.physics]
        rows += [
            [Text(AXES[axis]), Text(letter), *physics_cells(one)]
            for letter, one in zip(LETTERS, own, strict=True)
        ]
        until = min(60.0, 6.0 * max(2.0 / 6.0, *(one.found.rise_time for one in own)))
        figures[f"start-{SYMBOLS[axis]}"] = draw.start_and_stop(pair.models, axis, until)
    table = Table("boat", "Physics of both models", ("axis", "model", *PHYSICS_HEAD), rows)
    drawn = "".join(plot(ALL, name, "start and stop", "middle") for name in figures)
    body = f"""<div class="three">{drawn}</div>
{table.html()}<p class="note">{prose.PHYSICS}</p>"""
    return Section("physics", "Boat", body, {ALL: figures}, (table,), heading="The boat")


def advised(pair: ModelPair) -> Section | None:
    """What to do next with either."""
    if pair.evidence is None:
        return None
    parts = "".join(
        f"<div><h3>{letter}</h3>{_todo(one)}</div>"
        for letter, one in zip(LETTERS, pair.evidence, strict=True)
    )
    body = f'<div class="pair">{parts}</div>'
    return Section("advice", "Next drive", body, heading="The next drive")


def _opened(text: str) -> str:
    return text[:1].upper() + text[1:]


def _todo(one: Evidence) -> str:
    found = [sentence(text, names_in(one.model)) for text in advice(one)]
    return listing(found, "advice") if found else prose.ALL_WELL


def provenance(pair: ModelPair) -> Section:
    """Where both come from."""
    sides = [facts_of(model) for model in pair.models]
    rows: list[list[Cell]] = [
        [Text(a[0]), Text(a[1]), Text(b[1])]
        for a, b in zip_longest(*sides, fillvalue=("", ""))
        if a[0] == b[0]
    ]
    for place, (letter, model) in enumerate(zip(LETTERS, pair.models, strict=True)):
        for entry in model.recordings:
            for file in entry.files:
                cells = [
                    Text(f"{entry.name}, {minutes(entry.length)}: {file.name} {file.sha256}"),
                    Text(""),
                ]
                rows.append([Text(f"{letter} from"), *(cells if place == 0 else cells[::-1])])
    table = Table("provenance", "Provenance", ("", *LETTERS), rows, numbers=False)
    return Section("provenance", "Provenance", table.html(), tables=(table,))
