# SPDX-License-Identifier: MIT
"""The page's sections."""

from collections.abc import Sequence
from html import escape

import numpy as np

from seatrial.control import Tuning
from seatrial.control.tuning.console import guidance_lines, remarks
from seatrial.control.tuning.design import SENSITIVITY_LIMIT
from seatrial.control.tuning.loops import Margins
from seatrial.control.tuning.page import draw
from seatrial.control.tuning.responses import Responses
from seatrial.report.sections.base import ALL, Section, three
from seatrial.report.text.cells import Cell, Number, Text, known
from seatrial.report.text.names import sentence
from seatrial.report.text.table import Table
from seatrial.util.frames import AXES, POSE_UNITS, SYMBOLS

MARGINS = """Each loop with the other two closed, the worst of rest, of the fastest motion along each axis both
ways, and of a turn at speed. Gain margin: factor by which thrust may exceed the model's. Delay: additional
delay that keeps the loop stable. Sensitivity: largest |S|, the worst amplification of a disturbance. The limit
$limit guarantees a phase margin of 29° and a gain margin of 2."""
GUIDED = """This boat has no sway thrust. The second loop is the cross-track one of the guidance: heading and speed
closed, about rest, the slowest and the fastest motion ahead, and a turn at speed."""
STEPS = """Without feed-forward, at rest (without sway thrust: ahead at full speed), for errors so small that no
thruster saturates. A controller with integral action overshoots a step. It does not overshoot a feasible reference
with feed-forward. Shaded: draws of the model's covariance."""
BODE = """The loop of each axis with the other two closed, at rest (without sway thrust: ahead at full speed), with
exact delays. Dotted: 0&nbsp;dB, phase
−180°, the limit of the sensitivity."""


def gains(tuning: Tuning) -> Section:
    """Gains in command units."""
    full, delay = tuning.boat.authority, tuning.delay
    rows: list[list[Cell]] = [
        [
            Text(AXES[i]), *(Number(float(x)) for x in tuning.table()[i]),
            Text(f"1/{POSE_UNITS[i]}, 1/({POSE_UNITS[i]} s), s/{POSE_UNITS[i]}"),
            Number(float(full[i]), 3), Text(f"{POSE_UNITS[i]}/s²"), Number(float(delay[i]), 3),
        ]
        for i in tuning.boat.driven
    ]  # fmt: skip
    head = ("axis", "P", "I", "D", "unit", "full command", "", "delay [s]")
    table = Table("gains", "Gains in command units", head, rows)
    lines = "".join(
        f"<p>{sentence(text)}</p>" for text in (*guidance_lines(tuning), *remarks(tuning))
    )
    head_of_page = f"""<header><h1>{escape(tuning.model.name)}</h1>
<p class="subtitle">{tuning.action.upper()} tracking controller by internal model control, knob
{tuning.knob:g}&nbsp;s, {tuning.rate:g}&nbsp;Hz</p></header>
"""
    body = f"{table.html()}\n{lines}"
    return Section("gains", "Gains", body, tables=(table,), above=head_of_page)


def safety(tuning: Tuning) -> Section:
    """Margins."""
    drawn = (
        f"Worst of {tuning.draws} draws of the model (seed {tuning.seed}), {tuning.curves}"
        if tuning.draws
        else f"The model has no standard errors; {tuning.curves}"
    )
    rows: list[list[Cell]] = [
        [Text("The model")],
        *_rows(tuning.nominal, tuning.loops),
        [Text(drawn)],
        *_rows(tuning.worst, tuning.loops),
    ]
    measures = (
        "gain margin", "phase margin [deg]", "delay [s]", "sensitivity", "crossover [rad/s]",
    )  # fmt: skip
    head = ("axis", *measures)
    table = Table("margins", "Margins", head, rows)
    guided = "" if tuning.guidance is None else f'<p class="note">{GUIDED}</p>'
    body = f"""{table.html()}<p class="note">{MARGINS.replace("$limit", f"{SENSITIVITY_LIMIT:g}")}</p>{guided}"""
    return Section("margins", "Margins", body, tables=(table,))


def _rows(found: Margins, loops: Sequence[str]) -> list[list[Cell]]:
    return [
        [
            Text(axis), known(float(found.gain_up[i]), 3), Number(float(np.degrees(found.phase[i])), 3),
            Number(float(found.delay[i]), 3), Number(float(found.sensitivity[i]), 3),
            Number(float(found.crossover[i]), 3),
        ]
        for i, axis in enumerate(loops)
    ]  # fmt: skip


def steps(tuning: Tuning, curves: Responses) -> Section:
    """Step responses."""
    body = f"""<p class="note">{STEPS}</p>
{three(ALL, "step", "pose after a step of the reference", "middle")}"""
    figures = {
        f"step-{s}": draw.step(curves.step, i, tuning.loops[i]) for i, s in enumerate(SYMBOLS)
    }
    return Section("steps", "Steps", body, {ALL: figures}, heading="Step of the reference")


def bode(tuning: Tuning, curves: Responses) -> Section:
    """Bode plots and sensitivity."""
    body = f"""<p class="note">{BODE}</p>
{three(ALL, "gain", "gain of the open loop", "middle")}
{three(ALL, "phase", "phase of the open loop", "middle")}
{three(ALL, "sensitivity", "sensitivity", "middle")}"""
    figures = {}
    for i, s in enumerate(SYMBOLS):
        figures[f"gain-{s}"] = draw.gain(curves.gain, i, tuning.loops[i])
        figures[f"phase-{s}"] = draw.phase(curves.phase, i, tuning.loops[i])
        figures[f"sensitivity-{s}"] = draw.sensitivity(curves.sensitivity, i, tuning.loops[i])
    return Section("bode", "Frequency response", body, {ALL: figures})


def provenance(tuning: Tuning) -> Section:
    """Model, recordings, axes, inputs, delay."""
    model = tuning.model
    facts = [
        ("model", f"{model.name}, by {model.estimator.method}"),
        ("recordings", ", ".join(r.name for r in model.recordings) or "none"),
        ("axes", "forward-left-up"),
        ("inputs", ", ".join(model.vehicle.inputs)),
        ("delay of the controller", f"{tuning.hold:.3g} s"),
    ]
    rows: list[list[Cell]] = [[Text(name), Text(value)] for name, value in facts]
    table = Table("provenance", "Provenance", ("", ""), rows, numbers=False)
    return Section("provenance", "Provenance", table.html(), tables=(table,))
