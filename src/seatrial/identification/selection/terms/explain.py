# SPDX-License-Identifier: MIT
"""The rows of the table: for every term its tests, the verdict, and the reason."""

from collections.abc import Mapping, Sequence

import numpy as np

from seatrial.boat.structure import Term
from seatrial.identification.selection.terms.candidates import Alias, drag_of
from seatrial.identification.selection.terms.decisions import (
    Row,
    TermEvidence,
    TermTests,
    TermVerdict,
    repeats_text,
)
from seatrial.identification.selection.terms.held_out import Fold
from seatrial.util.format import sensible
from seatrial.util.frames import AXES


def rows_of(
    tested: TermTests,
    own: Sequence[Term],
    aliased: Sequence[Alias],
    refused: Mapping[str, str],
) -> tuple[Row, ...]:
    """The vehicle's own terms and the candidates, axis by axis."""
    fit, kept = tested.fit, tested.kept
    made = {a.coefficient: a for a in aliased if a.coefficient not in fit.values}
    everything = [t for t in (*own, *tested.search.candidates) if t.coefficient]
    outside = [
        t for t in everything if t.coefficient not in fit.values and t.coefficient not in made
    ]
    others = tested.others(outside)
    rows = []
    for term in sorted(everything, key=lambda t: t.axis):
        name, was = str(term.coefficient), term in own
        if name in made:
            verdict = TermVerdict.ALIASED
            reason = f"an exact combination of {', '.join(made[name].made_by)}, for any data"
        elif name in fit.values:
            verdict = TermVerdict.STAYS if was else TermVerdict.COMES
            reason = (
                _stays(kept[name], len(kept), tested.folds, term)
                if name in kept
                else "the only drag of its axis"
                if name in drag_of(fit.terms, term.axis)
                else "thrust"
            )
        else:
            verdict = TermVerdict.GOES if was else TermVerdict.OUT
            reason = refused.get(name) or reason_out(others[name], len(others), tested.folds)
        evidence = kept.get(name, others.get(name))
        rows.append(Row(term.text(), name, term.axis, term.unit(), verdict, reason, evidence))
    return tuple(rows)


def reason_out(evidence: TermEvidence, tests: int, folds: Sequence[Fold]) -> str:
    """Why a term that is not in the chosen structure is out; tests: how many such terms there are."""
    if not evidence.repeatable(tests):
        return f"not repeatable: {repeats_text(evidence.repeats, folds)}"
    z = f"z = {sensible(evidence.estimate.z)}"
    if evidence.significant:
        return f"{z}, but not enough for one of {tests} candidates, or left-out blocks are predicted no better"
    return f"not distinguishable from zero ({z})"


def _stays(evidence: TermEvidence, tests: int, folds: Sequence[Fold], term: Term) -> str:
    if evidence.idle:
        return (
            f"weak: at its bound, 0, yet not ruled out: it may move {AXES[term.axis]}'s prediction by "
            f"{evidence.reach:.2g} % of its change"
        )
    if not evidence.significant:
        text = (
            f"weak: not distinguishable from zero (z = {sensible(evidence.estimate.z)}), nor ruled out: it may "
            f"move {AXES[term.axis]}'s prediction by {evidence.reach:.2g} % of its change"
        )
    elif evidence.weak:
        text = f"weak: distinguishable from zero, but {_moves(evidence, term)}"
    else:
        text = f"distinguishable from zero, {_difference(evidence, term)} without it"
    if not evidence.repeatable(tests):
        text += f"; not repeatable: {repeats_text(evidence.repeats, folds)}"
    return text


def _moves(evidence: TermEvidence, term: Term) -> str:
    percent = evidence.change.moves
    return f"{AXES[term.axis]}'s prediction moves by {percent:.2g} % of its change with it"


def _difference(evidence: TermEvidence, term: Term) -> str:
    axis, percent = AXES[term.axis], evidence.change.percent
    if abs(percent) < 0.05:  # rounds to none
        return f"{axis} is predicted as well"
    size = "beyond bounds" if np.isinf(percent) else f"{sensible(abs(percent))} %"
    return f"{axis} is predicted {size} {'worse' if percent > 0 else 'better'}"
