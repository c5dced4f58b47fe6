# SPDX-License-Identifier: MIT
"""A selection as text and as JSON."""

from typing import Final

import numpy as np

from seatrial.boat.findings import finding_text
from seatrial.identification.selection.terms.decisions import (
    Row,
    Selection,
    TermEvidence,
    TermVerdict,
)
from seatrial.util.format import plus_minus, sensible, table
from seatrial.util.frames import AXES, Axes

SELECTION_FORMAT: Final = "selection 1"
HEAD = ("term", "estimate", "z", "spread", "held-out", "moves")
SPARE = (3, 5)  # what a narrow terminal does not get
TABLE_LEGEND = """\
  z: estimate / standard error, each candidate added alone; spread: between the repeats, relative to their
  standard errors; held-out: increase of the {horizon:g} s prediction error without the term, for recordings left
  out of the fit; moves: RMS change of that prediction by the term, relative to the change of the velocity"""


def selection_text(selection: Selection) -> str:
    """The table, axis by axis, and the chosen equations."""
    rows = selection.rows
    numbers = table(HEAD, [_numbers(row) for row in rows], spare=SPARE).splitlines()
    width = max(len(line) for line in numbers)
    lines = [f"Repeats: {' against '.join(f.name for f in selection.folds)}", numbers[0]]
    before = -1
    for row, line in zip(rows, numbers[1:], strict=True):
        lines += [AXES[row.axis]] if row.axis != before else []
        lines.append(f"{line.ljust(width)}  {row.verdict.value}: {row.reason}")
        before = row.axis
    lines.append(TABLE_LEGEND.format(horizon=selection.horizon))
    if selection.vehicle.axes is not Axes.FLU:
        lines.append(
            f"  all in {Axes.FLU.value} axes; the file's are {selection.vehicle.axes.value}"
        )
    structure = selection.vehicle.structure
    chosen = ["Chosen:", *(f"  {structure.equation(a)}" for a in range(3)), _sum(rows)]
    return "\n".join(
        [*lines, *chosen, *(f"Check first: {finding_text(f)}" for f in selection.asked)]
    )


def chosen_terms_text(selection: Selection) -> str:
    """The chosen equations, without the table of reasons."""
    structure = selection.vehicle.structure
    equations = [f"  {structure.equation(axis)}" for axis in range(3)]
    head = f"The recordings choose the terms, {len(selection.rows)} tested (-v shows the table):"
    return "\n".join([head, *equations, _sum(selection.rows)])


def _numbers(row: Row) -> tuple[str, ...]:
    found = row.evidence
    if found is None:
        return (row.term, *[""] * (len(HEAD) - 1))
    percent = found.change.percent
    change = "inf" if np.isinf(percent) else f"{sensible(percent)} %"
    estimate = found.estimate
    return (
        row.term,
        plus_minus(estimate.value, estimate.error),
        sensible(estimate.z),
        f"{found.repeats.ratio:.1f}",
        change,
        f"{found.change.moves:.2g} %",
    )


def _sum(rows: tuple[Row, ...]) -> str:
    def named(*verdicts: TermVerdict) -> str:
        return ", ".join(row.coefficient for row in rows if row.verdict in verdicts) or "none"

    kept = [row for row in rows if row.verdict.kept]
    weak = ", ".join(row.coefficient for row in kept if row.weak) or "none"
    return (
        f"Added: {named(TermVerdict.COMES)}. Removed: {named(TermVerdict.GOES)}. Weak: {weak}. "
        f"Aliased: {named(TermVerdict.ALIASED)}."
    )


def selection_json(selection: Selection) -> dict[str, object]:
    """The content of `select.json`; forward-left-up, SI."""
    return {
        "seatrial": SELECTION_FORMAT,
        "vehicle": selection.vehicle.name,
        "horizon": selection.horizon,
        "repeats": [
            {"name": f.name, "recordings": [r.name for r in f.recordings]} for f in selection.folds
        ],
        "structure": selection.vehicle.structure.lines(),
        "terms": [_entry(row) for row in selection.rows],
        "asked": [finding_text(finding) for finding in selection.asked],
    }


def _entry(row: Row) -> dict[str, object]:
    entry: dict[str, object] = {
        "term": row.term,
        "coefficient": row.coefficient,
        "axis": AXES[row.axis],
        "unit": row.unit,
        "kept": row.verdict.kept,
        "verdict": row.verdict.value,
        "reason": row.reason,
    }
    return entry if row.evidence is None else {**entry, **_measured(row.evidence)}


def _measured(found: TermEvidence) -> dict[str, object]:
    change = found.change
    return {
        "value": found.estimate.value,
        "error": found.estimate.error,
        "p": found.estimate.p,
        "repeats": found.repeats.values.tolist(),
        "repeats_errors": found.repeats.errors.tolist(),
        "repeats_p": found.repeats.p,
        "repeats_between": found.repeats.between,
        "held_out_percent": change.percent if np.isfinite(change.percent) else None,
        "held_out_moves": change.moves if np.isfinite(change.moves) else None,
        "held_out_z": change.z if np.isfinite(change.z) else None,
    }
