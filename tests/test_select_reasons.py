# SPDX-License-Identifier: MIT
"""What `select` says of a term: why it goes, why a candidate stays out."""

import numpy as np
import pytest

from seatrial.identification.selection.significance import Estimate, Repeats
from seatrial.identification.selection.terms.decisions import (
    TermEvidence,
    reason_to_go,
)
from seatrial.identification.selection.terms.explain import reason_out
from seatrial.identification.selection.terms.held_out import (
    PredictionChange,
)
from seatrial.util.format import sensible


def told(value=1.0, p=1e-9):
    return Estimate(value, 0.1, p)


def spread(p, between):
    return Repeats(np.zeros(2), np.ones(2), p, between, 1.0)


def changed(percent, z, moves=10.0, value=1.0):
    return PredictionChange(percent, z, moves, value)


SAME, FINE = spread(0.5, 0.0), changed(5.0, 6.0)


@pytest.mark.parametrize(
    ("evidence", "own", "said"),
    [
        (TermEvidence(told(), SAME, FINE), True, None),
        (TermEvidence(told(), spread(1e-6, 0.9), changed(0.0, 0.0)), True, "not repeatable"),
        (TermEvidence(told(), spread(1e-6, 0.2), changed(0.0, 0.0)), True, None),
        (TermEvidence(told(), spread(1e-6, 0.9), FINE), True, None),  # stays, but is said to spread
        (TermEvidence(told(), SAME, changed(-4.0, -5.0)), True, "4 % better without it"),
        (TermEvidence(told(), SAME, changed(0.0, 0.0, 0.01)), False, "by 0.01 % only"),
        (TermEvidence(told(), SAME, changed(0.0, 0.0, 0.01)), True, None),
        (TermEvidence(told(0.05, 0.6), SAME, FINE), True, None),  # not ruled out
        (TermEvidence(told(0.05, 0.6), SAME, changed(-0.2, -1.5, 9.0, 0.05)), True, "0.2 % better without it"),
        (TermEvidence(told(0.05, 0.6), SAME, changed(0.0, 0.0, 0.1, 0.05)), True, "by 0.5 % at most"),
        # all recordings together say 0, where each half says 0.1
        (TermEvidence(told(1e-9, 0.6), SAME, changed(0.0, 0.0, 0.4, 0.1)), True, "by 0.8 % at most"),
    ],
)  # fmt: skip
def test_why_a_term_of_the_model_goes(evidence, own, said):
    parts = [type("F", (), {"name": n})() for n in ("first", "second")]
    found = reason_to_go(evidence, 10, parts, own=own, one_boat=True)
    assert (found is None) if said is None else (said in found)


@pytest.mark.parametrize(
    ("evidence", "said"),
    [
        (TermEvidence(told(0.05, 0.6), SAME, FINE), "not distinguishable from zero (z = 0.5)"),
        (TermEvidence(told(0.3, 0.01), SAME, FINE),
         "z = 3.0, but not enough for one of 24 candidates, or left-out blocks are predicted no better"),
        (TermEvidence(told(), spread(1e-6, 0.9), FINE), "not repeatable: first: 0 ± 1; second: 0 ± 1"),
    ],
)  # fmt: skip
def test_why_a_candidate_stays_out(evidence, said):
    parts = [type("F", (), {"name": n})() for n in ("first", "second")]
    assert reason_out(evidence, 24, parts) == said


def test_what_rounds_to_nothing_has_no_sign():
    shown = [sensible(value) for value in (-0.04, 0.04, -9.96, -12.3, 650.2)]
    assert shown == ["0.0", "0.0", "-10.0", "-12", "650"]
