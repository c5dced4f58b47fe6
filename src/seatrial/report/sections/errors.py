# SPDX-License-Identifier: MIT
"""Residuals: histograms, autocorrelations, residuals against inputs."""

from collections.abc import Sequence
from string import Template

from seatrial.evaluation.residuals import in_words, significant
from seatrial.report.evidence.model_evidence import Evidence
from seatrial.report.evidence.runs import Run
from seatrial.report.figures import errors as draw
from seatrial.report.figures.base import Figure, driven_axes
from seatrial.report.sections.base import Section, axis_heading, first_of, foldable, plot, store_of
from seatrial.report.sections.prediction import sizes
from seatrial.report.text import prose
from seatrial.report.text.cells import Cell, Name, Number, Text
from seatrial.report.text.markup import listing, number
from seatrial.report.text.names import names_in, sentence
from seatrial.report.text.table import Table
from seatrial.util.frames import ERROR_UNITS, SYMBOLS

MOST_CORRELATIONS = 4  # sentences on the residuals of a recording


def section(evidence: Evidence) -> Section | None:
    """Each recording that could be predicted, foldable."""
    if not evidence.tested:
        return None
    first, names = first_of(evidence.runs), names_in(evidence.model)
    driven = driven_axes(evidence.model)
    parts = "\n".join(
        _one(run, i, names, driven, opened=i == first)
        for i, run in enumerate(evidence.runs)
        if run.tested
    )
    note = Template(prose.ERRORS).substitute(horizon=f"{evidence.horizon:g}")
    body = f"""<p class="note">{note}</p>
{parts}"""
    figures = {
        store_of(i): _figures(evidence, run) for i, run in enumerate(evidence.runs) if run.tested
    }
    return Section("errors", "Residuals", body, figures, (correlations(evidence),))


def correlations(evidence: Evidence) -> Table:
    """The largest correlation of every residual with every force."""
    head = ("residual", "force", "correlation", "lag [s]", "limit", "significant")
    rows: list[list[Cell]] = []
    for run in evidence.tested:
        rows.append([Text(run.name)])
        rows += [
            [
                Name(c.residual), Name(c.force), Number(c.peak, 2), Number(c.lag, 2),
                Number(c.limit, 2), Text("yes" if c.found else "no"),
            ]
            for c in run.correlations
        ]  # fmt: skip
    return Table("residuals", "Residuals of the filter against forces", head, rows)


def _figures(evidence: Evidence, run: Run) -> dict[str, Figure]:
    found = {}
    for axis, symbol in enumerate(SYMBOLS):
        found[f"histogram-{symbol}"] = draw.histogram(run, axis)
        found[f"autocorrelation-{symbol}"] = draw.correlation(run, axis)
        if axis in driven_axes(evidence.model):
            found[f"command-{symbol}"] = draw.against_command(evidence.model, run, axis)
        if run.correlations:
            found[f"followed-{symbol}"] = draw.residual_correlations(run, axis)
    return found


def _one(run: Run, place: int, names: Sequence[str], driven: Sequence[int], *, opened: bool) -> str:
    found = significant(run.correlations)
    lines = [sentence(in_words(c), names) for c in found[:MOST_CORRELATIONS]]
    if len(found) > MOST_CORRELATIONS:
        lines.append(f"and {len(found) - MOST_CORRELATIONS} more, in the plots")
    if run.correlations and not found:
        lines = ["no residual is significantly correlated with a force"]
    parts = "".join(_axis(run, place, axis, driven) for axis in range(3))
    return foldable(run.name, sizes(run), listing(lines) + parts, opened=opened)


def _axis(run: Run, place: int, axis: int, driven: Sequence[int]) -> str:
    sign, (name, scale), store = SYMBOLS[axis], ERROR_UNITS[axis], store_of(place)
    found = run.score.scores[sign]
    summary = (
        f"RMS {number(found.rms * scale, 2)} {name}, mean {number(found.bias * scale, 2)} {name}, "
        f"kurtosis {number(found.kurtosis, 2)}"
    )
    drawn = [
        plot(store, f"histogram-{sign}", f"histogram of the errors: {summary}", "small"),
        plot(store, f"autocorrelation-{sign}", "autocorrelation of the errors", "small"),
    ]
    if axis in driven:
        drawn.append(plot(store, f"command-{sign}", "mean error against the commands", "small"))
    if run.correlations:
        label = "correlation of residuals with forces"
        drawn.append(plot(store, f"followed-{sign}", label, "small"))
    return f"""{axis_heading(axis, summary)}
<div class="four">{"".join(drawn)}</div>"""
